"""Which legs a legged robot has lost, and what else its model lacks, from its body IMU.

Units are SI throughout: time in seconds, angles in radians, acceleration in m/s², angular rate in rad/s.
What is in another unit says so in its name: ``slope_deg``, ``error_deg``. Legs are numbered from 1.

Answers are dictionaries: the JSON objects that the command line ``mlr-ga`` prints with ``--json``. While
a function computes, other Python threads run, and Ctrl-C interrupts it.
"""

from . import answers
from ._mlr import VERSION as __version__
from .calibration import CalibratedRobot, calibrate
from .detection import detect
from .errors import BadInput, CannotAnswer, Error
from .explanation import explain
from .identification import identify, identify_together
from .logs import ReadRecording, Recording, read_log
from .simulation import SimulatedWalk, simulate

__all__ = [
    "BadInput",
    "CalibratedRobot",
    "CannotAnswer",
    "Error",
    "ReadRecording",
    "Recording",
    "SimulatedWalk",
    "__version__",
    "answers",
    "calibrate",
    "detect",
    "explain",
    "identify",
    "identify_together",
    "read_log",
    "simulate",
]
