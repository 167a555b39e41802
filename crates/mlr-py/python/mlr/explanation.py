"""What else is wrong with a robot."""

import json
from collections.abc import Sequence
from typing import Literal, cast

from numpy.typing import ArrayLike

from . import _mlr
from ._arguments import Path, Progress, columns, paths, running
from .answers import Explanation


def explain(
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
    start_s: float | None = None,
    atlas: Path | None = None,
    config: Path | None = None,
    explanation: Path | None = None,
    after: Explanation | None = None,
    threads: int | None = None,
    progress: Progress | None = None,
    in_body_axes: bool = False,
    notes: Sequence[str] = (),
    log: str = "",
) -> Explanation:
    """Say how probable it is that an effect which the model lacks made the robot walk as recorded.

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
    start_s : float, optional
        Time at which the robot was commanded to walk, where that is known: a delay of servos or sensor
        shows only then.
    atlas : path, optional
        Walks simulated beforehand by ``mlr-ga atlas build``.
    config : path, optional
        All settings, in TOML, such as the daemon's ``/etc/mlrd.toml``; arguments override it.
    explanation : path, optional
        All settings of the explanation, in TOML, instead of those of `config`.
    after : Explanation, optional
        What was found in an earlier recording of this robot on the same day: which effects it may have is taken
        from there, so that both count.
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
    Explanation
        The object that ``mlr-ga explain --json`` prints: among others ``effects``, most probable
        together, ``effect_probability`` by kind, and the errors before and after in degrees.

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
    options = {
        "search": search,
        "seed": seed,
        "start_s": start_s,
        "atlas": atlas,
        "config": config,
        "explanation": explanation,
        "after": None if after is None else json.dumps(after),
    }
    model = {"robot": robot, "gait": paths(gait)}
    answer = _mlr.explain(recording, options, model, running(threads, progress))
    return cast(Explanation, json.loads(answer))
