"""ToolRows: which rows of the tool's twist count where ranks are judged, and in which axes."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Literal

from pmjac_pin.errors import ArgumentError, did_you_mean, quoted
from pmjac_pin.values.checks import as_names

ToolAxes = Literal["LOCAL_WORLD_ALIGNED", "LOCAL"]

#: The rows of a twist in their order, linear ones first.
TWIST_ROWS = ("vx", "vy", "vz", "wx", "wy", "wz")
WORLD_AXES: ToolAxes = "LOCAL_WORLD_ALIGNED"
_TOOL_AXES: dict[str, ToolAxes] = {WORLD_AXES: WORLD_AXES, "LOCAL": "LOCAL"}
_IN_WORDS = {WORLD_AXES: "the world's axes", "LOCAL": "the tool's own axes"}
_BLOCKS = (TWIST_ROWS[:3], TWIST_ROWS[3:])


@dataclass(frozen=True, slots=True)
class ToolRows:
    """The rows of the tool's twist that are judged: what the machine is there to move.

    J_eq itself always has all six. Of a whole block, vx, vy and vz or wx, wy and wz, the rank is
    the same in all axes; of a part of one it is not.

    Attributes
    ----------
    names : tuple of str
        Of "vx", "vy", "vz", "wx", "wy" and "wz", in this order: the velocity of the tool's
        origin and the tool's angular velocity.
    axes : {"LOCAL_WORLD_ALIGNED", "LOCAL"}
        With Pinocchio's meaning: the world's axes, or the tool's own, which turn with it and
        with a base that the machine stands on.

    Examples
    --------
    >>> print(ToolRows(("vx", "vy"), "LOCAL"))
    vx, vy in the tool's own axes
    >>> print(ToolRows(("vx", "vy", "vz")), "|", ToolRows())
    vx, vy, vz | the whole twist
    >>> ToolRows(("vx", "wz")).linear, ToolRows(("vx", "wz")).angular
    ([0], [5])
    """

    names: tuple[str, ...] = TWIST_ROWS
    axes: ToolAxes = WORLD_AXES

    @property
    def linear(self) -> list[int]:
        """Which of the six rows, of the linear ones."""
        return [TWIST_ROWS.index(name) for name in self.names if name in _BLOCKS[0]]

    @property
    def angular(self) -> list[int]:
        """Which of the six rows, of the angular ones."""
        return [TWIST_ROWS.index(name) for name in self.names if name in _BLOCKS[1]]

    @property
    def is_whole(self) -> bool:
        """Whether these are all six."""
        return self.names == TWIST_ROWS

    def __str__(self) -> str:
        if self.is_whole or not self.names:
            return "the whole twist" if self.names else "no tool"
        listed = ", ".join(self.names)
        in_any_axes = all(set(block) & set(self.names) in (set(), set(block)) for block in _BLOCKS)
        return listed if in_any_axes else f"{listed} in {_IN_WORDS[self.axes]}"


#: All six rows.
WHOLE_TWIST = ToolRows()


def checked_rows(names: Iterable[str]) -> tuple[str, ...]:
    """Return names of rows in the twist's order.

    Raises
    ------
    ArgumentError
        No list of names, none in it, one that is no row, or one twice.

    Examples
    --------
    >>> checked_rows(["wz", "vx"])
    ('vx', 'wz')
    """
    given = as_names(names, f"the tool's rows are a list, of {', '.join(TWIST_ROWS)}")
    if not given:
        raise ArgumentError(f"the tool's rows are empty: name some of {', '.join(TWIST_ROWS)}")
    for name in given:
        if name not in TWIST_ROWS:
            hint = did_you_mean(name, TWIST_ROWS)
            raise ArgumentError(f"unknown row {quoted(name)} of the tool's twist{hint}")
    if len(set(given)) < len(given):
        twice = next(name for name in given if given.count(name) > 1)
        raise ArgumentError(f"the row {twice!r} is listed twice in the tool's rows")
    return tuple(name for name in TWIST_ROWS if name in given)


def checked_axes(axes: str) -> ToolAxes:
    """Return the name of the axes that rows are in.

    Raises
    ------
    ArgumentError
        Neither of the two.
    """
    if not isinstance(axes, str) or axes not in _TOOL_AXES:
        both = "LOCAL_WORLD_ALIGNED (the world's) or LOCAL (the tool's own)"
        raise ArgumentError(f"the axes of the tool's rows are {both}, got {quoted(axes)}")
    return _TOOL_AXES[axes]
