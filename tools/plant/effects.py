"""What may be wrong with a robot beyond its lost links.

`apply` changes a plant's settings and returns the effect as it is written to
truth: {"kind", "parameters"}, legs, links and joints numbered from 1. `draw`
picks the parameters of a weak or strong effect. Angles of slopes and pulls are
in the robot's starting body frame (x forward, y left). The ranges are the JetHexa's.

Beyond the kinds a model may know there are four that it does not: a vibrating
arm on the body, a loose IMU mount, a leg whose servos drop out, and a gyroscope
axis with hysteresis. The arm and the dropouts begin with the walk.
"""

import contextlib
import math

from gait import Gait
from robot import JETHEXA

GEARS = ("joint_friction", "backlash")
OUTSIDE = ("vibrating_arm", "loose_mount", "intermittent_leg", "gyro_hysteresis")
PAYLOAD_HEIGHT_M = 0.05


_enabled = True


@contextlib.contextmanager
def none():
    """Within it, `apply` leaves plants as they are."""
    global _enabled
    _enabled = False
    try:
        yield
    finally:
        _enabled = True


def apply(plant, kind, p):
    """Change `plant` by the effect `kind` with the parameters `p`."""
    if not _enabled:
        return {"kind": kind, "parameters": p}
    leg = p.get("leg", 1) - 1
    match kind:
        case "payload":
            plant.payload_kg = p["mass_kg"]
            plant.payload_pos_m = [p["x_m"], p["y_m"], PAYLOAD_HEIGHT_M]
        case "slope":
            plant.slope_deg, plant.slope_dir_deg = p["angle_deg"], p["uphill_deg"]
        case "rubble":
            plant.rubble_m, plant.rubble_seed = p["height_m"], p["seed"]
        case "friction":
            plant.mu = p["mu"]
        case "foot_friction":
            plant.foot_mu[leg] = p["mu"]
        case "servo_lag":  # dead time on top of the plant's own
            plant.latency += p["delay_s"]
        case "servo_stiffness":
            plant.kp = p["stiffness"]
        case "joint_friction":  # dry, of every joint
            plant.joint_friction_nm = p["torque_nm"]
        case "backlash":  # full width of the play of every joint
            plant.backlash = p["angle_rad"]
        case "weak_leg":  # of its stiffness and stall torque
            plant.leg_gain[leg] = p["gain"]
        case "stuck_joint":
            plant.stuck = dict(p)
        case "joint_offset":  # true angle - commanded angle
            plant.joint_offset_rad[leg][p["joint"] - 1] = p["angle_rad"]
        case "short_link":  # with its share of the mass
            plant.length_lost_m[leg][p["link"] - 1] = p["length_lost_m"]
        case "locked_links":
            plant.locked = True
        case "imu_misalignment":
            plant.mis_deg = [p["roll_deg"], p["pitch_deg"], plant.mis_deg[2]]
        case "gyro_bias":
            plant.gyro_bias = [p["x_dps"], p["y_dps"], p["z_dps"]]
        case "gyro_scale":  # true rate / reported rate, all axes
            plant.gyro_scale = p["scale"]
        case "sensor_delay":
            plant.sensor_delay_s = p["delay_s"]
        case "bias_drift":  # of the yaw axis, from the first sample on
            plant.bias_drift_dps_per_min = p["dps_per_min"]
        case "gait_period":
            plant.period_scale = p["scale"]
        case "ground_compliance":  # spring of one foot of six that stand
            plant.ground_stiffness_npm = p["stiffness_npm"]
        case "external_force":
            plant.force_n = [p["x_n"], p["y_n"], p["z_n"]]
        case "vibrating_arm":
            plant.vibration = dict(p)
        case "loose_mount":
            plant.loose_mount = dict(p)
        case "intermittent_leg":
            plant.dropout = dict(p)
        case "gyro_hysteresis":
            plant.hysteresis = dict(p)
        case _:
            raise ValueError(f"unknown effect {kind}")
    return {"kind": kind, "parameters": p}


def sign(rng):
    return 1.0 if rng.random() < 0.5 else -1.0


def a_leg(rng, intact):
    """A leg that has all its links, numbered from 1."""
    return int(rng.choice([leg + 1 for leg, links in enumerate(intact) if links == 3]))


def ring(rng, low, high):
    """A vector in the plane of random direction."""
    size, angle = rng.uniform(low, high), rng.uniform(0.0, 2.0 * math.pi)
    return size * math.cos(angle), size * math.sin(angle)


def payload(rng, low_kg, high_kg):
    y_sign = sign(rng)
    return {
        "mass_kg": rng.uniform(low_kg, high_kg),
        "x_m": sign(rng) * rng.uniform(0.03, 0.08), "y_m": y_sign * rng.uniform(0.02, 0.06),
    }


def slope(rng, low_deg, high_deg):
    return {"angle_deg": rng.uniform(low_deg, high_deg), "uphill_deg": rng.uniform(-180.0, 180.0)}


def misalignment(rng, low_deg, high_deg):
    roll, pitch = ring(rng, low_deg, high_deg)
    return {"roll_deg": roll, "pitch_deg": pitch}


def rubble(rng, low_m, high_m):
    return {"height_m": rng.uniform(low_m, high_m), "seed": int(rng.integers(2**31))}


def stuck_joint(rng, intact, low, high):
    leg, joint = a_leg(rng, intact), int(rng.integers(1, 4))
    angle = Gait(JETHEXA).joint_angles(leg - 1, 0.0)[joint - 1] + sign(rng) * rng.uniform(low, high)
    return {"leg": leg, "joint": joint, "angle_rad": angle}


def locked_links(intact):
    return {"legs": [leg + 1 for leg, links in enumerate(intact) if links < 3]}


def gyro_bias(rng, low, high):
    return {axis: sign(rng) * rng.uniform(low, high) for axis in ("x_dps", "y_dps", "z_dps")}


def external_force(rng, low, high):
    x, y = ring(rng, low, high)
    return {"x_n": x, "y_n": y, "z_n": sign(rng) * rng.uniform(0.0, 0.5 * high)}


def vibrating_arm(rng, low, high):
    """Between the harmonics of the gait, which lie at whole hertz."""
    return {
        "axis": str(rng.choice(["x", "y"])), "torque_nm": rng.uniform(low, high),
        "frequency_hz": float(rng.integers(2, 5)) + rng.uniform(0.25, 0.75),
    }


# kind: (draw, range of a weak effect, range of a strong one); draw(rng, intact, low, high)
LIBRARY = {
    "payload": (lambda r, i, *a: payload(r, *a), (0.10, 0.20), (0.30, 0.50)),
    "slope": (lambda r, i, *a: slope(r, *a), (2.0, 3.0), (5.0, 7.0)),
    "friction": (lambda r, i, *a: {"mu": r.uniform(*a)}, (0.40, 0.48), (0.18, 0.28)),
    "foot_friction": (lambda r, i, *a: {"leg": a_leg(r, i), "mu": r.uniform(*a)}, (0.30, 0.40), (0.08, 0.15)),
    "servo_lag": (lambda r, i, *a: {"delay_s": r.uniform(*a)}, (0.02, 0.03), (0.06, 0.09)),
    "servo_stiffness": (lambda r, i, *a: {"stiffness": r.uniform(*a)}, (18.0, 21.0), (11.0, 14.0)),
    "weak_leg": (lambda r, i, *a: {"leg": a_leg(r, i), "gain": r.uniform(*a)}, (0.5, 0.6), (0.15, 0.3)),
    "stuck_joint": (stuck_joint, (0.05, 0.15), (0.3, 0.5)),
    "joint_offset": (
        lambda r, i, *a: {"leg": a_leg(r, i), "joint": int(r.integers(1, 4)), "angle_rad": sign(r) * r.uniform(*a)},
        (0.04, 0.08), (0.15, 0.30),
    ),
    "short_link": (
        lambda r, i, *a: {"leg": a_leg(r, i), "link": int(r.integers(2, 4)), "length_lost_m": r.uniform(*a)},
        (0.006, 0.012), (0.020, 0.035),
    ),
    "locked_links": (lambda r, i, *a: locked_links(i), (), ()),
    "imu_misalignment": (lambda r, i, *a: misalignment(r, *a), (1.0, 1.5), (3.0, 5.0)),
    "gyro_bias": (lambda r, i, *a: gyro_bias(r, *a), (0.5, 1.0), (2.0, 5.0)),
    "gyro_scale": (lambda r, i, *a: {"scale": 1.0 + sign(r) * r.uniform(*a)}, (0.02, 0.03), (0.06, 0.12)),
    "sensor_delay": (lambda r, i, *a: {"delay_s": r.uniform(*a)}, (0.015, 0.025), (0.05, 0.08)),
    "bias_drift": (lambda r, i, *a: {"dps_per_min": sign(r) * r.uniform(*a)}, (3.0, 5.0), (12.0, 25.0)),
    "gait_period": (lambda r, i, *a: {"scale": 1.0 + sign(r) * r.uniform(*a)}, (0.012, 0.02), (0.05, 0.08)),
    "ground_compliance": (lambda r, i, *a: {"stiffness_npm": r.uniform(*a)}, (1200.0, 2000.0), (300.0, 600.0)),
    "external_force": (lambda r, i, *a: external_force(r, *a), (0.8, 1.2), (2.5, 4.0)),
    "vibrating_arm": (lambda r, i, *a: vibrating_arm(r, *a), (0.4, 0.7), (1.2, 1.8)),
    "loose_mount": (
        lambda r, i, *a: {"frequency_hz": r.uniform(*a), "damping_ratio": r.uniform(0.04, 0.12)},
        (9.0, 12.0), (4.0, 6.0),
    ),
    "intermittent_leg": (
        lambda r, i, *a: {"leg": a_leg(r, i), "period_s": r.uniform(1.3, 1.8), "off_s": r.uniform(*a)},
        (0.10, 0.20), (0.4, 0.6),
    ),
    "gyro_hysteresis": (
        lambda r, i, *a: {"axis": str(r.choice(["x", "y", "z"])), "width_dps": r.uniform(*a)}, (2.0, 3.0), (8.0, 15.0),
    ),
    "joint_friction": (lambda r, i, *a: {"torque_nm": r.uniform(*a)}, (0.05, 0.08), (0.15, 0.30)),
    "backlash": (lambda r, i, *a: {"angle_rad": r.uniform(*a)}, (0.012, 0.018), (0.035, 0.060)),
}


def draw(rng, kind, strong, intact):
    """The parameters of a weak or strong effect on a robot with `intact` links a leg."""
    pick, weak, big = LIBRARY[kind]
    return pick(rng, intact, *(big if strong else weak))
