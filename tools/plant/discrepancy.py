"""Learns the covariance of the model's own error from robots that are known.

    python tools/plant/draw.py undisturbed --seed 1001 --count 60 -o undisturbed-1001
    python tools/plant/draw.py effects --seed 1002 --count 100 -o effects-1002
    mlr-ga evaluate-discrepancy undisturbed-1001 -o walks.json
    python tools/plant/discrepancy.py walks.json -o data/discrepancy/jethexa.toml
    mlr-ga evaluate-discrepancy --means undisturbed-1001 -o means.json
    mlr-ga evaluate-discrepancy --means effects-1002 -o means-effects.json
    python tools/plant/discrepancy.py means.json means-effects.json -o data/discrepancy/jethexa-mean.toml

`walks.json` holds, for each walk, what the model of the right robot leaves when its parameters, those of its
effects among them, are fitted, and its sensitivities to these; `means.json` what the mean of such walks leaves, how
single walks scatter about it, and what compliant impacts change. The parameters of the Gaussian process in
`crates/mlr-residual/src/walk/discrepancy/covariance.rs` are those that make all residuals together most
probable, all parameters integrated out (type-II maximum likelihood): amplitudes first,
then how the scale of the errors is distributed. They are found by a pattern
search over their logarithms. Residuals left by a search that stopped early count like the
engine's: an explanation searches with the same effort.
"""

import argparse
import json
import os
from multiprocessing import Pool

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # processes share the cores already; read when numpy is loaded
import numpy as np
from scipy.linalg import solve_triangular

HARMONICS = 8
ANY_YAW_DEG = 180.0
GYROSCOPE_DEG_PER_SQRT_S = 0.004
SCALES = 2.0 ** np.arange(-3.0, 5.1, 0.5)  # smaller ones than in the program: amplitudes may begin too large
ANY_SCALE = np.where(SCALES >= 1.0, -np.log((SCALES >= 1.0).sum()), -np.inf)
UNUSUAL = 0.05  # share of robots whose walk the engine does not meet, for no known reason
PARTS = ("constant", "periodic", "irregular")
AMPLITUDE = ("base_deg", "swing_share", "spread_share", "impacts_share")
OF_AXIS = ("harmonic_decay", "coherence_s", "irregular_s", "ln_scale_deviation", "ln_scale_spread", "scatter_share", "impacts_share")
# One plant is no other, and no real robot: means are not trusted further than these, chosen on stand-in logs, which are of
# another simulation (docs/explain.md).
LEAST = {"base_deg": 0.035, "swing_share": 0.01}
REWEIGHTINGS = 6  # times that nuisance parameters and scales are found from each other
PRIOR_SPREAD = 2.0  # of the logarithm of each parameter about where the search starts


def starting_point():
    values = {}
    for axis in ("tilt", "yaw"):
        values[f"{axis}.white"] = {"base_deg": 0.01, "swing_share": 0.002, "spread_share": 0.01, "impacts_share": 0.03}
        for part in PARTS:
            values[f"{axis}.{part}"] = {"base_deg": 0.03, "swing_share": 0.01, "spread_share": 0.2, "impacts_share": 0.2}
        values[axis] = dict(zip(OF_AXIS, (0.5, 4.0, 0.3, 0.3, 0.2, 1.0, 1.0)))
    values["turning"] = {"base_dps": 0.4, "share": 0.1, "spread_share": 0.3}
    values["all"] = {"largest_spread_deg": 4.0}
    return {f"{group}.{name}": value for group, names in values.items() for name, value in names.items()}


START = starting_point()
NAMES = list(START)


class Walk:
    """One walk, with what of its covariance does not depend on the parameters."""

    def __init__(self, walk, with_scatter, with_impacts):
        self.t = np.array(walk["walked_s"])
        self.period_s, self.spread_deg = walk["period_s"], walk["spread_deg"]
        self.swing_deg = [walk["swing_deg"], walk["swing_deg"], walk["yaw_swing_deg"]]
        self.turned_dps, self.turning_spread_dps = walk["turned_dps"], walk["turning_spread_dps"]
        columns = [np.array([column[axis] for column in walk["scatter_deg"]]) for axis in range(3)]
        self.is_mean = with_scatter and len(walk["scatter_deg"]) > 0
        self.scatter = [c.T @ c if self.is_mean else 0.0 for c in columns]
        of_impacts = walk["impacts_deg"] if self.is_mean and with_impacts else [[0.0]] * 3
        self.impacts = [np.outer(column, column) for column in of_impacts]
        roll_deg, pitch_deg, yaw_deg = (np.std(np.array(c)[self.t > 0.0]) if len(c) > 1 else 0.0 for c in of_impacts)
        tilt_deg = np.hypot(roll_deg, pitch_deg) / np.sqrt(2.0)
        self.impacts_deg = [tilt_deg, tilt_deg, yaw_deg]
        self.residual = np.array(walk["residual_deg"])
        self.z = np.array([p["z_score"] for p in walk["parameters"]])
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
            base, *shares = (p[f"{name}.{part}.{a}"] for a in AMPLITUDE)
            of = (self.swing_deg[axis], spread_deg, self.impacts_deg[axis])
            return base**2 + sum((share * by) ** 2 for share, by in zip(shares, of))

        shares = np.arange(1, HARMONICS + 1) ** (-2.0 * p[f"{name}.harmonic_decay"])
        periodic = sum(share * wave for share, wave in zip(shares / shares.sum(), self.waves))
        periodic = periodic * np.exp(-0.5 * (self.lag_s / p[f"{name}.coherence_s"]) ** 2)
        lag = np.sqrt(3.0) * np.abs(self.lag_s) / p[f"{name}.irregular_s"]
        irregular = (1.0 + lag) * np.exp(-lag)
        walking = variance("constant") + variance("periodic") * periodic + variance("irregular") * irregular
        base = p[f"{name}.white.base_deg"] ** 2
        white = base + np.diag(self.walks) * (variance("white") - base)
        total = self.noise + self.walks * walking + np.diag(white)
        total = total + p[f"{name}.scatter_share"] ** 2 * self.scatter[axis]
        total = total + p[f"{name}.impacts_share"] ** 2 * self.impacts[axis]
        if axis == 2:
            total += ANY_YAW_DEG**2
            spread_dps = p["turning.spread_share"] * self.turning_spread_dps
            turned_dps = p["turning.share"] * self.turned_dps
            total += (p["turning.base_dps"] ** 2 + turned_dps**2 + spread_dps**2) * self.turning
        return total

    def ln_evidence(self, p, is_robust):
        """By Laplace's approximation; the walk is linear in its nuisance parameters."""
        # Roll and pitch have a scale of the errors in common, yaw has its own.
        groups = []
        for axes, axes_name in ((0, 1), "tilt"), ((2,), "yaw"):
            products, ln_determinant = 0.0, 0.0
            for axis in axes:
                try:
                    factor = np.linalg.cholesky(self.covariance(p, axis))
                except np.linalg.LinAlgError:
                    return -1e9
                columns = np.column_stack([self.sensitivity[:, axis].T, self.residual[axis]])
                white = solve_triangular(factor, columns, lower=True)
                products = products + white.T @ white
                ln_determinant += np.log(np.diag(factor)).sum()
            wide = p[f"{axes_name}.ln_scale_deviation"] + p[f"{axes_name}.ln_scale_spread"] * np.log1p(self.spread_deg)
            ln_scales = ln_scale_prior(wide, is_robust) - len(axes) * len(self.t) * np.log(SCALES)
            groups.append((products, ln_scales, ln_determinant))
        count = self.sensitivity.shape[0]
        step, z = np.zeros(count), self.z
        for _ in range(REWEIGHTINGS):
            ln_density, normal, slope = -0.5 * ((z + step) ** 2).sum(), np.eye(count), -z
            for products, ln_scales, ln_determinant in groups:
                at = np.append(-step, 1.0)
                terms = ln_scales - 0.5 * (at @ products @ at) / SCALES**2
                total = np.logaddexp.reduce(terms)
                ln_density += total - ln_determinant
                precision = (np.exp(terms - total) / SCALES**2).sum()
                normal += precision * products[:-1, :-1]
                slope = slope + precision * products[:-1, -1]
            step = np.linalg.solve(normal, slope)
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


def load(paths, with_scatter, with_impacts):
    walks[:] = [Walk(walk, with_scatter, with_impacts) for path in paths for walk in json.load(open(path))["walks"]]


def parameters(x):
    """Of these logarithms; for means none is less than it is trusted to be."""
    p = dict(zip(NAMES, np.exp(x)))
    return trusted(p) if any(walk.is_mean for walk in walks) else p


def of_walk(job):
    index, x, is_robust = job
    return walks[index].ln_evidence(parameters(x), is_robust)


def together(free):
    """Which parameters move at once: each alone, and what amplitudes of one axis have in common; a scale that
    all robots have is an amplitude that no part has alone."""
    named = [[k for k in free if NAMES[k].startswith(axis) and NAMES[k].endswith(end)]
             for axis in ("tilt", "yaw") for end in (*AMPLITUDE, tuple(AMPLITUDE))]
    return [[k] for k in free] + [group for group in named if group]


def search(pool, sweeps, x, free, is_robust):
    """The most probable parameters by a pattern search over the `free` ones, begun at `x`."""
    start = np.log([START[name] for name in NAMES])

    def cost(x):
        prior = 0.5 * ((x - start)[free] ** 2).sum() / PRIOR_SPREAD**2
        return prior - sum(pool.map(of_walk, [(k, x, is_robust) for k in range(len(walks))], chunksize=4))

    moves = together(free)
    x, step, random = x.copy(), np.full(len(moves), 0.7), np.random.default_rng(1)
    best = cost(x)
    for sweep in range(sweeps):
        before = best
        for move in random.permutation(len(moves)):
            for sign in (1.0, -1.0):
                moved = x.copy()
                moved[moves[move]] += sign * step[move]
                tried = cost(moved)
                if tried < best:
                    x, best = moved, tried
                    step[move] *= 1.4
                    break
            else:
                step[move] *= 0.5
        print(f"sweep {sweep + 1}: ln evidence {-best:.1f}", flush=True)
        if before - best < 0.5 and step.max() < 0.2:
            break
    return x


def learned(pool, sweeps):
    """Amplitudes first, with a scale of heavy tails, so that walks that are missed do not count; then
    how the scale is distributed, and how that depends on the spread."""
    x = np.log([START[name] for name in NAMES])
    of_spread = [k for k, name in enumerate(NAMES) if name.endswith("ln_scale_spread")]
    of_scale = [k for k, name in enumerate(NAMES) if "ln_scale" in name]
    x[of_spread] = np.log(1e-6)
    of_amplitude = [k for k in range(len(x)) if k not in of_scale]
    if not any(walk.is_mean for walk in walks):
        of_scatter = [k for k, name in enumerate(NAMES) if name.endswith(("scatter_share", "impacts_share"))]
        x[of_scatter] = -np.inf
        of_amplitude = [k for k in of_amplitude if k not in of_scatter]
    x = search(pool, sweeps, x, of_amplitude, True)
    x[of_scale] = np.log([START[NAMES[k]] for k in of_scale])
    return parameters(search(pool, sweeps, x, of_scale, False))


def trusted(p):
    """The same with parts of at least the size that another simulation leaves."""
    least = {f"{axis}.{part}.base_deg": LEAST["base_deg"] for axis in ("tilt", "yaw") for part in PARTS}
    least |= {f"{axis}.periodic.swing_share": LEAST["swing_share"] for axis in ("tilt", "yaw")}
    return {name: max(value, least.get(name, 0.0)) for name, value in p.items()}


def table(p, power):
    lines = [f"# Learned by tools/plant/discrepancy.py from {len(walks)} walks of robots that are known.", f"power = {power}"]
    lines += [f"largest_spread_deg = {p['all.largest_spread_deg']:.4g}", "rest_rate_dps = 0.03"]
    lines += ["", "[turning]"]
    lines += [f"{name} = {p[f'turning.{name}']:.4g}" for name in ("base_dps", "share", "spread_share")]
    for axis in ("tilt", "yaw"):
        lines += ["", f"[{axis}]"]
        lines += [f"{name} = {p[f'{axis}.{name}']:.4g}" for name in OF_AXIS]
        for part in ("white", *PARTS):
            lines.append(f"{part} = {{ " + ", ".join(f"{a} = {p[f'{axis}.{part}.{a}']:.4g}" for a in AMPLITUDE) + " }")
    return "\n".join(lines) + "\n"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("walks", nargs="+")
    parser.add_argument("-o", "--output", required=True)
    parser.add_argument("--sweeps", type=int, default=14)
    parser.add_argument("--power", type=float, default=0.2)
    parser.add_argument("--without-scatter", action="store_true", help="as if single walks did not scatter, to compare")
    parser.add_argument("--without-impacts", action="store_true", help="as if it were known how impacts are resolved, to compare")
    args = parser.parse_args()
    of = (args.walks, not args.without_scatter, not args.without_impacts)
    load(*of)
    with Pool(initializer=load, initargs=of) as pool:
        found = learned(pool, args.sweeps)
    with open(args.output, "w") as file:
        file.write(table(found, args.power))


if __name__ == "__main__":
    main()
