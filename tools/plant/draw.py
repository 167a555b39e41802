"""Draws sets of IMU logs of damaged robots that walk, with the truth beside them.

    python tools/plant/draw.py SET --seed N --count M -o DIR

SET is one of the functions in `SETS`; see README.md.
"""

import argparse
import contextlib
import copy
import dataclasses
import gzip
import io
import json
import math
import time
from pathlib import Path

import numpy as np

import effects
from robot import JETHEXA, LINKS, OCTOPOD
from settings import assemble, draw_plant
from walk import record

HEADER = "t_s,ax_mps2,ay_mps2,az_mps2,gx_radps,gy_radps,gz_radps,roll_rad,pitch_rad,yaw_rad"
SIBLINGS = 3  # robots that show by how much bodies of one batch walk unlike each other
FORMAT = ["%.5f"] + ["%.3f"] * 3 + ["%.4f"] * 3 + ["%.5f"] * 3


def without(legs, left=0, robot=JETHEXA):
    """Links left on each leg when `legs` (numbered from 1) keep only `left` of theirs."""
    return [left if leg + 1 in legs else LINKS for leg in range(robot.legs)]


def some_legs(rng, number, robot=JETHEXA):
    return sorted(int(leg) + 1 for leg in rng.choice(robot.legs, number, replace=False))


def any_damage(rng, healthy=0.10):
    """Unknown damage: whole legs mostly, or the last links of one or two legs."""
    kind = rng.choice(5, p=[healthy, 0.40 - healthy, 0.35, 0.10, 0.15])
    if kind < 4:
        return without(some_legs(rng, kind))
    intact = without([])
    for leg in some_legs(rng, rng.integers(1, 3)):
        intact[leg - 1] = int(rng.integers(1, 3))
    return intact


def robot_with(rng, intact, robot=JETHEXA):
    plant = draw_plant(rng, intact, robot)
    plant.locked = bool(any(links < LINKS for links in intact) and rng.random() < 0.5)
    return plant


def paper(rng, index):
    """The paper's eight scenarios on even ground."""
    scenarios = [
        without([3]), without([5]), without([1, 4]), without([3, 4]), without([3, 4], 1), without([3, 4], 2),
        without([4, 5]), without([2, 3]),
    ]
    intact = scenarios[index % len(scenarios)]
    return intact, robot_with(rng, intact), []


def legs(rng, index):
    """Healthy, every leg, some pairs, every leg without its last one or two links."""
    each = range(1, JETHEXA.legs + 1)
    cases = [without([])] + [without([leg]) for leg in each] + [without(some_legs(rng, 2)) for _ in each]
    cases += [without([leg], 1) for leg in each] + [without([leg], 2) for leg in each]
    intact = cases[index % len(cases)]
    return intact, robot_with(rng, intact), []


def rough_slope(rng, plant):
    """A slope of 7° covered with bumps of about 1 cm."""
    return [
        effects.apply(plant, "slope", effects.slope(rng, 7.0, 7.0)),
        effects.apply(plant, "rubble", effects.rubble(rng, 0.008, 0.012)),
    ]


def harsh(rng, index):
    """Any damage on a slope of 7° covered with bumps of about 1 cm."""
    intact = any_damage(rng, healthy=0.0)
    plant = robot_with(rng, intact)
    return intact, plant, rough_slope(rng, plant)


def slow(rng, index):
    """Any damage, slow and soft servos, and a gait clock that is up to 7 % off."""
    intact = any_damage(rng, healthy=0.0)
    plant = robot_with(rng, intact)
    plant.kp, plant.latency = rng.uniform(14.0, 20.0), rng.uniform(0.030, 0.050)
    return intact, plant, [effects.apply(plant, "gait_period", {"scale": rng.uniform(0.93, 1.07)})]


def wild(rng, index):
    """Any damage and wide ranges of everything; a third each: slope, payload, tilted IMU."""
    intact = any_damage(rng)
    plant = robot_with(rng, intact)
    plant.kp, plant.kd = rng.uniform(14.0, 45.0), rng.uniform(0.35, 0.90)
    plant.mu, plant.latency = rng.uniform(0.35, 1.0), rng.uniform(0.0, 0.050)
    plant.period_scale = rng.uniform(0.97, 1.03)
    found = []
    for kind, parameters in (
        ("slope", effects.slope(rng, 0.0, 7.0)),
        ("payload", effects.payload(rng, 0.0, 0.4)),
        ("imu_misalignment", effects.misalignment(rng, 0.0, 2.0)),
    ):
        if rng.random() < 1.0 / 3.0:
            found.append(effects.apply(plant, kind, parameters))
    return intact, plant, found


def undeclared(rng, index):
    """One effect a log, in turn, weak and strong, on healthy and damaged robots; some with two.

    A round is every kind once, then a healthy and a damaged robot without effect.
    """
    known = [kind for kind in effects.LIBRARY if kind not in effects.GEARS]  # these have a set of their own
    kinds = known + ["none, healthy", "none, damaged"]
    lap, kind = divmod(index, len(kinds))
    kind, strong = kinds[kind], bool((kind + lap) % 2)
    damaged = kind in ("locked_links", "none, damaged") or (kind != "none, healthy" and rng.random() < 0.5)
    intact = any_damage(rng, healthy=0.0) if damaged else without([])
    plant = assemble(rng, robot_with(rng, intact))
    if kind.startswith("none"):
        return intact, plant, []
    found = [effects.apply(plant, kind, effects.draw(rng, kind, strong, intact))]
    if rng.random() < 0.15:
        others = [k for k in known if k not in (kind, "locked_links", *effects.OUTSIDE)]
        second = str(rng.choice(others))
        found.append(effects.apply(plant, second, effects.draw(rng, second, bool(rng.random() < 0.5), intact)))
    return intact, plant, found


def detect(rng, index):
    """A healthy robot that stands for 6 s, walks for 13 s, locks one or two legs and walks on."""
    intact = without(some_legs(rng, rng.integers(1, 3)))
    plant = robot_with(rng, intact)
    plant.locked, plant.start, plant.damage_s, plant.walk_s = True, 6.0, 19.0, 26.0
    return intact, plant, []


def belly(rng, index):
    """Three or more damaged legs, a whole tripod group among them: the body rests on its belly."""
    group = ([1, 4, 5], [2, 3, 6])[index % 2]
    intact = without(group)
    for leg in group:
        intact[leg - 1] = int(rng.choice([0, 0, 0, 1, 2]))
    if rng.random() < 0.3:
        intact[int(rng.choice([leg for leg in range(JETHEXA.legs) if leg + 1 not in group]))] = 0
    return intact, robot_with(rng, intact), []


def strange(rng, index):
    """What no morphology explains: other gaits, a sensor that faces elsewhere, a robot that is shaken."""
    kind = ("phases", "sideways", "backward", "turned sensor", "shaken", "tiptoe")[index % 6]
    intact = any_damage(rng, healthy=0.4)
    plant = robot_with(rng, intact)
    match kind:
        case "phases":
            plant.gait = {"phase": tuple(float(p) for p in rng.permutation(JETHEXA.legs) / JETHEXA.legs)}
        case "sideways":
            plant.gait = {"heading_rad": float(rng.choice([-1.0, 1.0])) * math.radians(rng.uniform(60.0, 120.0))}
        case "backward":
            plant.gait = {"heading_rad": math.radians(rng.uniform(150.0, 210.0))}
        case "turned sensor":
            plant.mis_deg[2] = float(rng.choice([-90.0, 90.0, 180.0]))
        case "shaken":
            plant.vibration = {
                "axis": str(rng.choice(["x", "y"])),
                "torque_nm": rng.uniform(2.0, 5.0),
                "frequency_hz": rng.uniform(0.3, 2.5),
            }
        case "tiptoe":
            plant.gait = {"stride_m": rng.uniform(0.0, 0.03), "lift_m": rng.uniform(0.005, 0.02)}
    return intact, plant, [{"kind": kind, "parameters": {}}]


def octopod(rng, index):
    """The octopod with none to four damaged legs, half of which keep one or two links."""
    intact = without([], robot=OCTOPOD)
    for leg in some_legs(rng, index % 5, OCTOPOD):
        intact[leg - 1] = int(rng.choice([0, 0, 1, 2]))
    return intact, robot_with(rng, intact, OCTOPOD), []


PAPER_TESTS = [  # damaged legs, links left on them, tests: the paper's table of results
    ([3], 0, 2), ([5], 0, 2), ([1, 4], 0, 4), ([3, 4], 0, 2), ([3, 4], 1, 2), ([3, 4], 2, 2), ([4, 5], 0, 2),
    ([2, 3], 0, 2),
]


def tests(rng, index):
    """The paper's 18 tests, then legs 1 and 4 on its harsh ground; lost links are locked, as the paper's were."""
    each = [without(legs, left) for legs, left, count in PAPER_TESTS for _ in range(count)]
    intact = each[index] if index < len(each) else without([1, 4])
    plant = draw_plant(rng, intact)
    plant.locked = True
    return intact, plant, rough_slope(rng, plant) if index >= len(each) else []


def undisturbed(rng, index):
    """Healthy robots and any damage, as they were assembled, with nothing else wrong."""
    intact = any_damage(rng, healthy=0.2)
    return intact, assemble(rng, robot_with(rng, intact)), []


def gears(rng, index):
    """Dry friction of all joints, play of all joints, and both in turn, weak and strong; any damage or none."""
    intact = any_damage(rng, healthy=0.2)
    plant = assemble(rng, robot_with(rng, intact))
    lap, kinds = divmod(index, 3)
    found = [
        effects.apply(plant, kind, effects.draw(rng, kind, bool(lap % 2), intact))
        for bit, kind in enumerate(effects.GEARS) if (kinds + 1) >> bit & 1
    ]
    return intact, plant, found


# A log depends on its set's place in this list: new sets come last.
SETS = {
    "paper": paper, "legs": legs, "harsh": harsh, "slow": slow, "wild": wild, "effects": undeclared, "detect": detect,
    "belly": belly, "strange": strange, "octopod": octopod, "tests": tests,
    "undisturbed": undisturbed, "gears": gears,
}


def truth(intact, plant, found, walk):
    entry = {
        "morphology": [[int(link < links) for link in range(LINKS)] for links in intact],
        "locked": plant.locked,
        "motion_start_s": plant.start,
        "rows": len(walk.columns),
        "effect": found[0] if found else None,
        "effects": found,
        "lost_contact_steps": walk.lost_contacts,
        "plant": plant.to_json(),
    }
    return entry | ({"start_s": plant.start, "damage_s": plant.damage_s} if plant.damage_s > 0.0 else {})


def truths_before(known, first):
    """What an earlier call wrote of the logs before this one; nothing where a set begins anew."""
    return json.loads(known.read_text()) if first > 0 and known.exists() else {}


def trace(plain, intact, walk, noise, siblings):
    """What the effects of a walk change of roll, pitch and yaw while the robot walks, in degrees.

    See `change`. `plain` is the robot without them, which walks once more with the same `noise` (the generator
    as it was before the walk). `spread` is what robots with other bodies of the batch, drawn from the generator
    `siblings`, change of that walk, in the root mean square.
    """
    without = record(plain, intact, copy.deepcopy(noise)).columns
    changes = []
    for _ in range(SIBLINGS):
        sibling = dataclasses.replace(plain, **body(assemble(siblings, draw_plant(siblings, intact, plain.robot))))
        changes.append(change(without, record(sibling, intact, copy.deepcopy(noise)).columns, plain.start))
    mean, swing = change(without, walk.columns, plain.start)
    spread = np.sqrt(np.mean(np.square(changes), axis=0))
    return {
        "mean_deg": np.round(mean, 3).tolist(), "swing_deg": np.round(swing, 3).tolist(),
        "spread": {"mean_deg": np.round(spread[0], 3).tolist(), "swing_deg": np.round(spread[1], 3).tolist()},
    }


def body(plant):
    """What makes one body walk unlike the next, its sensor and clock left out."""
    names = (
        "kp", "kd", "mu", "latency", "mass_scale", "link_mass_scale", "body_com", "backlash", "armature",
        "contact_time_s", "contact_width_m", "joint_zero_rad",
    )
    return {name: getattr(plant, name) for name in names}


def change(columns, changed, start_s):
    """By how much the angles of a walk differ from another's, in degrees.

    For each axis the mean of the difference, and the RMS of what is left of it without
    mean and trend, at the shift in time (of up to 0.2 s) that leaves least.
    """
    start, end = start_s + 0.5, changed[-1, 0] - 0.3
    grid = np.arange(start, end, 0.02)

    def angles(columns, shift):
        unwrapped = np.degrees(np.unwrap(columns[:, 7:10], axis=0))
        return np.column_stack([np.interp(grid + shift, columns[:, 0], axis) for axis in unwrapped.T])

    def split(shift):
        difference = angles(changed, shift) - angles(columns, 0.0)
        line = np.column_stack([np.ones(len(grid)), grid - grid.mean()])
        fit, *_ = np.linalg.lstsq(line, difference, rcond=None)
        return fit[0], np.std(difference - line @ fit, axis=0)

    return min((split(shift) for shift in np.arange(-0.2, 0.2, 0.01)), key=lambda s: float(np.sum(s[1] ** 2)))


def write(path, columns):
    """Without a time stamp in the archive: the same data are the same bytes."""
    text = io.StringIO()
    np.savetxt(text, columns, fmt=FORMAT, delimiter=",", header=HEADER, comments="")
    path.write_bytes(gzip.compress(text.getvalue().encode(), 6, mtime=0))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("set", choices=SETS)
    parser.add_argument("--seed", type=int, required=True)
    parser.add_argument("--count", type=int, required=True)
    parser.add_argument("-o", "--output", type=Path, required=True)
    parser.add_argument("--first", type=int, default=0, help="draw from this log on, and add them to those that are there")
    parser.add_argument("--without-effects", action="store_true", help="the same robots with nothing wrong but lost links")
    args = parser.parse_args()
    args.output.mkdir(parents=True, exist_ok=True)
    known, began = args.output / "truth.json", time.monotonic()
    truths = truths_before(known, args.first)
    for index in range(args.first, args.count):
        entropy = [args.seed, list(SETS).index(args.set), index]
        rng = np.random.default_rng(entropy)
        with effects.none() if args.without_effects else contextlib.nullcontext():
            intact, plant, found = SETS[args.set](rng, index)
        found = [] if args.without_effects else found
        before = copy.deepcopy(rng)
        walk = record(plant, intact, rng)
        name = f"{args.set}-{index:03}"
        write(args.output / f"{name}.csv.gz", walk.columns)
        truths[name] = truth(intact, plant, found, walk)
        if found and args.set in ("effects", "gears"):
            siblings = np.random.default_rng(entropy)
            with effects.none():
                _, plain, _ = SETS[args.set](siblings, index)
            truths[name]["trace"] = trace(plain, intact, walk, before, siblings)
        known.write_text(json.dumps(truths, indent=1) + "\n")
    print(f"{args.count - args.first} logs in {time.monotonic() - began:.1f} s")


if __name__ == "__main__":
    main()
