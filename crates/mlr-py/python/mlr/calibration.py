"""A robot's own parameters."""

import json
from collections.abc import Sequence
from typing import cast

from . import _mlr
from ._arguments import Path, Progress, columns, paths, running
from .answers import Calibration
from .errors import BadInput
from .logs import ReadRecording, Recording


class CalibratedRobot(Calibration):
    """A calibration, and the robot's description with its own numbers."""

    description: str


def calibrate(
    recordings: Sequence[Recording | ReadRecording],
    *,
    gait: Path | Sequence[Path] | None = None,
    robot: Path | None = None,
    healthy: bool = False,
    measured: Sequence[str] = (),
    output: Path | None = None,
    config: Path | None = None,
    threads: int | None = None,
    progress: Progress | None = None,
) -> CalibratedRobot:
    """Find the robot's own parameters in walks in which nothing is wrong with it.

    Parameters
    ----------
    recordings : sequence of Recording
        The walks: dictionaries whose keys are the arguments of :func:`mlr.identify` that hold samples,
        such as :func:`mlr.read_log` returns.
    gait : path or sequence of paths, optional
        One gait for all walks, or one for each in their order; the embedded tripod by default.
    robot : path, optional
        Robot description in TOML; the embedded JetHexa by default.
    healthy : bool, optional
        Do not look for damage and effects first: take the caller's word that nothing was wrong.
    measured : sequence of str, optional
        Numbers of the robot that were measured on a bench, as in ``"body_mass=1.412+-0.005"``.
    output : path, optional
        Write the description to this file too. An existing file is never overwritten.
    config : path, optional
        All settings, in TOML, such as the daemon's ``/etc/mlrd.toml``; arguments override it.
    threads : int, optional
        Threads to use; one per core by default. The answer does not depend on it.
    progress : callable, optional
        Called about every 50 ms with the steps done and expected, from the calling thread. What it
        raises ends the call.

    Returns
    -------
    CalibratedRobot
        The object that ``mlr-ga calibrate --json`` prints, and ``description``: the robot's
        description in TOML, which every function takes from a file as `robot`.

    Raises
    ------
    BadInput
        An argument or a file makes no sense; the command line ends with exit status 2.
    CannotAnswer
        The recording cannot answer; the command line ends with exit status 1.
    """
    if not recordings:
        raise BadInput("recordings: none, expected at least one")
    options = {
        "healthy": healthy,
        "measured": list(measured),
        "output": output,
        "config": config,
    }
    model = {"robot": robot, "gait": paths(gait)}
    logs = [columns(recording) for recording in recordings]
    report, description = _mlr.calibrate(logs, options, model, running(threads, progress))
    return {**cast(Calibration, json.loads(report)), "description": description}
