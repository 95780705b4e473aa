"""Which joints of an MJCF model are motors: those that <actuator> moves."""

from __future__ import annotations

from collections.abc import Container, Mapping, Sequence
from typing import Any

from pmjac_pin.errors import quoted
from pmjac_pin.files.mjcf.joints import SCALAR, MjcfJoint


def read_motors(
    model: Any, names: Sequence[str], joints: Mapping[str, MjcfJoint], held: Container[str]
) -> tuple[tuple[str, ...], list[str]]:
    """Return the joints that actuators move, each once, in file order, and notes on the others.

    `names` are the joints' by MuJoCo's numbers.
    """
    motors: dict[str, None] = {}
    notes = []
    for number in range(model.nu):
        name = names[model.actuator_trnid[number, 0]]
        given = model.actuator(number).name
        where = f"actuator {quoted(given)}" if given else "an actuator"
        if joints[name].kind not in SCALAR:
            notes.append(f"{where} moves {joints[name].kind} joint {name!r}, and is left out")
        elif name in held:
            notes.append(f"{where} moves joint {name!r}, which is held, and is left out")
        else:
            motors[name] = None
    return tuple(motors), notes
