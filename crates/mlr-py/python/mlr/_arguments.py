"""What callers pass, as the native half takes it."""

from collections.abc import Callable, Mapping, Sequence
from os import PathLike
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .errors import BadInput

Path: TypeAlias = str | PathLike[str]
"""The name of a file."""

Progress: TypeAlias = Callable[[int, int], object]
"""Called with the steps that are done, and those expected in all so far."""

ANGLES = ("roll", "pitch", "yaw")
VECTORS = ("acceleration", "angular_rate")


def numbers(name: str, values: ArrayLike, columns: int | None = None) -> NDArray[np.float64]:
    """An array of float64 from whatever holds real numbers; masked ones are NaN."""
    if isinstance(values, np.ma.MaskedArray):
        masked: Any = values
        values = masked.astype(np.float64).filled(np.nan)
    array = np.asarray(values)
    expected = "(n,)" if columns is None else f"(n, {columns})"
    if array.dtype.kind not in "iuf":
        raise BadInput(f"{name}: is an array of {array.dtype}, expected real numbers")
    if array.ndim != (1 if columns is None else 2) or array.shape[1:] not in ((), (columns,)):
        raise BadInput(f"{name}: has the shape {array.shape}, expected {expected}")
    return np.asarray(array, dtype=np.float64)


def columns(recording: Mapping[str, Any]) -> dict[str, Any]:
    """The samples of a recording."""
    if recording.get("t") is None:
        raise BadInput("t: not given, expected the time of each sample")
    angles = [name for name in ANGLES if recording.get(name) is not None]
    vectors = [name for name in VECTORS if recording.get(name) is not None]
    for given, names in ((angles, ANGLES), (vectors, VECTORS)):
        if given and len(given) < len(names):
            missing = ", ".join(name for name in names if name not in given)
            raise BadInput(f"{missing}: not given, expected {' and '.join(names)} together")
    if not angles and not vectors:
        raise BadInput(
            "no samples, expected roll, pitch and yaw, or acceleration and angular_rate, or all of them"
        )
    return {
        "t": numbers("t", recording["t"]),
        **{name: numbers(name, recording[name]) if angles else None for name in ANGLES},
        **{name: numbers(name, recording[name], 3) if vectors else None for name in VECTORS},
        "in_body_axes": bool(recording.get("in_body_axes", False)),
        "notes": list(recording.get("notes", ())),
        "log": str(recording.get("log", "")),
    }


def paths(given: Path | Sequence[Path] | None) -> list[Path]:
    """None, one or several names of files."""
    if given is None:
        return []
    return [given] if isinstance(given, (str, PathLike)) else list(given)


def running(threads: int | None, progress: Progress | None) -> dict[str, Any]:
    return {"threads": threads, "progress": progress}
