"""The inertias of an SDFormat model's links: <inertial>, or SDFormat's default of 1 kg, 1 kg m²."""

from __future__ import annotations

from collections.abc import Sequence
from xml.etree.ElementTree import Element

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from pmjac_pin.errors import ModelFileError
from pmjac_pin.files.joint_dialects import listed
from pmjac_pin.files.sdf.frames import Frames, pose, truth
from pmjac_pin.files.sdf.joints import number_of
from pmjac_pin.files.xml_text import label, only

_LEAST_MOMENT = -1e-9  # of the largest moment: what rounding makes of zero
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
    return _inertia_at(where, mass, moments, centre)


def _inertia_at(
    where: str, mass: float, moments: NDArray[np.float64], placement: pin.SE3
) -> pin.Inertia:
    """Return an inertia whose centre and axes are placed in a frame, in that frame.

    Parameters
    ----------
    where : str
        How messages call it.
    mass : float
        kg.
    moments : ndarray, shape (3, 3)
        About the centre, kg m².
    placement : pin.SE3

    Raises
    ------
    ModelFileError
        A mass or a moment below zero.
    """
    if mass < 0.0:
        raise ModelFileError(f"{where}: the mass is {mass:g}; it must not be negative")
    principal, axes = np.linalg.eigh(moments)
    if principal[0] < _LEAST_MOMENT * max(abs(principal[0]), principal[2]):
        raise ModelFileError(f"{where}: a moment of inertia is {principal[0]:g}, below zero")
    turned = placement.rotation @ axes
    kept = turned @ np.diag(np.maximum(principal, 0.0)) @ turned.T
    return pin.Inertia(mass, placement.translation, (kept + kept.T) / 2.0)
