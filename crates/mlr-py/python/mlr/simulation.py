"""Logs from the model."""

import json
from collections.abc import Iterable, Sequence
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from . import _mlr
from ._arguments import Path, paths, running
from .answers import Simulation
from .errors import BadInput


class SimulatedWalk(Simulation):
    """What is said of a simulated log, and the log."""

    t: NDArray[np.float64]
    roll: NDArray[np.float64]
    pitch: NDArray[np.float64]
    yaw: NDArray[np.float64]


def simulate(
    *,
    legs_lost: int | Iterable[int] | None = None,
    morphology: str | Sequence[Sequence[int]] | None = None,
    lost_links: Literal["absent", "locked"] = "absent",
    stand_s: float = 2.0,
    walk_s: float = 10.0,
    time_step_s: float = 0.002,
    friction: float | None = None,
    joint_friction_nm: float = 0.0,
    backlash_rad: float = 0.0,
    slope_deg: float = 0.0,
    uphill_deg: float = 0.0,
    rubble_m: float | None = None,
    seed: int = 1,
    robot: Path | None = None,
    gait: Path | None = None,
) -> SimulatedWalk:
    """Simulate what the sensor of a robot records that stands and then walks.

    Parameters
    ----------
    legs_lost : int or iterable of int, optional
        Numbers of the legs, from 1, that are lost altogether.
    morphology : str or nested sequence of int, optional
        The existence numbers of all links: ``"111 110 000 111 111 111"``, or one list for each leg
        from the body outward, as answers have them.
    lost_links : {"absent", "locked"}, optional
        What became of lost links.
    stand_s, walk_s : float, optional
        How long the robot stands first and walks then, in seconds.
    time_step_s : float, optional
        Time between two samples, and of a simulation step, in seconds.
    friction : float, optional
        Friction between feet and ground; 0.7 by default.
    joint_friction_nm : float, optional
        Dry friction in every joint beyond the described one, in N m.
    backlash_rad : float, optional
        Play in every joint beyond the described one, in radians.
    slope_deg, uphill_deg : float, optional
        Inclination of the ground, and the direction in which it rises, counter-clockwise from straight
        ahead, in degrees.
    rubble_m : float, optional
        Height of rubble on the ground, in metres.
    seed : int, optional
        Chooses the rubble.
    robot : path, optional
        Robot description in TOML; the embedded JetHexa by default.
    gait : path, optional
        Gait in TOML, or ``"tripod"`` for the embedded one, which is the default.

    Returns
    -------
    SimulatedWalk
        The object that ``mlr-ga simulate --json`` prints of a log in no file, with the log: ``t``
        in seconds and ``roll``, ``pitch``, ``yaw`` in radians, each of shape (n,).

    Raises
    ------
    BadInput
        An argument or a file makes no sense; the command line ends with exit status 2.
    """
    if legs_lost is not None and morphology is not None:
        raise BadInput("legs_lost, morphology: expected one of them, not both")
    legs = [legs_lost] if isinstance(legs_lost, (int, np.integer)) else legs_lost
    options = {
        "legs_lost": None if legs is None else ",".join(str(leg) for leg in legs),
        "morphology": morphology if morphology is None else _vector(morphology),
        "lost_links": lost_links,
        "stand_s": stand_s,
        "walk_s": walk_s,
        "time_step_s": time_step_s,
        "friction": friction,
        "joint_friction_nm": joint_friction_nm,
        "backlash_rad": backlash_rad,
        "slope_deg": slope_deg,
        "uphill_deg": uphill_deg,
        "rubble_m": rubble_m,
        "seed": seed,
    }
    model = {"robot": robot, "gait": paths(gait)}
    report, (t, roll, pitch, yaw) = _mlr.simulate(options, model, running(1, None))
    said: Simulation = json.loads(report)
    return {**said, "t": t, "roll": roll, "pitch": pitch, "yaw": yaw}


def _vector(morphology: str | Sequence[Sequence[int]]) -> str:
    """A morphology as the command line takes it."""
    if isinstance(morphology, str):
        return morphology
    return " ".join("".join(str(int(link)) for link in leg) for leg in morphology)
