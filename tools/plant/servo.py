"""The bus servos between the controller's commands and the joints.

A command is held for 20 ms, arrives late by the latency, is rounded to the
servo's resolution and approached at the servo's speed limit. Gear backlash is a
dead zone around the set point. Stiffness, damping and stall torque are in the
MuJoCo actuators (`robot.servo_xml`), dry friction of the gears and the rotor's
inertia in its joints (`robot.link_xml`). Angles in radians, times in seconds since
the log's first sample.
"""

import math

import numpy as np

from gait import Gait, JointFile
from robot import LINKS, STEP_S

HOLD_S = 0.020
RESOLUTION_RAD = math.radians(0.24)
SPEED_RADPS = 5.2


def clip(value, limit):
    return np.minimum(np.maximum(value, -limit), limit)


class Servos:
    def __init__(self, plant, model, held):
        """`held`: angle by joint (leg, link) for joints that ignore the gait."""
        joints = [tuple(int(n) for n in model.actuator(i).name.split()) for i in range(model.nu)]
        self.plant, self.model = plant, model
        self.columns = [leg * LINKS + link for leg, link in joints]
        self.angles = [model.joint(f"{leg} {link}").qposadr[0] for leg, link in joints]
        self.offset = np.array([plant.joint_offset_rad[leg][link] + plant.joint_zero_rad[leg][link] for leg, link in joints])
        self.held = [(i, held[joint]) for i, joint in enumerate(joints) if joint in held]
        self.dropping = [i for i, (leg, _) in enumerate(joints) if plant.dropout and leg == plant.dropout["leg"] - 1]
        if plant.joints:
            # A controller that plays a file holds every row for one tick of its own clock.
            self.gait, self.hold_s = JointFile(plant.joints, plant.robot), HOLD_S * plant.period_scale
        else:
            # The nominal gait's time is asked for at every true tick.
            self.gait, self.hold_s = Gait(plant.robot, **plant.gait), HOLD_S
        self.powered = True
        self.tick = None
        self.set_point = self.target = self.targets(0.0, -math.inf)

    def targets(self, gait_s, t):
        target = np.round(np.array(self.gait.all_joint_angles(gait_s))[self.columns] / RESOLUTION_RAD) * RESOLUTION_RAD
        if t >= self.plant.damage_s:
            for joint, angle in self.held:
                target[joint] = angle
        return target + self.offset

    def start(self, data):
        """Put the joints where they are to stand."""
        self.set_point = self.target = self.targets(0.0, 0.0)
        data.qpos[self.angles] = self.set_point

    def step(self, data, t):
        plant = self.plant
        tick = math.floor((t - plant.start - plant.latency) / self.hold_s + 1e-6)
        if tick != self.tick:
            self.tick = tick
            self.target = self.targets(max(tick, 0) * self.hold_s / plant.period_scale, t)
        travel = SPEED_RADPS * STEP_S
        self.set_point = self.set_point + clip(self.target - self.set_point, travel)
        angle = data.qpos[self.angles]
        error = self.set_point - angle
        play = 0.5 * plant.backlash
        data.ctrl[:] = angle + error - clip(error, play)
        if self.dropping:
            self.switch(t)

    def switch(self, t):
        """Cut and restore the power of an intermittent leg; its gears still brake."""
        dropout = self.plant.dropout
        since_s = t - self.plant.start
        powered = since_s < 0.0 or since_s % dropout["period_s"] >= dropout["off_s"]
        if powered != self.powered:
            self.powered = powered
            kp = self.plant.kp * self.plant.leg_gain[dropout["leg"] - 1] if powered else 0.0
            self.model.actuator_gainprm[self.dropping, 0] = kp
            self.model.actuator_biasprm[self.dropping, 1] = -kp
