"""Compares what calibrations say of robots with what the plant made them of.

    python tools/plant/owned.py --seed N --count M -o DIR
    python tools/plant/coverage.py DIR --program target/release/mlr-ga

Calibrates each robot of owned.py by its healthy walk. For every parameter that the plant has: how often the 95 % interval
holds the plant's value, the error over the deviation that is claimed, and both over the deviation among robots of the make.
What an effect of the day's walk changed in the truth is left out. MuJoCo is not needed.
"""

import argparse
import concurrent.futures
import json
import math
import subprocess
import tempfile
from pathlib import Path

import numpy as np

from robot import JETHEXA

CHANGED_BY = {
    "servo_stiffness": {"servo_stiffness"}, "clock": {"gait_period"}, "gyro_scale": {"gyro_scale"},
    "imu_roll": {"imu_misalignment"}, "imu_pitch": {"imu_misalignment"},
}


def truth(entry):
    """The robot's own values in the coordinates of mlr's parameters."""
    plant, kinds = entry["plant"], {effect["kind"] for effect in entry["effects"]}
    values = {
        "servo_stiffness": math.log(plant["kp"]), "servo_damping": math.log(plant["kd"]),
        "clock": math.log(plant["period_scale"]), "gyro_scale": 0.0,
        "body_mass": math.log(JETHEXA.body_mass_kg * plant["mass_scale"]),
    }
    values |= {f"center_of_mass_{axis}": com for axis, com in zip("xyz", plant["body_com"])}
    values |= {f"imu_{axis}": angle for axis, angle in zip(("roll", "pitch", "yaw"), plant["mis_deg"])}
    for leg, zeros in enumerate(plant["joint_zero_rad"]):
        values |= {f"joint_zero_leg{leg + 1}_{joint + 1}": zero for joint, zero in enumerate(zeros)}
    return {name: value for name, value in values.items() if not CHANGED_BY.get(name, set()) & kinds}


def calibrated(program, logs, gaits, robot):
    """The parameters that `mlr-ga calibrate` reports, by name. What an earlier call left in `robot` is taken as it is."""
    kept = robot.with_suffix(".json")
    if not kept.exists():
        robot.unlink(missing_ok=True)
        command = [program, "calibrate", *logs, "--healthy", "--json", "--threads", "1", "-o", str(robot)]
        command += [part for gait in gaits for part in ("--gait", gait)]
        kept.write_text(subprocess.run(command, check=True, capture_output=True, text=True).stdout)
    report = json.loads(kept.read_text())
    return {one["name"]: one for one in report["parameters"]}, report["walks"][-1]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("directory", type=Path)
    parser.add_argument("--program", default="mlr-ga")
    parser.add_argument("--motion", metavar="GAIT", help="calibrate by robot-III-motion too, which is this gait")
    parser.add_argument("--fitted", action="store_true", help="of the values with which the model walks like the robot, in place of the robot's own")
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("-o", "--output", type=Path, help="keep each robot, and the report of its calibration, as robot-III-day in this directory: --own-robots of evaluate")
    args = parser.parse_args()
    truths = json.loads((args.directory / "truth.json").read_text())
    names = [name.removesuffix("-day") for name in truths]
    kinds = ["healthy", "motion"] if args.motion else ["healthy"]
    gaits = ["tripod", args.motion] if args.motion else []

    with tempfile.TemporaryDirectory() as folder, concurrent.futures.ThreadPoolExecutor(args.jobs) as pool:
        robots = args.output or Path(folder)
        robots.mkdir(parents=True, exist_ok=True)

        def run(name):
            logs = [str(args.directory / f"{name}-{kind}.csv.gz") for kind in kinds]
            return calibrated(args.program, logs, gaits, robots / f"{name}-day.toml")

        found = list(pool.map(run, names))
    errors, walks = {}, np.array([
        [walk[when]["validation_axes_deg"] for when in ("error_before", "error_after")] for _, walk in found
    ])
    for name, (parameters, _) in zip(names, found):
        for key, value in truth(truths[f"{name}-day"]).items():
            one = parameters[key]
            group = f"joint_zero, joint {key[-1]}" if key.startswith("joint_zero") else key
            found, deviation = (one["fitted"], one["deviation"]) if args.fitted else (one["physical"], one["physical_deviations"][-1])
            row = found - value, deviation, one["make_deviation"]
            errors.setdefault(group, []).append(row)
    print("| parameter | values | in the 95 % interval | error / claimed | error / make | claimed / make |\n|:--|--:|--:|--:|--:|--:|")
    for group, rows in errors.items():
        error, claimed, make = np.array(rows).T
        held = np.mean(np.abs(error) < 1.96 * claimed)
        of_make = np.sqrt(np.mean((error / make) ** 2)), np.mean(claimed / make)
        z = np.sqrt(np.mean((error / claimed) ** 2))
        print(f"| {group} | {len(rows)} | {100 * held:.0f} % | {z:.1f} | {of_make[0]:.2f} | {of_make[1]:.2f} |")
    before, after = np.median(walks, axis=0)
    print("\nmedian unseen error of roll, pitch, yaw:", *(f"{x:.2f}°" for x in before), "before,", *(f"{x:.2f}°" for x in after), "after")


if __name__ == "__main__":
    main()
