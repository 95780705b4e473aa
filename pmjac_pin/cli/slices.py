"""The options of commands that look at a slice, and what they write of it."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, TypeVar

from cyclopts import Parameter

from pmjac_pin.cli.options import (
    Choice,
    Force,
    PoseOption,
    output_option,
    ranges_by_name,
    split_names,
)
from pmjac_pin.cli.output import Json, Output
from pmjac_pin.configuration import Configuration
from pmjac_pin.files.output_file import check_new
from pmjac_pin.pictures.figures import check_figure_file, save_figure
from pmjac_pin.pictures.paper_axes import PRINTED
from pmjac_pin.words.blocks import Block, Verbatim

if TYPE_CHECKING:
    from matplotlib.figure import Figure

FoundSlice = TypeVar("FoundSlice")


@Parameter(name="*")
@dataclass(frozen=True)
class Slice:
    """Through which pose, in which plane and window, and what to write of it."""

    plane: Annotated[
        str, Parameter(help="Two motors, such as theta1,theta2, or two of x, y and z of the tool.")
    ]
    window: Annotated[
        str | None,
        Parameter(help="The range of each, such as x=-1:1,y=0:2; by default its limits or reach."),
    ] = None
    output: Annotated[str | None, output_option("A figure: .pdf, .svg or .png.")] = None
    force: Force = False
    json: Json = False
    pose: PoseOption = PoseOption()
    choice: Choice = Choice()

    def at(self, mechanism: str) -> Configuration:
        """Return the pose; refuse, before anything is computed, what cannot be written."""
        if self.output is not None:
            check_figure_file(self.output)
            check_new(self.output, self.force)
        return self.pose.configuration(self.choice.load(mechanism))[0]

    @property
    def names(self) -> list[str]:
        """What spans the plane."""
        return split_names(self.plane)

    @property
    def ranges(self) -> dict[str, tuple[float, float]] | None:
        """The window by these names."""
        return None if self.window is None else ranges_by_name("--window", self.window, "x=-1:1")

    def written(
        self,
        found: FoundSlice,
        plot: Callable[[FoundSlice], Figure],
        data: Callable[[FoundSlice], Mapping[str, object]],
        blocks: Callable[[FoundSlice], Iterable[Block]],
    ) -> Output:
        """Draw what was found where that is wanted, and return it as JSON has it, or tables."""
        if self.output is not None:
            save_figure(plot(found), self.output, dpi=PRINTED)
        if self.json:
            return data(found)
        return [*blocks(found), *([Verbatim(self.output)] if self.output else [])]
