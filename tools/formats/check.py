"""Reads what `mlr-ga convert` wrote with the libraries of the format, and compares.

    mlr-ga convert walk.csv.gz walk.mcap
    python tools/formats/check.py walk.csv.gz walk.mcap

The table must have angles and raw samples, like data/golden/formats/walk.csv.gz.
"""

import argparse
import csv
import gzip
from pathlib import Path

import numpy as np
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory

from make import quaternion

RAW = ("ax_mps2", "ay_mps2", "az_mps2", "gx_radps", "gy_radps", "gz_radps")


def read_mcap(path):
    """Time, quaternion w to z, and raw samples of every message, and what the file says of itself."""
    rows = []
    with path.open("rb") as file:
        reader = make_reader(file, decoder_factories=[DecoderFactory()])
        header, summary = reader.get_header(), reader.get_summary()
        for schema, channel, message, imu in reader.iter_decoded_messages():
            stamp = imu.header.stamp
            assert stamp.sec * 10**9 + stamp.nanosec == message.log_time
            assert (schema.name, channel.message_encoding) == ("sensor_msgs/msg/Imu", "cdr")
            q, a, g = imu.orientation, imu.linear_acceleration, imu.angular_velocity
            rows.append([message.log_time * 1e-9, q.x, q.y, q.z, q.w, a.x, a.y, a.z, g.x, g.y, g.z])
    channel, = summary.channels.values()
    print(f"profile {header.profile}, library {header.library}, topic {channel.topic}")
    print(f"{summary.statistics.message_count} messages in {summary.statistics.chunk_count} chunks")
    assert header.profile == "ros2" and summary.statistics.message_count == len(rows)
    return np.array(rows)


def read_table(path):
    """The same of a table."""
    with gzip.open(path, "rt") as text:
        table = [{name: float(text) for name, text in row.items()} for row in csv.DictReader(text)]
    return np.array([
        [
            row["t_s"],
            *quaternion(row["roll_rad"], row["pitch_rad"], row["yaw_rad"]),
            *(row[name] for name in RAW),
        ]
        for row in table
    ])


def main():
    """Compares every number."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("table", type=Path)
    parser.add_argument("mcap", type=Path)
    arguments = parser.parse_args()
    table, mcap = read_table(arguments.table), read_mcap(arguments.mcap)
    assert table.shape == mcap.shape, (table.shape, mcap.shape)
    # A quaternion and its negative are the same rotation.
    sign = np.sign(np.sum(table[:, 1:5] * mcap[:, 1:5], axis=1))
    mcap[:, 1:5] *= sign[:, None]
    difference = np.abs(table - mcap).max(axis=0)
    print("largest differences: time {:.1e} s, quaternion {:.1e}, raw samples {:.1e}".format(
        difference[0], difference[1:5].max(), difference[5:].max()))
    assert difference[0] < 1e-9 and difference[1:5].max() < 1e-12 and difference[5:].max() == 0.0


if __name__ == "__main__":
    main()
