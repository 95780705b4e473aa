"""Coupled joints of SDFormat: gearboxes, <mimic> of SDFormat 1.11 and of Drake, Gazebo's plugin."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from xml.etree.ElementTree import Element

import numpy as np

from pmjac_pin.errors import ModelFileError, did_you_mean, quoted
from pmjac_pin.files.gazebo_plugins import is_mimic_plugin
from pmjac_pin.files.sdf.joints import AXIS_TAGS, SdfJoint, freedom_names, number_of, text_of
from pmjac_pin.files.vocabulary import spelt
from pmjac_pin.files.xml_text import check_name, label, numbers, numbers_in, only
from pmjac_pin.model.loop_spec import JointLoop

_PARALLEL_AXES = 1e-6
_TURNING = ("revolute", "continuous", "screw")


def coupling(gearbox: SdfJoint, tree: Sequence[SdfJoint]) -> JointLoop:
    """Return the loop of a gearbox: θ₂ = −ratio·θ₁.

    θ₁ is the turn of the gearbox's parent about its first axis and θ₂ that of its child about its
    second, both against the reference body (SDFormat, `gearbox_reference_body`).

    Raises
    ------
    ModelFileError
        No joint of the tree turns these links about these axes.
    """
    where = label(gearbox.element)
    (ratio,) = numbers_in(f"{where}, <gearbox_ratio>", _child_text(gearbox, "gearbox_ratio"))
    if ratio == 0.0:
        todo = "give how often the first link turns against the second"
        raise ModelFileError(f"{where}, <gearbox_ratio> is 0, which holds a joint; {todo}")
    body = _child_text(gearbox, "gearbox_reference_body")
    (first, one), (second, other) = (
        _turning_joint(gearbox, tree, body, link, number)
        for number, link in enumerate((gearbox.parent, gearbox.child))
    )
    return JointLoop(joints=(first, second), ratio=-ratio * one * other)


def coupled_links(gearbox: SdfJoint) -> tuple[set[str], set[str]]:
    """Return the two pairs of links whose turns against each other a gearbox couples."""
    body = _child_text(gearbox, "gearbox_reference_body")
    return {body, gearbox.parent}, {body, gearbox.child}


def _child_text(gearbox: SdfJoint, tag: str) -> str:
    where = label(gearbox.element)
    if not (text := text_of(where, gearbox.element, tag)):
        raise ModelFileError(f"{where} has no <{tag}>; a gearbox needs it")
    return text


def _turning_joint(
    gearbox: SdfJoint, tree: Sequence[SdfJoint], body: str, link: str, number: int
) -> tuple[str, float]:
    """Return the joint between two links, and 1 or −1 as it turns with the axis or against it."""
    wanted = gearbox.placement.rotation @ gearbox.axes[number].direction
    for joint in tree:
        if len(joint.axes) == 1 and {joint.parent, joint.child} == {body, link}:
            along = float(wanted @ joint.placement.rotation @ joint.axes[0].direction)
            if abs(abs(along) - 1.0) < _PARALLEL_AXES and joint.kind in _TURNING:
                return joint.name, float(np.sign(along)) * (1.0 if joint.child == link else -1.0)
    what = f"{label(gearbox.element)}: no joint of the tree turns {link!r} against {body!r}"
    raise ModelFileError(f"{what} about the axis that the gearbox gives")


def read_mimics(joints: Sequence[SdfJoint], model: Element) -> tuple[JointLoop, ...]:
    """Return a loop for each joint that follows another.

    q = multiplier · (q_leader − reference) + offset (SDFormat 1.11, `joint/axis/mimic`).

    Raises
    ------
    ModelFileError
        A joint or an axis that does not exist, or that follows in two ways.
    """
    freedoms = {joint.name: freedom_names(joint) for joint in joints}
    found: dict[str, JointLoop] = {}
    for where, loop in (*_of_axes(joints, freedoms), *_of_plugins(model, freedoms)):
        follower = loop.joints[1]
        if found.setdefault(follower, loop) != loop:
            raise ModelFileError(f"{where}: joint {follower!r} follows in another way already")
    return tuple(found.values())


def _of_axes(
    joints: Sequence[SdfJoint], freedoms: Mapping[str, tuple[str, ...]]
) -> Iterator[tuple[str, JointLoop]]:
    for joint in joints:
        refuse_idle_mimics(joint)
        where = f"{label(joint.element)}, <mimic>"
        for number, follower in enumerate(freedoms[joint.name]):
            axis = only(label(joint.element), joint.element, AXIS_TAGS[number])
            if axis is None or (mimic := only(where, axis, "mimic")) is None:
                continue
            leader = _freedom(where, mimic.get("joint", ""), mimic.get("axis", "axis"), freedoms)
            ratio, offset, reference = (
                number_of(where, mimic, tag, default)
                for tag, default in (("multiplier", "1"), ("offset", "0"), ("reference", "0"))
            )
            yield where, _gear_loop(where, (leader, follower), ratio, offset - ratio * reference)
        for mimic in joint.element:
            if spelt(mimic.tag) == "drake:mimic":
                leader = _freedom(where, mimic.get("joint", ""), "axis", freedoms)
                follower = _freedom(where, joint.name, "axis", freedoms)
                (ratio,) = numbers(where, mimic, "multiplier", default="1")
                (offset,) = numbers(where, mimic, "offset", default="0")
                yield where, _gear_loop(where, (leader, follower), ratio, offset)


def refuse_idle_mimics(joint: SdfJoint) -> None:
    """Refuse a joint that is to follow another about an axis that it does not have."""
    count = 0 if joint.kind == "gearbox" else len(joint.axes)
    for tag in AXIS_TAGS[count:]:
        if joint.element.find(f"{tag}/mimic") is not None:
            got = f"{label(joint.element)}, <{tag}> holds a <mimic>"
            raise ModelFileError(f"{got}, and a joint of type {joint.kind} has no such axis")


def _of_plugins(
    model: Element, freedoms: Mapping[str, tuple[str, ...]]
) -> Iterator[tuple[str, JointLoop]]:
    for plugin in filter(is_mimic_plugin, model.findall("plugin")):
        where = label(plugin)
        leader, follower = (
            _freedom(where, text_of(where, plugin, tag) or "", "axis", freedoms)
            for tag in ("joint", "mimicJoint")
        )
        ratio, offset = (
            number_of(where, plugin, tag, default)
            for tag, default in (("multiplier", "1"), ("offset", "0"))
        )
        yield where, _gear_loop(where, (leader, follower), ratio, offset)


def _gear_loop(where: str, joints: tuple[str, str], ratio: float, offset: float) -> JointLoop:
    if joints[0] == joints[1]:
        raise ModelFileError(f"{where}: the joint follows itself")
    return JointLoop(joints=joints, ratio=ratio, offset=offset)


def _freedom(where: str, joint: str, axis: str, freedoms: Mapping[str, tuple[str, ...]]) -> str:
    """Return the degree of freedom about an axis of a joint."""
    check_name(f"{where}: the joint", joint, freedoms)
    known = dict(zip(AXIS_TAGS, freedoms[joint], strict=False))
    if axis not in known:
        raise ModelFileError(
            f"{where}: joint {joint!r} has no {quoted(axis)}{did_you_mean(axis, known)}"
        )
    return known[axis]
