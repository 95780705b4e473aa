"""The home pose that a model file lacks, as the line that would give it one."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from pmjac_pin.files.catalog import find_urdf
from pmjac_pin.files.joint_dialects import home_within_limits
from pmjac_pin.files.urdf.dialects import read_cut_tree

_NUMBERS = {"floating": 6, "planar": 3}  # of joints of several degrees of freedom
_MOST_WRITTEN = 60


def home_line(given: Mapping[str, Any], path: Path) -> str:
    """Return a line of TOML: each joint of a model file at 0, or within limits that exclude 0.

    Parameters
    ----------
    given : mapping
        The contents of the model file, but for its poses.
    path : Path
        Of the model file.

    Raises
    ------
    ModelFileError
        Its URDF cannot be read.
    """
    urdf, said = read_cut_tree(find_urdf(given["urdf"], path))
    balls = {*said.balls, *given.get("spherical", ())}
    inside, _ = home_within_limits(urdf.robot(), urdf.joints)
    moving = {joint.name: joint for joint in urdf.joints if joint.type != "fixed"}
    first = [name for name in given["actuated"] if name in moving]
    names = [*first, *(name for name in moving if name not in first)]
    values = []
    for name in [name for name in names if name not in given.get("locked", ())][:_MOST_WRITTEN]:
        count = 3 if name in balls else _NUMBERS.get(moving[name].type, 1)
        value = str([0.0] * count) if count > 1 else f"{inside.get(name, 0.0):.6g}"
        values.append(f"{_key(name)} = {value}")
    return f"home = {{{', '.join(values)}}}"


def _key(name: str) -> str:
    """Write a name as a key of TOML: in quotes where it is no bare one."""
    return name if re.fullmatch(r"[A-Za-z0-9_-]+", name) else json.dumps(name, ensure_ascii=False)
