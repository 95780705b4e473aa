"""Blueprint: what a file says a mechanism is built of, at any values of its parameters."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np
import pinocchio as pin

from pmjac_pin.closing.assembly import assembled, unassembled
from pmjac_pin.closing.home_on_the_way import followed, home_pose, part_of_the_way
from pmjac_pin.closing.parts import Parts, PartsAtHome
from pmjac_pin.errors import ArgumentError, ClosureError, ModelFileError, PmjacError, unknown_name
from pmjac_pin.files.urdf.locking import lock_joints
from pmjac_pin.files.urdf.robot import Urdf
from pmjac_pin.model.joint_kinds import JOINT_KINDS
from pmjac_pin.model.linkage import with_helical, with_spherical
from pmjac_pin.model.loop_spec import LOOP_KINDS
from pmjac_pin.model.spec import MechanismSpec
from pmjac_pin.values.arrays import Array, norm
from pmjac_pin.values.found_once import found_once
from pmjac_pin.values.made_lately import MadeLately
from pmjac_pin.values.sealed_pickle import sealed_pickle, unsealed

if TYPE_CHECKING:
    from pmjac_pin.algebra.recordings import Recordings

_FARTHEST_TURN = 0.5  # rad, of a joint's origin between stops: several on one body add up
_BLUEPRINTS = MadeLately["Blueprint"](most=8, most_bytes=500_000)  # of those unpickled


@dataclass(frozen=True, eq=False)
class Blueprint:
    """What parts are made of at any values of the parameters, the same whoever asks before.

    Attributes
    ----------
    path : str
        The file; only for messages.
    spec : MechanismSpec
    urdf : Urdf
        The cut tree at the parameters' defaults.
    """

    path: str
    spec: MechanismSpec
    urdf: Urdf

    def __reduce__(self) -> tuple[Any, ...]:
        # What is found once is not sent.
        return _unpickled_blueprint, (sealed_pickle((self.path, self.spec, self.urdf)),)

    def of(self, spec: MechanismSpec) -> Blueprint:
        """Return that of another spec of the same tree."""
        return replace(self, spec=spec)

    def parts(self, given: Mapping[str, float] | None = None) -> PartsAtHome:
        """Return the parts at these values, other parameters at their defaults.

        Raises
        ------
        UnknownNameError, ArgumentError
            No such parameter, or a value outside its range.
        ModelFileError, ClosureError
            As in `load`.
        """
        values = self.spec.parameter_values(given)
        try:
            parts = self._unassembled(values)
            return assembled(parts, self._start(parts))
        except (ClosureError, ModelFileError):
            raise
        except PmjacError as error:
            raise ModelFileError(f"{self.path}: {error}", path=self.path) from error

    def _unassembled(self, values: Mapping[str, float]) -> Parts:
        spec = self.spec
        urdf = self.urdf.moved(spec.moves(values))
        if spec.locked:
            held, limits = (spec.locked, spec.helical, spec.spherical), spec.enforce_limits
            urdf = lock_joints(urdf, *held, enforce_limits=limits)
        return unassembled(_pinocchio_model(urdf, spec), spec, values, urdf)

    @found_once
    def recordings(self) -> Recordings:
        """What is recorded of these mechanisms."""
        # What records is imported with the first program.
        from pmjac_pin.algebra.recordings import Recordings  # noqa: PLC0415

        return Recordings()

    @found_once
    def beginning(self) -> tuple[Parts, Array | None]:
        """The machine at the defaults, not assembled, and its home pose, where that closes."""
        parts = self._unassembled(self.spec.parameter_values())
        return parts, home_pose(parts.problem, parts.home_q)

    def _start(self, parts: Parts) -> Array | None:
        """Return where to assemble the home pose; the spec's values when None."""
        if dict(parts.values) == dict(self.spec.parameter_values()):
            return None
        beginning, home_q = self.beginning
        return followed([beginning, *self._stops(parts.values), parts], home_q)

    def _stops(self, values: Mapping[str, float]) -> Iterator[Parts]:
        """Yield machines on the way from the defaults, where angles turn joints far."""
        defaults = self.spec.parameter_values()
        turns: dict[str, float] = {}
        for move, delta in self.spec.moves(values):
            if move.joint is not None:
                angle = abs(delta) * norm(np.array(move.rpy))
                turns[move.joint] = turns.get(move.joint, 0.0) + angle
        legs = 1 + int(max(turns.values(), default=0.0) / _FARTHEST_TURN)
        for leg in range(1, legs):
            yield self._unassembled(part_of_the_way(defaults, values, leg / legs))


def _unpickled_blueprint(sealed: bytes) -> Blueprint:
    """Return the blueprint that a pickle says: the same for siblings, which share recordings."""
    kinds = (*LOOP_KINDS.values(), *JOINT_KINDS.values())
    return _BLUEPRINTS.of(sealed, kinds, lambda: Blueprint(*unsealed(sealed, "a blueprint")))


def _pinocchio_model(urdf: Urdf, spec: MechanismSpec) -> pin.Model:
    try:
        model = pin.buildModelFromXML(urdf.kinematic_xml())
    except (RuntimeError, ValueError) as error:
        message = f"Pinocchio cannot build the tree: {str(error).splitlines()[0]}"
        raise ArgumentError(message) from None
    if balls := tuple(name for name in spec.spherical if name not in spec.locked):
        model = with_spherical(model, balls)
    helical = {name: pitch for name, pitch in spec.helical.items() if name not in spec.locked}
    model = with_helical(model, helical) if helical else model
    for name in spec.armature.keys() - spec.locked.keys():
        if not model.existJointName(name):
            raise unknown_name("joint", name, tuple(model.names[1:]))
        joint = model.joints[model.getJointId(name)]
        model.armature[joint.idx_v : joint.idx_v + joint.nv] = spec.armature[name]
    return model
