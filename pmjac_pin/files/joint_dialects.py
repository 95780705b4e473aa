"""What people write into the joints of a URDF beyond the standard, or leave out.

The functions that take elements change them into what the standard knows.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from xml.etree.ElementTree import Element

from pmjac_pin.errors import ModelFileError, quoted
from pmjac_pin.files.urdf.joint_tree import UrdfJoint
from pmjac_pin.files.xml_text import label, only, written

WITHOUT_LIMIT = 1e16  # m, rad, N, N m, m/s or rad/s: what SDFormat writes for none
_TRUTHS: Mapping[str, bool] = {"true": True, "1": True, "false": False, "0": False}
BALL_TYPES = ("spherical", "ball")  # types of joints that only turn
_MOST_NAMED = 6
_WIDEST = 1e4  # m or rad: the middle of a wider range is nowhere


def opened_limits(joints: Sequence[Element]) -> list[str]:
    """Take a missing range for none: URDF's default, from 0 to 0, would lock the joint."""
    opened = []
    for joint in joints:
        limit = only(label(joint), joint, "limit")
        if joint.get("type") not in ("revolute", "prismatic") or limit is None:
            continue
        if limit.get("lower") is None and limit.get("upper") is None:
            limit.attrib.update(lower=written([-WITHOUT_LIMIT]), upper=written([WITHOUT_LIMIT]))
            opened.append(joint.get("name", ""))
    return [f"no limits are given for {listed(opened)}: none are assumed"] if opened else []


def floating_balls(joints: Sequence[Element]) -> list[str]:
    """Write ball joints, which URDF does not have, as floating ones; return their names."""
    balls = [joint for joint in joints if joint.get("type") in BALL_TYPES]
    for joint in balls:
        joint.set("type", "floating")
    return [joint.get("name", "") for joint in balls]


def independence(joints: Sequence[Element]) -> dict[str, bool]:
    """Return what URDF+ says of each joint that has the attribute, and take it away."""
    found = {}
    for joint in joints:
        if (text := joint.attrib.pop("independent", None)) is not None:
            if text.strip().lower() not in _TRUTHS:
                got = f"`independent` is {quoted(text)}"
                raise ModelFileError(f"{label(joint)}: {got}, neither true nor false")
            found[joint.get("name", "")] = _TRUTHS[text.strip().lower()]
    return found


def home_within_limits(
    checked: Element, tree: Sequence[UrdfJoint]
) -> tuple[dict[str, float], list[str]]:
    """Return values for joints that cannot be at zero: the middle of the range, or its near end."""
    names = {joint.name for joint in tree}
    home = {}
    for joint in checked:
        limit = joint.find("limit")
        if limit is None or limit.get("lower") is None or joint.get("name") not in names:
            continue
        lower, upper = (float(limit.get(key, "")) for key in ("lower", "upper"))
        if not lower <= 0.0 <= upper:
            near = min(lower, upper, key=abs)
            middle = 0.5 * lower + 0.5 * upper
            home[joint.get("name", "")] = middle if upper - lower < _WIDEST else near
    note = f"home starts within the limits of {listed(list(home))}, which exclude zero"
    return home, [note] if home else []


def listed(names: Sequence[str]) -> str:
    """Return names for a message, the first few."""
    some = ", ".join(map(repr, names[:_MOST_NAMED]))
    return some + (f" and {len(names) - _MOST_NAMED} more" if len(names) > _MOST_NAMED else "")
