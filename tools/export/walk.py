"""How an exported robot walks in MuJoCo, beside `mlr-ga simulate`.

`mlr-ga export --format mjcf` writes the robot, `mlr-ga simulate --joints` the joint angles that its
controller plays and the walk of the model. MuJoCo plays the same angles on the exported robot: every
command is held, late and limited in speed as the file's <numeric> elements say. Roll and pitch are
compared without their means, yaw from its start.

    python3 -m venv venv && venv/bin/pip install -r tools/export/requirements.txt
    cargo build --release -p mlr-ga --bin mlr-ga
    venv/bin/python tools/export/walk.py target/release/mlr-ga
"""

import argparse
import csv
import math
import subprocess
import tempfile
from pathlib import Path

import mujoco
import numpy as np

CASES = {
    "healthy": [],
    "leg 3 lost": ["--legs-lost", "3"],
    "legs 3,4 lost": ["--legs-lost", "3,4"],
    "leg 5 lost": ["--legs-lost", "5"],
    "legs 1,4 locked": ["--legs-lost", "1,4", "--lost-links", "locked"],
    "leg 2 lost from link 3 on, leg 6 lost, both locked": [
        "--morphology", "111 110 111 111 111 000", "--lost-links", "locked",
    ],
}
SETTLE_S, STAND_S, WALK_S, SAMPLE_S = 0.5, 1.0, 5.0, 0.01


def numeric(model, name):
    return float(model.numeric_data[model.numeric_adr[model.numeric(name).id]])


def roll_pitch_yaw(quaternion):
    w, x, y, z = quaternion
    return (
        math.atan2(2 * (w * x + y * z), 1 - 2 * (x * x + y * y)),
        math.asin(max(-1.0, min(1.0, 2 * (w * y - z * x)))),
        math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z)),
    )


def read(path):
    with open(path) as file:
        lines = [line for line in file if not line.startswith("#")]
    rows = list(csv.DictReader(lines))
    return {name: np.array([float(row[name]) for row in rows]) for name in rows[0]}


def play(robot, joints, solref):
    """Roll, pitch and yaw from the first step on; with other contacts than the file's, if so."""
    model = mujoco.MjModel.from_xml_path(str(robot))
    if solref:
        model.geom_solref[:] = solref
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, model.key("stance").id)
    hold_s, latency_s = numeric(model, "command_hold_s"), numeric(model, "latency_s")
    reach_rad = numeric(model, "speed_limit_rad_per_s") * model.opt.timestep
    commands = np.column_stack([joints[f"{model.actuator(k).name}_rad"] for k in range(model.nu)])
    angles, step_s = [], model.opt.timestep
    for step in range(-round(SETTLE_S / step_s), round(WALK_S / step_s) + 1):
        if step >= 0 and step % round(SAMPLE_S / step_s) == 0:
            angles.append(roll_pitch_yaw(data.qpos[3:7]))
        row = math.floor((step * step_s - latency_s) / hold_s + 1e-6)
        command = commands[min(max(row, 0), len(commands) - 1)]
        data.ctrl += np.clip(command - data.ctrl, -reach_rad, reach_rad)
        mujoco.mj_step(model, data)
    return np.degrees(np.unwrap(np.array(angles), axis=0))


def walk(program, case, folder, solref=None):
    robot, log, joints = (folder / name for name in ("robot.xml", "log.csv", "joints.csv"))
    run = lambda *arguments: subprocess.run([program, *map(str, arguments)], check=True, stdout=subprocess.DEVNULL)
    run("export", "--format", "mjcf", "-o", robot, *case)
    run("simulate", "-o", log, "--joints", joints, "--stand-s", STAND_S, "--walk-s", WALK_S, *case)
    theirs = play(robot, read(joints), solref)
    log = read(log)
    t = np.arange(len(theirs)) * SAMPLE_S + STAND_S
    ours = np.column_stack([
        np.degrees(np.interp(t, log["t_s"], np.unwrap(log[f"{axis}_rad"]))) for axis in ("roll", "pitch", "yaw")
    ])
    return ours, theirs


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("program", type=Path)
    parser.add_argument("--solref", type=float, nargs=2, help="other contacts than those of the file")
    options = parser.parse_args()
    program = options.program.resolve()
    rms = lambda x: float(np.sqrt(np.mean(x**2)))
    print("| robot | roll: motion [°] | apart [°] | pitch: motion [°] | apart [°] | yaw at the end, here [°] | in MuJoCo [°] | RMS apart [°] |")
    print("|:--|--:|--:|--:|--:|--:|--:|--:|")
    for name, case in CASES.items():
        with tempfile.TemporaryDirectory() as folder:
            ours, theirs = walk(program, case, Path(folder), options.solref)
        tilt = [x[:, :2] - x[:, :2].mean(0) for x in (ours, theirs)]
        yaw = [x[:, 2] - x[0, 2] for x in (ours, theirs)]
        cells = [f"{value:.2f}" for axis in (0, 1) for value in (rms(tilt[0][:, axis]), rms((tilt[0] - tilt[1])[:, axis]))]
        cells += [f"{yaw[0][-1]:.1f}", f"{yaw[1][-1]:.1f}", f"{rms(yaw[0] - yaw[1]):.1f}"]
        print(f"| {name} | {' | '.join(cells)} |")


if __name__ == "__main__":
    main()
