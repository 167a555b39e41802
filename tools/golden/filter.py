"""Golden data for the FFT filter, made with SciPy.

Reads a log, cuts a window out of it, and applies Algorithm 2 of the paper with
SciPy's own parts: linear interpolation, `periodogram`, `find_peaks`, and a plain
sum of cosines for the inverse transform. Writes the result next to the log.

    python3 -m venv venv && venv/bin/pip install -r tools/golden/requirements.txt
    venv/bin/python tools/golden/filter.py
"""

import gzip
import io
from pathlib import Path

import numpy as np
from scipy.signal import find_peaks, periodogram

DATA = Path(__file__).resolve().parents[2] / "data"
CUTOFF_HZ = 10.0
THRESHOLD_DEG2 = 0.1
RATE_HZ = 250.0
AXES = ("roll", "pitch", "yaw")


def read(path):
    with gzip.open(path, "rt") as text:
        return np.genfromtxt(text, delimiter=",", names=True)


def write(path, header, columns):
    """Compressed without a time stamp, so that the same data are the same bytes."""
    text = io.StringIO()
    np.savetxt(text, np.column_stack(columns), fmt="%.17g", delimiter=",", header=header, comments="")
    with open(path, "wb") as raw, gzip.GzipFile("", "wb", fileobj=raw, mtime=0) as packed:
        packed.write(text.getvalue().encode())


def cut(log, start_s, duration_s):
    """The window on an even grid of about the log's own rate, starting at zero."""
    t = log["t_s"]
    first = np.flatnonzero(t <= start_s + 1e-9)[-1]
    last = np.flatnonzero(t >= start_s + duration_s - 1e-9)[0]
    rate_hz = (last - first) / (t[last] - t[first])
    points = round(rate_hz * duration_s)
    grid_s = start_s + np.arange(points) * duration_s / points
    signals = {axis: np.interp(grid_s, t, log[f"{axis}_rad"]) for axis in AXES}
    return points / duration_s, {axis: x - x[0] for axis, x in signals.items()}


def condition(axis, signal, rate_hz, duration_s):
    frequency_hz, power_deg2 = periodogram(
        np.degrees(signal), rate_hz, window="boxcar", detrend=False, scaling="spectrum"
    )
    power_deg2[frequency_hz > CUTOFF_HZ + 1e-9] = 0.0
    strong = np.flatnonzero(power_deg2 > THRESHOLD_DEG2)
    if axis != "yaw":
        strong = np.intersect1d(strong, find_peaks(power_deg2)[0])
    spectrum = np.fft.rfft(signal) / len(signal)
    t = np.arange(round(RATE_HZ * duration_s)) / RATE_HZ
    result = np.zeros_like(t)
    for k in strong:
        weight = 1.0 if k == 0 else 2.0
        phase = 2.0 * np.pi * frequency_hz[k] * t
        result += weight * (spectrum[k].real * np.cos(phase) - spectrum[k].imag * np.sin(phase))
    return result


def expected(log, start_s, duration_s):
    rate_hz, signals = cut(log, start_s, duration_s)
    return [condition(axis, signals[axis], rate_hz, duration_s) for axis in AXES]


def synthetic():
    """Oscillations on and off the bins, a drift, noise, 950 to 1000 Hz with jitter."""
    random = np.random.default_rng(20261121)
    t = np.cumsum(random.uniform(1 / 1000, 1 / 950, 6400))
    tau = 2.0 * np.pi
    noise = lambda: random.normal(0.0, 2e-4, t.size)
    roll = 0.05 * np.sin(tau * 1.0 * t) + 0.02 * np.sin(tau * 3.07 * t + 1.0) + noise()
    pitch = 0.03 * np.sin(tau * 0.93 * t + 2.0) + 0.3 + 0.01 * np.sin(tau * 12.0 * t) + noise()
    yaw = 0.08 * t + 0.02 * np.sin(tau * 2.0 * t) + noise()
    return np.rec.fromarrays([t, roll, pitch, yaw], names="t_s,roll_rad,pitch_rad,yaw_rad")


def main():
    folder = DATA / "golden" / "filter"
    header = "t_s,roll_rad,pitch_rad,yaw_rad"
    log = synthetic()
    path = folder / "synthetic.csv.gz"
    write(path, header, [log[name] for name in header.split(",")])
    write(folder / "synthetic-start0.5-duration5.csv.gz", "roll_rad,pitch_rad,yaw_rad", expected(read(path), 0.5, 5.0))
    log = read(DATA / "logs" / "stand-in" / "legs1-4-lost.csv.gz")
    write(folder / "legs1-4-lost-start2.22-duration5.csv.gz", "roll_rad,pitch_rad,yaw_rad", expected(log, 2.22, 5.0))
    write(folder / "legs1-4-lost-start4-duration2.csv.gz", "roll_rad,pitch_rad,yaw_rad", expected(log, 4.0, 2.0))


if __name__ == "__main__":
    main()
