"""Golden mass matrices and bias forces of the JetHexa from MuJoCo.

For each morphology 20 random states in free space, and for each state the mass matrix and the
bias forces (Coriolis, centrifugal, gravity) in the quasi-velocities of `mlr_model::dynamics`:
velocity of the body's origin and angular velocity in the body frame, speeds of the joints.

MuJoCo's free joint has the velocity of the body's origin in the world frame, the angular velocity
in the body frame. With R from body to world, w the angular and v the linear velocity in the body
frame, MuJoCo's velocities are T nu with T = diag(R, 1, 1), and their rates T dnu + (R (w x v), 0, 0).
Therefore

    M = T' M_mujoco T        bias = T' (bias_mujoco + M_mujoco (R (w x v), 0, 0))

    python3 -m venv venv && venv/bin/pip install -r tools/golden/requirements.txt
    venv/bin/python tools/golden/mujoco_dynamics.py
"""

import csv
import gzip
import io
import math

import mujoco
import numpy as np

from mujoco_walk import COXA, FEMUR, GOLDEN, HIPS

STATES = 20
LENGTH = (0.0, COXA, FEMUR)  # where each link's joint is on the one before it
AXIS = ("0 0 1", "0 -1 0", "0 -1 0")
INERTIAL = (
    (0.02556, 0.020, "1e-5 1.4e-5 1.4e-5"),
    (0.08807, 0.0385, "2.2e-5 7e-5 7e-5"),
    (0.08993, 0.0565, "1.6e-5 1.2e-4 1.2e-4"),
)
LOCKED_DEG = (0.0, 75.0, 0.0)

# Links that are left of each leg, and whether the lost ones hang on, locked.
CASES = {
    "healthy": ([3, 3, 3, 3, 3, 3], False),
    "leg3-lost": ([3, 3, 0, 3, 3, 3], False),
    "legs2-3-tibia-lost": ([3, 2, 2, 3, 3, 3], False),
    "legs1-4-lost-5-coxa": ([0, 3, 3, 0, 1, 3], False),
    "legs3-4-6-locked": ([3, 3, 0, 2, 3, 1], True),
    "body-alone": ([0, 0, 0, 0, 0, 0], False),
}


def link_xml(leg, link, links, locked):
    """A link and all beyond it; a locked one is welded on, turned about its joint's axis."""
    if link == 3 or (link >= links and not locked):
        return ""
    mass, com, inertia = INERTIAL[link]
    # A positive turn about -y lifts the link: a negative Euler angle about y.
    joint = f'<joint name="{leg} {link}" axis="{AXIS[link]}"/>' if link < links else ""
    euler = "0 0 0" if link < links else ("0 0 %g" if link == 0 else "0 -%g 0") % LOCKED_DEG[link]
    return (
        f'<body pos="{LENGTH[link]} 0 0" euler="{euler}">{joint}'
        f'<inertial pos="{com} 0 0" mass="{mass}" diaginertia="{inertia}"/>'
        f"{link_xml(leg, link + 1, links, locked)}</body>"
    )


def model(links, locked):
    legs = "".join(
        f'<body pos="{x} {y} 0" euler="0 0 {yaw}">{link_xml(leg, 0, links[leg], locked)}</body>'
        for leg, (x, y, yaw) in enumerate(HIPS)
        if links[leg] or locked
    )
    return mujoco.MjModel.from_xml_string(f"""
<mujoco>
  <compiler angle="degree"/>
  <option gravity="0 0 -9.81"/>
  <worldbody>
    <body name="body"><freejoint/>
      <inertial pos="0 0 0.02" mass="1.369" diaginertia="0.005842 0.023327 0.026334"/>
      {legs}
    </body>
  </worldbody>
</mujoco>""")


def rotation(roll, pitch, yaw):
    """R = Rz(yaw) Ry(pitch) Rx(roll)."""
    (cr, cp, cy), (sr, sp, sy) = np.cos([roll, pitch, yaw]), np.sin([roll, pitch, yaw])
    return np.array([
        [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
        [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
        [-sp, cp * sr, cp * cr],
    ])


def dynamics(m, attitude, joints, nu):
    """Mass matrix and bias forces in the quasi-velocities nu."""
    d = mujoco.MjData(m)
    turn = rotation(*attitude)
    quaternion = np.zeros(4)
    mujoco.mju_mat2Quat(quaternion, turn.flatten())
    d.qpos[:] = np.concatenate([[0.3, -0.2, 0.5], quaternion, joints])
    to_mujoco = np.eye(m.nv)
    to_mujoco[:3, :3] = turn
    d.qvel[:] = to_mujoco @ nu
    mujoco.mj_forward(m, d)
    mass = np.zeros((m.nv, m.nv))
    mujoco.mj_fullM(m, d, mass)
    turning = np.zeros(m.nv)
    turning[:3] = turn @ np.cross(nu[3:6], nu[:3])
    return to_mujoco.T @ mass @ to_mujoco, to_mujoco.T @ (d.qfrc_bias + mass @ turning)


def main():
    for number, (name, (links, locked)) in enumerate(CASES.items()):
        rng = np.random.default_rng(number)
        m = model(links, locked)
        n, joints = m.nv, m.nv - 6
        header = ["roll_rad", "pitch_rad", "yaw_rad"]
        header += [f"q{k}" for k in range(joints)] + [f"v{k}" for k in range(n)] + [f"bias{k}" for k in range(n)]
        header += [f"m{i}_{j}" for i in range(n) for j in range(i + 1)]
        text = io.StringIO()
        rows = csv.writer(text, lineterminator="\n")
        rows.writerow(header)
        for _ in range(STATES):
            attitude = np.round(rng.uniform([-3, -1.5, -3], [3, 1.5, 3]), 6)
            q = np.round(rng.uniform(-math.pi, math.pi, joints), 6)
            nu = np.round(rng.normal(0.0, [0.5] * 3 + [2.0] * 3 + [5.0] * joints), 6)
            mass, bias = dynamics(m, attitude, q, nu)
            lower = mass[np.tril_indices(n)]
            rows.writerow([f"{x:.6f}" for x in (*attitude, *q, *nu)] + [f"{x:.11g}" for x in (*bias, *lower)])
        (GOLDEN / "dynamics").mkdir(exist_ok=True)
        with open(GOLDEN / "dynamics" / f"{name}.csv.gz", "wb") as file, gzip.GzipFile("", "wb", 9, file, 0) as packed:
            packed.write(text.getvalue().encode())
        print(name, n, "velocities", sum(m.body_mass), "kg")


if __name__ == "__main__":
    main()
