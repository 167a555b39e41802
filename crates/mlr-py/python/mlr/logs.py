"""Recordings, and the files that hold them."""

from collections.abc import Sequence
from typing import Any, TypedDict, cast

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _mlr
from ._arguments import Path, running


class _Times(TypedDict):
    t: ArrayLike


class Recording(_Times, total=False):
    """What a body's sensor recorded.

    The keys are the arguments of :func:`mlr.identify`, :func:`mlr.explain` and :func:`mlr.detect`,
    which take it as ``mlr.identify(**recording)``.
    """

    roll: ArrayLike | None
    pitch: ArrayLike | None
    yaw: ArrayLike | None
    acceleration: ArrayLike | None
    angular_rate: ArrayLike | None
    in_body_axes: bool
    notes: Sequence[str]
    log: str


class _ReadTimes(TypedDict):
    t: NDArray[np.float64]
    in_body_axes: bool
    notes: list[str]
    log: str


class ReadRecording(_ReadTimes, total=False):
    """A :class:`Recording` that was read from a file: its samples are arrays."""

    roll: NDArray[np.float64]
    pitch: NDArray[np.float64]
    yaw: NDArray[np.float64]
    acceleration: NDArray[np.float64]
    angular_rate: NDArray[np.float64]


def read_log(
    path: Path,
    *,
    column: Sequence[str] = (),
    topic: str | None = None,
    max_rows: int | None = None,
) -> ReadRecording:
    """Read a log: .csv, .csv.gz, a ROS 1 .bag or an .mcap.

    Parameters
    ----------
    path : path
        The log.
    column : sequence of str, optional
        Foreign columns as ``--column`` of the command line takes them:
        ``"QUANTITY=NAME[,UNIT]"``, as in ``"roll=euler.x,deg"``.
    topic : str, optional
        The topic of a bag or an MCAP file; needed where several hold ``sensor_msgs/Imu``.
    max_rows : int, optional
        The most rows that are read; a longer log is refused.

    Returns
    -------
    ReadRecording
        ``t`` in seconds; ``roll``, ``pitch``, ``yaw`` in radians where the log holds an orientation;
        ``acceleration`` in m/s² and ``angular_rate`` in rad/s, both of shape (n, 3), where it holds
        raw samples; ``log``, the path; ``notes`` on how it was read.

    Raises
    ------
    BadInput
        The log cannot be read; the message names file, line and column.

    Examples
    --------
    >>> answer = mlr.identify(**mlr.read_log("walk.csv.gz"))
    """
    options: dict[str, Any] = {"column": list(column), "topic": topic, "max_rows": max_rows}
    return cast(ReadRecording, _mlr.read_log(path, options, running(1, None)))
