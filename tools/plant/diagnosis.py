"""What a diagnosis motion tells of robots of the plant that lost links.

    python tools/plant/diagnosis.py target/release/mlr-ga [--robots 12] [--seed 1] [--probes 1] [--atlas FILE] -o DIR

Each robot, drawn as it is assembled, lost one to three links of one leg, or of two legs every third time;
they are gone or locked. It walks its nominal gait (`mlr-ga identify`); what that leaves open is asked by
a motion (`mlr-ga probe`) that the robot plays; then all logs are identified together, and with
`--probes 2` asked again. A robot whose logs leave nothing open plays nothing. Tilt is that of the true pose.
"""

import argparse
import json
import math
import statistics
import subprocess
import sys
from pathlib import Path

import numpy as np

from draw import robot_with, some_legs, without, write
from gait import JointFile
from robot import JETHEXA, LINKS
from settings import assemble
from walk import placed, record, steps

REST_S = 1.0  # recorded after the motion
WALK_S = 10.0


def drawn(seed, index):
    """Links left on each leg, and the robot."""
    rng = np.random.default_rng([seed, 78, index])
    intact = without([])
    for leg in some_legs(rng, 2 if index % 3 == 2 else 1):
        intact[leg - 1] = int(rng.integers(0, LINKS))
    return intact, assemble(rng, robot_with(rng, intact))


def set_motion(plant, joints):
    """Lets the robot walk its nominal gait, or play a file where one is given."""
    plant.joints, plant.walk_s = None, WALK_S
    if joints:
        plant.joints, plant.walk_s = str(joints), JointFile(joints, JETHEXA).length_s + REST_S


def recorded(path, seed, index, joints):
    """The log of the robot that walks, or plays a file."""
    intact, plant = drawn(seed, index)
    set_motion(plant, joints)
    rng = np.random.default_rng([seed, 79, index, int(bool(joints))])
    write(path, record(plant, intact, rng).columns)


def tilt_deg(plant, intact, joints):
    """Greatest angle between the body's z axis and the vertical while the robot plays the file."""
    set_motion(plant, joints)
    data, servos = placed(plant, intact)
    upright = min(data.body("body").xmat[8] for t in steps(plant, data, servos) if t >= 0)
    return math.degrees(math.acos(min(1.0, upright)))


def run(command):
    """The JSON that the program prints."""
    done = subprocess.run(list(map(str, command)), capture_output=True, text=True)
    if done.returncode != 0:
        raise RuntimeError(f"{' '.join(map(str, command))}: {done.stderr.strip()}")
    return json.loads(done.stdout)


def summary(answer, intact):
    """How many morphologies the answer leaves open, whether the truth is first, and among them."""
    truth = [[int(link < left) for link in range(LINKS)] for left in intact]
    listed = [answer["morphology"], *answer["indistinguishable"]]
    return len(listed), answer["morphology"] == truth, truth in listed


def text(of):
    count, first, listed = of
    return f"{count} | {'first' if first else 'listed' if listed else 'missing'}"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program", type=Path)
    parser.add_argument("--robots", type=int, default=12)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--probes", type=int, default=1)
    parser.add_argument("--atlas", type=Path)
    parser.add_argument("-o", "--output", type=Path, required=True, help="directory of the logs and motions; those that are there are not made again")
    args = parser.parse_args()
    args.output.mkdir(parents=True, exist_ok=True)
    atlas = ["--atlas", args.atlas] if args.atlas else []
    before, after, tilts = [], [], []
    print("| robot | lost | open | truth | motion s | nats expected | tilt ° | then open | truth |")
    print("|--:|:--|--:|:--|--:|--:|--:|--:|:--|")
    for index in range(args.robots):
        intact, plant = drawn(args.seed, index)
        lost = ", ".join(f"{leg + 1}: {LINKS - left}" for leg, left in enumerate(intact) if left < LINKS)
        lost += " locked" if plant.locked else " gone"
        logs, gaits = [args.output / f"{index}-walk.csv.gz"], ["tripod"]
        if not logs[0].exists():
            recorded(logs[0], args.seed, index, None)
        answer = run([args.program, "identify", *logs, "--json", *atlas])
        before.append(summary(answer, intact))
        row = f"| {index} | {lost} | {text(before[-1])} |"
        for number in range(1, args.probes + 1):
            motion, joints, report = (args.output / f"{index}-probe-{number}.{end}" for end in ("toml", "csv", "json"))
            each = [option for gait in gaits for option in ("--gait", gait)]
            if not report.exists():
                report.write_text(json.dumps(run(
                    [args.program, "probe", *logs, *each, "-o", motion, "--joints", joints, "--json", *atlas])))
            told = json.loads(report.read_text())
            if not motion.exists():
                row += f" {'sure' if told['sure'] else 'none'} | {told['entropy_before_nats']:.2f} | |"
                break
            log = args.output / f"{index}-probe-{number}-log.csv.gz"
            if not log.exists():
                recorded(log, args.seed, index, joints)
            lost_on, fresh = drawn(args.seed, index)
            tilts.append(tilt_deg(fresh, lost_on, joints))
            row += f" {told['duration_s']:.1f} | {told['entropy_before_nats']:.2f} to {told['entropy_after_nats']:.2f} | {tilts[-1]:.1f} |"
            logs.append(log)
            gaits.append(motion)
            each = [option for gait in gaits for option in ("--gait", gait)]
            answer = run([args.program, "identify", *logs, *each, "--json", *atlas])
            if number < args.probes:
                row += f" {text(summary(answer, intact))} |"
        after.append(summary(answer, intact))
        print(f"{row} {text(after[-1])} |")
        sys.stdout.flush()
    for name, each in (("walk", before), ("with the motion", after)):
        first, listed = (sum(one[k] for one in each) for k in (1, 2))
        median = statistics.median(one[0] for one in each)
        print(f"\n{name}: median of {median:g} open, truth first on {first}, listed on {listed} of {len(each)}")
    if tilts:
        print(f"\ngreatest tilt {max(tilts):.1f}°")


if __name__ == "__main__":
    main()
