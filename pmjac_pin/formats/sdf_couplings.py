"""Gearboxes of SDFormat: two joints whose rates have a fixed ratio."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from pmjac_pin.errors import ModelFileError
from pmjac_pin.formats.sdf_joints import SdfJoint, text_of
from pmjac_pin.loop_spec import JointLoop
from pmjac_pin.urdf_xml import label, numbers_in

_PARALLEL = 1e-6


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
    (ratio,) = numbers_in(f"{where}, <gearbox_ratio>", _text(gearbox, "gearbox_ratio"))
    body = _text(gearbox, "gearbox_reference_body")
    (first, one), (second, other) = (
        _turning(gearbox, tree, body, link, number)
        for number, link in enumerate((gearbox.parent, gearbox.child))
    )
    return JointLoop(joints=(first, second), ratio=-ratio * one * other)


def coupled_links(gearbox: SdfJoint) -> tuple[set[str], set[str]]:
    """Return the two pairs of links whose turns against each other a gearbox couples."""
    body = _text(gearbox, "gearbox_reference_body")
    return {body, gearbox.parent}, {body, gearbox.child}


def _text(gearbox: SdfJoint, tag: str) -> str:
    where = label(gearbox.element)
    if not (text := text_of(where, gearbox.element, tag)):
        raise ModelFileError(f"{where} has no <{tag}>; a gearbox needs it")
    return text


def _turning(
    gearbox: SdfJoint, tree: Sequence[SdfJoint], body: str, link: str, number: int
) -> tuple[str, float]:
    """Return the joint between two links, and 1 or −1 as it turns with the axis or against it."""
    wanted = gearbox.placement.rotation @ gearbox.axes[number].direction
    for joint in tree:
        if len(joint.axes) == 1 and {joint.parent, joint.child} == {body, link}:
            along = float(wanted @ joint.placement.rotation @ joint.axes[0].direction)
            if abs(abs(along) - 1.0) < _PARALLEL and joint.kind != "prismatic":
                return joint.name, float(np.sign(along)) * (1.0 if joint.child == link else -1.0)
    what = f"{label(gearbox.element)}: no joint of the tree turns {link!r} against {body!r}"
    raise ModelFileError(f"{what} about the axis that the gearbox gives")
