#!/usr/bin/env python3
"""Runs mlrd in ROS 1: /imu/data_raw in, diagnostics out.

For robots whose sensor is held by a driver of ROS already, as on the JetHexa. The node starts
mlrd, hands on every sensor_msgs/Imu as a line of JSON, and republishes what mlrd says as
diagnostic_msgs/DiagnosticArray on /diagnostics.

    rosrun … mlrd_node.py _mlrd:="mlrd --config /etc/mlrd.toml" imu:=/imu/data_raw

It needs nothing but rospy, sensor_msgs and diagnostic_msgs, and runs with Python 2.7 (Melodic)
and Python 3 (Noetic).
"""

import json
import shlex
import subprocess
import threading

import rospy
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from sensor_msgs.msg import Imu

UNKNOWN = -1.0
# What is no value of a diagnostic: it is its level, its name, or the time.
NOT_VALUES = ("level", "event", "time")


def as_line(message):
    """A message as mlrd reads it, with what is known of it."""
    sample = {"t_s": message.header.stamp.to_sec()}
    if sample["t_s"] == 0.0:
        sample["t_s"] = rospy.get_time()
    quaternion = message.orientation
    elements = (quaternion.w, quaternion.x, quaternion.y, quaternion.z)
    # Drivers that know no orientation often leave it zero or unturned without saying so.
    if message.orientation_covariance[0] != UNKNOWN and elements not in ((0, 0, 0, 0), (1, 0, 0, 0)):
        sample.update(zip(("qw", "qx", "qy", "qz"), elements))
    if message.linear_acceleration_covariance[0] != UNKNOWN:
        force = message.linear_acceleration
        sample.update(ax_mps2=force.x, ay_mps2=force.y, az_mps2=force.z)
    if message.angular_velocity_covariance[0] != UNKNOWN:
        rate = message.angular_velocity
        sample.update(gx_radps=rate.x, gy_radps=rate.y, gz_radps=rate.z)
    return (json.dumps(sample) + "\n").encode()


def as_diagnostics(event):
    """An event of mlrd as diagnostics: its level is that of ROS."""
    status = DiagnosticStatus()
    status.level = event.get("level", 0)
    status.name = "mlrd: legs"
    status.hardware_id = "mlrd"
    status.message = event["event"]
    result = event.get("result") or {}
    if "damaged_legs" in result:
        legs = ", ".join(str(leg) for leg in result["damaged_legs"])
        status.message += ": legs " + legs if legs else ": no leg is damaged"
    for key, value in event.items():
        if key not in NOT_VALUES:
            status.values.append(KeyValue(key, value if isinstance(value, str) else json.dumps(value)))
    array = DiagnosticArray()
    array.header.stamp = rospy.Time.now()
    array.status = [status]
    return array


def main():
    """Runs until ROS ends, or mlrd."""
    rospy.init_node("mlrd")
    command = shlex.split(rospy.get_param("~mlrd", "mlrd")) + ["--stdin"]
    daemon = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE)
    diagnostics = rospy.Publisher("/diagnostics", DiagnosticArray, queue_size=20)

    def republish():
        for line in iter(daemon.stdout.readline, b""):
            diagnostics.publish(as_diagnostics(json.loads(line.decode("utf-8"))))
        rospy.signal_shutdown("mlrd has ended")

    def hand_on(message):
        try:
            daemon.stdin.write(as_line(message))
            daemon.stdin.flush()
        except (IOError, ValueError):
            rospy.signal_shutdown("mlrd takes no samples")

    reader = threading.Thread(target=republish)
    reader.daemon = True
    reader.start()
    rospy.Subscriber("imu", Imu, hand_on, queue_size=1000)
    rospy.spin()
    # The end of its input is the end of the daemon.
    daemon.stdin.close()
    daemon.wait()


if __name__ == "__main__":
    main()
