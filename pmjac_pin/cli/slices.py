"""The options of commands that look at a slice."""

from __future__ import annotations

from typing import Annotated, TypeAlias

from cyclopts import Parameter

from pmjac_pin.cli.options import ranges_by_name
from pmjac_pin.files.output_file import check_new
from pmjac_pin.pictures.figures import check_figure_file

PlaneOption: TypeAlias = Annotated[
    str, Parameter(help="Two motors, such as theta1,theta2, or two of x, y and z of the tool.")
]
WindowOption: TypeAlias = Annotated[
    str | None,
    Parameter(help="The range of each, such as x=-1:1,y=0:2; by default its limits or reach."),
]
CellsOption: TypeAlias = Annotated[int, Parameter(help="Of the grid, along each axis.")]
FigureOption: TypeAlias = Annotated[
    str | None, Parameter(name=["--output", "-o"], help="A figure: .pdf, .svg or .png.")
]
Force: TypeAlias = Annotated[bool, Parameter(help="Replace a file that exists.")]


def checked_figure(path: str | None, force: bool) -> None:
    """Refuse, before anything is computed, what cannot be written."""
    if path is not None:
        check_figure_file(path)
        check_new(path, force)


def window_given(given: str | None) -> dict[str, tuple[float, float]] | None:
    """Return the ranges that an option names."""
    return None if given is None else ranges_by_name("--window", given, "x=-1:1")
