"""Draws robots that their owners know: a healthy walk, and another day's walk of the same robot.

    python tools/plant/owned.py --seed N --count M [--first I] [--set undisturbed] [--joints calibration.csv] -o DIR

`robot-III-healthy` lasts 20 s. `robot-III-day` is drawn as a set of draw.py: `effects`, one effect or two, or none, on
a whole or damaged robot, or `undisturbed`. `robot-III-motion`, with --joints, is the robot on a third day as it plays that file.
`truth.json` is about the day's walks, in draw.py's form; `plant` in it holds the robot's own settings. `spread` in `trace` is
that of robots of the make: what changes less may well stand out from what is known of this robot.
What belongs to a day is drawn anew for each log: the ground, the sensor's biases, the charge of the battery,
when the robot starts.
"""

import argparse
import copy
import dataclasses
import json
import time
from pathlib import Path

import numpy as np

import draw
from gait import JointFile
from play import REST_S
from robot import JETHEXA, LINKS
from settings import draw_plant
from walk import record

HEALTHY_S = 20.0
CHARGE = 0.05  # of the servos' stiffness, from day to day


def of_day(rng, plant, anew):
    """The robot on another day."""
    return dataclasses.replace(
        copy.deepcopy(plant), mu=anew.mu, gyro_bias=anew.gyro_bias, acc_bias=anew.acc_bias, start=anew.start,
        contact_time_s=plant.contact_time_s, kp=plant.kp * (1.0 + rng.uniform(-CHARGE, CHARGE)),
    )


def robot(seed, index, days, joints=None):
    """The name of each log of a robot with its walk, and the truth of the day's."""
    rng = np.random.default_rng([seed, 7919, index])
    siblings = copy.deepcopy(rng)
    with draw.effects.none():
        intact, plain, _ = draw.SETS[days](siblings, index)
    _, plant, found = draw.SETS[days](rng, index)
    whole = [LINKS] * len(intact)
    healthy = dataclasses.replace(of_day(rng, plain, draw_plant(rng, whole)), locked=False, walk_s=HEALTHY_S)
    walks = {"healthy": record(healthy, whole, rng)}
    noise = copy.deepcopy(rng)
    walks["day"] = record(plant, intact, rng)
    if joints:
        played = dataclasses.replace(
            of_day(rng, plain, draw_plant(rng, whole)), locked=False, joints=str(joints),
            walk_s=JointFile(joints, JETHEXA).length_s + REST_S,
        )
        walks["motion"] = record(played, whole, rng)
    truth = draw.truth(intact, plant, found, walks["day"])
    if found:
        truth["trace"] = draw.trace(plain, intact, walks["day"], noise, siblings)
    return walks, truth


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seed", type=int, required=True)
    parser.add_argument("--count", type=int, required=True)
    parser.add_argument("--first", type=int, default=0, help="draw from this robot on, and add them to those that are there")
    parser.add_argument("--set", choices=("effects", "undisturbed"), default="effects")
    parser.add_argument("--joints", type=Path)
    parser.add_argument("-o", "--output", type=Path, required=True)
    args = parser.parse_args()
    args.output.mkdir(parents=True, exist_ok=True)
    known, began = args.output / "truth.json", time.monotonic()
    truths = draw.truths_before(known, args.first)
    for index in range(args.first, args.count):
        walks, truth = robot(args.seed, index, args.set, args.joints)
        for name, walk in walks.items():
            draw.write(args.output / f"robot-{index:03}-{name}.csv.gz", walk.columns)
        truths[f"robot-{index:03}-day"] = truth
        known.write_text(json.dumps(truths, indent=1) + "\n")
    print(f"{args.count - args.first} robots in {time.monotonic() - began:.1f} s")


if __name__ == "__main__":
    main()
