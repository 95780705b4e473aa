"""MechanismSpec: what a model file says, checked. It knows nothing of Pinocchio.

A model file is data: which URDF, which loops, which motors, which tool, which poses, and how
the parameters move the origins of that URDF. Nothing in it is evaluated.
"""

from __future__ import annotations

import sys
from collections.abc import Iterable, Iterator, Mapping, Sized
from functools import cache, lru_cache, reduce
from numbers import Real
from operator import or_
from types import GenericAlias, MappingProxyType
from typing import TYPE_CHECKING, Annotated, Any

import msgspec
from msgspec.structs import replace

from pmjac_pin.errors import ArgumentError, did_you_mean, enumerated, quoted, unknown_name
from pmjac_pin.model.loop_spec import LOOP_KINDS, MAXIMAL_LOOPS, JointLoop, Loop
from pmjac_pin.model.parameter import Move, Parameter
from pmjac_pin.model.table import LONGEST_NAME, Name, TomlTable
from pmjac_pin.model.tool_rows import checked_axes, checked_rows
from pmjac_pin.model.tool_spec import NO_TOOL, Tool
from pmjac_pin.values.checks import LARGEST, SMALLEST, as_names, as_number

if TYPE_CHECKING:
    Loops = tuple[Loop, ...]
else:
    Loops = tuple[Any, ...]  # which kinds there are is known when a file is read: `converted`

MAXIMAL_ENTRIES = 1000  # poses, and parameters: each pose is assembled, and takes milliseconds
_SPECS = 8  # decoded ones that are kept

JointValue = float | tuple[float, ...]


class MechanismSpec(TomlTable, frozen=True, kw_only=True):
    """What a model file says.

    Attributes
    ----------
    name : str
        The mechanism's name; the file's stem when the file gives none.
    description : str
        One sentence.
    urdf : str
        The cut tree: a path relative to the model file or to the ``urdf`` folder beside its
        folder, or ``"example-robot-data:PATH"``.
    actuated, passive : tuple of str
        Joints in the order of the columns of K, J and K*, J*. Without `passive`: every other
        joint that moves, in Pinocchio's order.
    tool : Tool
        `NO_TOOL` where no frame is named.
    loops : tuple of PointLoop, DistanceLoop, ...
        ``[[loop]]`` in the file; `pmjac_pin.model.loop_spec` has all kinds.
    locked : mapping of str to float
        Joints that are held, at these values in rad or m: springs at rest, brakes. One of several
        degrees of freedom, such as a walking robot's base or a ball, at its values as in a pose;
        at its origin where 0.
    spherical : tuple of str
        Joints that the URDF writes as ``floating`` for want of a ball joint: they only turn.
    helical : mapping of str to float
        Joints that the URDF writes as ``revolute`` or ``continuous`` for want of a screw: how far
        they slide along their axes as they turn, m/rad.
    armature : mapping of str to float
        Of motors' rotors: what they add to the inertia of a joint, kg m² or kg, gears included.
    tolerance : float or None
        The gap in m up to which the loops count as closed, for models whose loops cannot close
        exactly because their numbers are rounded; None for 1e-12 of the mechanism's length.
    enforce_limits : bool
        Whether poses keep within the limits of the joints. Without, one that is given beyond them
        or closes only there is taken as it is, and so are values of locked joints.
    poses : mapping of str to mapping of str to float
        Joint values, m or rad, near which the loops are assembled; "home" is one of them.
    parameters : mapping of str to Parameter
    """

    name: Annotated[str, msgspec.Meta(max_length=LONGEST_NAME)] = ""
    description: str = ""
    urdf: str = ""
    actuated: tuple[Name, ...]
    passive: tuple[Name, ...] | None = None
    tool: Tool = NO_TOOL
    loops: Loops = msgspec.field(default=(), name="loop")
    locked: dict[Name, JointValue] = msgspec.field(default_factory=dict)
    spherical: tuple[Name, ...] = ()
    helical: dict[Name, float] = msgspec.field(default_factory=dict)
    armature: dict[Name, float] = msgspec.field(default_factory=dict)
    tolerance: float | None = None
    enforce_limits: bool = True
    poses: dict[Name, dict[Name, JointValue]]
    parameters: dict[Name, Parameter] = msgspec.field(default_factory=dict)

    def __post_init__(self) -> None:
        super().__post_init__()
        _refuse_many("loops", self.loops, MAXIMAL_LOOPS)
        _refuse_many("poses", self.poses, MAXIMAL_ENTRIES)
        _refuse_many("parameters", self.parameters, MAXIMAL_ENTRIES)
        _refuse_repeated("actuated", self.actuated)
        _refuse_repeated("passive", self.passive or ())
        _refuse_repeated("spherical", self.spherical)
        for name, pitch in self.helical.items():
            checked_pitch(name, pitch)
        for name, inertia in self.armature.items():
            if not as_number(inertia, f"the armature of joint {quoted(name)}") >= 0.0:
                raise ArgumentError(f"the armature of joint {quoted(name)} is below 0: {inertia:g}")
        if not isinstance(self.tolerance, Real | None):
            raise ArgumentError(f"`tolerance` is a number in m, got {quoted(self.tolerance)}")
        if self.tolerance is not None and not 0.0 < self.tolerance <= sys.float_info.max:
            raise ArgumentError(f"`tolerance` is a length above 0 m, got {quoted(self.tolerance)}")
        if not isinstance(self.enforce_limits, bool):
            given = quoted(self.enforce_limits)
            raise ArgumentError(f"`enforce_limits` is true or false, got {given}")
        if not self.actuated:
            raise ArgumentError("`actuated` is empty: name at least one motor joint")
        if both := sorted(set(self.actuated) & set(self.passive or ())):
            raise ArgumentError(f"joint {quoted(both[0])} is listed as actuated and as passive")
        self._check_locked()
        if "home" not in self.poses:
            others = f"; there are: {enumerated(tuple(self.poses))}" if self.poses else ""
            raise ArgumentError(f"`poses.home` is missing{others}")
        for loop in self.loops:
            _check_length(loop, self.parameters)
        for name in self.parameters:
            if not self._uses(name):
                raise ArgumentError(f"parameter {quoted(name)} moves nothing and is in no length")

    def _uses(self, parameter: str) -> bool:
        between = [loop for loop in self.loops if not isinstance(loop, JointLoop)]
        in_a_loop = any(parameter in loop.parameter_names for loop in between)
        return bool(self.parameters[parameter].moves) or in_a_loop

    def _check_locked(self) -> None:
        uses = {"actuated": self.actuated, "passive": self.passive or ()}
        for name in self.locked:
            for use, names in (*uses.items(), *((f"poses.{k}", v) for k, v in self.poses.items())):
                if name in names:
                    raise ArgumentError(f"joint {quoted(name)} is locked; remove it from `{use}`")

    def with_locked(self, joints: Iterable[str] | Mapping[str, JointValue]) -> MechanismSpec:
        """Return the spec with these joints held: they are in no pose, no motor and not passive.

        Parameters
        ----------
        joints : iterable of str, or mapping of str to float or floats
            Their names, for those that are held at their values in the home pose (0 where it
            has none), or their values in rad or m.

        Raises
        ------
        ArgumentError
            All motors, or a value that is no number.
        """
        names = as_names(joints, "`locked` is a list of joints or a mapping")
        home = {**self.locked, **self.poses["home"]}
        given = joints if isinstance(joints, Mapping) else {k: home.get(k, 0.0) for k in names}
        held = {name: _held_at(name, value) for name, value in given.items()}
        if not (driven := tuple(name for name in self.actuated if name not in held)):
            raise ArgumentError(
                f"all motors are locked ({enumerated(self.actuated)}); hold fewer, or name others "
                "by `actuated`"
            )
        return replace(
            self,
            actuated=driven,
            locked={**self.locked, **held},
            passive=self.passive and tuple(name for name in self.passive if name not in held),
            poses={
                pose: {name: value for name, value in values.items() if name not in held}
                for pose, values in self.poses.items()
            },
        )

    def with_tool_rows(self, rows: Iterable[str] | None, axes: str | None) -> MechanismSpec:
        """Return the spec with other rows of the tool's twist judged, or in other axes.

        Raises
        ------
        ArgumentError
            No such rows or axes; axes, but no rows.
        """
        tool = self.tool
        if tool.is_none and not (rows is None and axes is None):
            raise ArgumentError("rows of the tool's twist are given, and no tool: name its frame")
        if rows is not None:
            tool = replace(tool, rows=checked_rows(rows))
        if axes is not None:
            tool = replace(tool, axes=checked_axes(axes))
        return replace(self, tool=tool)

    def __reduce__(self) -> tuple[Any, ...]:
        return (decode_spec, (encode_spec(self),))

    def parameter_values(self, given: Mapping[str, float] | None = None) -> Mapping[str, float]:
        """Return every parameter's value: the given ones checked, the others at their default.

        Raises
        ------
        UnknownNameError
            A parameter that the model does not declare.
        ArgumentError
            Not a number, or outside the parameter's range.
        """
        values = {name: parameter.default for name, parameter in self.parameters.items()}
        if not isinstance(given, Mapping | None):
            message = f"parameters must be a mapping of names to numbers, got {quoted(given)}"
            raise ArgumentError(message)
        for name, value in (given or {}).items():
            if name not in self.parameters:
                raise unknown_name("parameter", name, tuple(self.parameters))
            values[name] = self.parameters[name].check(name, value)
        return MappingProxyType(values)

    def moves(self, values: Mapping[str, float]) -> Iterator[tuple[Move, float]]:
        """Yield each move with the parameter's distance from its default."""
        for name, parameter in self.parameters.items():
            for move in parameter.moves:
                yield move, values[name] - parameter.default


def encode_spec(spec: MechanismSpec) -> bytes:
    """Encode a spec as JSON."""
    return msgspec.json.encode(spec, enc_hook=_builtin)


def decode_spec(encoded: bytes) -> MechanismSpec:
    """Decode what `encode_spec` made; that of poses that come one after another is decoded once."""
    return _decoded(encoded, tuple(LOOP_KINDS.values()))


@lru_cache(maxsize=_SPECS)
def _decoded(encoded: bytes, kinds: tuple[type[Loop], ...]) -> MechanismSpec:
    return converted(msgspec.json.decode(encoded))


def converted(contents: Any) -> MechanismSpec:
    """Return the specification that a model file's contents are.

    Raises
    ------
    msgspec.ValidationError
        A key or value that is none; loops of all registered kinds are known.
    """
    if isinstance(contents, Mapping) and "loop" in contents:
        loops = msgspec.convert({"loop": contents["loop"]}, _loops_of(tuple(LOOP_KINDS.values())))
        contents = {**contents, "loop": loops.loops}
    return msgspec.convert(contents, MechanismSpec)


@cache
def _loops_of(kinds: tuple[type[Loop], ...]) -> Any:
    """Return the table of a model file's loops, of these kinds."""
    loops = GenericAlias(tuple, (reduce(or_, kinds), ...))
    return msgspec.defstruct("Loops", [("loops", loops, msgspec.field(name="loop"))])


def _builtin(value: Any) -> dict[str, Any] | float | str:
    """Return what JSON knows for a read-only mapping or one of NumPy's scalars."""
    if isinstance(value, str):
        return str(value)
    return float(value) if isinstance(value, Real) else dict(value)


def _refuse_many(what: str, entries: Sized, most: int) -> None:
    if len(entries) > most:
        raise ArgumentError(f"{len(entries)} {what} are too many; at most {most} are read")


def _refuse_repeated(key: str, names: Iterable[str]) -> None:
    seen: set[str] = set()
    for name in names:
        if name in seen:
            raise ArgumentError(f"joint {quoted(name)} is listed twice in `{key}`")
        seen.add(name)


def _held_at(name: str, value: object) -> JointValue:
    if isinstance(value, tuple | list):
        return tuple(_held_at_number(name, number) for number in value)
    return _held_at_number(name, value)


def _held_at_number(name: str, value: object) -> float:
    if isinstance(value, bool) or not isinstance(value, Real):
        raise ArgumentError(f"joint {quoted(name)} is locked at one number, got {quoted(value)}")
    return as_number(value, f"the value of the locked joint {quoted(name)}")


def checked_pitch(name: str, pitch: object) -> float:
    """Return how far a screw slides, m/rad, if that is neither nothing nor beyond measure.

    Raises
    ------
    ArgumentError
    """
    number = as_number(pitch, f"the pitch of joint {quoted(name)}")
    size = abs(number)
    if not SMALLEST <= size <= LARGEST:
        limits = f"of magnitude {SMALLEST:g} to {LARGEST:g} m/rad"
        raise ArgumentError(f"the pitch of joint {quoted(name)} is {limits}, got {number:g}")
    return number


def _check_length(loop: Loop, parameters: Mapping[str, Parameter]) -> None:
    if isinstance(loop, JointLoop):
        return
    for name in sorted(loop.parameter_names):
        if name not in parameters:
            hint = did_you_mean(name, parameters)
            raise ArgumentError(f"unknown parameter {quoted(name)} in the length of a loop{hint}")
    loop.resolved({name: item.default for name, item in parameters.items()})
