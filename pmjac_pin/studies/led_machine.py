"""LedMachine: a machine with joints of no part of it, which lead its tool and are its motors."""

from __future__ import annotations

from collections.abc import Sequence

import pinocchio as pin
from msgspec.structs import replace

from pmjac_pin.closing.assembly import build_parts
from pmjac_pin.errors import ArgumentError, quoted
from pmjac_pin.files.unused_name import unused_name
from pmjac_pin.mechanism import Mechanism
from pmjac_pin.model.coordinates import JointCoordinates
from pmjac_pin.model.loop_spec import Loop, resolved_loop
from pmjac_pin.values.arrays import Array


class LedMachine:
    """Makes it: joints and frames are added to the machine's tree, then loops that hold the tool.

    q of the machine comes first in its q, what leads behind it.

    Parameters
    ----------
    mechanism : Mechanism
    """

    def __init__(self, mechanism: Mechanism) -> None:
        self._mechanism, self._model = mechanism, mechanism.model
        self._motors: list[str] = []

    def joint(
        self, carrier: int, joint: pin.JointModel, place: pin.SE3, name: str, *, driven: bool = True
    ) -> int:
        """Add a joint behind another, and return its number.

        Raises
        ------
        ArgumentError
            A joint of the machine has this name: Pinocchio would take both.
        """
        if name in self._model.names or name in self._mechanism.coordinates.names:
            named = f"a joint of {self._mechanism.name} is named {quoted(name)} already"
            raise ArgumentError(f"{named}, as the one that is to lead its tool; rename it")
        self._motors += [name] * driven
        return int(self._model.addJoint(carrier, joint, place, name))

    def frame(self, name: str, carrier: int, place: pin.SE3) -> str:
        """Add a frame, and return its name: Pinocchio would take one that has it for the same."""
        unused = unused_name(name, {frame.name for frame in self._model.frames})
        frame = pin.Frame(unused, carrier, place, pin.FrameType.OP_FRAME)
        self._model.addFrame(frame, False)
        return unused

    def closed(
        self, q: Array, *, before: Sequence[Loop] = (), after: Sequence[Loop] = ()
    ) -> Mechanism:
        """Return the machine, at home at q, with loops before and after its own.

        Raises
        ------
        ClosureError
            It does not close there, or is singular.
        """
        mechanism, spec = self._mechanism, self._mechanism.spec
        own = (resolved_loop(loop, mechanism.parameters) for loop in spec.loops)
        led = replace(
            spec,
            actuated=tuple(self._motors),
            passive=None,
            loops=(*before, *own, *after),
            poses={"home": JointCoordinates(self._model).pose(q)},
            spherical=(),
            helical={},
            armature={},
            parameters={},
            enforce_limits=False,
        )
        return Mechanism(build_parts(self._model, led, {}, mechanism.urdf, q))
