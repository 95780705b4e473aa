"""The kinds of loop closure that a model file may declare, each with its equations.

p₁, p₂ are the origins of the loop's first and second frame, R₁, R₂ their axes in the world. An
`axis` has the same components in both frames: a is where the first frame carries it, b where the
second does. Residuals are first minus second, m or rad. Off closure, every rotation is measured
by its angle or chord, so that half a turn is not mistaken for none.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import ClassVar, Self

import numpy as np
from msgspec.structs import force_setattr, replace

from pmjac_pin.errors import ArgumentError, quoted
from pmjac_pin.model.joint_form import JointForm, Step, about_z, frame_along, shifted, single
from pmjac_pin.model.loop_between_frames import (
    LoopAlongAxis,
    LoopBetweenFrames,
    Opening,
    X,
    Y,
    check_pair,
    unit_vector,
)
from pmjac_pin.model.rows import Along, Distance, Gap, RightAngle, Rows, Turn
from pmjac_pin.model.table import Name, TomlTable, Vector
from pmjac_pin.values.arrays import Array
from pmjac_pin.values.checks import LARGEST, SMALLEST, as_number

#: As many as there may be degrees of freedom; the time to load grows with the cube of their rows.
MAXIMAL_LOOPS = 200


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


class RevoluteLoop(LoopAlongAxis, frozen=True, tag_field="kind", tag="revolute"):
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
        return Gap(), self.tilt

    def form(self, values: Mapping[str, float]) -> JointForm:
        """Return a hinge."""
        return single("revolute", frame_along(np.array(self.axis)))


class PrismaticLoop(LoopAlongAxis, frozen=True, tag_field="kind", tag="prismatic"):
    """A slider: η = (tₖ·(p₁ − p₂), log R₁R₂ᵀ in world axes), 2 + 3 rows."""

    opening: ClassVar[Opening] = "along"

    def rows(self, values: Mapping[str, float]) -> tuple[Rows, ...]:
        """Return the gap across the axis, and the turn."""
        return self.aside, Turn()

    def form(self, values: Mapping[str, float]) -> JointForm:
        """Return a slider."""
        return single("prismatic", frame_along(np.array(self.axis)))


class CylindricalLoop(LoopAlongAxis, frozen=True, tag_field="kind", tag="cylindrical"):
    """A turning slider: η = (tₖ·(p₁ − p₂), tilt of a against b), 4 rows."""

    opening: ClassVar[Opening] = "along"

    def rows(self, values: Mapping[str, float]) -> tuple[Rows, ...]:
        """Return the gap across the axis, and the tilt."""
        return self.aside, self.tilt

    def form(self, values: Mapping[str, float]) -> JointForm:
        """Return a turn about the axis, and a slide along it."""
        along = frame_along(np.array(self.axis))
        back = along.T
        turn, slide = (
            Step("turn", "continuous", along, np.eye(4)),
            Step("slide", "prismatic", np.eye(4), back),
        )
        return JointForm((turn, slide), lambda seen: along @ about_z((back @ seen @ along)[:3, 0]))


class PlanarLoop(LoopAlongAxis, frozen=True, tag_field="kind", tag="planar"):
    """A plane on a plane with normal `axis`: η = (b·(p₁ − p₂), tilt of a against b), 3 rows."""

    opening: ClassVar[Opening] = "across"

    def rows(self, values: Mapping[str, float]) -> tuple[Rows, ...]:
        """Return the height, and the tilt."""
        return Along(np.array([self.axis]), ("height",)), self.tilt

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
        force_setattr(self, "axes", (unit_vector("axes", first), unit_vector("axes", second)))

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

    @property
    def parameter_names(self) -> frozenset[str]:
        """Those that the length is a sum of."""
        return frozenset() if isinstance(self.length, float) else frozenset(self.length)

    def resolved(self, values: Mapping[str, float]) -> Self:
        """Return the rod with its length, a number."""
        return replace(self, length=self.resolved_length(values))

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
            length = sum((number * values[name] for name, number in self.length.items()), 0.0)
        if isinstance(length, float) and not SMALLEST <= length <= LARGEST:
            what = f"the length between {' and '.join(map(quoted, self.frames))}"
            raise ArgumentError(f"{what} must be {SMALLEST:g} to {LARGEST:g} m, got {length:g} m")
        return length


class JointLoop(TomlTable, frozen=True, tag_field="kind", tag="joint"):
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
        check_pair("joints", self.joints)
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


def resolved_loop(loop: Loop, values: Mapping[str, float]) -> Loop:
    """Return a loop with numbers in the place of its parameters."""
    return loop if isinstance(loop, JointLoop) else loop.resolved(values)


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
