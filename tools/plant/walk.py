"""One robot from standing up to the last sample of its log."""

import math
from dataclasses import dataclass

import mujoco
import numpy as np

import imu
import robot
from servo import Servos

SETTLE_S = 1.5


@dataclass
class Walk:
    columns: np.ndarray  # the ten columns of the log
    lost_contacts: int  # physics steps in which a lost link touched the ground


def held_joints(plant, intact):
    """The joints that ignore the gait, with their angles: locked links and a stuck joint."""
    lost = [(leg, link) for leg in range(plant.robot.legs) for link in range(intact[leg], robot.LINKS)]
    held = {(leg, link): plant.locked_pose[leg][link] for leg, link in lost} if plant.locked else {}
    if plant.stuck:
        held[plant.stuck["leg"] - 1, plant.stuck["joint"] - 1] = plant.stuck["angle_rad"]
    return held


def lost_geoms(model, intact):
    parts = [(1, "femur"), (2, "tibia"), (2, "foot")]
    names = [f"{name}{leg}" for leg in range(len(intact)) for link, name in parts if link >= intact[leg]]
    return [g for g in (mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_GEOM, name) for name in names) if g >= 0]


def push_body(plant, data, body, t):
    """A constant pull in the ground frame, and the shaking of a vibrating arm."""
    data.xfrc_applied[body, :3] = plant.force_n
    if plant.vibration and t > plant.start:
        axis = data.xmat[body].reshape(3, 3)[:, "xyz".index(plant.vibration["axis"])]
        phase = 2.0 * math.pi * plant.vibration["frequency_hz"] * (t - plant.start)
        data.xfrc_applied[body, 3:] = axis * plant.vibration["torque_nm"] * math.sin(phase)


def placed(plant, intact):
    """State of a robot with `intact[leg]` links left on each leg before its first step, and its servos."""
    model = robot.model(plant, [robot.LINKS] * plant.robot.legs if plant.locked else intact)
    data = mujoco.MjData(model)
    servos = Servos(plant, model, held_joints(plant, intact))
    servos.start(data)
    return data, servos


def steps(plant, data, servos, settle_s=SETTLE_S):
    """Takes every physics step to the end of the walk; its time."""
    body = data.model.body("body").id
    pushed = bool(plant.vibration) or any(plant.force_n)
    for step in range(-round(settle_s / robot.STEP_S), round((plant.start + plant.walk_s) / robot.STEP_S)):
        t = step * robot.STEP_S
        servos.step(data, t)
        if pushed:
            push_body(plant, data, body, t)
        mujoco.mj_step(data.model, data)
        yield t


def record(plant, intact, rng):
    """The log of a robot with `intact[leg]` links left on each leg."""
    data, servos = placed(plant, intact)
    lost = np.zeros(data.model.ngeom, bool)
    lost[lost_geoms(data.model, intact)] = True
    watched = lost.any()
    stamps, readings, contacts = [], [], 0
    due_s = 0.0
    for t in steps(plant, data, servos, SETTLE_S + plant.sensor_delay_s):
        stamp = t + plant.sensor_delay_s
        if stamp >= due_s - 1e-9:
            due_s += 1.0 / rng.uniform(*imu.RATE_HZ)
            stamps.append(stamp)
            readings.append(data.sensordata.copy())
        if watched and t >= plant.damage_s and data.ncon:
            contacts += bool(lost[data.contact.geom].any())
    if any(warning.number for warning in data.warning):
        raise RuntimeError("the simulation became unstable")
    readings = np.array(readings)
    columns = imu.log(plant, rng, np.array(stamps), readings[:, :3], readings[:, 3:])
    return Walk(columns, contacts)
