"""Everything about one robot that is not in the facts: the plant's settings.

A plain `Plant` is a robot on an even, hard floor; the fields after `locked` are
what the effects of `effects.py` change. Angles in degrees or radians as named,
the rest in SI units. Settings of each leg or link that are None stand at "nothing special".
"""

import math
from dataclasses import MISSING, dataclass, field, fields

import numpy as np

from robot import JETHEXA, LINKS, Robot


def zeros(n):
    return lambda: [0.0] * n


@dataclass
class Plant:
    robot: Robot  # its facts
    kp: float  # servo stiffness [N m/rad]
    kd: float  # servo damping [N m s/rad]
    mu: float  # ground friction
    latency: float  # from command to servo [s]
    mass_scale: float  # of all masses and inertias
    link_mass_scale: list  # of each link, on top of mass_scale
    body_com: list  # body frame [m]
    backlash: float  # full width of the gear play [rad]
    armature: float  # reflected inertia of a motor [kg m²]
    contact_time_s: float  # time constant of MuJoCo's contact (solref)
    contact_width_m: float  # depth at which the contact is fully hard (solimp)
    gyro_bias: list  # [deg/s]
    gyro_noise: float  # standard deviation of a sample [rad/s]
    acc_bias: list  # [m/s²]
    acc_noise: float  # standard deviation of a sample [m/s²]
    mis_deg: list  # roll, pitch, yaw at which the IMU is mounted [deg]
    period_scale: float  # true gait period / nominal gait period
    start: float  # first motion command [s]
    locked: bool = False  # lost links held clear of the ground; False: cut off
    locked_pose: list | None = None  # where they are held [rad]
    gait: dict = field(default_factory=dict)  # what it has other than the nominal one: `gait.Gait`
    joints: str | None = None  # a file of joint angles that it plays in place of a gait: `gait.JointFile`
    walk_s: float = 10.0  # from the start to the end of the log
    damage_s: float = -math.inf  # when a walking robot loses the links (locked only)
    payload_kg: float = 0.0
    payload_pos_m: list = field(default_factory=zeros(3))  # body frame
    slope_deg: float = 0.0
    slope_dir_deg: float = 0.0  # uphill, starting body frame
    rubble_m: float = 0.0  # height of the bumps
    rubble_seed: int = 0
    joint_zero_rad: list | None = None  # true angle - commanded angle of every joint, as assembled
    joint_friction_nm: float = 0.0  # dry friction of every joint
    foot_mu: list | None = None  # 0: as mu
    leg_gain: list | None = None  # of stiffness and torque
    stuck: dict = field(default_factory=dict)  # leg, joint, angle_rad
    joint_offset_rad: list | None = None
    length_lost_m: list | None = None
    ground_stiffness_npm: float | None = None  # of one foot, standing [N/m]
    force_n: list = field(default_factory=zeros(3))  # on the body, ground frame
    vibration: dict = field(default_factory=dict)  # axis, torque_nm, frequency_hz
    dropout: dict = field(default_factory=dict)  # leg, period_s, off_s
    gyro_scale: float = 1.0  # true rate / reported rate
    sensor_delay_s: float = 0.0
    bias_drift_dps_per_min: float = 0.0  # of the yaw axis
    loose_mount: dict = field(default_factory=dict)  # frequency_hz, damping_ratio
    hysteresis: dict = field(default_factory=dict)  # axis, width_dps

    def to_json(self):
        """The settings, without those that stand at "nothing special"."""
        settings = [f for f in fields(self) if f.name != "robot"]
        return {f.name: getattr(self, f.name) for f in settings if f.name == "locked" or self.differs(f)}

    def differs(self, setting):
        plain = setting.default if setting.default_factory is MISSING else setting.default_factory()
        return getattr(self, setting.name) != self.plain_legs().get(setting.name, plain)

    def plain_legs(self):
        """The settings of each leg or link that stand at "nothing special"."""
        legs = self.robot.legs

        def per_link():
            return [[0.0] * LINKS for _ in range(legs)]

        return {
            "locked_pose": per_link(), "foot_mu": [0.0] * legs, "leg_gain": [1.0] * legs,
            "joint_zero_rad": per_link(), "joint_offset_rad": per_link(), "length_lost_m": per_link(),
        }

    def __post_init__(self):
        for name, value in self.plain_legs().items():
            if getattr(self, name) is None:
                setattr(self, name, value)


def draw_plant(rng, intact, robot=JETHEXA):
    """A robot as robots of one batch differ, standing for 1 to 2.5 s, rarely up to 6 s.

    `intact`: links left on each leg.
    """
    return Plant(
        robot=robot,
        kp=rng.uniform(24.0, 36.0),
        kd=rng.uniform(0.45, 0.75),
        mu=rng.uniform(0.6, 0.85),
        latency=rng.uniform(0.004, 0.016),
        mass_scale=rng.uniform(0.97, 1.04),
        link_mass_scale=rng.uniform(0.96, 1.04, (robot.legs, LINKS)).tolist(),
        body_com=[rng.uniform(c - 0.004, c + 0.004) for c in robot.body_com_m],
        backlash=rng.uniform(0.0, 0.006),
        armature=rng.uniform(0.0005, 0.0015),
        contact_time_s=rng.uniform(0.005, 0.014),
        contact_width_m=rng.uniform(0.0005, 0.002),
        gyro_bias=rng.uniform(-0.25, 0.25, 3).tolist(),
        gyro_noise=rng.uniform(0.0019, 0.0023),
        acc_bias=rng.uniform(-0.05, 0.05, 3).tolist(),
        acc_noise=rng.uniform(0.042, 0.050),
        mis_deg=rng.uniform(-0.5, 0.5, 3).tolist(),
        period_scale=rng.uniform(0.997, 1.003),
        start=round(rng.uniform(1.0, 2.5) if rng.random() < 0.85 else rng.uniform(2.5, 6.0), 2),
        locked_pose=[draw_locked_pose(rng, links) for links in intact],
    )


def assemble(rng, plant):
    """What the hands that built the robot add: zeros of its joints, the sensor's mounting, worn gears, its feet.

    A horn has teeth 14° apart and is trimmed by eye to about 0.015 rad; a sensor glued on sits a degree off.
    """
    plant.joint_zero_rad = np.clip(rng.normal(0.0, 0.015, (plant.robot.legs, LINKS)), -0.04, 0.04).tolist()
    plant.mis_deg = rng.uniform(-1.0, 1.0, 3).tolist()
    plant.backlash = rng.uniform(0.0, 0.012)
    plant.contact_time_s = rng.uniform(0.005, 0.018)
    return plant


def as_described(robot=JETHEXA):
    """A whole robot as `data/robot` describes it, with the noise of its sensor and nothing else."""
    return Plant(
        robot=robot,
        kp=30.0, kd=0.6, mu=0.7, latency=0.010,
        mass_scale=1.0, link_mass_scale=[[1.0] * LINKS for _ in range(robot.legs)], body_com=list(robot.body_com_m),
        backlash=0.0, armature=0.001, contact_time_s=0.0095, contact_width_m=0.00125,
        gyro_bias=[0.0] * 3, gyro_noise=0.0021, acc_bias=[0.0] * 3, acc_noise=0.046, mis_deg=[0.0] * 3,
        period_scale=1.0, start=2.0,
    )


def draw_locked_pose(rng, links):
    """Leg folded up: coxa near the middle, femur steep, tibia straight on, or up if the femur still walks."""
    tibia_deg = 45.0 if links == 2 else 0.0
    spread_deg = ((-10.0, 10.0), (65.0, 85.0), (tibia_deg - 12.0, tibia_deg + 12.0))
    return [math.radians(rng.uniform(*spread)) for spread in spread_deg]
