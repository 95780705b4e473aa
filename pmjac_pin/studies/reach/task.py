"""Task: which coordinates of a tool a target tells, and which it leaves free."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Literal, assert_never

import numpy as np

from pmjac_pin.errors import ArgumentError, quoted
from pmjac_pin.model.loop_between_frames import Z, unit_vector
from pmjac_pin.model.rows import across
from pmjac_pin.model.table import Vector
from pmjac_pin.model.tool_rows import TWIST_ROWS, checked_rows
from pmjac_pin.values.arrays import Array

#: What of a tool's orientation counts: nothing, one angle, where one axis points, all of it.
Turning = Literal["free", "heading", "pointing", "orientation"]

_ALONG_AXES: tuple[Vector, ...] = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))


@dataclass(frozen=True, slots=True)
class Task:
    """What of a tool's pose counts: made by `Task.pose()`, `position`, `pointing`, `of`, ...

    Attributes
    ----------
    directions : tuple of vectors
        In the world, of length 1 and perpendicular to each other: along these the position of the
        tool's origin counts.
    turning : {"free", "heading", "pointing", "orientation"}
        What of its orientation does: nothing; the angle about `axis`, of the world, by which the
        tool's x axis is turned, seen along it; where `axis`, of the tool, points; all of it.
    axis : vector

    Examples
    --------
    >>> import pmjac_pin as pj
    >>> pj.Task.position()
    Task(3 of the position, orientation free)
    >>> pj.Task.planar().rows, pj.Task.of(["vx", "vz"]).rows, pj.Task.pointing().rows
    (3, 2, 2)
    """

    directions: tuple[Vector, ...] = _ALONG_AXES
    turning: Turning = "orientation"
    axis: Vector = Z

    @classmethod
    def pose(cls) -> Task:
        """Return the task of position and orientation: 6 rows."""
        return cls()

    @classmethod
    def position(cls) -> Task:
        """Return the task of the position alone: 3 rows."""
        return cls(_ALONG_AXES, "free")

    @classmethod
    def orientation(cls) -> Task:
        """Return the task of the orientation alone: 3 rows."""
        return cls((), "orientation")

    @classmethod
    def pointing(cls, axis: Vector = Z, *, position: bool = False) -> Task:
        """Return the task of where an axis of the tool points: 2 rows, or 5 with its position.

        Raises
        ------
        ArgumentError
            An axis without a direction.
        """
        return cls(_ALONG_AXES if position else (), "pointing", unit_vector("axis", axis))

    @classmethod
    def planar(cls, normal: Vector = Z) -> Task:
        """Return the task of a pose in a plane: position across its normal, and heading; 3 rows.

        Raises
        ------
        ArgumentError
            A normal without a direction.
        """
        axis = unit_vector("normal", normal)
        one, other = across(np.array(axis)).tolist()
        return cls((tuple(one), tuple(other)), "heading", axis)

    @classmethod
    def of(cls, rows: Iterable[str]) -> Task:
        """Return the task of some rows of the tool's twist, in the world's axes.

        Parameters
        ----------
        rows : iterable of str
            Of "vx", "vy", "vz", "wx", "wy" and "wz". Of the angular ones, all three are the
            orientation, two are where the tool's third axis points, and one is the heading about
            that axis.

        Raises
        ------
        ArgumentError
            As `checked_rows`.
        """
        names = checked_rows(rows)
        linear = tuple(_ALONG_AXES[k] for k in range(3) if TWIST_ROWS[k] in names)
        about = [k for k in range(3) if TWIST_ROWS[3 + k] in names]
        match len(about):
            case 0:
                return cls(linear, "free")
            case 1:
                return cls(linear, "heading", _ALONG_AXES[about[0]])
            case 2:
                return cls(linear, "pointing", _ALONG_AXES[3 - sum(about)])
            case _:
                return cls(linear, "orientation")

    @classmethod
    def masked(cls, mask: Sequence[bool]) -> Task:
        """Return the task of the rows of the tool's twist at which a mask is true, as of `of`.

        Parameters
        ----------
        mask : sequence of six bool
            Of vx, vy, vz, wx, wy and wz; 1 and 0 for True and False.

        Raises
        ------
        ArgumentError
            Not six of these, or all of them false.
        """
        given = tuple(mask) if isinstance(mask, Iterable) else ()
        flags = [one for one in given if isinstance(one, int | np.bool | np.integer)]
        if len(given) != len(TWIST_ROWS) or len(flags) < len(given) or not {0, 1}.issuperset(flags):
            wanted = f"a mask is six booleans, of {', '.join(TWIST_ROWS)}"
            raise ArgumentError(f"{wanted}; got {quoted(mask)}")
        if not any(flags):
            raise ArgumentError("the mask leaves nothing of the target: all of it is False")
        return cls.of(name for name, counts in zip(TWIST_ROWS, flags, strict=True) if counts)

    @property
    def rows(self) -> int:
        """How many independent numbers it is."""
        return len(self.directions) + _ROWS_OF_TURNING[self.turning]

    @property
    def linear(self) -> Array:
        """The directions, shape (k, 3)."""
        return np.array(self.directions).reshape(-1, 3)

    def angular(self, rotation: Array) -> Array:
        """Return what of an angular velocity counts where the tool is turned so, shape (a, 3).

        Parameters
        ----------
        rotation : ndarray, shape (3, 3)
            Of the tool, in the world.

        Raises
        ------
        ArgumentError
            The tool's x axis is along the axis of a heading, which is none there.
        """
        match self.turning:
            case "free":
                return np.zeros((0, 3))
            case "heading":
                return heading_rate(rotation, np.array(self.axis))[None]
            case "pointing":
                pointing = rotation @ np.array(self.axis)
                return across(pointing)
            case "orientation":
                return np.eye(3)
            case _:
                assert_never(self.turning)

    def __repr__(self) -> str:
        turning = "orientation" if self.turning == "orientation" else f"orientation {self.turning}"
        return f"Task({len(self.directions)} of the position, {turning})"


_ROWS_OF_TURNING: dict[Turning, int] = {"free": 0, "heading": 1, "pointing": 2, "orientation": 3}
_NO_HEADING = 1e-6  # sine of the angle between the tool's x axis and the axis of its heading


def plane_axes(axis: Array) -> Array:
    """Return axes (3, 3), columns: where headings about a unit vector are 0 and 90°, and itself."""
    sideways = across(axis)
    return np.column_stack([*sideways, axis])


def heading(rotation: Array, axis: Array) -> float:
    """Return by how much a tool's x axis is turned about an axis, rad.

    Raises
    ------
    ArgumentError
        It is along that axis.
    """
    x, y, _ = plane_axes(axis).T @ rotation[:, 0]
    if np.hypot(x, y) < _NO_HEADING:
        raise ArgumentError("the tool's x axis is along the axis of its heading: it has none")
    return float(np.arctan2(y, x))


def heading_rate(rotation: Array, axis: Array) -> Array:
    """Return r with d(heading)/dt = r·ω, shape (3,)."""
    heading(rotation, axis)
    forward = rotation[:, 0]
    level = forward - (forward @ axis) * axis
    # ẋ = ω × x, and the heading turns by (axis × level)·ẋ / |level|².
    rate: Array = np.cross(forward, np.cross(axis, level)) / (level @ level)
    return rate
