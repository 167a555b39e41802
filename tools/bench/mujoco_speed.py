"""Time per simulated walk: this project's model against MuJoCo, in one run.

Both walk the same random morphologies for 0.5 s of standing and 5 s of walking on
one core, in turns, so that a busy machine is unfair to neither. MuJoCo takes steps
of 4 ms and is driven from its C API's own loop as far as Python allows: commands
are computed beforehand, and the time of the Python code around `mj_step` is
measured apart and subtracted.

    python3 -m venv venv && venv/bin/pip install -r tools/golden/requirements.txt
    cargo build --release -p mlr-model --example walk_speed
    venv/bin/python tools/bench/mujoco_speed.py
"""

import subprocess
import sys
import time
from pathlib import Path

import mujoco
import numpy as np

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tools" / "golden"))
import mujoco_walk as golden  # noqa: E402

STEP_S = 0.004
WALKS_PER_ROUND, ROUNDS = 32, 4


def mujoco_ms(links):
    """Milliseconds that MuJoCo spends in its own steps for one walk."""
    model = golden.model(links)
    model.opt.timestep = STEP_S
    data = mujoco.MjData(model)
    names = [(leg, j, f"{('coxa', 'femur', 'tibia')[j]}{leg}") for leg, n in enumerate(links) for j in range(n)]
    position = [model.jnt_qposadr[model.joint(name).id] for _, _, name in names]
    velocity = [model.jnt_dofadr[model.joint(name).id] for _, _, name in names]
    steps = range(-round(golden.SETTLE_S / STEP_S), round(golden.WALK_S / STEP_S))
    held = {}
    for step in steps:
        tick = int(step * STEP_S / golden.HOLD_S)
        if tick not in held:
            angles = [golden.joint_angles(leg, tick * golden.HOLD_S) for leg in range(6)]
            held[tick] = np.array([angles[leg][j] for leg, j, _ in names])
    if names:
        data.qpos[position] = held[min(held)]
    spent = 0
    for step in steps:
        if names:
            error = held[int(step * STEP_S / golden.HOLD_S)] - data.qpos[position]
            torque = golden.STIFFNESS * error
            data.qfrc_applied[velocity] = np.clip(torque, -golden.TORQUE_NM, golden.TORQUE_NM)
        begin = time.perf_counter_ns()
        mujoco.mj_step(model, data)
        spent += time.perf_counter_ns() - begin
    return spent * 1e-6


def main():
    rng = np.random.default_rng(1)
    program = ROOT / "target" / "release" / "examples" / "walk_speed"
    ours, theirs = [], []
    for _ in range(ROUNDS):
        morphologies = rng.integers(0, 4, (WALKS_PER_ROUND, 6))
        spelled = ["".join(map(str, m)) for m in morphologies]
        ours.append(float(subprocess.run([program, *spelled], capture_output=True, check=True, text=True).stdout))
        theirs.append(np.mean([mujoco_ms(list(m)) for m in morphologies]))
        print(f"mlr-model {ours[-1]:6.2f} ms   MuJoCo {theirs[-1]:6.2f} ms")
    print(f"mean: mlr-model {np.mean(ours):.2f} ms, MuJoCo {np.mean(theirs):.2f} ms, "
          f"ratio {np.mean(ours) / np.mean(theirs):.2f}")


if __name__ == "__main__":
    main()
