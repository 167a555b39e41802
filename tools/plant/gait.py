"""The robots' nominal gaits of `data/gait`, others like them, and the inverse kinematics.

Lengths in metres in the body frame (x forward, y left, z up), angles in radians,
gait time in seconds on the robot's own clock: standing up to 0, walking after.
"""

import math
from dataclasses import dataclass

from robot import LENGTH_M, STANDING_HEIGHT_M, Robot

PERIOD_S, STRIDE_M, LIFT_M = 1.0, 0.060, 0.040


@dataclass(frozen=True)
class Gait:
    """The nominal gait of a robot, or another one."""

    robot: Robot
    phase: tuple | None = None  # of each leg; None: the nominal ones
    stride_m: float = STRIDE_M
    lift_m: float = LIFT_M
    heading_rad: float = 0.0  # of the stride, body frame

    def foot_target(self, leg, gait_s):
        x, y = self.robot.feet[leg]
        if gait_s <= 0.0:
            return x, y, -STANDING_HEIGHT_M
        p = (gait_s / PERIOD_S + (self.phase or self.robot.phase)[leg]) % 1.0
        if p < 0.5:
            s, z = -0.5 * math.cos(2.0 * math.pi * p), math.sin(2.0 * math.pi * p)
        else:
            s, z = 1.5 - 2.0 * p, 0.0
        ramp = min(gait_s / PERIOD_S, 1.0)
        step = ramp * s * self.stride_m
        x, y = x + step * math.cos(self.heading_rad), y + step * math.sin(self.heading_rad)
        return x, y, -STANDING_HEIGHT_M + ramp * z * self.lift_m

    def joint_angles(self, leg, gait_s):
        """Coxa, femur and tibia angle of the knee-up posture that reaches the target."""
        x, y, z = self.foot_target(leg, gait_s)
        hip_x, hip_y, yaw_deg = self.robot.hips[leg]
        azimuth = math.atan2(y - hip_y, x - hip_x) - math.radians(yaw_deg)
        azimuth = math.remainder(azimuth, 2.0 * math.pi)
        coxa, femur, tibia = LENGTH_M
        reach = math.hypot(x - hip_x, y - hip_y) - coxa
        distance = math.hypot(reach, z)
        at_hip = math.acos((femur**2 + distance**2 - tibia**2) / (2.0 * femur * distance))
        at_knee = math.acos((femur**2 + tibia**2 - distance**2) / (2.0 * femur * tibia))
        return azimuth, math.atan2(z, reach) + at_hip, at_knee - math.pi

    def all_joint_angles(self, gait_s):
        """Those of every joint, leg by leg."""
        return [angle for leg in range(self.robot.legs) for angle in self.joint_angles(leg, gait_s)]
