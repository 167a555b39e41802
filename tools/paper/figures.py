"""The paper's figures as SVG. The same data are the same bytes."""

import matplotlib
import numpy as np

matplotlib.use("svg")
matplotlib.rcParams.update({"svg.hashsalt": "mlr", "font.size": 9, "axes.grid": True, "grid.alpha": 0.3})
import matplotlib.pyplot as plt  # noqa: E402

AXES = ("roll", "pitch", "yaw")
MEASURED, SIMULATED, RAW = "#1f4e79", "#d96b0b", "#9aa5b1"
CUTOFF_HZ, THRESHOLD_DEG2 = 10.0, 0.1


def save(figure, path):
    figure.tight_layout()
    figure.savefig(path, metadata={"Date": None})
    plt.close(figure)


def convergence(runs, angles, title, path):
    """The least F of each run, generation by generation; `angles` are summed in F."""
    figure, axes = plt.subplots(figsize=(7, 3.5))
    for run in runs:
        axes.plot(np.radians(run["cost_per_generation"]) * angles, color=MEASURED, alpha=0.6)
    axes.set(xlabel="generation", ylabel="least F so far [rad]", title=f"{len(runs)} runs of --method paper: {title}")
    save(figure, path)


def right_and_wrong(pair, titles, path):
    """Measured and simulated angles after Algorithm 2, for a right and a wrong morphology."""
    figure, rows = plt.subplots(3, 2, figsize=(9, 6), sharex=True, sharey="row")
    for column, ((report, signals), title) in enumerate(zip(pair, titles)):
        for axes, name in zip(rows[:, column], AXES):
            axes.plot(signals["t_s"], signals[f"measured_{name}_deg"], color=MEASURED, label="measured")
            axes.plot(signals["t_s"], signals[f"simulated_{name}_deg"], color=SIMULATED, label="simulated")
            axes.set_ylabel(f"{name} [°]")
        rows[0, column].set_title(f"{title}, F = {report['cost_rad']:.1f} rad")
        rows[2, column].set_xlabel("time since the start of the walk [s]")
    rows[0, 0].legend()
    save(figure, path)


def power(angles_deg):
    """One-sided mean-square power of each bin, as `mlr_filter::PowerSpectrum` has it."""
    bins = np.abs(np.fft.rfft(angles_deg) / len(angles_deg)) ** 2
    bins[1:] *= 2.0
    return bins


def spectra(log, start_s, signals, path, duration_s=5.0):
    """Recorded angles and their spectra, raw and after Algorithm 2."""
    within = (log["t_s"] >= start_s) & (log["t_s"] < start_s + duration_s)
    even_s = start_s + np.arange(0.0, duration_s, 0.001)
    figure, rows = plt.subplots(3, 2, figsize=(9, 6))
    for (left, right), name in zip(rows, AXES):
        raw_deg = np.degrees(np.interp(even_s, log["t_s"][within], np.unwrap(log[f"{name}_rad"][within])))
        raw_deg -= raw_deg[0]
        filtered_deg = signals[f"measured_{name}_deg"]
        left.plot(even_s - start_s, raw_deg, color=RAW, label="recorded")
        left.plot(signals["t_s"], filtered_deg, color=MEASURED, label="after Algorithm 2")
        left.set_ylabel(f"{name} [°]")
        for angles_deg, color, width in ((raw_deg, RAW, 3), (filtered_deg, MEASURED, 1)):
            bins = power(angles_deg)[: int(15 * duration_s)]
            right.semilogy(np.arange(len(bins)) / duration_s, np.maximum(bins, 1e-6), color=color, lw=width)
        right.axvline(CUTOFF_HZ, color=SIMULATED, ls="--", lw=1)
        right.axhline(THRESHOLD_DEG2, color=SIMULATED, ls="--", lw=1)
        right.set_ylabel("power [deg²]")
    rows[0, 0].legend()
    rows[2, 0].set_xlabel("time since the start of the walk [s]")
    rows[2, 1].set_xlabel("frequency [Hz]; dashed: F_c and P_c")
    save(figure, path)


def terrain(plant, path, half_width_m=0.8):
    """The ground of the harsh test from above: rubble on a slope."""
    from types import SimpleNamespace

    import robot

    bumps_mm = 1000.0 * plant["rubble_m"] * robot.rubble(SimpleNamespace(rubble_seed=plant["rubble_seed"]))
    reach = robot.RUBBLE_HALF_WIDTH_M
    figure, axes = plt.subplots(figsize=(5.5, 4.5))
    shown = axes.imshow(bumps_mm, origin="lower", extent=(-reach, reach, -reach, reach), cmap="copper", interpolation="nearest")
    axes.set(xlim=(-half_width_m, half_width_m), ylim=(-half_width_m, half_width_m), xlabel="x, ahead [m]", ylabel="y, left [m]")
    uphill = np.radians(plant["slope_dir_deg"])
    axes.annotate("", xytext=(0, 0), xy=(0.5 * np.cos(uphill), 0.5 * np.sin(uphill)), arrowprops={"color": "white", "width": 2})
    axes.add_patch(plt.Rectangle((-0.105, -0.078), 0.21, 0.156, fill=False, color="white", lw=1.5))
    axes.set_title(f"rubble on a slope of {plant['slope_deg']:.0f}° (arrow: uphill; box: the body)")
    axes.grid(False)
    figure.colorbar(shown, label="height [mm]")
    save(figure, path)
