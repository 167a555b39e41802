"""What an orientation filter and a plain bias make of the recordings of a real gyroscope.

For each recording in `data/real/mpu6050-encoder`, the RMS error to the shaft's encoder of

* the integral of the rate, as the data sheet scales it,
* the same less a constant bias, fitted on the first stretch, or on the first two,
* VQF (D. Laidig and T. Seel, Information Fusion 91, 2023) in the implementation of its
  authors, on rates and accelerations without a magnetometer, with its default settings:
  the tilt about the level shaft, the heading about the upright one.

The stretches are those of `mlr-ga explain-sensor`: fit, selection and test. Integrals start
at the encoder's first reading; VQF's zero is where it differs least from the encoder on the
first two stretches. VQF wants even samples: they are interpolated at the median step. Offline
VQF runs forwards and backwards over the whole recording and knows what comes after each sample.

    python3 -m venv venv && venv/bin/pip install -r tools/bench/requirements.txt
    venv/bin/python tools/bench/vqf_baseline.py

Prints a Markdown table. `--shares 0.5 0` fits on the first half and tests on the second.
"""

import argparse
import csv
import gzip
from pathlib import Path

import numpy as np
from vqf import VQF, offlineVQF

FOLDER = Path(__file__).resolve().parents[2] / "data" / "real" / "mpu6050-encoder"
# Index of the sensor's axis that the shaft turns, and the sign of its rate.
SHAFTS = {"roll": (0, 1.0), "yaw": (2, -1.0)}
STANDARD_GRAVITY_MPS2 = 9.80665
# As in `mlr-ga explain-sensor`, which leaves out what a late sensor does not know yet.
UNSCORED_S = 0.3


def recording(name):
    """Times in s, encoder in degrees, rates in rad/s and specific forces in m/s²."""
    with gzip.open(FOLDER / f"{name}.csv.gz", "rt") as file:
        rows = list(csv.DictReader(file))

    def columns(*names):
        return np.array([[float(row[name]) for name in names] for row in rows])

    times_s = columns("t_s")[:, 0]
    later = np.r_[True, np.diff(np.maximum.accumulate(times_s)) > 0]
    return (
        times_s[later],
        columns("encoder_deg")[later, 0],
        np.radians(columns("g2x_dps", "g2y_dps", "g2z_dps"))[later],
        STANDARD_GRAVITY_MPS2 * columns("a2x_g", "a2y_g", "a2z_g")[later],
    )


def shaft_angle_deg(quaternions, axis, sign):
    """Unwrapped roll or heading of the sensor."""
    w, x, y, z = quaternions.T
    if axis == 0:
        angle = np.arctan2(2 * (w * x + y * z), 1 - 2 * (x * x + y * y))
    else:
        angle = np.arctan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))
    return sign * np.degrees(np.unwrap(angle))


def predictions(times_s, encoder_deg, rates, forces, axis, sign, fit, seen):
    """Name and angle in degrees of each way to get it."""
    since_s = times_s - times_s[0]
    rate_dps = sign * np.degrees(rates[:, axis])
    steps_deg = 0.5 * np.diff(times_s) * (rate_dps[1:] + rate_dps[:-1])
    integral = encoder_deg[0] + np.r_[0.0, np.cumsum(steps_deg)]
    yield "data sheet", integral
    for name, on in (("bias, fitted on fit", fit), ("bias, fitted on fit and selection", seen)):
        missing = (encoder_deg - integral)[on]
        bias_dps = missing @ since_s[on] / (since_s[on] @ since_s[on])
        yield name, integral + bias_dps * since_s

    step_s = np.median(np.diff(times_s))
    even_s = np.arange(times_s[0], times_s[-1], step_s)

    def even(values):
        return np.column_stack([np.interp(even_s, times_s, column) for column in values.T])

    rates, forces = even(rates), even(forces)
    online = VQF(step_s).updateBatch(rates, forces)["quat6D"]
    offline = offlineVQF(rates, forces, None, step_s)["quat6D"]
    for name, quaternions in (("VQF", online), ("offline VQF", offline)):
        angle = np.interp(times_s, even_s, shaft_angle_deg(quaternions, axis, sign))
        yield name, angle + np.mean((encoder_deg - angle)[seen])


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument(
        "--shares",
        nargs=2,
        type=float,
        default=(0.4, 0.3),
        metavar=("FIT", "SELECTION"),
        help="shares of the recording that are fit and selection stretch",
    )
    fit_share, selection_share = parser.parse_args().shares

    print("| shaft | method | fit [°] | selection [°] | test [°] |")
    print("|:--|:--|--:|--:|--:|")
    for name, (axis, sign) in SHAFTS.items():
        times_s, encoder_deg, rates, forces = recording(name)
        share = (times_s - times_s[0]) / (times_s[-1] - times_s[0])
        fit = share < fit_share
        seen = share < fit_share + selection_share
        test = ~seen & (times_s < times_s[-1] - UNSCORED_S)
        stretches = (fit, seen & ~fit, test)
        arguments = (times_s, encoder_deg, rates, forces, axis, sign, fit, seen)
        for method, angle in predictions(*arguments):
            squares = (encoder_deg - angle) ** 2
            errors = [np.sqrt(np.mean(squares[on])) if on.any() else np.nan for on in stretches]
            print(f"| {name} | {method} | " + " | ".join(f"{error:.2f}" for error in errors) + " |")


if __name__ == "__main__":
    main()
