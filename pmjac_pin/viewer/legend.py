"""The legend of the picture: which colour is what, as far as a mechanism has it."""

from __future__ import annotations

from pmjac_pin.mechanism import Mechanism
from pmjac_pin.model.loop_spec import JointLoop
from pmjac_pin.viewer import palette
from pmjac_pin.viewer.messages import Key


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
        (True, "motor", [palette.MOTOR]),
        (bool(mechanism.passive), "passive joint", [palette.JOINT]),
        (bool(closures), "loop closure", [palette.FIRST_ANCHOR, palette.SECOND_ANCHOR]),
        (any(loop.rod(mechanism.parameters) for loop in closures), "its rod", [palette.ROD]),
        (bool(closures), "open gap", [palette.GAP]),
        (len(closures) < len(mechanism.spec.loops), "gears", [palette.WHEEL, palette.GEAR]),
        (True, "tool x, y, z", list(palette.AXIS_COLOURS)),
        (True, "load", [palette.LOAD]),
        (bool(closures), "free at a singularity", [palette.FREE]),
    ]
    shown = ((text, map(palette.hexadecimal, colours)) for there, text, colours in entries if there)
    return tuple(Key(text, tuple(colours)) for text, colours in shown)
