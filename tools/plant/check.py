"""Compares the plant with the stand-in logs of `data/logs/stand-in`.

    python tools/plant/check.py

Walks every robot of the stand-in truth that has no undeclared effect with the
settings given there (the others at their draw's values) and prints, next to the
stand-in log's numbers, the range of roll and pitch and the mean yaw rate of the
walk after its first second, the noise of roll and pitch
around a cubic while standing, and for
how many physics steps a locked link touched the ground. Angles in degrees.
"""

import gzip
import json
from pathlib import Path

import numpy as np

from settings import draw_plant
from walk import record

LOGS = Path(__file__).resolve().parents[2] / "data" / "logs" / "stand-in"
GIVEN = (
    "kp", "kd", "mu", "latency", "mass_scale", "body_com", "backlash", "gyro_bias", "mis_deg", "period_scale", "start",
)


def numbers(columns, start):
    t, angles = columns[:, 0], np.degrees(np.unwrap(columns[:, 7:10], axis=0))
    walking, standing = t > start + 1.0, t < start - 0.1
    roll, pitch, yaw = angles[walking].T
    noise = [np.std(a - np.polyval(np.polyfit(t[standing], a, 3), t[standing])) for a in angles[standing, :2].T]
    return (
        f"roll {roll.min():6.2f} {roll.max():6.2f}  pitch {pitch.min():6.2f} {pitch.max():6.2f}"
        f"  yaw rate {np.polyfit(t[walking], yaw, 1)[0]:6.2f}  standing {noise[0]:.4f} {noise[1]:.4f}"
    )


def main():
    for name, truth in json.loads((LOGS / "truth.json").read_text()).items():
        if truth["effect"] or "damage_s" in truth:
            continue
        with gzip.open(LOGS / f"{name}.csv.gz") as text:
            columns = np.loadtxt(text, delimiter=",", skiprows=1)
        print(f"{name:14} log   {numbers(columns, truth['motion_start_s'])}")
        rng = np.random.default_rng(1)
        intact = [sum(leg) for leg in truth["morphology"]]
        plant = draw_plant(rng, intact)
        for setting in GIVEN:
            setattr(plant, setting, truth["plant"][setting])
        plant.locked = truth["locked"]
        walk = record(plant, intact, rng)
        touched = f"  touched {walk.lost_contacts}" if plant.locked else ""
        print(f"{'':14} plant {numbers(walk.columns, plant.start)}{touched}")


if __name__ == "__main__":
    main()
