"""Which legs are damaged."""

import json
from collections.abc import Sequence
from typing import Literal, cast

from numpy.typing import ArrayLike

from . import _mlr
from ._arguments import Path, Progress, columns, paths, running
from .answers import Identification
from .logs import ReadRecording, Recording


def identify(
    t: ArrayLike,
    roll: ArrayLike | None = None,
    pitch: ArrayLike | None = None,
    yaw: ArrayLike | None = None,
    *,
    acceleration: ArrayLike | None = None,
    angular_rate: ArrayLike | None = None,
    robot: Path | None = None,
    gait: Path | None = None,
    search: Literal["ga", "exact", "atlas"] | None = None,
    seed: int = 1,
    method: Literal["mlr", "paper"] | None = None,
    repeats: int | None = None,
    window_s: float | None = None,
    from_s: float | None = None,
    lost_links: Literal["absent", "locked", "either"] | None = None,
    friction: float | None = None,
    atlas: Path | None = None,
    config: Path | None = None,
    threads: int | None = None,
    progress: Progress | None = None,
    in_body_axes: bool = False,
    notes: Sequence[str] = (),
    log: str = "",
) -> Identification:
    """Name the damaged legs of the robot that made a recording while it walked.

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
    robot : path, optional
        Robot description in TOML; the embedded JetHexa by default.
    gait : path, optional
        Gait in TOML, or ``"tripod"`` for the embedded one, which is the default.
    search : {"ga", "exact", "atlas"}, optional
        How the morphologies are searched; in the atlas where there is one, else by the genetic
        algorithm.
    seed : int, optional
        Makes every run repeatable.
    method : {"mlr", "paper"}, optional
        What decides: the most probable morphology, or the paper's cost F.
    repeats : int, optional
        How often the genetic algorithm runs: once, or ten times by the paper's method.
    window_s : float, optional
        Length of the compared stretch, in seconds; 5 by default.
    from_s : float, optional
        Time at which the compared stretch begins; by default the start of the walk, or when damage
        is flagged in mid-walk.
    lost_links : {"absent", "locked", "either"}, optional
        What lost links may have become; either by default.
    friction : float, optional
        Friction between feet and ground; 0.7 by default.
    atlas : path, optional
        Walks simulated beforehand by ``mlr-ga atlas build``.
    config : path, optional
        All settings, in TOML, such as the daemon's ``/etc/mlrd.toml``; arguments override it.
    threads : int, optional
        Threads to use; one per core by default. The answer does not depend on it.
    progress : callable, optional
        Called about every 50 ms with the steps done and expected, from the calling thread. What it
        raises ends the call.
    in_body_axes : bool, optional
        Whether the samples are in the body's axes already, so that the mounting of `config` is not
        applied once more.
    notes : sequence of str, optional
        What is known of how the samples were read; comes first among the answer's warnings.
    log : str, optional
        A name for the recording, in the answer and in messages.

    Returns
    -------
    Identification
        The object that ``mlr-ga identify --json`` prints: among others ``morphology``, one list of
        existence numbers for each leg, ``damaged_legs``, numbered from 1, and
        ``leg_damage_probability``.

    Raises
    ------
    BadInput
        An argument or a file makes no sense; the command line ends with exit status 2.
    CannotAnswer
        The recording cannot answer; the command line ends with exit status 1.

    Examples
    --------
    >>> walk = mlr.simulate(legs_lost=[3, 4])
    >>> mlr.identify(walk["t"], walk["roll"], walk["pitch"], walk["yaw"])["damaged_legs"]
    [3, 4]
    """
    recording: Recording = {
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
    return identify_together(
        [recording],
        robot=robot,
        gait=gait,
        search=search,
        seed=seed,
        method=method,
        repeats=repeats,
        window_s=window_s,
        from_s=from_s,
        lost_links=lost_links,
        friction=friction,
        atlas=atlas,
        config=config,
        threads=threads,
        progress=progress,
    )


def identify_together(
    recordings: Sequence[Recording | ReadRecording],
    *,
    robot: Path | None = None,
    gait: Path | Sequence[Path] | None = None,
    search: Literal["ga", "exact", "atlas"] | None = None,
    seed: int = 1,
    method: Literal["mlr", "paper"] | None = None,
    repeats: int | None = None,
    window_s: float | None = None,
    from_s: float | None = None,
    lost_links: Literal["absent", "locked", "either"] | None = None,
    friction: float | None = None,
    atlas: Path | Sequence[Path] | None = None,
    config: Path | None = None,
    threads: int | None = None,
    progress: Progress | None = None,
) -> Identification:
    """Name the damaged legs of one robot from several recordings.

    Nothing more may have been damaged between them: every morphology in question is compared with all.

    Parameters
    ----------
    recordings : sequence of Recording
        Dictionaries whose keys are the arguments of :func:`mlr.identify` that hold samples, such as
        :func:`mlr.read_log` returns.
    gait : path or sequence of paths, optional
        One gait for all recordings, or one for each in their order.
    atlas : path or sequence of paths, optional
        Walks simulated beforehand, one file for each gait.
    robot, search, seed, method, repeats, window_s, from_s, lost_links, friction, config, threads, progress
        As in :func:`mlr.identify`. `from_s` is of one recording only.

    Returns
    -------
    Identification
        The object that ``mlr-ga identify --json`` prints.

    Raises
    ------
    BadInput
        An argument or a file makes no sense; the command line ends with exit status 2.
    CannotAnswer
        The recording cannot answer; the command line ends with exit status 1.
    """
    options = {
        "search": search,
        "seed": seed,
        "method": method,
        "repeats": repeats,
        "window_s": window_s,
        "from_s": from_s,
        "lost_links": lost_links,
        "friction": friction,
        "atlas": paths(atlas),
        "config": config,
    }
    model = {"robot": robot, "gait": paths(gait)}
    logs = [columns(recording) for recording in recordings]
    answer = _mlr.identify(logs, options, model, running(threads, progress))
    return cast(Identification, json.loads(answer))
