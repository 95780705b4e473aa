"""Bodies that move and have no mass: dynamics would go wrong without a word."""

from __future__ import annotations

from collections.abc import Collection, Sequence

from pmjac_pin.files.joint_dialects import listed
from pmjac_pin.files.urdf.robot import Urdf


def without_mass(names: Sequence[str]) -> list[str]:
    """Return a note on bodies for which a file gives no mass, if there are any."""
    return [f"no mass is given for {listed(names)}: it is 0 in `model`"] if names else []


def massless_bodies(urdf: Urdf, names: Collection[str]) -> list[str]:
    """Return the first link of each body that moves, has no mass, and is one of these.

    A body is all links that fixed joints join.
    """
    heavy = {
        link.get("name", "")
        for link in urdf.robot().iterfind("link")
        if (mass := link.find("inertial/mass")) is not None and float(mass.get("value", "0")) > 0.0
    }
    below: dict[str, list[str]] = {}
    for joint in urdf.joints:
        if joint.type == "fixed":
            below.setdefault(joint.parent, []).append(joint.child)
    found = []
    for joint in urdf.joints:
        body = [joint.child] if joint.type != "fixed" else []
        for link in body:
            body += below.get(link, ())
        if body and not heavy & set(body):
            found += [link for link in body if link in names][:1]
    return found
