"""Accuracy against time of a walk: this project's model and MuJoCo, in one run.

Both walk the eight morphologies of `docs/convergence.md` for 0.5 s of standing and
5 s of walking at several time steps, on one core and in turns, so that a busy machine
is unfair to neither. Errors are mean absolute differences to the same engine's walk
at 0.25 ms; time is processor time per walk, the median over the rounds. MuJoCo drives
the joints with its own position actuators, within `mujoco.rollout`, so that no Python
runs between its steps. It is tried with the integrator that it recommends, and with the
one that takes springs implicitly as rapier does, the latter with both of its friction
cones.

    python3 -m venv venv && venv/bin/pip install -r tools/bench/requirements.txt
    cargo build --release -p mlr-model --example walk_speed
    venv/bin/python tools/bench/speed.py

Prints a Markdown table and the ratios at equal accuracy, and writes `docs/speed.svg`.
`--armature` gives the joints of MuJoCo's robot a reflected inertia, which
`data/robot/jethexa.toml` does not know; nothing is plotted then.
"""

import argparse
import math
import resource
import subprocess
import sys
import time
from pathlib import Path

import matplotlib
import mujoco
import numpy as np
from matplotlib import pyplot
from mujoco import rollout

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tools" / "golden"))
import mujoco_walk as golden  # noqa: E402

PROGRAM = ROOT / "target" / "release" / "examples" / "walk_speed"
PLOT = ROOT / "docs" / "speed.svg"
MORPHOLOGIES = (  # links left on each leg
    (3, 3, 3, 3, 3, 3), (3, 3, 0, 3, 3, 3), (3, 3, 3, 3, 0, 3), (3, 3, 0, 0, 3, 3),
    (0, 3, 3, 0, 3, 3), (3, 2, 2, 3, 3, 3), (3, 3, 3, 1, 1, 3), (0, 3, 0, 3, 3, 0),
)
REFERENCE_S = 0.00025
OURS = "mlr-model"
OUR_STEPS_S = (0.002, 0.005, 0.010, 0.020)
DEFAULT_S = 0.010  # `SimulationSettings::default`
THEIR_STEPS_S = (0.001, 0.002, 0.004, 0.005, 0.010, 0.020)
THEIR_OPTIONS = {  # integrator, friction cone, impratio
    "MuJoCo implicitfast": (mujoco.mjtIntegrator.mjINT_IMPLICITFAST, mujoco.mjtCone.mjCONE_ELLIPTIC, 10.0),
    "MuJoCo discrete": (mujoco.mjtIntegrator.mjINT_DISCRETE, mujoco.mjtCone.mjCONE_ELLIPTIC, 10.0),
    "MuJoCo discrete, pyramids": (mujoco.mjtIntegrator.mjINT_DISCRETE, mujoco.mjtCone.mjCONE_PYRAMIDAL, 1.0),
}
SAMPLE_S = 0.020
ROUNDS = 5
REPEATS = 3  # of our walks; their time is that beyond a run without repeats
CLEARANCE_M = 0.001
AXES = ("roll", "pitch", "yaw")
PLOTTED_DEG = {0: (0.02, 1.0), 2: (0.15, 5.0)}  # axis: errors shown


def run_ours(step_s, repeats):
    """Processor time [s] and the walks: morphology, sample, axis [rad]."""
    spelled = [" ".join("1" * n + "0" * (3 - n) for n in links) for links in MORPHOLOGIES]
    command = [PROGRAM, str(step_s), str(repeats), *spelled]
    begin = resource.getrusage(resource.RUSAGE_CHILDREN)
    done = subprocess.run(command, capture_output=True, check=True, text=True)
    end = resource.getrusage(resource.RUSAGE_CHILDREN)
    walks = np.array([line.split() for line in done.stdout.splitlines()], float)
    spent_s = end.ru_utime - begin.ru_utime + end.ru_stime - begin.ru_stime
    return spent_s, walks.reshape(len(MORPHOLOGIES), -1, 3)


def our_walks(step_s):
    """Processor time per walk [s] and the walks."""
    once_s, walks = run_ours(step_s, 1)
    more_s, _ = run_ours(step_s, 1 + REPEATS)
    return (more_s - once_s) / REPEATS / len(MORPHOLOGIES), walks


def mujoco_model(links, step_s, options, armature):
    """The robot of the golden walks, with MuJoCo's own servos. The joints damp themselves."""
    names = [f"{('coxa', 'femur', 'tibia')[j]}{leg}" for leg, n in enumerate(links) for j in range(n)]
    spec = mujoco.MjSpec.from_string(golden.model_xml(links))
    for name in names:
        servo = spec.add_actuator(name=name, target=name, trntype=mujoco.mjtTrn.mjTRN_JOINT)
        servo.set_to_position(kp=golden.STIFFNESS)
        servo.forcelimited, servo.forcerange = True, [-golden.TORQUE_NM, golden.TORQUE_NM]
    for joint in spec.joints:
        if joint.name in names:
            joint.armature = armature
    model = spec.compile()
    model.opt.timestep = step_s
    model.opt.integrator, model.opt.cone, model.opt.impratio = options
    return model


def set_points(links, step_s):
    """What each servo is told at each step, at the servo's speed."""
    joints = [(leg, j) for leg, n in enumerate(links) for j in range(n)]
    ticks = {}

    def commands(t):
        tick = max(math.floor((t - golden.LATENCY_S) / golden.HOLD_S + 1e-6), 0)
        if tick not in ticks:
            angles = [golden.joint_angles(leg, tick * golden.HOLD_S) for leg in range(len(links))]
            ticks[tick] = np.array([angles[leg][j] for leg, j in joints])
        return ticks[tick]

    reach = golden.SPEED * step_s
    points = [commands(0.0)]
    for step in range(-round(golden.SETTLE_S / step_s), round(golden.WALK_S / step_s)):
        points.append(points[-1] + np.clip(commands(step * step_s) - points[-1], -reach, reach))
    return np.array(points)


class MujocoWalk:
    """One morphology with one step, ready to walk any number of times."""

    def __init__(self, links, step_s, options, armature):
        self.step_s = step_s
        self.model = mujoco_model(links, step_s, options, armature)
        self.data = mujoco.MjData(self.model)
        self.told = set_points(links, step_s)
        self.data.qpos[2] = golden.HEIGHT_M + CLEARANCE_M
        self.data.qpos[7:] = self.told[0]
        self.start = np.empty(mujoco.mj_stateSize(self.model, mujoco.mjtState.mjSTATE_FULLPHYSICS))
        mujoco.mj_getState(self.model, self.data, self.start, mujoco.mjtState.mjSTATE_FULLPHYSICS)

    def walk(self):
        """Processor time [s] and the states after each step."""
        begin = time.process_time()
        states, _ = rollout.rollout(self.model, self.data, self.start, self.told[1:])
        return time.process_time() - begin, states[0]

    def angles(self, states):
        """Roll, pitch and yaw at each sample of the walk [rad]."""
        first, stride = round(golden.SETTLE_S / self.step_s) - 1, round(SAMPLE_S / self.step_s)
        w, x, y, z = states[first::stride, 4:8].T
        roll = np.arctan2(2 * (w * x + y * z), 1 - 2 * (x * x + y * y))
        pitch = np.arcsin(np.clip(2 * (w * y - z * x), -1.0, 1.0))
        yaw = np.arctan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))
        return np.column_stack([roll, pitch, np.unwrap(yaw)])


class Mujoco:
    """All morphologies with one step."""

    def __init__(self, step_s, options, armature):
        self.walks = [MujocoWalk(links, step_s, options, armature) for links in MORPHOLOGIES]

    def __call__(self):
        spent, angles = 0.0, []
        for walk in self.walks:
            walk_s, states = walk.walk()
            spent += walk_s
            angles.append(walk.angles(states))
        return spent / len(self.walks), np.array(angles)


def errors_deg(walks, reference):
    """Mean over morphologies and samples, of roll, pitch and yaw."""
    return np.degrees(np.abs(walks - reference).mean((0, 1)))


def compare(ours, theirs):
    """Our time at the default step beside theirs at the same error, as sentences."""
    _, steps, our_times, our_errors = ours
    name, _, times, errors = theirs
    default = steps.index(DEFAULT_S)
    for axis, error_deg in enumerate(our_errors[default]):
        order = np.argsort(errors[:, axis])
        known, their_times = errors[order, axis], times[order]
        bound = "" if known[0] <= error_deg <= known[-1] else "more than " if error_deg < known[0] else "less than "
        equal_s = math.exp(np.interp(math.log(error_deg), np.log(known), np.log(their_times)))
        print(f"at {error_deg:.3f}° of {AXES[axis]}: {OURS} {1e3 * our_times[default]:.1f} ms, "
              f"{name} {bound}{1e3 * equal_s:.1f} ms, ratio {our_times[default] / equal_s:.2f}")


def plot(curves):
    matplotlib.rcParams.update({"svg.hashsalt": "mlr", "svg.fonttype": "none", "font.size": 10})
    figure, panels = pyplot.subplots(1, 2, figsize=(10.0, 4.5), layout="constrained")
    for panel, (axis, shown_deg) in zip(panels, PLOTTED_DEG.items()):
        for (name, steps, times, errors), marker in zip(curves, "os^v"):
            panel.loglog(1e3 * times, errors[:, axis], marker=marker, label=name)
            for step_s, x, y in zip(steps, 1e3 * times, errors[:, axis]):
                panel.annotate(f"{1e3 * step_s:g}", (x, y), (4, 3), textcoords="offset points", fontsize=7)
        panel.set_xlabel("processor time per walk [ms]; step [ms] beside each point")
        panel.set_ylabel(f"error of {AXES[axis]} [°]")
        panel.set_ylim(shown_deg)
        panel.grid(True, which="both", alpha=0.3)
    panels[0].legend(fontsize=8)
    figure.savefig(PLOT, metadata={"Date": None})


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--armature", type=float, default=0.0, help="reflected inertia of MuJoCo's joints [kg m²]")
    armature = parser.parse_args().armature
    runs = {(OURS, step_s): lambda step_s=step_s: our_walks(step_s) for step_s in OUR_STEPS_S}
    references = {OURS: run_ours(REFERENCE_S, 1)[1]}
    for name, options in THEIR_OPTIONS.items():
        runs |= {(name, step_s): Mujoco(step_s, options, armature) for step_s in THEIR_STEPS_S}
        references[name] = Mujoco(REFERENCE_S, options, armature)()[1]
    times, walks = {key: [] for key in runs}, {}
    for _ in range(ROUNDS):
        for key, run in runs.items():
            spent_s, walks[key] = run()
            times[key].append(spent_s)

    print("| engine | step [ms] | roll [°] | pitch [°] | yaw [°] | time [ms] |\n|:--|--:|--:|--:|--:|--:|")
    curves = []
    for name, reference in references.items():
        keys = [key for key in runs if key[0] == name]
        medians_s = np.array([np.median(times[key]) for key in keys])
        errors = np.array([errors_deg(walks[key], reference) for key in keys])
        curves.append((name, [step_s for _, step_s in keys], medians_s, errors))
        for (_, step_s), walk_s, (roll, pitch, yaw) in zip(keys, medians_s, errors):
            print(f"| {name} | {1e3 * step_s:g} | {roll:.3f} | {pitch:.3f} | {yaw:.2f} | {1e3 * walk_s:.1f} |")
    for theirs in curves[1:]:
        compare(curves[0], theirs)
    if armature == 0.0:
        plot(curves)


if __name__ == "__main__":
    main()
