"""Loci and workspaces of slices as headings, paragraphs and tables."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from pmjac_pin.studies.singularities.locus import SingularityLocus
from pmjac_pin.studies.workspaces.workspace import Workspace
from pmjac_pin.words.blocks import Block, Heading, Paragraph, Table
from pmjac_pin.words.plain import told

_SINGULARITY_TYPES = {"gain": "gain (type II)", "loss": "loss (type I)"}


def locus_blocks(locus: SingularityLocus) -> Iterator[Block]:
    """Show curves and special points of a locus, and what they rest on."""
    yield Heading(f"Singularities of {locus.at.mechanism.name}: {' and '.join(locus.plane)}")
    yield Paragraph(_slice(locus))
    rows = tuple(
        (
            str(number),
            _SINGULARITY_TYPES[curve.kind],
            str(len(curve.places)),
            "closed" if curve.is_closed else "open",
            " ".join(map(str, curve.modes)),
        )
        for number, curve in enumerate(locus.curves)
    )
    yield Table("Curves", ("", "kind", "points", "", "modes"), rows, "><><<")
    special = tuple(
        (point.mark, _SINGULARITY_TYPES[point.kind], *(f"{value:.9g}" for value in point.place))
        for point in locus.points
    )
    header = ("", "of", *_plane_labels(locus.plane, locus.units))
    yield Table("Special points", header, special, "<<>>")
    yield Paragraph(f"{locus.evidence}.")


def workspace_blocks(found: Workspace) -> Iterator[Block]:
    """Show how large a workspace is, what bounds it, and what that rests on."""
    yield Heading(f"Workspace of {found.at.mechanism.name}: {' and '.join(found.plane)}")
    yield Paragraph(f"{found.mode}. {_slice(found)}")
    unit = " ".join(found.units) if found.units[0] != found.units[1] else f"{found.units[0]}²"
    rows = [
        (f"area [{unit}]", f"{found.area:.9g}" if np.isfinite(found.area) else "not closed"),
        (f"area of cells [{unit}]", f"{found.cell_area:.4g}"),
        ("cells reached", f"{int(found.reached.sum())} of {found.reached.size}"),
    ]
    if found.measure and found.reached.any():
        values = found.values[np.isfinite(found.values)]
        rows += [(f"{found.measure}, least", f"{values.min():.4g}")]
        rows += [(f"{found.measure}, largest", f"{values.max():.4g}")]
    yield Table("Region", ("", ""), tuple(rows), "<>")
    reasons = sorted({piece.reason for piece in found.border})
    yield Paragraph(f"Bounded by: {', '.join(reasons) or 'nothing that was traced'}.")
    yield Paragraph(f"{found.evidence}.")


def locus_data(locus: SingularityLocus) -> dict[str, object]:
    """Return a locus as plain data."""
    return {
        **_slice_told(locus),
        "curves": [
            {"kind": curve.kind, "closed": curve.is_closed, **told(curve, "modes", "places")}
            for curve in locus.curves
        ],
        "points": [told(point, "mark", "kind", "place") for point in locus.points],
        "evidence": str(locus.evidence),
    }


def workspace_data(found: Workspace) -> dict[str, object]:
    """Return a workspace as plain data, without its grid."""
    return {
        **_slice_told(found),
        **told(found, "mode", "area", "cell_area"),
        "border": [told(piece, "reason", "places") for piece in found.border],
        "evidence": str(found.evidence),
    }


def _slice_told(found: SingularityLocus | Workspace) -> dict[str, object]:
    mechanism = found.at.mechanism.name
    return {"mechanism": mechanism, **told(found, "plane", "units"), "held": dict(found.held)}


def _slice(found: SingularityLocus | Workspace) -> str:
    held = ", ".join(f"{name} = {value:.6g}" for name, value in found.held.items())
    return f"Held: {held}." if held else "Nothing is held."


def _plane_labels(plane: tuple[str, str], units: tuple[str, str]) -> list[str]:
    return [f"{name} [{unit}]" for name, unit in zip(plane, units, strict=True)]
