"""Counts walls beside a robot of ROS 2, and shows them in RViz:

    ros2 launch integrations/ros2/crosscut.launch.py scan:=/scan odometry:=/odom
    ros2 launch integrations/ros2/crosscut.launch.py robot:=zenoh://robot:7447 rviz:=false options:="--save flight.rrd"

Needs the program of crosscut's wheel with the extra `dds` (or, for zenoh://, `live`) on the PATH.
"""

import os
import shlex

from launch import LaunchContext, LaunchDescription
from launch.actions import DeclareLaunchArgument, ExecuteProcess, OpaqueFunction
from launch.conditions import IfCondition
from launch.substitutions import LaunchConfiguration

RVIZ = os.path.join(os.path.dirname(os.path.abspath(__file__)), "crosscut.rviz")
ARGUMENTS = {
    "robot": (f"ros2://{os.environ.get('ROS_DOMAIN_ID', '0')}", "where the robot is heard: ros2://DOMAIN or zenoh://HOST:PORT"),
    "scan": ("/scan", "topic of the scans; of zenoh:// in another domain than 0: /scan?domain=N"),
    "odometry": ("", "topic of nav_msgs/Odometry, or /tf; empty: none"),
    "publish": ("crosscut", "results, map and markers are sent to topics below this"),
    "options": ("", "more of `crosscut run --help`, such as --save flight.rrd"),
    "rviz": ("true", "whether RViz is started"),
}


def command(value) -> list[str]:
    """The words of `crosscut run`, of a function that gives the value of an argument."""
    odometry = ["--set", f"ingest.odometry={value('odometry')}"] if value("odometry") else []
    robot = value("robot") + value("scan")
    return ["crosscut", "run", robot, *odometry, "--publish", value("publish"), *shlex.split(value("options"))]


def started(context: LaunchContext) -> list[ExecuteProcess]:
    cmd = command(lambda name: LaunchConfiguration(name).perform(context))
    # Ctrl-C of the launch ends the run, which saves what was made; a large map takes longer than the usual 5 s.
    return [ExecuteProcess(cmd=cmd, output="screen", sigterm_timeout="20")]


def generate_launch_description() -> LaunchDescription:
    arguments = [
        DeclareLaunchArgument(name, default_value=default, description=text) for name, (default, text) in ARGUMENTS.items()
    ]
    rviz = ExecuteProcess(cmd=["rviz2", "-d", RVIZ], condition=IfCondition(LaunchConfiguration("rviz")))
    return LaunchDescription([*arguments, OpaqueFunction(function=started), rviz])
