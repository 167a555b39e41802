"""When damage happened."""

import json
from collections.abc import Sequence
from typing import Literal, cast

from numpy.typing import ArrayLike

from . import _mlr
from ._arguments import Path, columns, running
from .answers import Detection


def detect(
    t: ArrayLike,
    roll: ArrayLike | None = None,
    pitch: ArrayLike | None = None,
    yaw: ArrayLike | None = None,
    *,
    acceleration: ArrayLike | None = None,
    angular_rate: ArrayLike | None = None,
    method: Literal["mlr", "paper"] | None = None,
    config: Path | None = None,
    in_body_axes: bool = False,
    notes: Sequence[str] = (),
    log: str = "",
) -> Detection:
    """Find when the robot started to walk and when it was damaged.

    Parameters
    ----------
    t : array_like, shape (n,)
        Time in seconds.
    roll, pitch, yaw : array_like, shape (n,), optional
        Orientation of the body in radians: rotations about x (forward), y (left) and z (up),
        ``R = Rz(yaw) @ Ry(pitch) @ Rx(roll)``. Jumps of a turn are unwrapped.
    acceleration : array_like, shape (n, 3), optional
        Specific force in m/s², up positive at rest. With `angular_rate`, the raw samples of the
        sensor. Without angles, the orientation is fused from them; beside angles, a few rows may
        be NaN.
    angular_rate : array_like, shape (n, 3), optional
        Angular rate in rad/s.
    method : {"mlr", "paper"}, optional
        The detector's rule: mlr forgives a lull, the paper's does not.
    config : path, optional
        All settings, in TOML, such as the daemon's ``/etc/mlrd.toml``; arguments override it.
    in_body_axes : bool, optional
        Whether the samples are in the body's axes already, so that the mounting of `config` is not
        applied once more.
    notes : sequence of str, optional
        What is known of how the samples were read; comes first among the answer's warnings.
    log : str, optional
        A name for the recording, in the answer and in messages.

    Returns
    -------
    Detection
        The object that ``mlr-ga detect --json`` prints. ``damage_s`` is the time at which damage was
        flagged, or None.

    Raises
    ------
    BadInput
        An argument or a file makes no sense; the command line ends with exit status 2.
    CannotAnswer
        The recording cannot answer; the command line ends with exit status 1.
    """
    recording = columns(
        {
            "t": t,
            "roll": roll,
            "pitch": pitch,
            "yaw": yaw,
            "acceleration": acceleration,
            "angular_rate": angular_rate,
            "in_body_axes": in_body_axes,
            "notes": notes,
            "log": log,
        }
    )
    options = {"method": method, "config": config}
    return cast(Detection, json.loads(_mlr.detect(recording, options, running(1, None))))
