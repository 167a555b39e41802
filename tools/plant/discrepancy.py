"""Learns the covariance of the model's own error from robots that lack nothing.

    python tools/plant/draw.py undisturbed --seed 1001 --count 60 -o undisturbed-1001
    mlr-ga evaluate-discrepancy undisturbed-1001 -o walks.json
    python tools/plant/discrepancy.py walks.json -o data/discrepancy/jethexa.toml

`walks.json` holds, for each walk, what the model of the right robot leaves when its nuisance
parameters are fitted, and its sensitivities to these. The parameters of the Gaussian process in
`crates/mlr-residual/src/walk/discrepancy.rs` are those that make all residuals together most
probable, the nuisance parameters integrated out (type-II maximum likelihood): amplitudes first,
then how the scale of the errors is distributed. They are found by a pattern
search over their logarithms. Residuals left by a search that stopped early count like the
engine's: an explanation searches with the same effort.
"""

import argparse
import json
from multiprocessing import Pool

import numpy as np
from scipy.linalg import solve_triangular

HARMONICS = 8
ANY_YAW_DEG = 180.0
GYROSCOPE_DEG_PER_SQRT_S = 0.004
SCALES = 2.0 ** np.arange(-1.5, 5.1, 0.5)
ANY_SCALE = np.where(SCALES >= 1.0, -np.log((SCALES >= 1.0).sum()), -np.inf)
UNUSUAL = 0.05  # share of robots whose walk the engine does not meet, for no known reason
PARTS = ("constant", "periodic", "irregular")
AMPLITUDE = ("base_deg", "swing_share", "spread_share")
PRIOR_SPREAD = 1.5  # of the logarithm of each parameter about where the search starts


def starting_point():
    values = {}
    for axis in ("tilt", "yaw"):
        values[f"{axis}.white"] = {"base_deg": 0.01, "swing_share": 0.002, "spread_share": 0.01}
        for part in PARTS:
            values[f"{axis}.{part}"] = {"base_deg": 0.03, "swing_share": 0.01, "spread_share": 0.2}
        values[axis] = {"harmonic_decay": 0.5, "coherence_s": 4.0, "irregular_s": 0.3, "ln_scale_deviation": 0.5, "ln_scale_spread": 0.2}
    values["turning"] = {"base_dps": 0.4, "share": 0.1, "spread_share": 0.3}
    values["all"] = {"largest_spread_deg": 4.0}
    return {f"{group}.{name}": value for group, names in values.items() for name, value in names.items()}


START = starting_point()
NAMES = list(START)


class Walk:
    """One walk, with what of its covariance does not depend on the parameters."""

    def __init__(self, walk):
        self.t = np.array(walk["walked_s"])
        self.period_s, self.spread_deg = walk["period_s"], walk["spread_deg"]
        self.swing_deg = [walk["swing_deg"], walk["swing_deg"], walk["yaw_swing_deg"]]
        self.turned_dps, self.turning_spread_dps = walk["turned_dps"], walk["turning_spread_dps"]
        self.residual = np.array(walk["residual_deg"])
        self.z2 = sum(p["z_score"] ** 2 for p in walk["parameters"])
        self.sensitivity = np.array([p["sensitivity_deg"] for p in walk["parameters"]])
        walks = self.t > 0.0
        self.walks = np.outer(walks, walks).astype(float)
        self.lag_s = self.t[:, None] - self.t[None, :]
        turns = 2.0 * np.pi * self.lag_s / self.period_s
        self.waves = [np.cos((k + 1) * turns) for k in range(HARMONICS)]
        since_s = self.t + walk["stood_s"]
        self.noise = GYROSCOPE_DEG_PER_SQRT_S**2 * np.minimum.outer(since_s, since_s)
        strides_s = np.where(self.t < self.period_s, self.t**2 / (2.0 * self.period_s), self.t - self.period_s / 2.0)
        self.turning = np.outer(strides_s, strides_s) * self.walks

    def covariance(self, p, axis):
        name = "yaw" if axis == 2 else "tilt"
        spread_deg = self.spread_deg / (1.0 + self.spread_deg / p["all.largest_spread_deg"])

        def variance(part):
            base, swing, spread = (p[f"{name}.{part}.{a}"] for a in AMPLITUDE)
            return base**2 + (swing * self.swing_deg[axis]) ** 2 + (spread * spread_deg) ** 2

        shares = np.arange(1, HARMONICS + 1) ** (-2.0 * p[f"{name}.harmonic_decay"])
        periodic = sum(share * wave for share, wave in zip(shares / shares.sum(), self.waves))
        periodic = periodic * np.exp(-0.5 * (self.lag_s / p[f"{name}.coherence_s"]) ** 2)
        lag = np.sqrt(3.0) * np.abs(self.lag_s) / p[f"{name}.irregular_s"]
        irregular = (1.0 + lag) * np.exp(-lag)
        walking = variance("constant") + variance("periodic") * periodic + variance("irregular") * irregular
        base = p[f"{name}.white.base_deg"] ** 2
        white = base + np.diag(self.walks) * (variance("white") - base)
        total = self.noise + self.walks * walking + np.diag(white)
        if axis == 2:
            total += ANY_YAW_DEG**2
            spread_dps = p["turning.spread_share"] * self.turning_spread_dps
            turned_dps = p["turning.share"] * self.turned_dps
            total += (p["turning.base_dps"] ** 2 + turned_dps**2 + spread_dps**2) * self.turning
        return total

    def ln_evidence(self, p, is_robust):
        count = self.sensitivity.shape[0]
        ln_density, normal = -0.5 * self.z2, np.eye(count)
        # Roll and pitch have a scale of the errors in common, yaw has its own.
        for axes, axes_name in ((0, 1), "tilt"), ((2,), "yaw"):
            curvature, square = np.zeros((count, count)), 0.0
            for axis in axes:
                try:
                    factor = np.linalg.cholesky(self.covariance(p, axis))
                except np.linalg.LinAlgError:
                    return -1e9
                columns = np.column_stack([self.sensitivity[:, axis].T, self.residual[axis]])
                white = solve_triangular(factor, columns, lower=True)
                curvature += white[:, :-1].T @ white[:, :-1]
                square += white[:, -1] @ white[:, -1]
                ln_density -= np.log(np.diag(factor)).sum()
            wide = p[f"{axes_name}.ln_scale_deviation"] + p[f"{axes_name}.ln_scale_spread"] * np.log1p(self.spread_deg)
            terms = ln_scale_prior(wide, is_robust) - 0.5 * square / SCALES**2
            terms -= len(axes) * len(self.t) * np.log(SCALES)
            total = np.logaddexp.reduce(terms)
            ln_density += total
            normal += (np.exp(terms - total) / SCALES**2).sum() * curvature
        return ln_density - 0.5 * np.linalg.slogdet(normal)[1]


def ln_scale_prior(wide, is_robust):
    """Student's distribution of the logarithm, or a normal one beside walks that are missed altogether."""
    if is_robust:
        tail = -2.0 * np.log1p((np.log(SCALES) / wide) ** 2 / 3.0)
        return tail - np.logaddexp.reduce(tail)
    usual = -0.5 * (np.log(SCALES) / wide) ** 2
    usual -= np.logaddexp.reduce(usual)
    return np.logaddexp(np.log(1.0 - UNUSUAL) + usual, np.log(UNUSUAL) + ANY_SCALE)


walks = []


def load(paths):
    walks[:] = [Walk(walk) for path in paths for walk in json.load(open(path))["walks"]]


def of_walk(job):
    index, x, is_robust = job
    return walks[index].ln_evidence(dict(zip(NAMES, np.exp(x))), is_robust)


def search(pool, sweeps, x, free, is_robust):
    """The most probable parameters by a pattern search over the `free` ones, begun at `x`."""
    start = np.log([START[name] for name in NAMES])

    def cost(x):
        prior = 0.5 * ((x - start)[free] ** 2).sum() / PRIOR_SPREAD**2
        return prior - sum(pool.map(of_walk, [(k, x, is_robust) for k in range(len(walks))], chunksize=4))

    x, step, random = x.copy(), np.full(len(x), 0.7), np.random.default_rng(1)
    best = cost(x)
    for sweep in range(sweeps):
        before = best
        for k in random.permutation(free):
            for sign in (1.0, -1.0):
                moved = x.copy()
                moved[k] += sign * step[k]
                tried = cost(moved)
                if tried < best:
                    x, best = moved, tried
                    step[k] *= 1.4
                    break
            else:
                step[k] *= 0.5
        print(f"sweep {sweep + 1}: ln evidence {-best:.1f}", flush=True)
        if before - best < 1.0:
            break
    return x


def learned(pool, sweeps):
    """Amplitudes first, with a scale of heavy tails, so that walks that are missed do not count; then
    how the scale is distributed, and how that depends on the spread."""
    x = np.log([START[name] for name in NAMES])
    of_spread = [k for k, name in enumerate(NAMES) if name.endswith("ln_scale_spread")]
    of_scale = [k for k, name in enumerate(NAMES) if "ln_scale" in name]
    x[of_spread] = np.log(1e-6)
    x = search(pool, sweeps, x, [k for k in range(len(x)) if k not in of_spread], True)
    x[of_scale] = np.log([START[NAMES[k]] for k in of_scale])
    x = search(pool, sweeps, x, of_scale, False)
    return dict(zip(NAMES, np.exp(x)))


# Chosen, not learned from these walks: with it, the intervals of 25 calibrated robots hold the plant's values (owned.py).
PHYSICAL_POWER = 0.01
ENGINE_BIAS = 1.2


def table(p, power):
    lines = [f"# Learned by tools/plant/discrepancy.py from {len(walks)} walks of robots that lack nothing.", f"power = {power}",
             f"physical_power = {PHYSICAL_POWER}", f"engine_bias = {ENGINE_BIAS}"]
    lines += [f"largest_spread_deg = {p['all.largest_spread_deg']:.4g}", "rest_rate_dps = 0.03"]
    lines += ["", "[turning]"]
    lines += [f"{name} = {p[f'turning.{name}']:.4g}" for name in ("base_dps", "share", "spread_share")]
    for axis in ("tilt", "yaw"):
        lines += ["", f"[{axis}]"]
        lines += [f"{name} = {p[f'{axis}.{name}']:.4g}" for name in ("harmonic_decay", "coherence_s", "irregular_s", "ln_scale_deviation", "ln_scale_spread")]
        for part in ("white", *PARTS):
            lines.append(f"{part} = {{ " + ", ".join(f"{a} = {p[f'{axis}.{part}.{a}']:.4g}" for a in AMPLITUDE) + " }")
    return "\n".join(lines) + "\n"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("walks", nargs="+")
    parser.add_argument("-o", "--output", required=True)
    parser.add_argument("--sweeps", type=int, default=14)
    parser.add_argument("--power", type=float, default=0.2)
    args = parser.parse_args()
    load(args.walks)
    with Pool(initializer=load, initargs=(args.walks,)) as pool:
        found = learned(pool, args.sweeps)
    with open(args.output, "w") as file:
        file.write(table(found, args.power))


if __name__ == "__main__":
    main()
