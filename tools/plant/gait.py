"""The robots' nominal gaits of `data/gait`, others like them, and the inverse kinematics; files of joint angles.

Lengths in metres in the body frame (x forward, y left, z up), angles in radians,
gait time in seconds on the robot's own clock: standing up to 0, walking after.
"""

import math
from dataclasses import dataclass

import numpy as np

from robot import LENGTH_M, LINK_NAMES, STANDING_HEIGHT_M, Robot

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


class JointFile:
    """The joint angles of a CSV file, row by row: `t_s,leg1_coxa_rad,…`, as `mlr-ga simulate --joints` writes it.

    A row is held until the next. After the last row comes the first of those that a line `# repeat A..B` names
    (rows from 0, B not among them), else the robot holds the last.
    """

    def __init__(self, path, robot):
        with open(path, encoding="utf-8") as file:
            lines = [line.strip() for line in file]
        comments = [line for line in lines if line.startswith("#")]
        table = [line for line in lines if line and not line.startswith("#")]
        columns = ["t_s", *(f"leg{leg + 1}_{link}_rad" for leg in range(robot.legs) for link in LINK_NAMES)]
        if not table or table[0].split(",") != columns:
            raise ValueError(f"{path}: expected the columns {','.join(columns)}")
        rows = [[float(field) for field in line.split(",")] for line in table[1:]]
        if len(rows) < 2 or any(len(row) != len(columns) for row in rows):
            raise ValueError(f"{path}: expected at least 2 rows of {len(columns)} numbers")
        rows = np.array(rows)
        self.row_s = rows[1, 0] - rows[0, 0]
        if not (self.row_s > 0.0 and np.allclose(rows[:, 0], np.arange(len(rows)) * self.row_s, rtol=0.0, atol=1e-6)):
            raise ValueError(f"{path}: expected t_s to begin at 0 and to rise evenly")
        if not np.all(np.isfinite(rows)):
            raise ValueError(f"{path}: expected finite numbers")
        self.angles = rows[:, 1:]
        self.repeat = None
        for comment in comments:
            if comment.startswith("# repeat "):
                first, end = (int(n) for n in comment.removeprefix("# repeat ").split(".."))
                if not 0 <= first < end <= len(rows):
                    raise ValueError(f"{path}: expected rows of the file: {comment}")
                self.repeat = first, end

    @property
    def length_s(self):
        """When the last row is commanded."""
        return (len(self.angles) - 1) * self.row_s

    def all_joint_angles(self, gait_s):
        """Those of every joint, leg by leg."""
        row = max(math.floor(gait_s / self.row_s + 1e-6), 0)
        if self.repeat and row >= self.repeat[1]:
            first, end = self.repeat
            row = first + (row - first) % (end - first)
        return self.angles[min(row, len(self.angles) - 1)]
