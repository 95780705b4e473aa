"""Values as plain data, and plain data as JSON."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping

import msgspec
import numpy as np
import pinocchio as pin


def told(value: object, *names: str) -> dict[str, object]:
    """Return these attributes of a value: what is told of it."""
    return {name: getattr(value, name) for name in names}


def to_json(data: Mapping[str, object]) -> str:
    """Write what is told of a report, or of a diagnosis, as strict JSON in ASCII, a line a key.

    JSON knows no infinity and no NaN: both become null. There are five: the radii of the
    force ellipsoid in directions that the structure bears by itself, the singularity's
    `smallest` (no loops) and `condition` (singular), the pitch of a screw without an axis, and
    the arm and the transmission angle of a joint that has none.
    """
    lines = (f"{_ascii(key)}: {_ascii(value)}" for key, value in data.items())
    return "{\n" + ",\n".join(lines) + "\n}"


def encoded(value: object) -> str:
    """Write plain data, arrays, poses and structs as JSON; infinite numbers become null."""
    return msgspec.json.encode(value, enc_hook=_plain).decode()


def _ascii(value: object) -> str:
    # Units have superscripts, and a pipe may be unable to carry them. In JSON they can only
    # stand in strings, where an escape means the same.
    return re.sub("[^\x00-\x7f]", lambda match: json.dumps(match[0])[1:-1], encoded(value))


def _plain(value: object) -> object:
    match value:
        case np.ndarray():
            return value.tolist()
        case pin.SE3():
            return {"position": value.translation, "rotation": value.rotation}
        case _:
            raise TypeError(f"JSON has no word for a {type(value).__name__}")
