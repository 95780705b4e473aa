"""Plugins of Gazebo: those that have no bearing on the machine, and those that tie joints.

A plugin is a program, so that only those are passed over whose names are known.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from xml.etree.ElementTree import Element

from pmjac_pin.files.vocabulary import Vocabulary, could_tie

# Sensors, controllers, publishers and forces, by their whole names as `_bare` gives them: what a
# name merely contains says nothing.
_HARMLESS_NAMES = """
    ackermanndrive ackermannodometry ackermannsteering acousticcomms actuator advancedliftdrag
    airpressure airspeed altimeter applyforce applyjointforce applylinkwrench attachlight barometer
    battery blocklaser breadcrumbs bumper buoyancy buoyancyengine camera cameravideorecorder
    commsendpoint contact control controlselectjoints controller cpulidar depthcamera diffdrive
    drivetoposecontroller dvl environmentalsensor environmentpreload f3d flashlight followactor
    force forcetorque ftsensor gps gpssensor gpulaser gpuray groundtruth hydrodynamics imu imusensor
    jointcontrol jointcontroller jointeffort jointposetrajectory jointpositioncontroller
    jointstatepublisher jointtrajcontrol jointtrajectory jointtrajectorycontroller keystojoints
    kineticenergymonitor kinect label laser led lensflare lidar liftdrag lightcontroller
    lighterthanairdynamics linearbattery linearbatteryconsumer linkplot3d logicalaudiosensor
    logicalcamera logvideorecorder magnetic magnetometer magnetometersensor mecanumdrive
    modelphotoshoot modelpropshop modelstate motormodel multicamera multicoptercontrol
    multicoptermotormodel navsat odometry odometrypublisher omni3wddrive openkinect opennikinect
    opticalflow opticaltactile p3d particleemitter perfectcomms performerdetector physics
    planarmove pose posepublisher powermonitor pressure projector prosilica range ray raysensor
    realsense rfcomms scenebroadcaster sensors shaderparam skidsteerdrive sonar
    spacecraftthrustermodel thermal thermalsensor thruster touch trackcontroller trackedvehicle
    trajectoryfollower tricycledrive triggeredcamera triggeredmulticamera triggeredpublisher
    usercommands velocitycontrol velodynegpulaser velodynelaser video wheelslip wind windeffects
    worldodometry
"""
_HARMLESS = frozenset(_HARMLESS_NAMES.split())
_PACKAGING = re.compile(r"(gazebo|gz|ign|ignition|sim)\d*|ros2?|hector|rotors|plugins?|system")


def is_harmless(filename: str) -> bool:
    """Whether a plugin's file is known to have no bearing on the machine.

    Examples
    --------
    >>> is_harmless("libgazebo_ros_ft_sensor.so"), is_harmless("gz-sim8-contact-system")
    (True, True)
    >>> is_harmless("libforce_weld_contact.so"), is_harmless("")
    (False, False)
    """
    return _bare(filename) in _HARMLESS


def _bare(filename: str) -> str:
    """Return a file's name without what says where it is from, in small letters."""
    name = re.sub(r"^lib|\.(so|dylib|dll)(\.\d+)*$", "", re.split(r"[/\\]", filename)[-1].lower())
    words = re.split(r"[-_]", name)
    return "".join(word for word in words if not _PACKAGING.fullmatch(word)).removesuffix("plugin")


_MIMIC_WORDS = Vocabulary("""
plugin name filename : joint mimicJoint multiplier offset sensitiveness* maxEffort* hasPID*
  robotNamespace* namespace* violenceFactor* updateRate*
""")


def unread_harmless(root: Element) -> Iterator[Element]:
    """Yield the plugins of a file that have no bearing on the machine.

    One whose name is harmless is not among them if it holds what could tie bodies together.
    """
    for plugin in root.iter("plugin"):
        tied = any(could_tie(inside) for inside in plugin.iter() if inside is not plugin)
        if is_harmless(plugin.get("filename", "")) and not tied:
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


def is_mimic_plugin(plugin: Element) -> bool:
    """Whether a plugin makes one joint follow another, as that of roboticsgroup and its kin do."""
    return plugin.find("joint") is not None and plugin.find("mimicJoint") is not None
