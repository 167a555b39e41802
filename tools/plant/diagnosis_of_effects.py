"""What a diagnosis motion tells of two effects that look alike in a walk.

    python tools/plant/diagnosis_of_effects.py target/release/mlr-ga [--robots 12] [--seed 1] [--only PAIR] [--ask] -o DIR

Each robot, drawn as it is assembled, has all its links and one of two effects that a nominal walk hardly tells
apart: a slope or a tilted sensor, a payload or a pull, soft servos or soft ground. It walks its nominal gait
(`mlr-ga explain`); what that leaves open is asked by a motion (`mlr-ga probe --explanation`) that the robot
plays; then that log is explained after the first answer (`mlr-ga explain --after`). With `--ask`
both effects of the pair are asked about whatever the first answer says. Tilt is that of the true
pose.
"""

import argparse
import json
import sys
from pathlib import Path

import numpy as np

import effects
from diagnosis import run, set_motion, tilt_deg
from draw import robot_with, without, write
from settings import assemble
from walk import record

PAIRS = {
    "slope": ("slope", "imu_misalignment"),
    "payload": ("payload", "external_force"),
    "servos": ("servo_stiffness", "ground_compliance"),
}


def drawn(seed, pair, index):
    """Links left on each leg, the robot, and the effect that it has."""
    rng = np.random.default_rng([seed, 81, list(PAIRS).index(pair), index])
    intact = without([])
    plant = assemble(rng, robot_with(rng, intact))
    kind = PAIRS[pair][index % 2]
    return intact, plant, effects.apply(plant, kind, effects.draw(rng, kind, True, intact))


def recorded(path, seed, pair, index, joints):
    """The log of the robot that walks, or plays a file."""
    intact, plant, _ = drawn(seed, pair, index)
    set_motion(plant, joints)
    rng = np.random.default_rng([seed, 82, list(PAIRS).index(pair), index, int(bool(joints))])
    write(path, record(plant, intact, rng).columns)


def asked(report, command):
    """The answer of a command, kept in a file."""
    if not report.exists():
        report.write_text(json.dumps(run(command)))
    return json.loads(report.read_text())


def said(answer, kind, rival):
    """What an answer says of both effects, and whether the right one is the more probable one."""
    of = answer["effect_probability"]
    return f"{of[kind]:.2f}, {of[rival]:.2f}", of[kind] > of[rival]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program", type=Path)
    parser.add_argument("--robots", type=int, default=10, help="of each pair of effects")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", choices=PAIRS)
    parser.add_argument("--ask", action="store_true", help="ask about both effects of the pair in any case")
    parser.add_argument("-o", "--output", type=Path, required=True, help="directory of the logs and answers; those that are there are not made again")
    args = parser.parse_args()
    args.output.mkdir(parents=True, exist_ok=True)
    print("| pair | robot | effect | P by the walk: it, the other | motion s | nats expected | tilt ° | P after the motion |")
    print("|:--|--:|:--|--:|--:|--:|--:|--:|")
    for pair in [args.only] if args.only else PAIRS:
        before, after, tilts = [], [], []
        for index in range(args.robots):
            _, _, effect = drawn(args.seed, pair, index)
            kind = effect["kind"]
            rival = next(other for other in PAIRS[pair] if other != kind)
            path = lambda name: args.output / f"{pair}-{index}-{name}"  # noqa: E731
            log = path("walk.csv.gz")
            if not log.exists():
                recorded(log, args.seed, pair, index, None)
            first = path("walk.json")
            answer = asked(first, [args.program, "explain", log, "--json"])
            of_walk, right = said(answer, kind, rival)
            before.append(right)
            motion, joints = path("probe.toml"), path("probe.csv")
            of_pair = ["--ask", ",".join(PAIRS[pair])] if args.ask else []
            told = asked(path("probe.json"), [
                args.program, "probe", "--explanation", first, *of_pair, "-o", motion, "--joints", joints, "--json"])
            parameters = ", ".join(f"{name} {value:.3g}" for name, value in effect["parameters"].items())
            row = f"| {pair} | {index} | {kind} {parameters} | {of_walk} |"
            if motion.exists():
                log = path("probe-log.csv.gz")
                if not log.exists():
                    recorded(log, args.seed, pair, index, joints)
                intact, plant, _ = drawn(args.seed, pair, index)
                tilts.append(tilt_deg(plant, intact, joints))
                row += f" {told['duration_s']:.1f} | {told['entropy_before_nats']:.2f} to {told['entropy_after_nats']:.2f} | {tilts[-1]:.1f} |"
                answer = asked(path("both.json"), [
                    args.program, "explain", log, "--gait", motion, "--after", first, "--json"])
            else:
                row += f" {'sure' if told['sure'] else 'none'} | {told['entropy_before_nats']:.2f} | |"
            of_both, right = said(answer, kind, rival)
            after.append(right)
            print(f"{row} {of_both} |")
            sys.stdout.flush()
        print(f"\n{pair}: told apart by the walk on {sum(before)}, after the motion on {sum(after)} of {len(after)};"
              f" greatest tilt {max(tilts, default=0.0):.1f}°\n")


if __name__ == "__main__":
    main()
