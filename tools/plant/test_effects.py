"""Every effect of `effects.py` reaches the simulation, and does there what its name says.

    python tools/plant/test_effects.py

Two robots that are compared have the same settings, the same noise and the same
time stamps, so that whatever their logs differ by is due to the effect. Where gravity
would bend the joints, robots float without it.
"""

import math
import unittest

import mujoco
import numpy as np

import effects
import imu
import robot
from robot import JETHEXA, LINKS
from servo import Servos
from settings import assemble, draw_plant
from walk import SETTLE_S, placed, record, steps

HEALTHY = [LINKS] * JETHEXA.legs
LEG_3_LOST = [3, 3, 0, 3, 3, 3]
GYRO, ANGLES = slice(4, 7), slice(7, 10)

# A thousandth more mass changes the angles of this walk by 0.1°, an effect by at least:
VISIBLE_DEG = 0.3


def plant_of(intact, **settings):
    """The same robot every time; it starts to walk at 1 s."""
    plant = draw_plant(np.random.default_rng(5), intact)
    plant.start, plant.walk_s = 1.0, 3.0
    for name, value in settings.items():
        setattr(plant, name, value)
    return plant


def with_effect(kind, intact=HEALTHY, parameters=None, **settings):
    plant = plant_of(intact, **settings)
    effects.apply(plant, kind, parameters)
    return plant


def log_of(plant, intact=HEALTHY):
    return record(plant, intact, np.random.default_rng(1)).columns


def change_deg(log, other):
    """By how much roll, pitch and yaw differ between two logs, root mean square over time."""
    grid = np.arange(max(log[0, 0], other[0, 0]), min(log[-1, 0], other[-1, 0]), 0.01)

    def angles(columns):
        return np.column_stack([np.interp(grid, columns[:, 0], a) for a in np.unwrap(columns[:, ANGLES], axis=0).T])

    return math.degrees(math.sqrt(np.mean(np.sum((angles(log) - angles(other)) ** 2, axis=1))))


def standing(log):
    """The rows before the robot of `plant_of` starts to walk."""
    return log[log[:, 0] < 0.9]


def mass_kg(plant, intact=HEALTHY):
    return float(np.sum(robot.model(plant, intact).body_mass))


def centre_of_mass_m(plant):
    """Of the whole robot with straight legs, body frame."""
    model = robot.model(plant, HEALTHY)
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    return data.subtree_com[model.body("body").id] - data.body("body").xpos


def run(plant, until_s, intact=HEALTHY, gravity=True, observe=None):
    """Model and state of a robot at `until_s`; `observe(t, model, data)` is called after every step."""
    data, servos = placed(plant, intact)
    if not gravity:
        data.model.opt.gravity[:] = 0.0
        data.qpos[2] += 1.0
    plant.walk_s = until_s - plant.start
    for t in steps(plant, data, servos):
        if observe:
            observe(t, data.model, data)
    return data.model, data


def joint_rad(data, leg, joint):
    """Numbered from 1."""
    return float(data.joint(f"{leg - 1} {joint - 1}").qpos[0])


def floating_joint_rad(plant, leg, joint, t=0.0, intact=HEALTHY):
    return joint_rad(run(plant, t, intact, gravity=False)[1], leg, joint)


def track(plant, leg, joint, until_s):
    """One joint of a floating robot, at every step from t = 0 on."""
    angles = []
    run(plant, until_s, gravity=False, observe=lambda t, _, data: t >= 0.0 and angles.append(joint_rad(data, leg, joint)))
    return np.array(angles)


def at(t):
    return round(t / robot.STEP_S)


class EveryEffect(unittest.TestCase):
    def test_a_strong_one_changes_the_log(self):
        without = log_of(plant_of(LEG_3_LOST), LEG_3_LOST)
        for kind in effects.LIBRARY:
            with self.subTest(kind):
                parameters = effects.draw(np.random.default_rng(7), kind, True, LEG_3_LOST)
                changed = log_of(with_effect(kind, LEG_3_LOST, parameters), LEG_3_LOST)
                self.assertGreater(change_deg(without, changed), VISIBLE_DEG)

    def test_what_is_no_effect_changes_less(self):
        plant = plant_of(LEG_3_LOST)
        without = log_of(plant, LEG_3_LOST)
        plant.mass_scale *= 1.001
        self.assertLess(change_deg(without, log_of(plant, LEG_3_LOST)), VISIBLE_DEG / 2)

    def test_within_none_logs_stay_the_same_to_the_bit(self):
        without = log_of(plant_of(LEG_3_LOST), LEG_3_LOST)
        with effects.none():
            for kind in effects.LIBRARY:
                with self.subTest(kind):
                    parameters = effects.draw(np.random.default_rng(7), kind, True, LEG_3_LOST)
                    plant = with_effect(kind, LEG_3_LOST, parameters)
                    self.assertEqual(plant, plant_of(LEG_3_LOST))
        np.testing.assert_array_equal(log_of(plant, LEG_3_LOST), without)

    def test_an_unknown_one_is_refused(self):
        with self.assertRaises(ValueError):
            with_effect("paylod", parameters={})


class Masses(unittest.TestCase):
    def test_payload_adds_its_mass_and_moves_the_centre_of_mass(self):
        loaded = with_effect("payload", parameters={"mass_kg": 0.4, "x_m": 0.08, "y_m": -0.05})
        bare_kg = mass_kg(plant_of(HEALTHY))
        self.assertAlmostEqual(mass_kg(loaded), bare_kg + 0.4, places=9)
        bare_m = centre_of_mass_m(plant_of(HEALTHY))
        place_m = np.array([0.08, -0.05, effects.PAYLOAD_HEIGHT_M])
        expected_m = (bare_kg * bare_m + 0.4 * place_m) / (bare_kg + 0.4)
        np.testing.assert_allclose(centre_of_mass_m(loaded), expected_m, atol=1e-9)

    def test_locked_links_keep_their_mass_and_are_held(self):
        locked = with_effect("locked_links", LEG_3_LOST, {"legs": [3]})
        model, data = run(locked, 0.0, LEG_3_LOST, gravity=False)
        leg_kg = sum(m * s for m, s in zip(robot.LINK_MASS_KG, locked.link_mass_scale[2])) * locked.mass_scale
        cut_off_kg = mass_kg(plant_of(LEG_3_LOST), LEG_3_LOST)
        self.assertAlmostEqual(float(np.sum(model.body_mass)), cut_off_kg + leg_kg, places=9)
        held = [joint_rad(data, 3, joint) for joint in (1, 2, 3)]
        np.testing.assert_allclose(held, locked.locked_pose[2], atol=0.5 * locked.backlash + 1e-3)

    def test_short_link_is_shorter_and_lighter(self):
        for link, first, last in ((2, "femur", "tibia"), (3, "tibia", "foot")):
            with self.subTest(link=link):
                short = with_effect("short_link", parameters={"leg": 4, "link": link, "length_lost_m": 0.03})
                lengths_m, masses_kg = [], []
                for plant in (plant_of(HEALTHY), short):
                    model, data = run(plant, -SETTLE_S)
                    mujoco.mj_forward(model, data)
                    bodies = [model.geom(f"{name}3").bodyid[0] for name in (first, last)]
                    end = data.geom("foot3").xpos if last == "foot" else data.xpos[bodies[1]]
                    lengths_m.append(np.linalg.norm(end - data.xpos[bodies[0]]))
                    masses_kg.append(model.body_mass[bodies[0]])
                self.assertAlmostEqual(lengths_m[0] - lengths_m[1], 0.03, places=9)
                kept = 1.0 - 0.03 / robot.LENGTH_M[link - 1]
                self.assertAlmostEqual(masses_kg[1] / masses_kg[0], kept, places=9)
                self.assertAlmostEqual(mass_kg(plant_of(HEALTHY)) - mass_kg(short), masses_kg[0] - masses_kg[1], places=9)


class Ground(unittest.TestCase):
    def frictions(self, plant):
        """Of the contact of each foot, leg by leg, while standing."""
        model, data = run(plant, 0.0)
        found = {model.geom(g).name: float(c.friction[0]) for c in data.contact for g in c.geom}
        return [found[f"foot{leg}"] for leg in range(JETHEXA.legs)]

    def test_friction_is_that_of_every_contact(self):
        np.testing.assert_allclose(self.frictions(with_effect("friction", parameters={"mu": 0.23})), 0.23)

    def test_foot_friction_is_that_of_one_contact(self):
        plant = with_effect("foot_friction", parameters={"leg": 2, "mu": 0.1})
        np.testing.assert_allclose(self.frictions(plant), [plant.mu, 0.1] + [plant.mu] * 4)
        self.assertGreater(plant.mu, 0.5)

    def test_slope_tilts_gravity_and_the_robot_towards_uphill(self):
        level = standing(log_of(plant_of(HEALTHY)))[:, ANGLES].mean(0)
        for uphill_deg, expected in ((0.0, (0.0, -6.0)), (90.0, (6.0, 0.0)), (180.0, (0.0, 6.0))):
            with self.subTest(uphill_deg=uphill_deg):
                plant = with_effect("slope", parameters={"angle_deg": 6.0, "uphill_deg": uphill_deg})
                pull = np.array(robot.model(plant, HEALTHY).opt.gravity)
                self.assertAlmostEqual(np.linalg.norm(pull), robot.GRAVITY_MPS2, places=9)
                self.assertAlmostEqual(math.degrees(math.acos(-pull[2] / robot.GRAVITY_MPS2)), 6.0, places=6)
                tilt = np.degrees(standing(log_of(plant))[:, ANGLES].mean(0) - level)
                np.testing.assert_allclose(tilt[:2], expected, atol=0.5)

    def test_rubble_is_as_high_as_said(self):
        model = robot.model(with_effect("rubble", parameters={"height_m": 0.01, "seed": 3}), HEALTHY)
        field = model.hfield_data * model.hfield_size[0][2]
        self.assertAlmostEqual(float(field.max() - field.min()), 0.01, places=6)
        self.assertEqual(robot.model(plant_of(HEALTHY), HEALTHY).nhfield, 0)

    def test_compliant_ground_lets_the_robot_sink_as_its_weight_on_six_springs(self):
        soft = with_effect("ground_compliance", parameters={"stiffness_npm": 500.0})
        heights = [run(plant, 0.0)[1].qpos[2] for plant in (plant_of(HEALTHY), soft)]
        expected_m = mass_kg(soft) * robot.GRAVITY_MPS2 / (JETHEXA.legs * 500.0)
        self.assertAlmostEqual((heights[0] - heights[1]) / expected_m, 1.0, delta=0.15)

    def test_external_force_accelerates_the_whole_robot(self):
        force_n = np.array([3.0, -2.0, 1.0])
        pulled = with_effect("external_force", parameters={"x_n": 3.0, "y_n": -2.0, "z_n": 1.0})
        velocity = []
        for plant in (pulled, plant_of(HEALTHY)):
            model, data = run(plant, 0.0, gravity=False)
            mujoco.mj_subtreeVel(model, data)
            velocity.append(data.subtree_linvel[model.body("body").id].copy())
        np.testing.assert_allclose(velocity[0], force_n / mass_kg(pulled) * SETTLE_S, rtol=1e-3)
        np.testing.assert_allclose(velocity[1], 0.0, atol=1e-6)

    def test_vibrating_arm_shakes_from_the_start_of_the_walk_on(self):
        shaking = {"axis": "x", "torque_nm": 1.5, "frequency_hz": 2.5}
        plant, torques = with_effect("vibrating_arm", parameters=shaking), []
        run(plant, plant.start + 0.2, observe=lambda t, m, d: torques.append((t, *d.xfrc_applied[m.body("body").id, 3:])))
        t, torque = np.array(torques)[:, 0], np.linalg.norm(np.array(torques)[:, 1:], axis=1)
        self.assertTrue(np.all(torque[t <= plant.start] == 0.0))
        phase = 2.0 * math.pi * 2.5 * (t - plant.start)
        np.testing.assert_allclose(torque, np.where(t > plant.start, 1.5 * np.sin(phase), 0.0), atol=1e-9)


class Servo(unittest.TestCase):
    LEG, JOINT = 2, 2

    def walking(self, kind=None, parameters=None, until_s=3.6):
        plant = with_effect(kind, parameters=parameters, backlash=0.0) if kind else plant_of(HEALTHY, backlash=0.0)
        return track(plant, self.LEG, self.JOINT, until_s)

    def test_servo_lag_makes_the_joints_start_later(self):
        angles, late = self.walking(), self.walking("servo_lag", {"delay_s": 0.08})
        started = [np.flatnonzero(np.abs(a - a[0]) > 0.01)[0] * robot.STEP_S for a in (angles, late)]
        self.assertAlmostEqual(started[1] - started[0], 0.08, delta=0.001)

    def test_gait_period_is_that_of_the_joints(self):
        angles, slow = self.walking(), self.walking("gait_period", {"scale": 1.1})
        cycle = slice(at(2.3), at(2.5))
        later = slice(cycle.start + at(1.1), cycle.stop + at(1.1))
        self.assertLess(np.max(np.abs(slow[later] - slow[cycle])), 0.02)
        self.assertGreater(np.max(np.abs(angles[later] - angles[cycle])), 0.05)

    def test_stiffness_is_torque_by_angle(self):
        soft = robot.model(with_effect("servo_stiffness", parameters={"stiffness": 12.0}), HEALTHY)
        np.testing.assert_allclose(soft.actuator_gainprm[:, 0], 12.0)
        np.testing.assert_allclose(soft.actuator_biasprm[:, 1], -12.0)

    def test_dry_friction_holds_every_joint_against_less_torque_and_no_more(self):
        plant = with_effect("joint_friction", parameters={"torque_nm": 0.2})
        model = robot.model(plant, HEALTHY)
        np.testing.assert_allclose(model.dof_frictionloss[6:], 0.2)
        self.assertFalse(np.any(robot.model(plant_of(HEALTHY), HEALTHY).dof_frictionloss))
        # A floating robot whose servos are off: the torque at one joint turns it or does not.
        joint = model.joint(f"{self.LEG - 1} {self.JOINT - 1}")
        turned = []
        for torque_nm in (0.15, 0.25):  # MuJoCo's friction creeps
            model.opt.gravity[:], model.actuator_gainprm[:], model.actuator_biasprm[:] = 0.0, 0.0, 0.0
            data = mujoco.MjData(model)
            data.qfrc_applied[joint.dofadr] = torque_nm
            for _ in range(at(0.2)):
                mujoco.mj_step(model, data)
            turned.append(abs(float(data.qpos[joint.qposadr][0])))
        self.assertLess(turned[0], 0.02)
        self.assertGreater(turned[1], 0.2)

    def test_backlash_leaves_every_joint_free_within_its_angle(self):
        plant = with_effect("backlash", parameters={"angle_rad": 0.06})
        model, data = robot.model(plant, HEALTHY), None
        servos = Servos(plant, model, {})
        for off, free in ((0.029, True), (-0.029, True), (0.04, False), (-0.04, False)):
            data = mujoco.MjData(model)
            servos.start(data)
            data.qpos[servos.angles] += off
            servos.step(data, 0.0)
            torque_nm = plant.kp * (data.ctrl - data.qpos[servos.angles])
            expected_nm = 0.0 if free else -plant.kp * math.copysign(abs(off) - 0.03, off)
            np.testing.assert_allclose(torque_nm, expected_nm, atol=1e-9)

    def test_a_weak_leg_has_less_stiffness_and_torque(self):
        plant = plant_of(HEALTHY)
        healthy, weak = (robot.model(p, HEALTHY) for p in (plant, with_effect("weak_leg", parameters={"leg": 5, "gain": 0.2})))
        of_leg = np.array([0.2 if name.startswith("4 ") else 1.0 for name in (weak.actuator(i).name for i in range(weak.nu))])
        self.assertEqual(np.sum(of_leg < 1.0), LINKS)
        np.testing.assert_allclose(weak.actuator_gainprm[:, 0], healthy.actuator_gainprm[:, 0] * of_leg)
        np.testing.assert_allclose(weak.actuator_biasprm[:, 1], healthy.actuator_biasprm[:, 1] * of_leg)
        np.testing.assert_allclose(weak.actuator_forcerange, healthy.actuator_forcerange * of_leg[:, None])

    def test_a_stuck_joint_does_not_move(self):
        stuck = self.walking("stuck_joint", {"leg": self.LEG, "joint": self.JOINT, "angle_rad": 0.4})
        np.testing.assert_allclose(stuck, 0.4, atol=0.03)
        self.assertGreater(np.ptp(self.walking()), 0.3)

    def test_a_joint_offset_is_added_to_the_commanded_angle(self):
        plant = with_effect("joint_offset", parameters={"leg": 6, "joint": 3, "angle_rad": -0.2}, backlash=0.0)
        change = floating_joint_rad(plant, 6, 3) - floating_joint_rad(plant_of(HEALTHY, backlash=0.0), 6, 3)
        self.assertAlmostEqual(change, -0.2, places=3)

    def test_joint_zeros_of_an_assembled_robot_are_those_of_its_joints(self):
        plant = assemble(np.random.default_rng(2), plant_of(HEALTHY))
        plant.backlash = 0.0
        _, assembled = run(plant, 0.0, gravity=False)
        _, nominal = run(plant_of(HEALTHY, backlash=0.0), 0.0, gravity=False)
        joints = [(leg, joint) for leg in range(1, JETHEXA.legs + 1) for joint in range(1, LINKS + 1)]
        change = [joint_rad(assembled, *j) - joint_rad(nominal, *j) for j in joints]
        np.testing.assert_allclose(change, np.ravel(plant.joint_zero_rad), atol=1e-3)
        self.assertGreater(np.max(np.abs(change)), 0.01)

    def test_an_intermittent_leg_is_without_power_now_and_then(self):
        plant = with_effect("intermittent_leg", parameters={"leg": 2, "period_s": 1.5, "off_s": 0.5})
        gains = {}
        run(plant, 3.2, observe=lambda t, m, d: gains.update({round(t, 4): m.actuator_gainprm[:, 0].copy()}))
        leg = np.arange(JETHEXA.legs * LINKS) // LINKS == 1
        for t, power in ((0.5, 1.0), (1.2, 0.0), (1.7, 1.0), (2.7, 0.0), (3.1, 1.0)):
            with self.subTest(t=t):
                np.testing.assert_allclose(gains[t], np.where(leg, power * plant.kp, plant.kp))


class Sensor(unittest.TestCase):
    def test_gyro_bias_is_what_a_standing_robot_reads(self):
        log = standing(log_of(with_effect("gyro_bias", parameters={"x_dps": 3.0, "y_dps": -4.0, "z_dps": 2.0})))
        np.testing.assert_allclose(np.degrees(log[:, GYRO].mean(0)), [3.0, -4.0, 2.0], atol=0.1)

    def test_gyro_scale_divides_the_rates(self):
        bias = {"gyro_bias": [0.0] * 3}
        rates = log_of(plant_of(LEG_3_LOST, **bias), LEG_3_LOST)[:, GYRO]
        scaled = log_of(with_effect("gyro_scale", LEG_3_LOST, {"scale": 1.1}, **bias), LEG_3_LOST)[:, GYRO]
        self.assertAlmostEqual(np.sum(rates**2) / np.sum(rates * scaled), 1.1, delta=0.005)

    def test_sensor_delay_moves_the_log_in_time(self):
        for delay_s in (0.0, 0.07):
            with self.subTest(delay_s=delay_s):
                prompt = log_of(plant_of(LEG_3_LOST), LEG_3_LOST)
                late = log_of(with_effect("sensor_delay", LEG_3_LOST, {"delay_s": delay_s}), LEG_3_LOST)

                def change_when_moved_by(shift_s):
                    moved = late - ([shift_s] + [0.0] * 9)
                    return change_deg(prompt[prompt[:, 0] > 0.2], moved[moved[:, 0] > 0.2])

                best_s = min(np.arange(-0.02, 0.12, 0.01), key=change_when_moved_by)
                self.assertAlmostEqual(best_s, delay_s, places=6)

    def test_bias_drift_is_of_the_yaw_axis(self):
        log = log_of(with_effect("bias_drift", parameters={"dps_per_min": 20.0}, start=6.0, walk_s=0.0))
        drift = np.degrees(np.polyfit(log[:, 0], log[:, GYRO], 1)[0]) * 60.0
        np.testing.assert_allclose(drift, [0.0, 0.0, 20.0], atol=0.5)

    def test_a_misaligned_sensor_reads_its_tilt(self):
        straight = plant_of(HEALTHY, mis_deg=[0.0] * 3)
        tilted = with_effect("imu_misalignment", parameters={"roll_deg": 4.0, "pitch_deg": -3.0}, mis_deg=[0.0] * 3)
        read = [standing(log_of(plant))[:, ANGLES].mean(0) for plant in (straight, tilted)]
        np.testing.assert_allclose(np.degrees(read[1] - read[0])[:2], [4.0, -3.0], atol=0.2)

    def test_a_loose_mount_rings_at_its_frequency(self):
        t = np.arange(0.0, 4.0, 0.001)
        kicked = np.zeros((len(t), 3))
        kicked[t >= 1.0, 1] = 1.0
        _, rates = imu.swing_on_mount(t, kicked, np.zeros((len(t), 3)), 1.0, 5.0, 0.05)
        strength = np.abs(np.fft.rfft(rates[t >= 1.0, 0]))
        self.assertAlmostEqual(np.fft.rfftfreq(np.sum(t >= 1.0), 0.001)[strength.argmax()], 5.0, delta=0.35)
        self.assertTrue(np.all(rates[t < 1.0] == 0.0))

    def test_hysteresis_holds_one_axis_within_its_band(self):
        rates = log_of(plant_of(LEG_3_LOST), LEG_3_LOST)[:, GYRO]
        hysteresis = {"axis": "y", "width_dps": 10.0}
        stuck = log_of(with_effect("gyro_hysteresis", LEG_3_LOST, hysteresis), LEG_3_LOST)[:, GYRO]
        change = np.degrees(np.abs(stuck - rates).max(0))
        rounding_dps = 2.0 * math.degrees(imu.GYRO_LSB)
        np.testing.assert_allclose(change, [0.0, 5.0, 0.0], atol=rounding_dps)


if __name__ == "__main__":
    unittest.main()
