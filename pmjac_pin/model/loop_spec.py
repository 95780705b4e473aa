"""The kinds of loop closure that a model file may declare, each with its equations.

p₁, p₂ are the origins of the loop's first and second frame, R₁, R₂ their axes in the world. An
`axis` has the same components in both frames: a is where the first frame carries it, b where the
second does. Residuals are first minus second, m or rad. Off closure, every rotation is measured
by its angle or chord, so that half a turn is not mistaken for none.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

from msgspec.structs import force_setattr

from pmjac_pin.errors import ArgumentError, quoted
from pmjac_pin.model.table import Name, Table, Vector
from pmjac_pin.values.checks import LARGEST, SMALLEST, as_number, as_numbers

X: Vector = (1.0, 0.0, 0.0)
Y: Vector = (0.0, 1.0, 0.0)
Z: Vector = (0.0, 0.0, 1.0)
_SHORTEST_AXIS = 1e-6

#: As many as there may be degrees of freedom; the time to load grows with the cube of their rows.
MAXIMAL_LOOPS = 200


class _FramePair(Table, frozen=True):
    """A loop between two frames of the tree."""

    frames: tuple[Name, Name]

    def __post_init__(self) -> None:
        super().__post_init__()
        _refuse_other_than_names("frames", self.frames)
        _refuse_equal("frames", self.frames)

    @property
    def ends(self) -> tuple[str, str]:
        """The names of what the loop joins."""
        return self.frames


class _AxisPair(_FramePair, frozen=True):
    """A loop between two frames with a common axis."""

    axis: Vector = Z

    def __post_init__(self) -> None:
        super().__post_init__()
        force_setattr(self, "axis", _unit("axis", self.axis))


class PointLoop(_FramePair, frozen=True, tag_field="kind", tag="point"):
    """Two points coincide: η = p₁ − p₂, world axes, 3 rows.

    Examples
    --------
    >>> import pmjac_pin as pj
    >>> pj.PointLoop(frames=("coupler_tip", "rocker_tip")).frames
    ('coupler_tip', 'rocker_tip')
    """


class SphericalLoop(_FramePair, frozen=True, tag_field="kind", tag="spherical"):
    """A ball and its socket: the equations of a point loop, η = p₁ − p₂, 3 rows."""


class FrameLoop(_FramePair, frozen=True, tag_field="kind", tag="frame"):
    """Two bodies are one: η = (p₁ − p₂, log R₁R₂ᵀ), world axes, 6 rows."""


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


class PrismaticLoop(_AxisPair, frozen=True, tag_field="kind", tag="prismatic"):
    """A slider: η = (tₖ·(p₁ − p₂), log R₁R₂ᵀ in world axes), 2 + 3 rows."""


class CylindricalLoop(_AxisPair, frozen=True, tag_field="kind", tag="cylindrical"):
    """A turning slider: η = (tₖ·(p₁ − p₂), tilt of a against b), 4 rows."""


class PlanarLoop(_AxisPair, frozen=True, tag_field="kind", tag="planar"):
    """A plane on a plane with normal `axis`: η = (b·(p₁ − p₂), tilt of a against b), 3 rows."""


class UniversalLoop(_FramePair, frozen=True, tag_field="kind", tag="universal"):
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


class DistanceLoop(_FramePair, frozen=True, tag_field="kind", tag="distance"):
    """A rod between two points: η = |p₁ − p₂|² − length², m², 1 row.

    `length` is a number in m, or a table ``{parameter = coefficient}``: the sum of the
    coefficients times the parameters' values.
    """

    length: float | dict[str, float]

    def __post_init__(self) -> None:
        if not isinstance(self.length, Mapping):
            force_setattr(self, "length", as_number(self.length, "a rod's `length`"))
        super().__post_init__()

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


LoopBetweenFrames = (
    PointLoop
    | SphericalLoop
    | FrameLoop
    | RevoluteLoop
    | PrismaticLoop
    | CylindricalLoop
    | PlanarLoop
    | UniversalLoop
    | DistanceLoop
)
Loop = LoopBetweenFrames | JointLoop
LOOP_KINDS: dict[str, type] = {kind.__struct_config__.tag: kind for kind in Loop.__args__}


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
