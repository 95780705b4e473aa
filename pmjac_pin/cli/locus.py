"""``pmjac locus``."""

from __future__ import annotations

from typing import Annotated

from cyclopts import Parameter

from pmjac_pin.cli.options import NameOption, split_names
from pmjac_pin.cli.output import Output
from pmjac_pin.cli.slices import Slice
from pmjac_pin.pictures.slice_figure import plot_locus
from pmjac_pin.studies.singularities.singularity_locus import singularity_locus
from pmjac_pin.words.slice_tables import locus_blocks, locus_data


def locus_command(
    mechanism: NameOption,
    /,
    *,
    where: Slice,
    kinds: Annotated[
        str | None,
        Parameter(
            help="Which singularities: gain (type II), loss (type I); by default all it may have."
        ),
    ] = None,
    cells: Annotated[int, Parameter(help="Of the grid, along each axis.")] = 81,
) -> Output:
    """Trace the singular poses in a slice of motor space or of the tool's; draw them."""
    at = where.at(mechanism)
    found = singularity_locus(
        at.mechanism,
        where.names,
        at=at,
        window=where.ranges,
        kinds=None if kinds is None else split_names(kinds),  # type: ignore[arg-type]
        cells=cells,
    )
    return where.written(found, plot_locus, locus_data, locus_blocks)
