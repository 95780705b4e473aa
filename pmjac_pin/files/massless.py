"""Inertia that `model` does not have: dynamics would go wrong without a word."""

from __future__ import annotations

from collections.abc import Collection, Sequence

from pmjac_pin.files.joint_dialects import listed
from pmjac_pin.files.urdf.robot import Urdf

_NO_MASSES = "no masses are given: they are 0 in `model`"


def without_mass(names: Sequence[str]) -> list[str]:
    """Return a note on bodies for which a file gives no mass, if there are any."""
    return [f"no mass is given for {listed(names)}: it is 0 in `model`"] if names else []


def mass_notes(urdf: Urdf, names: Collection[str]) -> list[str]:
    """Return what is to be said of the bodies of a URDF, or of those that are among these links."""
    heavy = urdf.heavy()
    if not heavy and any(joint.type != "fixed" for joint in urdf.joints):
        return [_NO_MASSES]
    return without_mass(_massless(urdf, heavy, names))


def _massless(urdf: Urdf, heavy: Collection[str], names: Collection[str]) -> list[str]:
    """Return the first of these links on each body that moves and has no mass.

    A body is all links that fixed joints join.
    """
    below: dict[str, list[str]] = {}
    for joint in urdf.joints:
        if joint.type == "fixed":
            below.setdefault(joint.parent, []).append(joint.child)
    found = []
    for joint in urdf.joints:
        body = [joint.child] if joint.type != "fixed" else []
        for link in body:
            body += below.get(link, ())
        if body and not set(heavy) & set(body):
            found += [link for link in body if link in names][:1]
    return found
