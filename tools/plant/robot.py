"""The robots and their ground, as a MuJoCo model.

The facts are those of `data/robot/*.toml` and `data/gait/*.toml`, written down a
second time so that nothing is shared with the program under test. SI units; body
frame x forward, y left, z up; every angle zero = leg straight out and horizontal;
a positive femur or tibia angle lifts the link. Leg and link indices start at 0
here, and at 1 in everything that is written to a file.
"""

import math
from dataclasses import dataclass

import mujoco
import numpy as np
from scipy.ndimage import gaussian_filter


@dataclass(frozen=True)
class Robot:
    """What robots differ by; links, servos and stance are the same."""

    hips: tuple  # of each leg: x [m], y [m], yaw [deg]
    feet: tuple  # of each leg, standing: x [m], y [m]
    phase: tuple  # of each leg in the nominal gait, as a share of the period
    body_mass_kg: float
    body_inertia: tuple  # [kg m²]
    body_size_m: tuple
    body_com_m: tuple

    @property
    def legs(self):
        return len(self.hips)


JETHEXA = Robot(
    hips=(
        (0.093205, 0.05098, 45), (0.093205, -0.05098, -45), (0.0, 0.073535, 90),
        (0.0, -0.073535, -90), (-0.093205, 0.05098, 135), (-0.093205, -0.05098, -135),
    ),
    feet=(
        (0.1636, 0.1508), (0.1636, -0.1508), (0.0, 0.1935),
        (0.0, -0.1935), (-0.1636, 0.1508), (-0.1636, -0.1508),
    ),
    phase=(0.0, 0.5, 0.5, 0.0, 0.0, 0.5),
    body_mass_kg=1.369, body_inertia=(0.005842, 0.023327, 0.026334),
    body_size_m=(0.21, 0.156, 0.036), body_com_m=(0.0, 0.0, 0.02),
)
OCTOPOD = Robot(
    hips=(
        (0.150, 0.051, 45), (0.150, -0.051, -45), (0.050, 0.0735, 75), (0.050, -0.0735, -75),
        (-0.050, 0.0735, 105), (-0.050, -0.0735, -105), (-0.150, 0.051, 135), (-0.150, -0.051, -135),
    ),
    feet=(
        (0.220, 0.151), (0.220, -0.151), (0.080, 0.190), (0.080, -0.190),
        (-0.080, 0.190), (-0.080, -0.190), (-0.220, 0.151), (-0.220, -0.151),
    ),
    phase=(0.0, 0.5, 0.5, 0.0, 0.0, 0.5, 0.5, 0.0),
    body_mass_kg=1.6, body_inertia=(0.003418, 0.014693, 0.017765),
    body_size_m=(0.33, 0.156, 0.036), body_com_m=(0.02, 0.0, 0.02),
)
LINKS = 3
LINK_NAMES = ("coxa", "femur", "tibia")
LENGTH_M = (0.04505, 0.07703, 0.123)
LINK_MASS_KG = (0.02556, 0.08807, 0.08993)
LINK_COM_M = (0.020, 0.0385, 0.0565)
LINK_INERTIA = ((1.0e-5, 1.4e-5), (2.2e-5, 7.0e-5), (1.6e-5, 1.2e-4))  # along, across [kg m²]
JOINT_AXIS = ("0 0 1", "0 -1 0", "0 -1 0")
FOOT_RADIUS_M, FEMUR_RADIUS_M, TIBIA_RADIUS_M = 0.012, 0.012, 0.008
FEMUR_FREE_M = 0.03  # its hip end, inside the coxa's bracket, touches nothing
STANDING_HEIGHT_M = 0.090
IMU_HEIGHT_M = 0.04
STALL_TORQUE_NM = 3.4
GRAVITY_MPS2 = 9.81
STEP_S = 0.0005
SOFT_IMPEDANCE = 0.8
MASS_AT_FOOT_KG = 0.18  # calibrated: the standing robot sinks as its weight on six springs would

RUBBLE_HALF_WIDTH_M, RUBBLE_CELL_M, RUBBLE_CORRELATION_M = 2.5, 0.02, 0.025


def link_lengths(plant, leg):
    return [LENGTH_M[k] - plant.length_lost_m[leg][k] for k in range(LINKS)]


def contact_attributes(plant):
    """MuJoCo's solref and solimp: the floor's own, or a soft one of the wanted stiffness.

    A soft contact under a force f sinks by r = f (1-d)/d / (m k), k = 1/(d tau)²,
    with impedance d, time constant tau and the mass m that the contact feels.
    """
    if plant.ground_stiffness_npm is None:
        return f'solref="{plant.contact_time_s} 1" solimp="0.9 0.95 {plant.contact_width_m}"'
    d = SOFT_IMPEDANCE
    time_s = math.sqrt(MASS_AT_FOOT_KG * d / (1 - d) / plant.ground_stiffness_npm) / d
    return f'solref="{time_s} 1" solimp="{d} {d} 0.001"'


def link_xml(plant, leg, link, inner):
    length = link_lengths(plant, leg)
    kept = length[link] / LENGTH_M[link]
    mass = LINK_MASS_KG[link] * plant.mass_scale * plant.link_mass_scale[leg][link] * kept
    along, across = (i * mass / LINK_MASS_KG[link] for i in LINK_INERTIA[link])
    geom = ""
    if link == 1:
        geom = f'<geom name="femur{leg}" type="capsule" size="{FEMUR_RADIUS_M}" fromto="{FEMUR_FREE_M} 0 0 {length[1]} 0 0"/>'
    if link == 2:
        tip = length[2] - FOOT_RADIUS_M
        geom = (
            f'<geom name="tibia{leg}" type="capsule" size="{TIBIA_RADIUS_M}" fromto="0.02 0 0 {tip - 0.02} 0 0"/>'
            f'<geom name="foot{leg}" type="sphere" size="{FOOT_RADIUS_M}" pos="{tip} 0 0"'
            f' friction="{plant.foot_mu[leg] or plant.mu} 0.0001 0.0001"/>'
        )
    start = 0.0 if link == 0 else length[link - 1]
    return (
        f'<body pos="{start} 0 0"><joint name="{leg} {link}" axis="{JOINT_AXIS[link]}" armature="{plant.armature}"'
        f' frictionloss="{plant.joint_friction_nm}"/>'
        f'<inertial pos="{LINK_COM_M[link] * kept} 0 0" mass="{mass}" diaginertia="{along} {across} {across}"/>'
        f"{geom}{inner}</body>"
    )


def leg_xml(plant, leg, links):
    inner = ""
    for link in reversed(range(links)):
        inner = link_xml(plant, leg, link, inner)
    x, y, yaw = plant.robot.hips[leg]
    return f'<body pos="{x} {y} 0" euler="0 0 {yaw}">{inner}</body>' if links else ""


def servo_xml(plant, leg, link):
    """Torque = kp (ctrl - angle) - kd rate, within the stall torque."""
    gain = plant.leg_gain[leg]
    kp, limit = plant.kp * gain, STALL_TORQUE_NM * gain
    return (
        f'<general name="{leg} {link}" joint="{leg} {link}" gainprm="{kp}" biastype="affine"'
        f' biasprm="0 {-kp} {-plant.kd}" forcerange="{-limit} {limit}"/>'
    )


def payload_xml(plant):
    if plant.payload_kg == 0.0:
        return ""
    x, y, z = plant.payload_pos_m
    inertia = plant.payload_kg * 0.02**2
    return (
        f'<body pos="{x} {y} {z}"><inertial pos="0 0 0" mass="{plant.payload_kg}"'
        f' diaginertia="{inertia} {inertia} {inertia}"/></body>'
    )


def gravity(plant):
    """Gravity in a world whose floor is level: a slope is a tilted gravity.

    `slope_dir_deg` is the direction uphill, from the robot's starting x towards its y.
    """
    tilt, uphill = math.radians(plant.slope_deg), math.radians(plant.slope_dir_deg)
    return [
        -GRAVITY_MPS2 * math.sin(tilt) * math.cos(uphill),
        -GRAVITY_MPS2 * math.sin(tilt) * math.sin(uphill),
        -GRAVITY_MPS2 * math.cos(tilt),
    ]


def rubble(plant):
    """Smooth random bumps between 0 and 1, as MuJoCo wants a height field."""
    cells = round(2 * RUBBLE_HALF_WIDTH_M / RUBBLE_CELL_M) + 1
    noise = np.random.default_rng(plant.rubble_seed).standard_normal((cells, cells))
    bumps = gaussian_filter(noise, RUBBLE_CORRELATION_M / RUBBLE_CELL_M, mode="wrap")
    low, high = np.quantile(bumps, [0.02, 0.98])
    return np.clip((bumps - low) / (high - low), 0.0, 1.0)


def model(plant, links):
    """The robot with `links[leg]` links left on each leg, and the ground it stands on."""
    floor, asset = '<geom name="ground" type="plane" size="5 5 0.1" contype="2" conaffinity="1" friction="0 0 0"/>', ""
    if plant.rubble_m:
        bumps = rubble(plant)
        half = RUBBLE_HALF_WIDTH_M
        asset = (
            f'<asset><hfield name="rubble" nrow="{bumps.shape[0]}" ncol="{bumps.shape[1]}"'
            f' size="{half} {half} {plant.rubble_m} 0.1"/></asset>'
        )
        floor = floor.replace('type="plane" size="5 5 0.1"', 'type="hfield" hfield="rubble"')
    robot = plant.robot
    present = [(leg, link) for leg in range(robot.legs) for link in range(links[leg])]
    height = STANDING_HEIGHT_M + plant.rubble_m + 0.003
    com, size = plant.body_com, [s / 2 for s in robot.body_size_m]
    inertia = " ".join(str(i * plant.mass_scale) for i in robot.body_inertia)
    built = mujoco.MjModel.from_xml_string(f"""
<mujoco>
  <compiler angle="degree"/>
  <option timestep="{STEP_S}" integrator="implicitfast" cone="elliptic" impratio="10"
    gravity="{' '.join(str(g) for g in gravity(plant))}"/>
  <default><geom friction="{plant.mu} 0.0001 0.0001" contype="1" conaffinity="2" {contact_attributes(plant)}/></default>
  {asset}
  <worldbody>
    {floor}
    <body name="body" pos="0 0 {height}">
      <freejoint/>
      <inertial pos="{com[0]} {com[1]} {com[2]}" mass="{robot.body_mass_kg * plant.mass_scale}" diaginertia="{inertia}"/>
      <geom name="body" type="box" size="{size[0]} {size[1]} {size[2]}"/>
      <site name="imu" pos="0 0 {IMU_HEIGHT_M}"/>
      {payload_xml(plant)}
      {''.join(leg_xml(plant, leg, links[leg]) for leg in range(robot.legs))}
    </body>
  </worldbody>
  <actuator>{''.join(servo_xml(plant, leg, link) for leg, link in present)}</actuator>
  <sensor><accelerometer site="imu"/><gyro site="imu"/></sensor>
</mujoco>""")
    if plant.rubble_m:
        built.hfield_data[:] = bumps.ravel()
    return built
