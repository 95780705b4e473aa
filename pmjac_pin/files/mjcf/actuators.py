"""Which joints of an MJCF model are motors: those that <actuator> moves."""

from __future__ import annotations

from collections.abc import Container, Mapping, Sequence
from typing import Any

import numpy as np

from pmjac_pin.errors import quoted
from pmjac_pin.files.mjcf.joints import SCALAR, MjcfJoint
from pmjac_pin.files.mjcf.names import JOINT_TYPES
from pmjac_pin.values.arrays import Array

_FREEDOMS = {"ball": 3, "free": 6}


def read_motors(
    model: Any, names: Sequence[str], joints: Mapping[str, MjcfJoint], held: Container[str]
) -> tuple[tuple[str, ...], list[str]]:
    """Return the joints that actuators move, each once, in file order, and notes on the others.

    A ball or a free joint is one of them where its actuators move it in every direction.

    `names` are the joints' by MuJoCo's numbers.
    """
    motors: dict[str, None] = {}
    notes = []
    moved = _moved_any_way(model)
    for number in range(model.nu):
        joint = int(model.actuator_trnid[number, 0])
        name = names[joint]
        given = model.actuator(number).name
        where = f"actuator {quoted(given)}" if given else "an actuator"
        if joints[name].kind not in SCALAR and joint not in moved:
            notes.append(f"{where} moves {joints[name].kind} joint {name!r}, and is left out")
        elif name in held:
            notes.append(f"{where} moves joint {name!r}, which is held, and is left out")
        else:
            motors[name] = None
    return tuple(motors), notes


def _moved_any_way(model: Any) -> set[int]:
    """Return the balls and free joints whose actuators together move them in every direction."""
    gears: dict[int, list[Array]] = {}
    for number in range(model.nu):
        joint = int(model.actuator_trnid[number, 0])
        gears.setdefault(joint, []).append(model.actuator_gear[number])
    freedoms = {joint: _FREEDOMS.get(JOINT_TYPES[model.jnt_type[joint]], 1) for joint in gears}
    return {
        joint
        for joint, rows in gears.items()
        if np.linalg.matrix_rank(np.array(rows)[:, : freedoms[joint]]) == freedoms[joint]
    }
