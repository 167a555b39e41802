"""The nominal tripod gait of `data/gait/tripod.toml`, others like it, and the inverse kinematics.

Lengths in metres in the body frame (x forward, y left, z up), angles in radians,
gait time in seconds on the robot's own clock: standing up to 0, walking after.
"""

import math
from dataclasses import dataclass

from robot import HIPS, LEGS, LENGTH_M, STANDING_HEIGHT_M

FEET = [
    (0.1636, 0.1508), (0.1636, -0.1508), (0.0, 0.1935),
    (0.0, -0.1935), (-0.1636, 0.1508), (-0.1636, -0.1508),
]
PHASE = (0.0, 0.5, 0.5, 0.0, 0.0, 0.5)
PERIOD_S, STRIDE_M, LIFT_M = 1.0, 0.060, 0.040


@dataclass(frozen=True)
class Gait:
    """The tripod of the logs, or another one."""

    phase: tuple = PHASE
    stride_m: float = STRIDE_M
    lift_m: float = LIFT_M
    heading_rad: float = 0.0  # of the stride, body frame

    def foot_target(self, leg, gait_s):
        x, y = FEET[leg]
        if gait_s <= 0.0:
            return x, y, -STANDING_HEIGHT_M
        p = (gait_s / PERIOD_S + self.phase[leg]) % 1.0
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
        hip_x, hip_y, yaw_deg = HIPS[leg]
        azimuth = math.atan2(y - hip_y, x - hip_x) - math.radians(yaw_deg)
        azimuth = math.remainder(azimuth, 2.0 * math.pi)
        coxa, femur, tibia = LENGTH_M
        reach = math.hypot(x - hip_x, y - hip_y) - coxa
        distance = math.hypot(reach, z)
        at_hip = math.acos((femur**2 + distance**2 - tibia**2) / (2.0 * femur * distance))
        at_knee = math.acos((femur**2 + tibia**2 - distance**2) / (2.0 * femur * tibia))
        return azimuth, math.atan2(z, reach) + at_hip, at_knee - math.pi

    def all_joint_angles(self, gait_s):
        """Eighteen angles, leg by leg."""
        return [angle for leg in range(LEGS) for angle in self.joint_angles(leg, gait_s)]


def joint_angles(leg, gait_s):
    """Those of the nominal gait."""
    return Gait().joint_angles(leg, gait_s)
