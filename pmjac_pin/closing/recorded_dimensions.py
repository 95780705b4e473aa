"""The dimensions of a machine from a file, as functions of its parameters that can be recorded.

Origins of a URDF's joints are known numbers with what parameters move them by, and fixed joints
between two that move are one placement of Pinocchio's. So each placement is a product of origins,
of recorded numbers where a parameter moves one of them. Elsewhere it is the model's, to the bit.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

import numpy as np
import pinocchio as pin

from pmjac_pin.algebra.arrays import Numbers
from pmjac_pin.algebra.programs import PROGRAMS, objects
from pmjac_pin.algebra.terms import Term
from pmjac_pin.closing.blueprint import Blueprint
from pmjac_pin.closing.parts import Parts
from pmjac_pin.errors import ArgumentError
from pmjac_pin.files.urdf.locking import lock_joints
from pmjac_pin.files.urdf.placed_numbers import Origin, origins_of
from pmjac_pin.files.urdf.robot import Urdf
from pmjac_pin.kinematics.dimensions import Dimensions, Placement
from pmjac_pin.model.frames import find_frame
from pmjac_pin.model.loop_spec import DistanceLoop, JointLoop
from pmjac_pin.model.spec import MechanismSpec

_SAME = 1e-12  # m, or of an axis: by which a product of origins is Pinocchio's placement
_AXIS_ROUNDING = 1e-15  # of an axis


class RecordedDimensions:
    """Where joints and frames of a machine are, at recorded values of its parameters.

    Parameters
    ----------
    parts : Parts
        The machine at some values.
    blueprint : Blueprint
        What it was made of.

    Raises
    ------
    ArgumentError
        Its placements are not those that its file's origins lead to.
    """

    def __init__(self, parts: Parts, blueprint: Blueprint) -> None:
        self._parts = parts
        self._chains = _Chains(blueprint.urdf, parts.spec)
        self._frames = dict(self._named_frames())
        self._turned = {0: pin.SE3.Identity()}
        own = self._chains.at(parts.values)
        self._hang(own)
        self._check(self._placed(own))

    def at(self, values: Mapping[str, Any]) -> Dimensions:
        """Return the dimensions at values of the parameters, doubles or recorded numbers.

        Raises
        ------
        ArgumentError
            A recorded value that changes a loop's rows otherwise than by the length of a rod.
        """
        recorded = {name for name, value in values.items() if isinstance(value, Term)}
        for loop in self._parts.spec.loops:
            moved = set() if isinstance(loop, JointLoop) else recorded & loop.parameter_names
            if moved and not isinstance(loop, DistanceLoop):
                raise ArgumentError(f"{sorted(moved)} change loops otherwise than a rod's length")
        joints, frames = self._placed(self._chains.at(values))
        model = self._parts.model
        return Dimensions(
            {k: _where_fixed(place, model.jointPlacements[k]) for k, place in joints.items()},
            {k: _where_fixed(place, model.frames[k].placement) for k, place in frames.items()},
            values,
        )

    def _placed(self, chains: _Carried) -> tuple[dict[int, Placement], dict[int, Placement]]:
        """Return the placements of joints and of frames, by Pinocchio's indices."""
        model, turned = self._parts.model, self._turned
        joints, frames = {}, {}
        for joint in range(1, model.njoints):
            _, place = chains.joints[model.names[joint]]
            above = turned[model.parents[joint]].inverse()
            joints[joint] = Placement.of(above) * place * turned[joint]
        for index, name in self._frames.items():
            carrier, place = (chains.links if name in chains.links else chains.ends)[name]
            number = model.getJointId(carrier) if carrier else 0
            frames[index] = Placement.of(turned[number].inverse()) * place
        return joints, frames

    def _named_frames(self) -> Iterator[tuple[int, str]]:
        """Yield the frames that loops and tool rest on, with what the URDF calls them."""
        spec, model = self._parts.spec, self._parts.model
        names = [
            name for loop in spec.loops if not isinstance(loop, JointLoop) for name in loop.frames
        ]
        for name in [*names, *spec.tool.names]:
            yield find_frame(model, name).index, name

    def _hang(self, chains: _Carried) -> None:
        """Find how each body's frame is turned against the URDF's, where joints were rebuilt."""
        model = self._parts.model
        for joint in range(1, model.njoints):
            if model.names[joint] not in chains.joints:
                raise ArgumentError(f"joint {model.names[joint]!r} is none of the file's")
            _, place = chains.joints[model.names[joint]]
            fixed = pin.SE3(place.rotation.astype(float), place.translation.astype(float))
            above = self._turned[model.parents[joint]]
            turned = fixed.actInv(above * model.jointPlacements[joint])
            if np.abs(turned.translation).max() > _SAME:
                raise ArgumentError(f"joint {model.names[joint]!r} is not where its file has it")
            self._turned[joint] = pin.SE3(_without_rounding(turned.rotation), np.zeros(3))

    def _check(self, placed: tuple[dict[int, Placement], dict[int, Placement]]) -> None:
        """Raise where a placement is another than the model's."""
        joints, frames = placed
        model = self._parts.model
        pairs = [(place, model.jointPlacements[k]) for k, place in joints.items()]
        pairs += [(place, model.frames[k].placement) for k, place in frames.items()]
        for mine, known in pairs:
            off = np.abs((mine.rotation - known.rotation).astype(float)).max()
            off = max(off, np.abs((mine.translation - known.translation).astype(float)).max())
            if off > _SAME:
                raise ArgumentError(f"a placement is {off:g} beside the one of its file")


class _Carried(NamedTuple):
    """Names of links and joints ↦ the joint that carries them, "" for none, and where on it.

    Attributes
    ----------
    links, ends : dict
        Links; the frames behind joints, which have their names.
    joints : dict
        Joints, before they move.
    """

    links: dict[str, tuple[str, Placement]]
    joints: dict[str, tuple[str, Placement]]
    ends: dict[str, tuple[str, Placement]]


class _Chains:
    """The joints of a URDF as chains of origins."""

    def __init__(self, urdf: Urdf, spec: MechanismSpec) -> None:
        self._urdf, self._spec, self._origins = urdf, spec, origins_of(urdf)
        locked = lock_joints(urdf, spec.locked, spec.helical, spec.spherical, enforce_limits=False)
        self._locked = {
            name: _placement(self._origins[name]).inverse() * _placement(origin)
            for name, origin in origins_of(locked).items()
            if name in spec.locked
        }

    def at(self, values: Mapping[str, Any]) -> _Carried:
        """Return where all of them are at values of the parameters."""
        moved = dict(self._moved(values))
        here = Placement.of(pin.SE3.Identity())
        found = _Carried(dict.fromkeys(self._urdf.links, ("", here)), {}, {})
        waiting = {joint.child: joint for joint in self._urdf.joints}
        for link in self._urdf.links:
            above = []
            while (joint := waiting.pop(link, None)) is not None:
                above.append(joint)
                link = joint.parent  # noqa: PLW2901 - up to what is known
            for joint in reversed(above):
                carrier, place = found.links[joint.parent]
                place = place * moved[joint.name]
                moves = joint.type != "fixed" and joint.name not in self._spec.locked
                end = (joint.name, here) if moves else (carrier, place)
                found.joints[joint.name] = (carrier, place)
                found.links[joint.child] = found.ends[joint.name] = end
        return found

    def _moved(self, values: Mapping[str, Any]) -> Iterator[tuple[str, Placement]]:
        """Yield the origins of the joints, what locks them included."""
        shifts: dict[str, list[tuple[Any, Any]]] = {}
        for move, delta in self._spec.moves(values):
            if move.joint is not None:
                shifts.setdefault(move.joint, []).append((move, delta))
        for name, origin in self._origins.items():
            xyz, rpy = list(origin.xyz), list(origin.rpy)
            for move, delta in shifts.get(name, ()):
                xyz = [a + delta * k for a, k in zip(xyz, move.xyz, strict=True)]
                rpy = [a + delta * k for a, k in zip(rpy, move.rpy, strict=True)]
            place = Placement(_roll_pitch_yaw(rpy), objects(xyz))
            yield name, place * self._locked[name] if name in self._locked else place


def _roll_pitch_yaw(rpy: list[Any]) -> Numbers:
    """Return the rotation of roll, pitch and yaw, of doubles or recorded numbers."""
    rotation: Numbers = np.eye(3).astype(object)
    for axis, angle in enumerate(rpy):
        rotation = _about(axis, angle) @ rotation
    return rotation


def _about(axis: int, angle: Any) -> Numbers:
    if isinstance(angle, Term):
        c, s = PROGRAMS.cos(angle), PROGRAMS.sin(angle)
    else:
        c, s = _without_rounding(np.array([np.cos(angle), np.sin(angle)])).tolist()
    j, k = (axis + 1) % 3, (axis + 2) % 3
    turned: Numbers = np.eye(3).astype(object)
    turned[j, j], turned[j, k], turned[k, j], turned[k, k] = c, -s, s, c
    return turned


def _placement(origin: Origin) -> pin.SE3:
    return pin.SE3(pin.rpy.rpyToMatrix(np.array(origin.rpy)), np.array(origin.xyz))


def _without_rounding(entries: Any) -> Any:
    """Return entries of rotations, those that are 0, 1 or −1 but for rounding made so."""
    whole = np.rint(entries)
    return np.where(np.abs(entries - whole) <= _AXIS_ROUNDING, whole, entries)


def _where_fixed(place: Placement, known: pin.SE3) -> Placement:
    """Return a placement whose entries are the known ones where no parameter moves them."""

    def entries(mine: Numbers, theirs: Any) -> Numbers:
        pairs = zip(mine.ravel(), theirs.ravel().tolist(), strict=True)
        found = objects(a if isinstance(a, Term) else b for a, b in pairs)
        return found.reshape(mine.shape)

    return Placement(
        entries(place.rotation, known.rotation), entries(place.translation, known.translation)
    )
