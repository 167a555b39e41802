# %% [markdown]
# # A walk that changes
#
# A log of a hexapod that stands for six seconds, walks, and loses legs: when was it damaged, which
# legs are gone, and does the model with these legs gone walk like it? The log is a stand-in, recorded from
# a simulated robot that is not the model's own (`data/logs/stand-in/README.md`).
#
# The cells run in VS Code and Jupyter (Jupytext); the file runs as it is:
#
#     python damaged_walk.py [PICTURE]

# %%
import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import mlr

here = Path(__file__).parent if "__file__" in globals() else Path.cwd()
data = next(folder / "data" for folder in [here, *here.parents] if (folder / "data" / "logs").is_dir())

recording = mlr.read_log(data / "logs" / "stand-in" / "detect-legs3-4.csv.gz")
t = recording["t"]
print(f"{len(t)} samples in {t[-1] - t[0]:.1f} s: {', '.join(recording)}")

# %% [markdown]
# ## When
# The detector watches how far roll and pitch swing within a sliding window.

# %%
detection = mlr.detect(**recording)
print(f"walks from {detection['motion_start_s']:.2f} s on, damage flagged at {detection['damage_s']:.2f} s")

# %% [markdown]
# ## Which legs
# Lost links were cut off in this log, so that only that is tried: it takes half of the time.

# %%
answer = mlr.identify(**recording, lost_links="absent", progress=lambda done, of: print(f"\r{done}/{of}", end=""))
print(f"\rdamaged legs: {answer['damaged_legs']}, with a probability of {answer['legs_probability']:.1%}")
for leg, probability in enumerate(answer["leg_damage_probability"], start=1):
    print(f"  leg {leg}: {probability:7.2%} {'#' * round(30 * probability)}".rstrip())

# %% [markdown]
# ## The model beside the robot
# A robot without these legs walks in the model. Where in its gait the robot was when the damage struck is
# not known, so the simulated walk is shifted by what fits its pitch and roll best, within a cycle.

# %%
fit = answer["fit"]
walk = mlr.simulate(
    morphology=answer["morphology"],
    lost_links=fit["lost_links"],
    friction=fit["friction"],
    stand_s=0.0,
    walk_s=10.0,
    time_step_s=0.01,
)

start_s, length_s = answer["window_start_s"], answer["window_s"]
window = np.arange(0.0, length_s, 0.01)
recorded = {"roll": recording["roll"], "pitch": recording["pitch"], "yaw": recording["yaw"]}
walked = {"roll": walk["roll"], "pitch": walk["pitch"], "yaw": walk["yaw"]}
measured = {name: np.interp(start_s + window, t, angle) for name, angle in recorded.items()}


def simulated(shift_s: float) -> dict[str, np.ndarray[tuple[int], np.dtype[np.float64]]]:
    """The walk of the model from so long after its start on, its yaw from where the robot's was."""
    angles = {name: np.interp(shift_s + window, walk["t"], angle) for name, angle in walked.items()}
    angles["yaw"] = angles["yaw"] - angles["yaw"][0] + measured["yaw"][0]
    return angles


def error_deg(shift_s: float) -> float:
    """Root mean square of roll and pitch without their means."""
    left = [measured[name] - angle for name, angle in simulated(shift_s).items() if name != "yaw"]
    return float(np.degrees(np.sqrt(np.mean([np.var(one) for one in left]))))


shift_s = min(np.arange(1.0, 4.0, 0.01), key=error_deg)
print(f"roll and pitch differ by {error_deg(shift_s):.2f}° RMS")

# %%
figure, axes = plt.subplots(4, 1, figsize=(9, 10), constrained_layout=True)
axes[0].plot(t, np.degrees(recording["roll"]), label="roll")
axes[0].plot(t, np.degrees(recording["pitch"]), label="pitch")
axes[0].axvline(detection["damage_s"], color="tab:red", label="damage flagged")
axes[0].axvspan(start_s, start_s + length_s, color="0.9", label="compared")
axes[0].set(title=answer["description"], ylabel="degrees")
axes[0].legend(loc="lower left", ncols=2)
for axis, (name, angle) in zip(axes[1:], measured.items()):
    axis.plot(start_s + window, np.degrees(angle), label="measured")
    axis.plot(start_s + window, np.degrees(simulated(shift_s)[name]), "--", label="simulated")
    axis.set(ylabel=f"{name} in degrees")
axes[1].legend(loc="upper right", ncols=2)
axes[-1].set(xlabel="time in seconds")

if len(sys.argv) > 1 and sys.argv[1].endswith((".png", ".svg", ".pdf")):
    figure.savefig(sys.argv[1], dpi=90)
else:
    plt.show()
