"""Plugins of Gazebo: those that have no bearing on the machine, and those that tie joints.

A plugin is a program, so that only those are passed over whose names are known.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from xml.etree.ElementTree import Element

from pmjac_pin.vocabulary import Vocabulary

# Sensors, controllers, publishers and forces, by a part of the file's name.
_HARMLESS = re.compile(
    r"ros2?_control|controller|camera|kinect|realsense|depth|laser|lidar|ray_sensor|imu|gps|navsat"
    r"|p3d|odometry|bumper|contact|ft_sensor|force_?torque|(ros_|apply_?)force|power_?monitor"
    r"|battery|joint_?state|model_?state|publisher|diff_?drive|skid_?steer|ackermann|planar_move"
    r"|sensors|magnetometer|altimeter|air_?pressure|motor_?model|lift_?drag|buoyancy|hydrodynamics"
    r"|wind|user-?_?commands|scene-?_?broadcaster|physics|video",
    re.IGNORECASE,
)


_MIMIC_WORDS = Vocabulary("""
plugin name filename : joint mimicJoint multiplier offset sensitiveness* maxEffort* hasPID*
  robotNamespace* namespace* violenceFactor* updateRate*
""")


def unread_harmless(root: Element) -> Iterator[Element]:
    """Yield the plugins of a file that have no bearing on the machine."""
    for plugin in root.iter("plugin"):
        if _HARMLESS.search(plugin.get("filename", "")) and not is_mimic(plugin):
            yield plugin


def misread_mimics(root: Element) -> list[str]:
    """Return what is not known in plugins that are called mimic.

    Raises
    ------
    ModelFileError
        A misspelt word.
    """
    plugins = [plugin for plugin in root.iter("plugin") if "mimic" in plugin.get("filename", "")]
    return [note for plugin in plugins for note in _MIMIC_WORDS.unread(plugin)]


def is_mimic(plugin: Element) -> bool:
    """Whether a plugin makes one joint follow another, as that of roboticsgroup and its kin do."""
    return plugin.find("joint") is not None and plugin.find("mimicJoint") is not None
