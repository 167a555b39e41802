"""Golden walks of the JetHexa in MuJoCo.

An independent implementation of robot, gait, inverse kinematics and servo,
written from the same facts as `data/robot/jethexa.toml` and `data/gait/tripod.toml`
but sharing nothing with the Rust code. Two engines never agree exactly: their
contact laws differ. The golden test compares what both must get right.

    python3 -m venv venv && venv/bin/pip install -r tools/golden/requirements.txt
    venv/bin/python tools/golden/mujoco_walk.py
"""

import math
from pathlib import Path

import mujoco
import numpy as np

GOLDEN = Path(__file__).resolve().parents[2] / "data" / "golden" / "mujoco"

HIPS = [
    (0.093205, 0.05098, 45), (0.093205, -0.05098, -45), (0.0, 0.073535, 90),
    (0.0, -0.073535, -90), (-0.093205, 0.05098, 135), (-0.093205, -0.05098, -135),
]
FEET = [
    (0.1636, 0.1508), (0.1636, -0.1508), (0.0, 0.1935),
    (0.0, -0.1935), (-0.1636, 0.1508), (-0.1636, -0.1508),
]
COXA, FEMUR, TIBIA = 0.04505, 0.07703, 0.123
GROUP_A = {0, 3, 4}
PERIOD_S, STRIDE_M, LIFT_M, HEIGHT_M = 1.0, 0.060, 0.040, 0.090
STIFFNESS, DAMPING, TORQUE_NM, SPEED = 30.0, 0.6, 3.4, 5.2
HOLD_S, LATENCY_S = 0.020, 0.010
STEP_S, SETTLE_S, WALK_S, SAMPLE_S, FALL_S = 0.0005, 0.5, 5.0, 0.02, 1.4
LOCKED_DEG = (0.0, 75.0, 0.0)

CASES = {
    "healthy": [3, 3, 3, 3, 3, 3],
    "leg3-lost": [3, 3, 0, 3, 3, 3],
    "legs3-4-lost": [3, 3, 0, 0, 3, 3],
    "legs4-5-lost": [3, 3, 3, 0, 0, 3],
    "legs2-3-tibia-lost": [3, 2, 2, 3, 3, 3],
}


def foot_target(leg, t):
    x, y = FEET[leg]
    if t <= 0.0:
        return x, y, -HEIGHT_M
    p = (t / PERIOD_S + (0.0 if leg in GROUP_A else 0.5)) % 1.0
    ramp = min(t / PERIOD_S, 1.0)
    if p < 0.5:
        s, z = -0.5 * math.cos(2.0 * math.pi * p), math.sin(2.0 * math.pi * p)
    else:
        s, z = 0.5 - 2.0 * (p - 0.5), 0.0
    return x + ramp * s * STRIDE_M, y, -HEIGHT_M + ramp * z * LIFT_M


def joint_angles(leg, t):
    """Knee-down solution of the three-link leg."""
    x, y, z = foot_target(leg, t)
    hip_x, hip_y, yaw_deg = HIPS[leg]
    yaw = math.radians(yaw_deg)
    dx, dy = x - hip_x, y - hip_y
    forward = math.cos(yaw) * dx + math.sin(yaw) * dy
    left = -math.sin(yaw) * dx + math.cos(yaw) * dy
    reach = math.hypot(forward, left) - COXA
    knee = math.acos((reach**2 + z**2 - FEMUR**2 - TIBIA**2) / (2.0 * FEMUR * TIBIA))
    lift = math.atan2(z, reach) + math.atan2(TIBIA * math.sin(knee), FEMUR + TIBIA * math.cos(knee))
    return [math.atan2(left, forward), lift, -knee]


def link(name, axis, pos, mass, com, inertia, geom, children):
    return (
        f'<body name="{name}" pos="{pos} 0 0"><joint name="{name}" type="hinge" axis="{axis}" damping="{DAMPING}"/>'
        f'<inertial pos="{com} 0 0" mass="{mass}" diaginertia="{inertia}"/>{geom}{children}</body>'
    )


def leg_xml(leg, links):
    if links == 0:
        return ""
    foot = f'<geom type="sphere" size="0.012" pos="{TIBIA - 0.012} 0 0"/>'
    shaft = f'<geom type="capsule" size="0.012" fromto="0 0 0 {FEMUR} 0 0"/>'
    tibia = link(f"tibia{leg}", "0 -1 0", FEMUR, 0.08993, 0.0565, "1.6e-5 1.2e-4 1.2e-4", foot, "") if links > 2 else ""
    femur = link(f"femur{leg}", "0 -1 0", COXA, 0.08807, 0.0385, "2.2e-5 7e-5 7e-5", shaft, tibia) if links > 1 else ""
    coxa = link(f"coxa{leg}", "0 0 1", 0.0, 0.02556, 0.020, "1e-5 1.4e-5 1.4e-5", "", femur)
    x, y, yaw = HIPS[leg]
    return f'<body pos="{x} {y} 0" euler="0 0 {yaw}">{coxa}</body>'


def locked_leg_xml(leg):
    """A leg held in the air, which touches nothing."""
    inner = ""
    for pos, mass, com, inertia, angle in reversed((
        (0.0, 0.02556, 0.020, "1e-5 1.4e-5 1.4e-5", f"0 0 {LOCKED_DEG[0]}"),
        (COXA, 0.08807, 0.0385, "2.2e-5 7e-5 7e-5", f"0 {-LOCKED_DEG[1]} 0"),
        (FEMUR, 0.08993, 0.0565, "1.6e-5 1.2e-4 1.2e-4", f"0 {-LOCKED_DEG[2]} 0"),
    )):
        inertial = f'<inertial pos="{com} 0 0" mass="{mass}" diaginertia="{inertia}"/>'
        inner = f'<body pos="{pos} 0 0" euler="{angle}">{inertial}{inner}</body>'
    x, y, yaw = HIPS[leg]
    return f'<body pos="{x} {y} 0" euler="0 0 {yaw}">{inner}</body>'


def model_xml(links, locked=()):
    legs = "".join(leg_xml(leg, n) for leg, n in enumerate(links)) + "".join(map(locked_leg_xml, locked))
    return f"""
<mujoco>
  <compiler angle="degree"/>
  <option timestep="{STEP_S}" integrator="implicitfast" cone="elliptic" impratio="10"/>
  <default><geom friction="0.7 0.0001 0.0001" contype="1" conaffinity="2" density="0"/></default>
  <worldbody>
    <geom type="plane" size="5 5 0.1" contype="2" conaffinity="1"/>
    <body name="body" pos="0 0 0.095">
      <freejoint/>
      <inertial pos="0 0 0.02" mass="1.369" diaginertia="0.005842 0.023327 0.026334"/>
      <geom type="box" size="0.105 0.078 0.018"/>
      {legs}
    </body>
  </worldbody>
</mujoco>"""


def walk(links):
    m = mujoco.MjModel.from_xml_string(model_xml(links))
    d = mujoco.MjData(m)
    names = [(leg, j, f"{('coxa', 'femur', 'tibia')[j]}{leg}") for leg, n in enumerate(links) for j in range(n)]
    position = [m.jnt_qposadr[m.joint(name).id] for _, _, name in names]
    velocity = [m.jnt_dofadr[m.joint(name).id] for _, _, name in names]
    set_point = np.array([joint_angles(leg, 0.0)[j] for leg, j, _ in names])
    d.qpos[position] = set_point
    angles, position_m = [], []
    sample_every = round(SAMPLE_S / STEP_S)
    for step in range(-round(SETTLE_S / STEP_S), round(WALK_S / STEP_S) + 1):
        t = step * STEP_S
        if step >= 0 and step % sample_every == 0:
            position_m.append(d.qpos[:3].copy())
            w, x, y, z = d.qpos[3:7]
            angles.append((
                math.atan2(2 * (w * x + y * z), 1 - 2 * (x * x + y * y)),
                math.asin(max(-1.0, min(1.0, 2 * (w * y - z * x)))),
                math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z)),
            ))
        tick = math.floor((t - LATENCY_S) / HOLD_S + 1e-6) * HOLD_S
        command = np.array([joint_angles(leg, tick)[j] for leg, j, _ in names])
        set_point += np.clip(command - set_point, -SPEED * STEP_S, SPEED * STEP_S)
        # The joints' own damping belongs to the servo: both together stay within the torque.
        braking = DAMPING * d.qvel[velocity]
        torque = np.clip(STIFFNESS * (set_point - d.qpos[position]) - braking, -TORQUE_NM, TORQUE_NM)
        d.qfrc_applied[velocity] = torque + braking
        mujoco.mj_step(m, d)
    angles = np.array(angles)
    angles[:, 2] = np.unwrap(angles[:, 2])
    return angles, np.array(position_m)


def fall():
    """Pitch of a robot that is set down with its front legs locked in the air, and falls on its nose."""
    m = mujoco.MjModel.from_xml_string(model_xml([0, 0, 3, 3, 3, 3], locked=(0, 1)))
    d = mujoco.MjData(m)
    names = [(leg, j, f"{('coxa', 'femur', 'tibia')[j]}{leg}") for leg in range(2, 6) for j in range(3)]
    position = [m.jnt_qposadr[m.joint(name).id] for _, _, name in names]
    velocity = [m.jnt_dofadr[m.joint(name).id] for _, _, name in names]
    stance = np.array([joint_angles(leg, 0.0)[j] for leg, j, _ in names])
    d.qpos[position] = stance
    d.qpos[2] = HEIGHT_M + 0.0001
    pitch = []
    for step in range(round(FALL_S / STEP_S) + 1):
        if step % round(SAMPLE_S / STEP_S) == 0:
            w, x, y, z = d.qpos[3:7]
            pitch.append(math.asin(2 * (w * y - z * x)))
        braking = DAMPING * d.qvel[velocity]
        torque = np.clip(STIFFNESS * (stance - d.qpos[position]) - braking, -TORQUE_NM, TORQUE_NM)
        d.qfrc_applied[velocity] = torque + braking
        mujoco.mj_step(m, d)
    return np.array(pitch)


def main():
    pitch = fall()
    np.savetxt(
        GOLDEN / "nose-fall.csv", np.column_stack([np.arange(len(pitch)) * SAMPLE_S, pitch]), fmt=["%.2f", "%.6f"],
        delimiter=",", header="t_s,pitch_rad", comments="",
    )
    print("falls to", np.degrees(pitch.max()), "comes to rest at", np.degrees(pitch[-1]))
    for name, links in CASES.items():
        angles, position_m = walk(links)
        t = np.arange(len(angles)) * SAMPLE_S
        np.savetxt(
            GOLDEN / f"{name}.csv", np.column_stack([t, angles, position_m]), fmt=["%.2f"] + 3 * ["%.6f"] + 3 * ["%.5f"],
            delimiter=",", header="t_s,roll_rad,pitch_rad,yaw_rad,x_m,y_m,z_m", comments="",
        )
        low, high = np.degrees(angles.min(0)), np.degrees(angles.max(0))
        print(name, "roll", low[0], high[0], "pitch", low[1], high[1], "yaw", np.degrees(angles[-1, 2]))


if __name__ == "__main__":
    main()
