"""Fits the error models of `crates/mlr-ga/src/belief/plausibility.rs` to evaluated logs.

    mlr-ga evaluate paper legs wild harsh slow belly strange --atlas jethexa.atlas --json > answers.json
    python tools/plant/plausibility.py answers.json

Answers that name the right legs teach how far the right morphology usually is off; wrong ones
of the set `strange` how far the best is off where none is right. Both models are Student
distributions of ln e with six degrees of freedom, fitted by maximum likelihood. Of the mean error
of the nominal model its share of the motion is shown, by quantiles.
"""

import argparse
import json
from pathlib import Path

import numpy as np
from scipy.optimize import minimize

DEGREES_OF_FREEDOM = 6.0
NAMES = ("noise_deg", "motion_share", "noise_spread", "motion_spread")


def unpack(packed):
    """Noise, share and their spreads for each axis, and the correlation, from free numbers."""
    return np.exp(packed[:12]).reshape(4, 3), 1.0 / (1.0 + np.exp(-packed[12]))


def ln_density(packed, error_deg, motion_deg):
    (noise, share, noise_spread, motion_spread), r = unpack(packed)
    n2, m2 = noise**2, (share * motion_deg) ** 2
    spread = np.sqrt((noise_spread**2 * n2 + motion_spread**2 * m2) / (n2 + m2))
    z = (np.log(error_deg) - 0.5 * np.log(n2 + m2)) / spread
    distance2 = ((z**2).sum(1) - r * z.sum(1) ** 2 / (1.0 + 2.0 * r)) / (1.0 - r)
    ln_determinant = 2.0 * np.log(1.0 - r) + np.log(1.0 + 2.0 * r)
    tail = 0.5 * (DEGREES_OF_FREEDOM + 3.0) * np.log1p(distance2 / DEGREES_OF_FREEDOM)
    return -0.5 * ln_determinant - np.log(spread).sum(1) - tail


def fit(cost, start):
    """Nelder and Mead, begun anew where it first stops."""
    for _ in range(3):
        start = minimize(cost, start, method="Nelder-Mead", options={"maxiter": 20000, "maxfev": 20000}).x
    return start


def show(title, packed):
    values, correlation = unpack(packed)
    print(title)
    for name, row in zip(NAMES, values):
        print(f"  {name:<14}{np.round(row, 3).tolist()}")
    print(f"  {'correlation':<14}{correlation:.2f}")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("answers", type=Path, nargs="+")
    args = parser.parse_args()
    right, wrong = [], []
    for path in args.answers:
        for directory in json.loads(path.read_text())["directories"]:
            strange = Path(directory["directory"]).name == "strange"
            for log in directory["logs"]:
                if log["legs_right"] and not strange:
                    right.append(log)
                elif strange and not log["legs_right"]:
                    wrong.append(log)
    columns = [np.array([log[name] for log in logs]) for logs in (right, wrong) for name in ("error_deg", "motion_deg")]
    error, motion, strange_error, strange_motion = columns

    start = np.log([0.03, 0.1, 0.03, 0.06, 0.06, 0.15, 0.2, 0.4, 0.2, 0.6, 0.6, 0.7])
    usual = fit(lambda p: -ln_density(p, error, motion).sum(), np.append(start, 0.0))
    show(f"usual, {len(right)} logs", usual)

    def of_unexplained(free):
        spreads = np.tile(free[3:6], 2)
        return np.concatenate([usual[:3], free[:3], spreads, free[6:]])

    begin = np.concatenate([np.log([0.9] * 3), np.log([0.4] * 3), [0.0]])
    free = fit(lambda p: -ln_density(of_unexplained(p), strange_error, strange_motion).sum(), begin)
    show(f"unexplained, {len(wrong)} logs", of_unexplained(free))

    for title, logs in (("usual", right), ("unexplained", wrong)):
        shares = [log["mean_error_deg"] / np.sqrt(np.mean(np.square(log["motion_deg"]))) for log in logs]
        print(f"mean error / motion, {title}: 5, 50, 95 % {np.round(np.quantile(shares, [0.05, 0.5, 0.95]), 2).tolist()}")


if __name__ == "__main__":
    main()
