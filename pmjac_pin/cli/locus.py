"""``pmjac locus``."""

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
from pmjac_pin.pictures.slice_figure import plot_locus
from pmjac_pin.studies.singularities.singularity_locus import singularity_locus
from pmjac_pin.words.blocks import Verbatim
from pmjac_pin.words.plain import to_json
from pmjac_pin.words.slice_tables import locus_blocks, locus_data


def locus_command(
    mechanism: NameOption,
    /,
    *,
    plane: PlaneOption,
    window: WindowOption = None,
    kinds: Annotated[
        str | None,
        Parameter(
            help="Which singularities: gain (type II), loss (type I); by default all it may have."
        ),
    ] = None,
    cells: CellsOption = 81,
    output: FigureOption = None,
    force: Force = False,
    json: Json = False,
    pose: PoseOption = PoseOption(),
    choice: Choice = Choice(),
) -> Output:
    """Trace the singular poses in a slice of motor space or of the tool's; draw them."""
    checked_figure(output, force)
    at, _ = pose.configuration(choice.load(mechanism))
    found = singularity_locus(
        at.mechanism,
        split_names(plane),
        at=at,
        window=window_given(window),
        kinds=None if kinds is None else split_names(kinds),  # type: ignore[arg-type]
        cells=cells,
    )
    if output is not None:
        save_figure(plot_locus(found), output, dpi=PRINTED)
    if json:
        return f"{to_json(locus_data(found))}\n"
    return [*locus_blocks(found), *([Verbatim(output)] if output else [])]
