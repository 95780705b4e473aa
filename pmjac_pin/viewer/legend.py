"""The legend of the picture: which colour is what, as far as a mechanism has it."""

from __future__ import annotations

from pmjac_pin.mechanism import Mechanism
from pmjac_pin.model.loop_spec import JointLoop
from pmjac_pin.viewer.messages import Key
from pmjac_pin.viewer.palette import (
    AXIS_COLOURS,
    FIRST_ANCHOR,
    FREE,
    GAP,
    GEAR,
    JOINT,
    LOAD,
    MOTOR,
    ROD,
    SECOND_ANCHOR,
    WHEEL,
    hexadecimal,
)


def legend(mechanism: Mechanism) -> tuple[Key, ...]:
    """Return the entries of a mechanism's picture.

    Examples
    --------
    >>> import pmjac_pin as pj
    >>> [key.text for key in legend(pj.load("serial_2r"))]
    ['motor', 'tool x, y, z', 'load']
    """
    closures = [loop for loop in mechanism.spec.loops if not isinstance(loop, JointLoop)]
    entries = [
        (True, "motor", [MOTOR]),
        (bool(mechanism.passive), "passive joint", [JOINT]),
        (bool(closures), "loop closure", [FIRST_ANCHOR, SECOND_ANCHOR]),
        (any(loop.rod(mechanism.parameters) for loop in closures), "its rod", [ROD]),
        (bool(closures), "open gap", [GAP]),
        (len(closures) < len(mechanism.spec.loops), "gears", [WHEEL, GEAR]),
        (True, "tool x, y, z", list(AXIS_COLOURS)),
        (True, "load", [LOAD]),
        (bool(closures), "free at a singularity", [FREE]),
    ]
    return tuple(
        Key(text, tuple(map(hexadecimal, colours))) for there, text, colours in entries if there
    )
