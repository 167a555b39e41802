"""Records a robot that plays a file of joint angles, after standing as the other logs do.

    python tools/plant/play.py joints.csv --seed N -o LOG.csv.gz

The robot is that of log `--index` of `draw.py undisturbed --seed N`: any damage, as it was
assembled, nothing else wrong. `--healthy` leaves it whole; `--nominal` takes a whole robot as
it is described instead, with the noise of its sensor.
"""

import argparse
import json
from pathlib import Path

import numpy as np

from draw import SETS, robot_with, truth, without, write
from gait import JointFile
from robot import JETHEXA
from settings import as_described, assemble
from walk import record

REST_S = 1.0  # recorded after the last row of a file that does not repeat
REPEATING_S = 10.0  # recorded of one that does


def robot(rng, index, nominal, healthy):
    """Links left on each leg, and the plant."""
    if nominal:
        return without([]), as_described()
    if healthy:
        return without([]), assemble(rng, robot_with(rng, without([])))
    intact, plant, _ = SETS["undisturbed"](rng, index)
    return intact, plant


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("joints", type=Path)
    parser.add_argument("--seed", type=int, required=True)
    parser.add_argument("--index", type=int, default=0)
    whole = parser.add_mutually_exclusive_group()
    whole.add_argument("--nominal", action="store_true")
    whole.add_argument("--healthy", action="store_true")
    parser.add_argument("--duration", type=float, metavar="S", help="from the first row to the end of the log")
    parser.add_argument("--truth", type=Path, help="JSON to write what was done to the robot into, beside other logs'")
    parser.add_argument("-o", "--output", type=Path, required=True)
    args = parser.parse_args()
    file = JointFile(args.joints, JETHEXA)
    rng = np.random.default_rng([args.seed, list(SETS).index("undisturbed"), args.index])
    intact, plant = robot(rng, args.index, args.nominal, args.healthy)
    plant.joints = str(args.joints)
    plant.walk_s = args.duration or (REPEATING_S if file.repeat else file.length_s + REST_S)
    walk = record(plant, intact, rng)
    write(args.output, walk.columns)
    if args.truth:
        truths = json.loads(args.truth.read_text()) if args.truth.exists() else {}
        truths[args.output.name.removesuffix(".gz").removesuffix(".csv")] = truth(intact, plant, [], walk)
        args.truth.write_text(json.dumps(truths, indent=1) + "\n")


if __name__ == "__main__":
    main()
