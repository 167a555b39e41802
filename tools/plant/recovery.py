"""How recovery gaits walk on robots of the plant, beside the nominal gait on the same robots.

    python tools/plant/recovery.py target/release/mlr-ga [--robots 4] [--seed 1] [--cases 3 1,4 weak:2:0.25 stuck:3:2:0.1] [-o DIR]

Every case is a damage that is known: legs that are lost, a weak leg with what is left of its strength,
or a stuck joint with its angle. For each, `mlr-ga recover` finds a gait; robots with this damage are
drawn as they are assembled, play it and the nominal gait, and are measured from their true pose.
Then `mlr-ga steer` steers the gait by the log of each robot's sensor, and the robot plays what it gets.
"""

import argparse
import json
import math
import subprocess
import sys
import time
from pathlib import Path

import numpy as np

import effects
from draw import without, write
from gait import JointFile
from robot import JETHEXA, LINKS, STEP_S
from settings import assemble, draw_plant
from walk import placed, record, steps

WINDOW_S, SHIFT_S = 0.5, 0.1  # of the damage detector
SAMPLE_S = 0.01
WALK_S = 10.0  # measured, from the first row that repeats on
NOMINAL_PERIOD_S = 1.0
SINGLES = [str(leg) for leg in range(1, 7)]
PAIRS = [f"{a},{b}" for a in range(1, 7) for b in range(a + 1, 7)]
FAULTS = ["weak:2:0.25", "weak:3:0.2", "weak:5:0.3", "stuck:1:2:0.9", "stuck:4:3:-1.6"]


def damage(case):
    """Links left on each leg, options of the program, and effects of the plant."""
    kind, *numbers = case.split(":")
    if kind == "weak":
        leg, gain = int(numbers[0]), float(numbers[1])
        return without([]), ["--weak-leg", f"{leg}:{gain}"], [("weak_leg", {"leg": leg, "gain": gain})]
    if kind == "stuck":
        leg, joint, angle = int(numbers[0]), int(numbers[1]), float(numbers[2])
        parameters = {"leg": leg, "joint": joint, "angle_rad": angle}
        return without([]), ["--stuck-joint", f"{leg}:{joint}:{angle}"], [("stuck_joint", parameters)]
    legs = [int(leg) for leg in case.split(",")]
    return without(legs), ["--legs-lost", case], []


def poses(plant, intact, until_s):
    """Time, position, roll, pitch and yaw of the body from the first command on."""
    plant.walk_s = until_s
    every = round(SAMPLE_S / STEP_S)
    rows = []
    data, servos = placed(plant, intact)
    for t in steps(plant, data, servos):
        if round(t / STEP_S) % every == 0 and t >= plant.start:
            w, x, y, z = data.qpos[3:7]
            roll = math.atan2(2 * (w * x + y * z), 1 - 2 * (x * x + y * y))
            pitch = math.asin(max(-1.0, min(1.0, 2 * (w * y - z * x))))
            yaw = math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))
            rows.append([t - plant.start, *data.qpos[:3], roll, pitch, yaw])
    rows = np.array(rows)
    rows[:, 6] = np.unwrap(rows[:, 6])
    return rows


def fluctuation_deg(rows):
    """Largest of maximum less minimum of roll or pitch within the window."""
    width, shift = round(WINDOW_S / SAMPLE_S), round(SHIFT_S / SAMPLE_S)
    starts = range(0, max(len(rows) - width, 1), shift)
    return max(math.degrees(np.ptp(rows[s:s + width, 4:6], axis=0).max()) for s in starts)


def measure(rows, from_s, cycle_s):
    """Speed along the heading [m/s], fluctuation [°], drift [°/m] of whole cycles after `from_s`."""
    steady = rows[rows[:, 0] >= from_s - 1e-9]
    per_cycle = cycle_s / SAMPLE_S
    cycles = int((len(steady) - 1) / per_cycle)
    marks = steady[[round(k * per_cycle) for k in range(cycles + 1)]]
    ahead = np.stack([np.cos(marks[:-1, 6]), np.sin(marks[:-1, 6])], axis=1)
    way_m = float((np.diff(marks[:, 1:3], axis=0) * ahead).sum())
    turned_deg = math.degrees(marks[-1, 6] - marks[0, 6])
    duration_s = marks[-1, 0] - marks[0, 0]
    drift = turned_deg / max(abs(way_m), 0.002 * duration_s)
    return way_m / duration_s, fluctuation_deg(steady), drift


def drawn(case, seed, index):
    """A robot with this damage as it was assembled, and the links left on its legs; whole without a case."""
    intact, _, found = damage(case) if case else (without([]), [], [])
    rng = np.random.default_rng([seed, 77, index])
    plant = assemble(rng, draw_plant(rng, intact, JETHEXA))
    for kind, parameters in found:
        effects.apply(plant, kind, parameters)
    return plant, intact


def played(plant, joints):
    """Lets the robot play a file, or its nominal gait without one: when its cycles begin, and how long they take."""
    if joints is None:
        plant.joints, from_s, cycle_s = None, 2 * NOMINAL_PERIOD_S, NOMINAL_PERIOD_S
    else:
        file = JointFile(joints, JETHEXA)
        first, end = file.repeat
        cycle_s = (end - first) * file.row_s
        plant.joints, from_s = str(joints), first * file.row_s + cycle_s / 2
    cycle_s *= plant.period_scale
    plant.walk_s = from_s + max(WALK_S, 4 * cycle_s) + SAMPLE_S
    return from_s, cycle_s


def walk(plant, intact, joints):
    from_s, cycle_s = played(plant, joints)
    rows = poses(plant, intact, plant.walk_s)
    onset = fluctuation_deg(rows[rows[:, 0] < from_s])
    return (*measure(rows, from_s, cycle_s), onset)


def steered(program, plant, intact, joints, rng, name):
    """The joint file of the gait steered by this robot's own log of it, in files of this name."""
    log, gait, after = (joints.with_name(f"{name}.{end}") for end in ("log.csv.gz", "toml", "csv"))
    if not after.exists():
        played(plant, joints)
        write(log, record(plant, intact, rng).columns)
        command = [program, "steer", joints.with_suffix(".json"), log, "-o", gait, "--joints", after]
        subprocess.run(list(map(str, command)), check=True, capture_output=True)
    return after


def recover(program, case, seed, directory):
    """The files of a gait, its report, and the user CPU seconds that it took."""
    name = case.replace(":", "_").replace(",", "-")
    gait, joints, report = (directory / f"{name}.{end}" for end in ("toml", "csv", "json"))
    if not joints.exists():
        import resource

        before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
        _, options, _ = damage(case)
        command = [program, "recover", *options, "-o", gait, "--joints", joints, "--json", "--seed", str(seed)]
        done = subprocess.run(list(map(str, command)), capture_output=True, text=True)
        if done.returncode != 0:
            return None, done.stderr.strip(), 0.0
        answer = json.loads(done.stdout)
        answer["user_s"] = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before
        report.write_text(json.dumps(answer))
    answer = json.loads(report.read_text())
    return joints, answer, answer["user_s"]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program", type=Path)
    parser.add_argument("--robots", type=int, default=4)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--cases", nargs="*", default=[*SINGLES, *PAIRS, *FAULTS])
    parser.add_argument("-o", "--output", type=Path, required=True, help="directory of the gaits; those that are there are not searched again")
    args = parser.parse_args()
    args.output.mkdir(parents=True, exist_ok=True)
    healthy = np.array([walk(*drawn(None, args.seed, index), None) for index in range(args.robots)])
    speed_m_per_s = healthy[:, 0].mean()
    print(
        f"healthy, nominal gait: {1e3 * speed_m_per_s:.0f} mm/s, fluctuation {healthy[:, 1].mean():.1f}°,"
        f" drift {np.abs(healthy[:, 2]).mean():.1f} °/m\n"
    )
    print("| damage | margin mm | speed mm/s | of healthy | fluctuation ° | worst | onset ° | drift °/m | worst | signed | steered: drift | worst | speed | P below 5° | nominal: speed | fluctuation | drift | model: speed | fluctuation | CPU s |")
    print("|:--|" + "--:|" * 19)
    for case in args.cases:
        joints, report, user_s = recover(args.program, case, args.seed, args.output)
        if joints is None:
            print(f"| {case} | {report} |")
            continue
        after, straight, before = [], [], []
        for index in range(args.robots):
            after.append(walk(*drawn(case, args.seed, index), joints))
            before.append(walk(*drawn(case, args.seed, index), None))
            rng = np.random.default_rng([args.seed, 78, index])
            own = steered(args.program, *drawn(case, args.seed, index), joints, rng, f"{joints.stem}-robot{index}")
            straight.append(walk(*drawn(case, args.seed, index), own))
        after, straight, before = np.array(after), np.array(straight), np.array(before)
        speed, size = after[:, 0].mean(), np.abs(after[:, 2])
        model = report["after"]
        print(
            f"| {case} | {1e3 * report['margin_m']:.0f} | {1e3 * speed:.0f} | {speed / speed_m_per_s:.2f}"
            f" | {after[:, 1].mean():.1f} | {after[:, 1].max():.1f} | {after[:, 3].max():.1f} | {size.mean():.1f} | {size.max():.1f} | {after[:, 2].mean():+.1f}"
            f" | {np.abs(straight[:, 2]).mean():.1f} | {np.abs(straight[:, 2]).max():.1f} | {1e3 * straight[:, 0].mean():.0f}"
            f" | {model['calm_probability']:.2f} | {1e3 * before[:, 0].mean():.0f} | {before[:, 1].mean():.1f}"
            f" | {np.abs(before[:, 2]).mean():.1f} | {1e3 * model['speed_m_per_s']:.0f} | {model['fluctuation_deg']:.1f} | {user_s:.0f} |",
            flush=True,
        )


if __name__ == "__main__":
    sys.exit(main())
