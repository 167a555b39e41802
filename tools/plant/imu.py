"""The MPU6050 on the body and the orientation its driver computes.

In: specific force [m/s²] and rate [rad/s] at the sensor in the body frame, and
time stamps [s]. Out: what a log holds: both as reported in the sensor frame, and
roll, pitch, yaw [rad] of a complementary filter without magnetometer.
"""

import math

import numpy as np
from scipy.spatial.transform import Rotation

from robot import GRAVITY_MPS2

RATE_HZ = (950.0, 1000.0)
ACC_LSB = GRAVITY_MPS2 / 2048.0  # range ±16 g
GYRO_LSB = math.radians(1.0 / 65.5)  # range ±500 deg/s
FILTER_TIME_S = 2.0
GRAVITY_GATE = 0.1  # the accelerometer counts while it is within 10 % of gravity
MOUNT_COUPLING_PER_M = 10.0  # angular per linear acceleration of a loose sensor


def quantise(value, lsb):
    return np.clip(np.round(value / lsb), -32768, 32767) * lsb


def swing_on_mount(t, acc, gyro, start, frequency_hz, damping_ratio):
    """A sensor on a soft mount: it lags behind the body about x and y and rings."""
    spring = (2.0 * math.pi * frequency_hz) ** 2
    damper = 2.0 * damping_ratio * 2.0 * math.pi * frequency_hz
    push = (acc - acc[t < start].mean(0))[:, :2]
    push = MOUNT_COUPLING_PER_M * np.column_stack([push[:, 1], -push[:, 0]])
    angle, rate = np.zeros(2), gyro[0, :2].copy()
    angles, rates = np.zeros((len(t), 2)), np.zeros((len(t), 2))
    for i, dt in enumerate(np.diff(t, prepend=t[0])):
        rate = rate + dt * (push[i] - damper * (rate - gyro[i, :2]) - spring * angle)
        angle = angle + dt * (rate - gyro[i, :2])
        angles[i], rates[i] = angle, rate
    tilt = Rotation.from_rotvec(np.column_stack([angles, np.zeros(len(t))]))
    return tilt.apply(acc, inverse=True), np.column_stack([rates, gyro[:, 2]])


def stick(rate, width):
    """Hysteresis: the output follows only when the input leaves a band around it."""
    out = np.empty_like(rate)
    value = rate[0]
    for i, r in enumerate(rate):
        value = min(max(value, r - 0.5 * width), r + 0.5 * width)
        out[i] = value
    return out


def measure(plant, rng, t, acc, gyro):
    """Both triples as the sensor reports them."""
    if plant.loose_mount:
        acc, gyro = swing_on_mount(t, acc, gyro, plant.start, **plant.loose_mount)
    mounted = Rotation.from_euler("ZYX", plant.mis_deg[::-1], degrees=True)
    acc, gyro = mounted.apply(acc, inverse=True), mounted.apply(gyro, inverse=True)
    gyro = gyro / plant.gyro_scale + np.radians(plant.gyro_bias)
    gyro[:, 2] += math.radians(plant.bias_drift_dps_per_min / 60.0) * t
    if plant.hysteresis:
        axis = "xyz".index(plant.hysteresis["axis"])
        gyro[:, axis] = stick(gyro[:, axis], math.radians(plant.hysteresis["width_dps"]))
    acc = acc + np.array(plant.acc_bias) + rng.normal(0.0, plant.acc_noise, acc.shape)
    gyro = gyro + rng.normal(0.0, plant.gyro_noise, gyro.shape)
    return quantise(acc, ACC_LSB), quantise(gyro, GYRO_LSB)


def complementary_filter(t, acc, gyro):
    """Euler angles integrated from the rates, drawn to the accelerometer's roll and pitch."""
    tilt = np.column_stack([np.arctan2(acc[:, 1], acc[:, 2]), np.arctan2(-acc[:, 0], np.hypot(acc[:, 1], acc[:, 2]))])
    gate = np.abs(np.linalg.norm(acc, axis=1) / GRAVITY_MPS2 - 1.0) < GRAVITY_GATE
    dt = np.diff(t, prepend=t[0])
    gain = np.where(gate, dt / FILTER_TIME_S, 0.0)
    roll, pitch, yaw = tilt[0, 0], tilt[0, 1], 0.0
    angles = []
    for (gx, gy, gz), (acc_roll, acc_pitch), k, d in zip(gyro.tolist(), tilt.tolist(), gain.tolist(), dt.tolist()):
        sine, cosine = math.sin(roll), math.cos(roll)
        turn = sine * gy + cosine * gz
        roll, pitch, yaw = (
            roll + d * (gx + turn * math.tan(pitch)),
            pitch + d * (cosine * gy - sine * gz),
            yaw + d * turn / math.cos(pitch),
        )
        roll += k * math.remainder(acc_roll - roll, 2.0 * math.pi)
        pitch += k * (acc_pitch - pitch)
        angles.append((roll, pitch, math.remainder(yaw, 2.0 * math.pi)))
    return np.array(angles)


def log(plant, rng, t, acc, gyro):
    """The ten columns of a log."""
    acc, gyro = measure(plant, rng, t, acc, gyro)
    return np.column_stack([t, acc, gyro, complementary_filter(t, acc, gyro)])
