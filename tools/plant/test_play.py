"""Files of joint angles reach the plant's servos row by row.

    cargo build --release -p mlr-ga
    python tools/plant/test_play.py

The variable MLR_GA names another program than `target/release/mlr-ga`.
"""

import json
import os
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

import numpy as np

import robot
from gait import Gait, JointFile
from robot import JETHEXA, LINKS, OCTOPOD
from servo import HOLD_S, Servos
from settings import as_described, assemble, draw_plant
from walk import held_joints, record

ROOT = Path(__file__).resolve().parents[2]
PROGRAM = os.environ.get("MLR_GA", ROOT / "target" / "release" / "mlr-ga")
HEALTHY, LEG_3_LOST = [LINKS] * JETHEXA.legs, [3, 3, 0, 3, 3, 3]
WALK_S = 6.0


def assembled():
    """A robot with joint zeros, backlash and a sensor of its own, whose clock is right."""
    rng = np.random.default_rng(5)
    plant = assemble(rng, draw_plant(rng, LEG_3_LOST))
    plant.period_scale = 1.0
    return plant


def log_of(plant, intact, joints=None, walk_s=WALK_S):
    plant.start, plant.walk_s, plant.joints = 1.0, walk_s, joints and str(joints)
    return record(plant, intact, np.random.default_rng(1)).columns


def commands(plant, joints, until_s):
    """What the servos of a robot that stands until 0 s are to reach, at every step."""
    plant.start, plant.latency, plant.joints = 0.0, 0.0, joints and str(joints)
    model = robot.model(plant, HEALTHY)
    servos = Servos(plant, model, held_joints(plant, HEALTHY))
    data = robot.mujoco.MjData(model)
    targets = []
    for step in range(round(until_s / robot.STEP_S)):
        servos.step(data, step * robot.STEP_S)
        targets.append(servos.target)
    return np.array(targets)


class Play(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(cls.folder.cleanup)
        cls.tripod = Path(cls.folder.name) / "tripod.csv"
        log = cls.tripod.with_name("log.csv")
        subprocess.run([PROGRAM, "simulate", "--walk-s", "3", "-o", log, "--joints", cls.tripod], check=True, stdout=subprocess.PIPE)

    def changed(self, change):
        """The file with other lines."""
        path = self.tripod.with_name("changed.csv")
        path.write_text("\n".join(change(self.tripod.read_text().splitlines())) + "\n")
        return path

    def test_the_tripod_from_a_file_is_the_same_walk(self):
        for name, plant, intact in (("nominal", as_described, HEALTHY), ("assembled", assembled, LEG_3_LOST)):
            with self.subTest(name):
                own = log_of(plant(), intact)
                np.testing.assert_array_equal(log_of(plant(), intact, self.tripod), own)
                # The control: one angle of one of the rows that repeat.
                def bend(lines):
                    fields = lines[2 + 120].split(",")
                    fields[2] = str(float(fields[2]) + 0.1)
                    return [*lines[:122], ",".join(fields), *lines[123:]]

                self.assertFalse(np.array_equal(log_of(plant(), intact, self.changed(bend)), own))

    def test_its_commands_are_those_of_the_plants_own_tripod(self):
        own = commands(as_described(), None, WALK_S)
        np.testing.assert_array_equal(commands(as_described(), self.tripod, WALK_S), own)
        self.assertGreater(np.ptp(own), 0.3)

    def test_without_rows_that_repeat_it_holds_the_last(self):
        ending = self.changed(lambda lines: lines[1:])
        targets = commands(as_described(), ending, WALK_S)
        after = round(3.0 / robot.STEP_S)
        np.testing.assert_array_equal(targets[after:], np.tile(targets[after], (len(targets) - after, 1)))
        self.assertFalse(np.array_equal(commands(as_described(), self.tripod, WALK_S), targets))

    def test_a_slow_clock_holds_every_row_for_longer(self):
        for scale in (0.98, 1.0, 1.03):
            with self.subTest(scale=scale):
                plant = as_described()
                plant.period_scale = scale
                targets = commands(plant, self.tripod, 1.5)
                changes = np.flatnonzero(np.any(np.diff(targets, axis=0), axis=1)) + 1
                ticks = changes * robot.STEP_S / (HOLD_S * scale)
                # A row begins at the first step after its time.
                late = (ticks - np.floor(ticks + 1e-6)) * HOLD_S * scale
                self.assertGreater(len(changes), 40)
                self.assertLess(np.max(late), robot.STEP_S)

    def test_files_that_make_no_sense_are_refused(self):
        for change, named in (
            (lambda lines: [line.replace("leg2_femur", "leg2_thigh") for line in lines], "columns"),
            (lambda lines: [*lines[:5], lines[5].rpartition(",")[0], *lines[6:]], "numbers"),
            (lambda lines: [*lines[:5], *lines[6:]], "evenly"),
            (lambda lines: [*lines[:5], lines[5].rpartition(",")[0] + ",nan", *lines[6:]], "finite"),
            (lambda lines: ["# repeat 100..152", *lines[1:]], "rows of the file"),
            (lambda lines: lines[:3], "2 rows"),
        ):
            with self.subTest(named), self.assertRaisesRegex(ValueError, named):
                JointFile(self.changed(change), JETHEXA)
        with self.assertRaisesRegex(ValueError, "leg8_tibia_rad"):
            JointFile(self.tripod, OCTOPOD)
        np.testing.assert_allclose(
            JointFile(self.tripod, JETHEXA).all_joint_angles(1.234), Gait(JETHEXA).all_joint_angles(1.22), atol=1e-9
        )

    def test_the_command_records_a_log_and_what_it_is_of(self):
        folder = Path(self.folder.name)
        play = [sys.executable, Path(__file__).with_name("play.py"), self.tripod, "--seed", "3", "--duration", "2"]
        truth = folder / "truth.json"
        for name, more in (("a", []), ("again", []), ("whole", ["--healthy"]), ("plain", ["--nominal"])):
            subprocess.run([*play, *more, "-o", folder / f"{name}.csv.gz", "--truth", truth], check=True)
        content = {name: (folder / f"{name}.csv.gz").read_bytes() for name in ("a", "again", "whole", "plain")}
        self.assertEqual(content["a"], content["again"])
        self.assertEqual(len(set(content.values())), 3)
        truths = json.loads(truth.read_text())
        self.assertEqual(list(truths), ["a", "again", "whole", "plain"])
        self.assertEqual(truths["whole"]["morphology"], [[1] * LINKS] * JETHEXA.legs)
        self.assertEqual(truths["plain"]["plant"]["joints"], str(self.tripod))


if __name__ == "__main__":
    unittest.main()
