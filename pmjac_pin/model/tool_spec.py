"""Tool: the frame whose twist is asked for, as a model file names it."""

from __future__ import annotations

from msgspec.structs import force_setattr

from pmjac_pin.errors import ArgumentError, quoted
from pmjac_pin.model.table import Name, TomlTable
from pmjac_pin.model.tool_rows import WHOLE_TWIST, WORLD_AXES, ToolRows, checked_axes, checked_rows

#: Pinocchio's name of the world's own frame, which rests: a tool there is none.
_THE_WORLD = "universe"
_NO_ROWS = ToolRows(())


class Tool(TomlTable, frozen=True, kw_only=True):
    """The tool: a frame of the URDF, or the frame that three points span.

    Three points p₁, p₂, p₃ give the origin (p₁ + p₂ + p₃)/3, x along p₂ − p₁, z along
    (p₂ − p₁) × (p₃ − p₁) and y = z × x.

    `rows` says which rows of its twist count where ranks are judged (None for all six), `axes` in
    which axes these are: see `ToolRows`.
    """

    frame: Name | None = None
    points: tuple[Name, Name, Name] | None = None
    rows: tuple[str, ...] | None = None
    axes: str = WORLD_AXES

    def __post_init__(self) -> None:
        super().__post_init__()
        if (self.frame is None) == (self.points is None):
            raise ArgumentError("a tool is either `frame = NAME` or `points = [NAME, NAME, NAME]`")
        if self.points is not None and len(set(self.points)) < 3:
            raise ArgumentError(
                f"the three points of a tool must differ, got {quoted(list(self.points))}"
            )
        if self.axes is not WORLD_AXES:
            force_setattr(self, "axes", checked_axes(self.axes))
        if self.rows is not None:
            force_setattr(self, "rows", checked_rows(self.rows))
        elif self.axes != WORLD_AXES:
            raise ArgumentError("the tool has `axes` but no `rows` that would be in these")

    @property
    def is_none(self) -> bool:
        """Whether no frame is the tool: what nobody names, or the world's."""
        return self.frame == _THE_WORLD

    @property
    def names(self) -> tuple[str, ...]:
        """The frame, or the three whose origins span the tool."""
        return (self.frame,) if self.frame else self.points or ()

    @property
    def judged(self) -> ToolRows:
        """The rows that count where ranks are judged; none without a tool."""
        if self.is_none:
            return _NO_ROWS
        return WHOLE_TWIST if self.rows is None else ToolRows(self.rows, checked_axes(self.axes))


NO_TOOL = Tool(frame=_THE_WORLD)
