"""``pmjac workspace``."""

from __future__ import annotations

from typing import Annotated

from cyclopts import Parameter

from pmjac_pin.cli.options import NameOption
from pmjac_pin.cli.output import Output
from pmjac_pin.cli.slices import Slice
from pmjac_pin.pictures.slice_figure import plot_workspace
from pmjac_pin.studies.workspaces.find_workspace import workspace
from pmjac_pin.words.slice_tables import workspace_blocks, workspace_data


def workspace_command(
    mechanism: NameOption,
    /,
    *,
    where: Slice,
    measure: Annotated[
        str | None,
        Parameter(help='What colours the map, such as dexterity, "gear ratio", force or speed.'),
    ] = None,
    cells: Annotated[int, Parameter(help="Of the grid, along each axis.")] = 101,
) -> Output:
    """Find what one mode reaches in a slice, its border and its area; draw a map of it."""
    at = where.at(mechanism)
    found = workspace(
        at.mechanism,
        where.names,
        mode=at,
        measure=measure,
        window=where.ranges,
        cells=cells,
        limits=at.mechanism.spec.enforce_limits,
    )
    return where.written(found, plot_workspace, workspace_data, workspace_blocks)
