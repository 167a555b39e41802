"""Learns how many robots the engine misses as something unknown would make them walk.

    mlr-ga evaluate-discrepancy --means SET… -o means.json
    python tools/plant/missed.py means.json [--check others.json]

The robots of the sets lack nothing but what they are known to, so that where something unknown would make a walk likelier
the engine errs. The odds to be missed grow with a power of how far robots of one make spread in the walk; both numbers,
for `[missed]` of data/discrepancy/jethexa-mean.toml, are the most probable ones. The gains are those by the table
that the program was run with: this comes after discrepancy.py. --check says what they are worth on other robots. Shares of
thirds of the robots, by their own likelihood, show what the power of the spread has to follow.
"""

import argparse
import json

import numpy as np
from scipy.optimize import minimize, minimize_scalar

WIDE = 3.0  # deviation of the logarithms of both numbers about where the search starts
START = np.log([10.0, 1.0])


def gains_of(paths):
    walks = [walk for path in paths for walk in json.load(open(path))["walks"]]
    known = [(walk["spread_deg"], walk["ln_gain_of_unknown"]) for walk in walks if walk["ln_gain_of_unknown"] is not None]
    return np.array(known).T


def ln_likelihood(ln_numbers, spread_deg, ln_gain):
    half_at_deg, power = np.exp(ln_numbers)
    ln_odds = power * np.log(spread_deg / half_at_deg)
    return (np.logaddexp(0.0, ln_odds + ln_gain) - np.logaddexp(0.0, ln_odds)).sum()


def share_by_itself(ln_gain):
    """Of robots of which nothing is known but their gains."""
    minus_ln_likelihood = lambda share: -np.logaddexp(np.log1p(-share), np.log(share) + ln_gain).sum()
    return minimize_scalar(minus_ln_likelihood, bounds=(1e-6, 1.0 - 1e-6), method="bounded").x


def describe(name, ln_numbers, known):
    half_at_deg, power = np.exp(ln_numbers)
    expected = (1.0 / (1.0 + (half_at_deg / known[0]) ** power)).sum()
    print(f"# {name}: {known.shape[1]} robots, {expected:.1f} missed, ln likelihood {ln_likelihood(ln_numbers, *known):.1f}")
    for third in np.array_split(known[:, known[0].argsort()], 3, axis=1):
        print(f"#   spread {third[0][0]:.2f} to {third[0][-1]:.2f} degrees: share {share_by_itself(third[1]):.2f}")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("walks", nargs="+")
    parser.add_argument("--check", nargs="+", default=[])
    args = parser.parse_args()
    known = gains_of(args.walks)
    minus_ln_posterior = lambda x: 0.5 * (((x - START) / WIDE) ** 2).sum() - ln_likelihood(x, *known)
    found = minimize(minus_ln_posterior, START, method="Nelder-Mead").x
    half_at_deg, power = np.exp(found)
    print(f"[missed]\nhalf_at_deg = {half_at_deg:.3g}\npower = {power:.3g}")
    describe("these", found, known)
    if args.check:
        describe("others", found, gains_of(args.check))


if __name__ == "__main__":
    main()
