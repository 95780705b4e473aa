"""The kinds of loop closure that a model file may declare, each with its equations.

p₁, p₂ are the origins of the loop's first and second frame, R₁, R₂ their axes in the world. An
`axis` has the same components in both frames: a is where the first frame carries it, b where the
second does. Residuals are first minus second, m or rad. Off closure, every rotation is measured
by its angle or chord, so that half a turn is not mistaken for none.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import ClassVar, Literal

import numpy as np
from msgspec.structs import force_setattr, replace
from numpy.typing import NDArray

from pmjac_pin.errors import ArgumentError, quoted
from pmjac_pin.model.joint_form import JointForm, Step, about_z, frame_along, shifted, single
from pmjac_pin.model.rows import Along, Distance, Gap, RightAngle, Rows, Tilt, Turn, across
from pmjac_pin.model.table import Name, Table, Vector
from pmjac_pin.values.checks import LARGEST, SMALLEST, as_number, as_numbers

Array = NDArray[np.float64]

X: Vector = (1.0, 0.0, 0.0)
Y: Vector = (0.0, 1.0, 0.0)
Z: Vector = (0.0, 0.0, 1.0)
_SHORTEST_AXIS = 1e-6

#: As many as there may be degrees of freedom; the time to load grows with the cube of their rows.
MAXIMAL_LOOPS = 200


#: What of the way between its frames a loop lets be: nothing, along an axis, or across it.
Opening = Literal["nothing", "along", "across"]


class LoopBetweenFrames(Table, frozen=True):
    """A loop between two frames of the tree: what each kind of it says of itself.

    Attributes
    ----------
    opening : str
        What of the way between the frames is no gap.
    """

    frames: tuple[Name, Name]
    opening: ClassVar[Opening] = "nothing"

    def __post_init__(self) -> None:
        super().__post_init__()
        _refuse_other_than_names("frames", self.frames)
        _refuse_equal("frames", self.frames)

    @property
    def ends(self) -> tuple[str, str]:
        """The names of what the loop joins."""
        return self.frames

    @property
    def lines(self) -> tuple[Vector, Vector] | None:
        """The axis that each frame carries; None where none does."""
        return None

    @property
    def exchanged(self) -> LoopBetweenFrames:
        """What the loop is with its frames exchanged, but for their names."""
        return self

    def rows(self, values: Mapping[str, float]) -> tuple[Rows, ...]:
        """Return the loop's rows where the parameters have these values."""
        raise NotImplementedError(type(self).__name__)

    def form(self, values: Mapping[str, float]) -> JointForm:
        """Return the joints that keep the loop closed."""
        raise NotImplementedError(type(self).__name__)

    def rod(self, values: Mapping[str, float]) -> float:
        """Return the length of the rod between the frames, m; 0 without."""
        return 0.0


class _AxisPair(LoopBetweenFrames, frozen=True):
    """A loop between two frames with a common axis."""

    axis: Vector = Z

    @property
    def lines(self) -> tuple[Vector, Vector] | None:
        """The one axis, twice."""
        return self.axis, self.axis

    @property
    def _tilt(self) -> Tilt:
        return Tilt(np.array(self.axis), across(np.array(self.axis)))

    @property
    def _aside(self) -> Along:
        return Along(across(np.array(self.axis)), ("across 1", "across 2"))

    def __post_init__(self) -> None:
        super().__post_init__()
        force_setattr(self, "axis", _unit("axis", self.axis))


class PointLoop(LoopBetweenFrames, frozen=True, tag_field="kind", tag="point"):
    """Two points coincide: η = p₁ − p₂, world axes, 3 rows.

    Examples
    --------
    >>> import pmjac_pin as pj
    >>> pj.PointLoop(frames=("coupler_tip", "rocker_tip")).frames
    ('coupler_tip', 'rocker_tip')
    """

    def rows(self, values: Mapping[str, float]) -> tuple[Rows, ...]:
        """Return p₁ − p₂."""
        return (Gap(),)

    def form(self, values: Mapping[str, float]) -> JointForm:
        """Return a ball."""
        return single("spherical", np.eye(4))


class SphericalLoop(PointLoop, frozen=True, tag_field="kind", tag="spherical"):
    """A ball and its socket: a point loop by its joint's name, η = p₁ − p₂, 3 rows."""


class FrameLoop(LoopBetweenFrames, frozen=True, tag_field="kind", tag="frame"):
    """Two bodies are one: η = (p₁ − p₂, log R₁R₂ᵀ), world axes, 6 rows."""

    def rows(self, values: Mapping[str, float]) -> tuple[Rows, ...]:
        """Return gap and turn."""
        return Gap(), Turn()

    def form(self, values: Mapping[str, float]) -> JointForm:
        """Return a weld."""
        return single("fixed", np.eye(4))


class RevoluteLoop(_AxisPair, frozen=True, tag_field="kind", tag="revolute"):
    """A hinge: η = (p₁ − p₂ in world axes, tilt of a against b), 5 rows.

    The tilt's two rows are tₖ·a / cos(α/2), with α the angle between a and b and t₁, t₂ fixed in
    the second frame, perpendicular to b.

    Parameters
    ----------
    frames : tuple of str
    axis : tuple of float, optional
        The hinge's axis, with the same components in both frames; z when not given.
    """

    def rows(self, values: Mapping[str, float]) -> tuple[Rows, ...]:
        """Return gap and tilt."""
        return Gap(), self._tilt

    def form(self, values: Mapping[str, float]) -> JointForm:
        """Return a hinge."""
        return single("revolute", frame_along(np.array(self.axis)))


class PrismaticLoop(_AxisPair, frozen=True, tag_field="kind", tag="prismatic"):
    """A slider: η = (tₖ·(p₁ − p₂), log R₁R₂ᵀ in world axes), 2 + 3 rows."""

    opening: ClassVar[Opening] = "along"

    def rows(self, values: Mapping[str, float]) -> tuple[Rows, ...]:
        """Return the gap across the axis, and the turn."""
        return self._aside, Turn()

    def form(self, values: Mapping[str, float]) -> JointForm:
        """Return a slider."""
        return single("prismatic", frame_along(np.array(self.axis)))


class CylindricalLoop(_AxisPair, frozen=True, tag_field="kind", tag="cylindrical"):
    """A turning slider: η = (tₖ·(p₁ − p₂), tilt of a against b), 4 rows."""

    opening: ClassVar[Opening] = "along"

    def rows(self, values: Mapping[str, float]) -> tuple[Rows, ...]:
        """Return the gap across the axis, and the tilt."""
        return self._aside, self._tilt

    def form(self, values: Mapping[str, float]) -> JointForm:
        """Return a turn about the axis, and a slide along it."""
        along = frame_along(np.array(self.axis))
        back = along.T
        turn, slide = (
            Step("turn", "continuous", along, np.eye(4)),
            Step("slide", "prismatic", np.eye(4), back),
        )
        return JointForm((turn, slide), lambda seen: along @ about_z((back @ seen @ along)[:3, 0]))


class PlanarLoop(_AxisPair, frozen=True, tag_field="kind", tag="planar"):
    """A plane on a plane with normal `axis`: η = (b·(p₁ − p₂), tilt of a against b), 3 rows."""

    opening: ClassVar[Opening] = "across"

    def rows(self, values: Mapping[str, float]) -> tuple[Rows, ...]:
        """Return the height, and the tilt."""
        return Along(np.array([self.axis]), ("height",)), self._tilt

    def form(self, values: Mapping[str, float]) -> JointForm:
        """Return a plane on a plane."""
        return single("planar", frame_along(np.array(self.axis)))


class UniversalLoop(LoopBetweenFrames, frozen=True, tag_field="kind", tag="universal"):
    """A universal (Cardan) joint: η = (p₁ − p₂ in world axes, a·b), 4 rows.

    Parameters
    ----------
    frames : tuple of str
    axes : tuple of two vectors, optional
        The cross's axis a that the first frame carries, in the first frame, and b that the
        second carries, in the second frame; x and y when not given.
    """

    axes: tuple[Vector, Vector] = (X, Y)

    def __post_init__(self) -> None:
        super().__post_init__()
        if not isinstance(self.axes, Sequence) or len(self.axes) != 2:
            raise ArgumentError(f"a universal joint has two `axes`, got {quoted(self.axes)}")
        first, second = self.axes
        force_setattr(self, "axes", (_unit("axes", first), _unit("axes", second)))

    @property
    def lines(self) -> tuple[Vector, Vector] | None:
        """The cross's axes."""
        return self.axes

    @property
    def exchanged(self) -> LoopBetweenFrames:
        """The cross with its axes exchanged."""
        return replace(self, axes=self.axes[::-1])

    def rows(self, values: Mapping[str, float]) -> tuple[Rows, ...]:
        """Return the gap, and the cosine between the axes."""
        return Gap(), RightAngle(np.array(self.axes[0]), np.array(self.axes[1]))

    def form(self, values: Mapping[str, float]) -> JointForm:
        """Return a cross that turns about z of one frame, and carries the other's axis as its x."""
        one, other = (frame_along(np.array(axis)) for axis in self.axes)
        back, away = one.T, other.T
        first = Step("1", "continuous", one, np.eye(4))
        second = Step("2", "continuous", frame_along(np.array(X)), away)
        return JointForm((first, second), lambda seen: one @ about_z((back @ seen @ other)[:3, 2]))


class DistanceLoop(LoopBetweenFrames, frozen=True, tag_field="kind", tag="distance"):
    """A rod between two points: η = |p₁ − p₂|² − length², m², 1 row.

    `length` is a number in m, or a table ``{parameter = coefficient}``: the sum of the
    coefficients times the parameters' values.
    """

    length: float | dict[str, float]

    def __post_init__(self) -> None:
        if not isinstance(self.length, Mapping):
            force_setattr(self, "length", as_number(self.length, "a rod's `length`"))
        super().__post_init__()

    def rows(self, values: Mapping[str, float]) -> tuple[Rows, ...]:
        """Return |p₁ − p₂|² − length²."""
        return (Distance(self.resolved_length(values)),)

    def form(self, values: Mapping[str, float]) -> JointForm:
        """Return a rod along z with a ball at each end, about which it may spin."""

        def middle(seen: Array) -> Array:
            way = seen[:3, 3]
            return frame_along(way / np.linalg.norm(way))

        far = shifted(np.array([0.0, 0.0, self.resolved_length(values)]))
        near = Step("near", "spherical", np.eye(4), np.eye(4))
        return JointForm((near, Step("far", "spherical", far, np.eye(4))), middle)

    def rod(self, values: Mapping[str, float]) -> float:
        """Return the length."""
        return self.resolved_length(values)

    def resolved_length(self, values: Mapping[str, float]) -> float:
        """Return the length in m at these values of the parameters.

        Raises
        ------
        ArgumentError
            It is none: not positive, or so small or large that its square is lost.
        """
        if isinstance(self.length, float):
            length = self.length
        else:
            length = sum(number * values[name] for name, number in self.length.items())
        if not SMALLEST <= length <= LARGEST:
            what = f"the length between {' and '.join(map(quoted, self.frames))}"
            raise ArgumentError(f"{what} must be {SMALLEST:g} to {LARGEST:g} m, got {length:g} m")
        return length


class JointLoop(Table, frozen=True, tag_field="kind", tag="joint"):
    """Two joints are geared: η = q_second − ratio·q_first − offset, rad or m, 1 row.

    Parameters
    ----------
    joints : tuple of str
        The first drives, the second follows; each has one degree of freedom.
    ratio : float
        Of the second joint's rate to the first's; rad or m of the one per rad or m of the other.
    offset : float
        The second joint's value where the first is at 0.
    """

    joints: tuple[Name, Name]
    ratio: float = 1.0
    offset: float = 0.0

    def __post_init__(self) -> None:
        super().__post_init__()
        _refuse_other_than_names("joints", self.joints)
        _refuse_equal("joints", self.joints)
        for key in ("ratio", "offset"):
            force_setattr(self, key, as_number(getattr(self, key), f"`{key}`"))
        if 0.0 < abs(self.ratio) < SMALLEST:
            limit = f"of magnitude {SMALLEST:g} to {LARGEST:g}, or 0"
            raise ArgumentError(f"`ratio` is a number {limit}; got {self.ratio:g}")

    @property
    def ends(self) -> tuple[str, str]:
        """The names of what the loop joins."""
        return self.joints


Loop = LoopBetweenFrames | JointLoop
#: The kinds that a model file may name; `register` adds to them.
LOOP_KINDS: dict[str, type[Loop]] = {}


def register(kind: type[Loop]) -> None:
    """Let model files name a kind of loop, by its tag."""
    LOOP_KINDS[str(kind.__struct_config__.tag)] = kind


for _kind in (
    PointLoop,
    SphericalLoop,
    FrameLoop,
    RevoluteLoop,
    PrismaticLoop,
    CylindricalLoop,
    PlanarLoop,
    UniversalLoop,
    DistanceLoop,
    JointLoop,
):
    register(_kind)


def _refuse_equal(what: str, names: tuple[str, str]) -> None:
    if names[0] == names[1]:
        raise ArgumentError(f"a loop joins two different {what}, got {quoted(names[0])} twice")


def _refuse_other_than_names(what: str, names: object) -> None:
    pair = isinstance(names, tuple | list) and len(names) == 2
    if not pair or not all(isinstance(name, str) for name in names):  # type: ignore[attr-defined]
        raise ArgumentError(f"a loop names two {what}, got {quoted(names)}")


def _unit(key: str, vector: Vector) -> Vector:
    array = as_numbers(vector, f"`{key}`")
    if array.shape != (3,):
        raise ArgumentError(f"`{key}` has three components, got {quoted(vector)}")
    x, y, z = array.tolist()
    if (length := math.hypot(x, y, z)) < _SHORTEST_AXIS:
        raise ArgumentError(f"`{key}` needs a direction, got {[x, y, z]}")
    return (x / length, y / length, z / length)
