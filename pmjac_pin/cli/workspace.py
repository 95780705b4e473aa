"""``pmjac workspace``."""

from __future__ import annotations

from typing import Annotated

from cyclopts import Parameter

from pmjac_pin.cli.options import Choice, NameOption, PoseOption, split_names
from pmjac_pin.cli.output import Json, Output
from pmjac_pin.cli.slices import (
    CellsOption,
    FigureOption,
    Force,
    PlaneOption,
    WindowOption,
    checked_figure,
    window_given,
)
from pmjac_pin.pictures.figures import save_figure
from pmjac_pin.pictures.paper_axes import PRINTED
from pmjac_pin.pictures.slice_figure import plot_workspace
from pmjac_pin.studies.workspaces.find_workspace import workspace
from pmjac_pin.words.blocks import Verbatim
from pmjac_pin.words.plain import to_json
from pmjac_pin.words.slice_tables import workspace_blocks, workspace_data


def workspace_command(
    mechanism: NameOption,
    /,
    *,
    plane: PlaneOption,
    measure: Annotated[
        str | None,
        Parameter(help='What colours the map, such as dexterity, "gear ratio", force or speed.'),
    ] = None,
    window: WindowOption = None,
    cells: CellsOption = 101,
    output: FigureOption = None,
    force: Force = False,
    json: Json = False,
    pose: PoseOption = PoseOption(),
    choice: Choice = Choice(),
) -> Output:
    """Find what one mode reaches in a slice, its border and its area; draw a map of it."""
    checked_figure(output, force)
    at, _ = pose.configuration(choice.load(mechanism))
    found = workspace(
        at.mechanism,
        split_names(plane),
        mode=at,
        measure=measure,
        window=window_given(window),
        cells=cells,
        limits=at.mechanism.spec.enforce_limits,
    )
    if output is not None:
        save_figure(plot_workspace(found), output, dpi=PRINTED)
    if json:
        return f"{to_json(workspace_data(found))}\n"
    return [*workspace_blocks(found), *([Verbatim(output)] if output else [])]
