"""The four-bar of the catalogue at its home pose, as other formats write it.

All links stand parallel to the world where the joints are at zero; the coupler's midpoint is
the tool.
"""

from __future__ import annotations

import functools

import numpy as np
from mechanisms import loaded

Z = "0 0 1"
TOOL = "middle"


@functools.cache
def home():
    """The catalogue's home pose."""
    return loaded("four_bar").home


@functools.cache
def points():
    """A to D, the middle of BC, at that pose."""
    a, d = np.zeros(3), np.array([4.0, 0.0, 0.0])
    theta, phi = home().actuated[0], home().passive[0]
    b = np.array([np.cos(theta), np.sin(theta), 0.0])
    c = d + 3.5 * np.array([np.cos(phi), np.sin(phi), 0.0])
    return {"A": a, "B": b, "C": c, "D": d, "M": 0.5 * (b + c)}


def numbers(vector):
    return " ".join(map(repr, map(float, vector)))


MASS = (
    '<inertial><mass value="1"/>'
    '<inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial>'
)


def link(name, inside=MASS):
    return f'<link name="{name}">{inside}</link>'


def joint(name, kind, parent, child, xyz=(0, 0, 0), axis=Z, inside="", attributes=""):
    limit = '<limit lower="-4" upper="4" effort="1" velocity="1"/>'
    limit = limit if kind in ("revolute", "prismatic") and "<limit" not in inside else ""
    direction = f'<axis xyz="{axis}"/>' if kind not in ("fixed", "floating") else ""
    return (
        f'<joint name="{name}" type="{kind}" {attributes}><parent link="{parent}"/>'
        f'<child link="{child}"/><origin xyz="{numbers(xyz)}"/>{direction}{limit}{inside}</joint>'
    )


def robot(*elements):
    return "\n".join(['<robot name="four_bar">', *elements, "</robot>"])


def chain(attributes=""):
    """Links and joints of the cut four-bar: ground, crank, coupler, rocker, the tool."""
    p = points()
    links = [link(name) for name in ("ground", "crank", "coupler", "rocker", TOOL)]
    joints = {
        "theta1": joint("theta1", "revolute", "ground", "crank", p["A"], attributes=attributes),
        "phi2": joint("phi2", "revolute", "crank", "coupler", p["B"]),
        "phi1": joint("phi1", "revolute", "ground", "rocker", p["D"]),
        "tool": joint("tool", "fixed", "coupler", TOOL, p["M"] - p["B"]),
    }
    return links, joints


def two_parents(order=("theta1", "phi2", "phi1", "weld", "hinge", "tool"), kind="revolute"):
    """The pin at C is welded to the coupler and hinged to the rocker."""
    p = points()
    links, joints = chain()
    joints["weld"] = joint("weld", "fixed", "coupler", "pin", p["C"] - p["B"])
    joints["hinge"] = joint("hinge", kind, "rocker", "pin", p["C"] - p["D"])
    return robot(*links, link("pin"), *(joints[name] for name in order))


def cycle():
    """Every link is a child: ground, crank, coupler, rocker, foot, and ground again."""
    p = points()
    links, joints = chain()
    del joints["phi1"]
    joints["c"] = joint("c", "revolute", "coupler", "rocker", p["C"] - p["B"])
    joints["d"] = joint("d", "revolute", "rocker", "foot", p["D"] - p["C"])
    joints["weld"] = joint("weld", "fixed", "foot", "ground", p["A"] - p["D"])
    return robot(*links, link("foot"), *joints.values())


def turned():
    """The coupler is the parent of both its joints: one is turned round to hang it up."""
    p = points()
    links = [link(name) for name in ("ground", "crank", "end", "coupler", "rocker", "pin", TOOL)]
    joints = (
        joint("theta1", "revolute", "ground", "crank", p["A"]),
        joint("end", "fixed", "crank", "end", p["B"]),
        joint("phi2", "revolute", "coupler", "end", p["B"] - p["M"]),
        joint("phi1", "revolute", "ground", "rocker", p["D"]),
        joint("weld", "fixed", "coupler", "pin", p["C"] - p["M"]),
        joint("hinge", "revolute", "rocker", "pin", p["C"] - p["D"]),
        joint("tool", "fixed", "coupler", TOOL),
    )
    return robot(*links, *joints)


def with_element(element, attributes=""):
    links, joints = chain(attributes)
    return robot(*links, *joints.values(), element)


def loop_element(kind="revolute", axis=f'<axis xyz="{Z}"/>'):
    p = points()
    return (
        f'<loop name="tip" type="{kind}">'
        f'<predecessor link="coupler"><origin xyz="{numbers(p["C"] - p["B"])}"/></predecessor>'
        f'<successor link="rocker"><origin xyz="{numbers(p["C"] - p["D"])}"/></successor>'
        f"{axis}</loop>"
    )


def constraint_element(kind="revolute", parent_axis=Z, child_axis=Z, rpy="0 0 0", tail=""):
    p = points()
    return (
        f'<constraint name="tip" type="{kind}"><parent link="coupler"/>'
        f'<parent_origin xyz="{numbers(p["C"] - p["B"])}"/><parent_axis xyz="{parent_axis}"/>'
        f'<child link="rocker"/><child_origin xyz="{numbers(p["C"] - p["D"])}" rpy="{rpy}"/>'
        f'<child_axis xyz="{child_axis}"/>{tail}</constraint>'
    )


def with_drake(element):
    return with_element(element).replace("<robot", '<robot xmlns:drake="http://drake.mit.edu"', 1)


def ball_constraint():
    p = points()
    return (
        '<drake:ball_constraint><drake:ball_constraint_body_A name="coupler"/>'
        '<drake:ball_constraint_body_B name="rocker"/>'
        f'<drake:ball_constraint_p_AP value="{numbers(p["C"] - p["B"])}"/>'
        f'<drake:ball_constraint_p_BQ value="{numbers(p["C"] - p["D"])}"/></drake:ball_constraint>'
    )


def loop_joint(kind="continuous"):
    p = points()
    return (
        f'<loop_joint name="tip" type="{kind}">'
        f'<link1 link="coupler" xyz="{numbers(p["C"] - p["B"])}" rpy="0 0 0"/>'
        f'<link2 link="rocker" xyz="{numbers(p["C"] - p["D"])}"/><axis xyz="{Z}"/></loop_joint>'
    )


def gazebo_joint(kind="revolute", parent="coupler", axis=f"<axis><xyz>{Z}</xyz></axis>"):
    """Placed in the frame of its child, as SDFormat does."""
    p = points()
    child, origin = ("rocker", "D") if parent == "coupler" else ("coupler", "B")
    return (
        f'<gazebo><joint name="tip" type="{kind}"><parent>{parent}</parent><child>{child}</child>'
        f"<pose>{numbers(p['C'] - p[origin])} 0 0 0</pose>{axis}</joint></gazebo>"
    )


def closing_frames():
    p = points()
    ends = (("closing_tip_1", "coupler", "B"), ("closing_tip_2", "rocker", "D"))
    return "".join(
        link(name, "") + joint(f"{name}_frame", "fixed", parent, name, p["C"] - p[origin])
        for name, parent, origin in ends
    )


def mimic_plugin(multiplier="-2", follower="phi1", inside=""):
    return (
        '<gazebo><plugin name="follow" filename="libroboticsgroup_gazebo_mimic_joint_plugin.so">'
        f"<joint>theta1</joint><mimicJoint>{follower}</mimicJoint>"
        f"<multiplier>{multiplier}</multiplier><offset>0.5</offset>{inside}</plugin></gazebo>"
    )
