"""A mechanism as a value: its names and numbers, and what makes two of them the same."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import partial
from types import MappingProxyType
from typing import Any, Self

import pinocchio as pin

from pmjac_pin.closing.assembly import FoundAtHome, rebuilt_parts
from pmjac_pin.closing.blueprint import Blueprint
from pmjac_pin.closing.closure_problem import ClosureProblem
from pmjac_pin.closing.nearby_poses import FARTHEST
from pmjac_pin.closing.parts import PartsAtHome
from pmjac_pin.errors import ArgumentError, NoToolError, enumerated
from pmjac_pin.files.urdf.robot import Urdf
from pmjac_pin.kinematics.pinocchio import Kinematics
from pmjac_pin.model.coordinates import JointCoordinates
from pmjac_pin.model.frames import frames_from_the_ends
from pmjac_pin.model.joint_kinds import JOINT_KINDS
from pmjac_pin.model.loop_spec import LOOP_KINDS, JointLoop
from pmjac_pin.model.spec import MechanismSpec
from pmjac_pin.values.arrays import Array, read_only
from pmjac_pin.values.found_once import found_once
from pmjac_pin.values.made_lately import MadeLately
from pmjac_pin.values.sealed_pickle import sealed_pickle, unsealed

_MOST_FRAMES = 12  # listed in one message
# Of those that were unpickled. What one holds grows much faster than its pickle, of 3 to 8 kB a
# joint: of a ladder with 129 joints, which holds as many MB, none is kept.
_MECHANISMS = MadeLately["MechanismValue"](most=8, most_bytes=500_000)


@dataclass(frozen=True, eq=False, repr=False)
class MechanismValue:
    """What never changes of a mechanism, wherever it stands.

    Equal where spec, parameters and Pinocchio model are; copied as itself; pickled by what it is
    built of and what was found for it, as Pinocchio's constraint models cannot be.
    """

    _parts: PartsAtHome
    notes: tuple[str, ...] = field(default=(), kw_only=True)
    unread: tuple[str, ...] = field(default=(), kw_only=True)
    blueprint: Blueprint | None = field(default=None, kw_only=True)

    def __post_init__(self) -> None:
        if not isinstance(self._parts, PartsAtHome):
            raise ArgumentError("a Mechanism is made by pmjac_pin.load or from_pinocchio")

    @property
    def name(self) -> str:
        """The mechanism's name."""
        return self._parts.spec.name

    @property
    def spec(self) -> MechanismSpec:
        """What the model file says."""
        return self._parts.spec

    @property
    def model(self) -> pin.Model:
        """The Pinocchio model of the cut tree: a copy, to change as you like."""
        return self._parts.standing.copy()

    @property
    def urdf(self) -> Urdf | None:
        """What the model was built of, at these parameters; None for a model of Pinocchio's."""
        return self._parts.urdf

    @property
    def parameters(self) -> Mapping[str, float]:
        """The parameters' values, m or rad."""
        return self._parts.values

    @property
    def coordinates(self) -> JointCoordinates:
        """The joints' values in q by name, their limits and units."""
        return self._parts.coordinates

    @property
    def kinematics(self) -> Kinematics:
        """The tree, its loops and its tool at any q, beside `place`; not to be changed.

        `kinematics.model` is the Pinocchio model that everything is computed with: `model` less
        `place`, and the same where the mechanism stands near the world's origin.
        """
        return self._parts.kinematics

    @property
    def problem(self) -> ClosureProblem:
        """The closure problem: loop equations, split into motors and passive joints, tolerance.

        `problem.partition` has the split, the scales and the generic ranks; what asks a question
        of a mechanism starts here.

        Examples
        --------
        >>> import pmjac_pin as pj
        >>> mechanism = pj.load("four_bar")
        >>> residual, jacobian = mechanism.problem.evaluate(mechanism.home.q)
        >>> jacobian[:, mechanism.problem.partition.passive].shape
        (3, 2)
        """
        return self._parts.problem

    @property
    def actuated(self) -> tuple[str, ...]:
        """Names of the n actuated degrees of freedom: the columns of K and J."""
        return self._parts.problem.partition.actuated_names

    @property
    def passive(self) -> tuple[str, ...]:
        """Names of the m_p passive degrees of freedom: the columns of K* and J*."""
        return self._parts.problem.partition.passive_names

    @property
    def possible_tools(self) -> tuple[str, ...]:
        """The links, those at the ends of chains first: what a tool may be named of."""
        loops = self.spec.loops
        anchors = {
            name for loop in loops if not isinstance(loop, JointLoop) for name in loop.frames
        }
        return frames_from_the_ends(self._parts.model, anchors)

    def need_tool(self) -> None:
        """Raise NoToolError where no frame is named as the tool."""
        if self.spec.tool.is_none:
            frames = self.possible_tools
            name = "name a frame by `tool`, as in --tool or jacobian(tool=...)"
            advice = (
                f"{name}, of: {enumerated(frames, _MOST_FRAMES)}"
                if frames
                else f"its model has no link that could be one; add a frame to it, and {name}"
            )
            raise NoToolError(f"{self.name} has no tool: {advice}", frames=frames)

    @property
    def rows(self) -> tuple[str, ...]:
        """Names of the p rows of the loop equations."""
        return self._parts.problem.partition.row_names

    @property
    def row_units(self) -> tuple[str, ...]:
        """Unit of each of the p rows: "m" for a point loop, "m²" for a distance loop."""
        return self._parts.problem.partition.row_units

    @property
    def units(self) -> Mapping[str, str]:
        """Unit of each degree of freedom by its name: "m" or "rad"."""
        partition = self._parts.problem.partition
        columns, units = partition.columns, partition.units
        return MappingProxyType({name: units[k] for name, k in columns.items()})

    @property
    def nq(self) -> int:
        """Pinocchio's number of configuration variables."""
        return int(self._parts.model.nq)

    @property
    def nv(self) -> int:
        """Pinocchio's number of velocity variables."""
        return int(self._parts.model.nv)

    @property
    def mobility(self) -> int | None:
        """Degrees of freedom: nv − rank [K K*], the largest rank of home and poses near it.

        None where it is not known: no pose near home closes, although the ranks at home alone
        would allow a motion. The mechanism is a structure, or its home is singular. Where only
        poses very near home close, loops may part beyond them: `repr` says so, and `check`.
        """
        partition = self._parts.problem.partition
        return None if partition.isolated else self.nv - partition.constraint_rank

    @property
    def characteristic_length(self) -> float:
        """The length in m that makes radians and metres comparable where ranks are judged."""
        return self._parts.problem.partition.length

    @property
    def place(self) -> Array:
        """Where the mechanism stands, shape (3,), m; 0 unless it is far from the world's origin.

        Far from it, coordinates have few digits left for what moves: everything is computed, and
        drawn, beside this place. `model`, `Configuration.tool_pose` and frame "WORLD" are the
        world's all the same.
        """
        return read_only(self._parts.place)

    @property
    def tolerance(self) -> float:
        """The gap in m below which loops count as closed.

        1e-12 of the characteristic length, or what the model gives; and no less than the rounding
        of the coordinates where the machine stands, 3.6e-8 m at 1e7 m from the world's origin.
        """
        return self._parts.problem.tolerance

    @property
    def poses(self) -> tuple[str, ...]:
        """Names of the poses, each a start for `close`."""
        return tuple(self.spec.poses)

    def limits(self, name: str) -> tuple[float, float]:
        """Return the lower and upper limit of a degree of freedom, m or rad; infinite without.

        Parameters
        ----------
        name : str
            One of `actuated` or `passive`, or a joint's.

        Raises
        ------
        UnknownNameError, ArgumentError

        Examples
        --------
        >>> import pmjac_pin as pj
        >>> pj.load("three_rps").limits("l1")
        (0.1, 3.0)
        """
        coordinates, columns = self._parts.coordinates, self._parts.problem.partition.columns
        if isinstance(name, str) and name in columns:
            column = columns[name]
            return float(coordinates.lower[column]), float(coordinates.upper[column])
        return coordinates.limits(name)

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, MechanismValue):
            return NotImplemented
        mine, theirs = self._parts, other._parts
        return (
            mine.spec == theirs.spec
            and dict(mine.values) == dict(theirs.values)
            and bool(mine.standing == theirs.standing)
        )

    def __hash__(self) -> int:
        return hash((self.name, self.actuated, tuple(self.parameters.items())))

    def __copy__(self) -> Self:
        return self

    def __deepcopy__(self, memo: dict[int, Any]) -> Self:
        return self

    @found_once
    def _sealed(self) -> bytes:
        """What a pickle says of it: what it is built of, and what was found for it."""
        parts, blueprint = self._parts, self.blueprint
        told = {"notes": self.notes, "unread": self.unread, "blueprint": blueprint}
        urdf = None if blueprint is not None and blueprint.urdf is parts.urdf else parts.urdf
        built_of = (parts.standing, parts.spec, dict(parts.values), urdf)
        return sealed_pickle((told, *built_of, FoundAtHome.of(parts)))

    def __reduce__(self) -> tuple[Any, ...]:
        return (_unpickled_mechanism, (type(self), self._sealed))

    def __repr__(self) -> str:
        motors = ", ".join(self.actuated[:3]) + ", ..." * (len(self.actuated) > 3)
        return (
            f"Mechanism({self.name}, actuated=({motors}), {len(self.passive)} passive, "
            f"{len(self.spec.loops)} loop{'s' * (len(self.spec.loops) != 1)}, "
            f"mobility {'not known' if self.mobility is None else self.mobility}{self._seen})"
        )

    @property
    def _seen(self) -> str:
        partition, turns = self._parts.problem.partition, self._parts.coordinates.rotational
        if not 0.0 < partition.reach < FARTHEST:
            return ""
        far = (
            f"{partition.reach:g} rad"
            if turns.any()
            else f"{partition.reach * partition.length:g} m"
        )
        return f", seen no further than {far} from home"


def _unpickled_mechanism(kind: type[MechanismValue], sealed: bytes) -> MechanismValue:
    """Return the mechanism that a pickle says: the same one while the same is unpickled again."""
    # What names mean depends on the kinds that are registered.
    kinds = (kind, *LOOP_KINDS.values(), *JOINT_KINDS.values())
    return _MECHANISMS.of(sealed, kinds, partial(_rebuilt, kind, sealed))


def _rebuilt(kind: type[MechanismValue], sealed: bytes) -> MechanismValue:
    told, model, spec, values, urdf, found = unsealed(sealed, "a mechanism")
    if urdf is None and told["blueprint"] is not None:
        urdf = told["blueprint"].urdf
    return kind(rebuilt_parts(model, spec, values, urdf, found), **told)
