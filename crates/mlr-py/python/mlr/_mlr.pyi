"""The native half. What its dictionaries hold is what its callers in this package put in."""

from collections.abc import Mapping, Sequence
from os import PathLike
from typing import Any

import numpy as np
from numpy.typing import NDArray

VERSION: str

def identify(
    recordings: Sequence[Mapping[str, Any]],
    options: Mapping[str, Any],
    model: Mapping[str, Any],
    running: Mapping[str, Any],
) -> str: ...
def explain(
    recording: Mapping[str, Any],
    options: Mapping[str, Any],
    model: Mapping[str, Any],
    running: Mapping[str, Any],
) -> str: ...
def detect(
    recording: Mapping[str, Any],
    options: Mapping[str, Any],
    running: Mapping[str, Any],
) -> str: ...
def simulate(
    options: Mapping[str, Any],
    model: Mapping[str, Any],
    running: Mapping[str, Any],
) -> tuple[str, list[NDArray[np.float64]]]: ...
def calibrate(
    recordings: Sequence[Mapping[str, Any]],
    options: Mapping[str, Any],
    model: Mapping[str, Any],
    running: Mapping[str, Any],
) -> tuple[str, str]: ...
def read_log(
    path: str | PathLike[str],
    options: Mapping[str, Any],
    running: Mapping[str, Any],
) -> dict[str, Any]: ...
