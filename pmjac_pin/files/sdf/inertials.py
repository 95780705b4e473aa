"""The inertias of an SDFormat model's links: <inertial>, or SDFormat's default of 1 kg, 1 kg m²."""

from __future__ import annotations

from collections.abc import Sequence
from xml.etree.ElementTree import Element

import numpy as np
import pinocchio as pin

from pmjac_pin.files.inertia import inertia_at
from pmjac_pin.files.joint_dialects import listed
from pmjac_pin.files.sdf.frames import Frames, pose, truth
from pmjac_pin.files.sdf.joints import number_of
from pmjac_pin.files.xml_text import label, only

_ONES = ("mass", "inertia/ixx", "inertia/iyy", "inertia/izz")  # of which the default is 1
_DEFAULTS = {"ixx": "1", "ixy": "0", "ixz": "0", "iyy": "1", "iyz": "0", "izz": "1"}


def read_inertias(
    links: Sequence[Element], frames: Frames
) -> tuple[dict[str, pin.Inertia], list[str]]:
    """Return each link's inertia in the link's frame, and notes on those that are not given.

    Raises
    ------
    ModelFileError
        A number that is none, or a mass below zero.
    """
    found, without, computed = {}, [], []
    partly: dict[str, list[str]] = {}
    for link in links:
        name, where = link.get("name", ""), f"{label(link)}, <inertial>"
        inertial = only(label(link), link, "inertial")
        if inertial is None:
            without.append(name)
            inertial = Element("inertial")
        if truth(where, inertial.get("auto", "false")):
            computed.append(name)
        else:
            found[name] = _link_inertia(where, inertial, name, frames)
            missing = [tag for tag in _ONES if inertial.find(tag) is None]
            if missing and name not in without:
                tags = ", ".join(f"<{tag.rpartition('/')[2]}>" for tag in missing)
                partly.setdefault(tags, []).append(name)
    one = "SDFormat's default, 1, is taken"
    notes = [f"no {tags} is given for {listed(names)}: {one}" for tags, names in partly.items()]
    if without:
        default = "SDFormat's default, 1 kg and 1 kg m², is taken"
        notes.append(f"no <inertial> is given for {listed(without)}: {default}")
    if computed:
        what = f"the <inertial> of {listed(computed)} is to be computed from shapes"
        notes.append(f"{what}, which is not done: the mass is 0 in `model`")
    return found, notes


def _link_inertia(where: str, inertial: Element, link: str, frames: Frames) -> pin.Inertia:
    mass, inertia = number_of(where, inertial, "mass", "1"), only(where, inertial, "inertia")
    values = {tag: number_of(where, inertia, tag, one) for tag, one in _DEFAULTS.items()}
    moments = np.array([[values[f"i{min(a, b)}{max(a, b)}"] for b in "xyz"] for a in "xyz"])
    relative_to, place = pose(where, inertial, link)
    centre = frames.placement(link, where).actInv(frames.placement(relative_to, where) * place)
    return inertia_at(where, mass, moments, centre)
