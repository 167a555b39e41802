"""Writes a log of this project as bags of ROS 1 and as MCAP, by the libraries of those formats.

    python tools/formats/make.py data/logs/stand-in/legs3-4-lost.csv.gz data/golden/formats

makes the files that the tests read back: twelve seconds at about 140 Hz as a table, as a bag
and as MCAP, compressed in every way there is, and two seconds with several topics.
"""

import argparse
import csv
import dataclasses
import gzip
from pathlib import Path

import numpy as np
from mcap.writer import CompressionType
from mcap.writer import Writer as McapWriter
from mcap_ros2.writer import Writer as Ros2Writer
from rosbags.rosbag1 import Writer as BagWriter
from rosbags.typesys import Stores, get_typestore

ROS1 = get_typestore(Stores.ROS1_NOETIC)
ROS2 = get_typestore(Stores.ROS2_HUMBLE)
IMU = "sensor_msgs/msg/Imu"
# When the walk is said to have begun: any time will do, and the same one makes the same files.
BEGIN_NS = 1_700_000_000_000_000_000
# Samples of the log to one that is kept.
EVERY = 7
LENGTH_S = 12.0
SHORT_S = 2.0


def read_log(path):
    """The rows of a log as dictionaries of texts, thinned out."""
    with gzip.open(path, "rt") as text:
        rows = list(csv.DictReader(text))[::EVERY]
    return [row for row in rows if float(row["t_s"]) <= LENGTH_S]


def quaternion(roll, pitch, yaw):
    """x, y, z, w of Rz(yaw) Ry(pitch) Rx(roll)."""
    (sr, sp, sy), (cr, cp, cy) = (f(np.array([roll, pitch, yaw]) / 2) for f in (np.sin, np.cos))
    return (
        sr * cp * cy - cr * sp * sy,
        cr * sp * cy + sr * cp * sy,
        cr * cp * sy - sr * sp * cy,
        cr * cp * cy + sr * sp * sy,
    )


def imu_message(store, sequence, row, with_orientation=True):
    """A row as a message of one of the type stores, and its time in nanoseconds."""
    types = store.types
    value = {name: float(text) for name, text in row.items()}
    time_ns = BEGIN_NS + round(value["t_s"] * 1e9)
    stamp = types["builtin_interfaces/msg/Time"](sec=time_ns // 10**9, nanosec=time_ns % 10**9)
    of_ros1 = {"seq": sequence} if store is ROS1 else {}
    vector = types["geometry_msgs/msg/Vector3"]
    x, y, z, w = quaternion(value["roll_rad"], value["pitch_rad"], value["yaw_rad"])
    unknown = np.zeros(9)
    if not with_orientation:
        x, y, z, w = 0.0, 0.0, 0.0, 0.0
        unknown = np.array([-1.0, *np.zeros(8)])
    message = types[IMU](
        header=types["std_msgs/msg/Header"](stamp=stamp, frame_id="imu_link", **of_ros1),
        orientation=types["geometry_msgs/msg/Quaternion"](x=x, y=y, z=z, w=w),
        orientation_covariance=unknown,
        angular_velocity=vector(*(value[f"g{axis}_radps"] for axis in "xyz")),
        angular_velocity_covariance=np.zeros(9),
        linear_acceleration=vector(*(value[f"a{axis}_mps2"] for axis in "xyz")),
        linear_acceleration_covariance=np.zeros(9),
    )
    return message, time_ns


def write_csv(path, rows):
    """A table with the columns of the log; the same rows give the same bytes."""
    with path.open("wb") as file, gzip.GzipFile(fileobj=file, mode="wb", mtime=0, filename="") as zipped:
        zipped.write((",".join(rows[0]) + "\n").encode())
        for row in rows:
            zipped.write((",".join(row.values()) + "\n").encode())


def write_bag(path, rows, compression=None):
    """A bag of ROS 1 with the one topic /imu/data."""
    bag = BagWriter(path)
    if compression is not None:
        bag.set_compression(compression)
    with bag:
        connection = bag.add_connection("/imu/data", IMU, typestore=ROS1)
        for sequence, row in enumerate(rows):
            message, time_ns = imu_message(ROS1, sequence, row)
            bag.write(connection, time_ns, ROS1.serialize_ros1(message, IMU))


def write_bag_of_several_topics(path, rows):
    """A bag without compression: raw samples, orientations, and texts."""
    with BagWriter(path) as bag:
        raw = bag.add_connection("/imu/data_raw", IMU, typestore=ROS1)
        fused = bag.add_connection("/imu/data", IMU, typestore=ROS1)
        log = bag.add_connection("/rosout", "std_msgs/msg/String", typestore=ROS1)
        for sequence, row in enumerate(rows):
            message, time_ns = imu_message(ROS1, sequence, row, with_orientation=False)
            bag.write(raw, time_ns, ROS1.serialize_ros1(message, IMU))
            message, time_ns = imu_message(ROS1, sequence, row)
            if sequence % 2 == 0:
                bag.write(fused, time_ns + 1000, ROS1.serialize_ros1(message, IMU))
            text = ROS1.types["std_msgs/msg/String"](data="x" * (sequence % 50))
            bag.write(log, time_ns + 2000, ROS1.serialize_ros1(text, "std_msgs/msg/String"))


def with_lists(message):
    """A message as mcap-ros2-support takes it, which knows lists and no arrays."""
    arrays = {
        field.name: getattr(message, field.name).tolist()
        for field in dataclasses.fields(message)
        if isinstance(getattr(message, field.name), np.ndarray)
    }
    return dataclasses.replace(message, **arrays)


def write_ros2_mcap(path, rows):
    """MCAP as ROS 2 writes it, by mcap-ros2-support: Zstandard."""
    definition, _ = ROS2.generate_msgdef(IMU, ros_version=2)
    with path.open("wb") as file:
        mcap = Ros2Writer(file)
        schema = mcap.register_msgdef(IMU, definition)
        for sequence, row in enumerate(rows):
            message, time_ns = imu_message(ROS2, sequence, row)
            message = with_lists(message)
            mcap.write_message("/imu/data", schema, message, time_ns, time_ns, sequence)
        mcap.finish()


def write_mcap(path, rows, store, encoding, compression, chunked=True):
    """MCAP whose messages are serialised by rosbags: of ROS 1, or of ROS 2 on a big-endian machine."""
    version = 1 if store is ROS1 else 2
    definition, _ = store.generate_msgdef(IMU, ros_version=version)
    name = "sensor_msgs/Imu" if version == 1 else IMU
    with path.open("wb") as file:
        mcap = McapWriter(file, compression=compression, use_chunking=chunked)
        mcap.start(profile=f"ros{version}")
        schema = mcap.register_schema(name, f"ros{version}msg", definition.encode())
        channel = mcap.register_channel("/imu/data", encoding, schema)
        for sequence, row in enumerate(rows):
            message, time_ns = imu_message(store, sequence, row)
            if store is ROS1:
                data = store.serialize_ros1(message, IMU)
            else:
                data = store.serialize_cdr(message, IMU, little_endian=False)
            mcap.add_message(channel, time_ns, bytes(data), time_ns, sequence)
        mcap.finish()


def main():
    """Writes every file."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("log", type=Path, help="with angles and raw samples, .csv.gz")
    parser.add_argument("folder", type=Path)
    arguments = parser.parse_args()
    rows = read_log(arguments.log)
    short = [row for row in rows if float(row["t_s"]) <= SHORT_S]
    folder = arguments.folder
    folder.mkdir(parents=True, exist_ok=True)
    for old in folder.glob("*.bag"):
        old.unlink()
    write_csv(folder / "walk.csv.gz", rows)
    write_bag(folder / "walk-lz4.bag", rows, BagWriter.CompressionFormat.LZ4)
    write_bag(folder / "walk-bz2.bag", rows, BagWriter.CompressionFormat.BZ2)
    write_bag_of_several_topics(folder / "several-topics.bag", short)
    write_ros2_mcap(folder / "walk-ros2-zstd.mcap", rows)
    write_mcap(folder / "walk-ros1-lz4.mcap", rows, ROS1, "ros1", CompressionType.LZ4)
    write_mcap(folder / "short-big-endian.mcap", short, ROS2, "cdr", CompressionType.NONE)
    write_mcap(folder / "short-unchunked.mcap", short, ROS1, "ros1", CompressionType.NONE, chunked=False)


if __name__ == "__main__":
    main()
