"""A singularity in tables: the ranks, what is free, lost or forbidden, and the margins."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from pmjac_pin.rates.screw import Screw
from pmjac_pin.rates.singularity import Singularity
from pmjac_pin.values.arrays import Array
from pmjac_pin.values.brief import brief
from pmjac_pin.words.blocks import Block, Table
from pmjac_pin.words.margin_tables import margin_blocks
from pmjac_pin.words.numbers import matrix_numbers
from pmjac_pin.words.rates_report import by_name

_STILL = 1e-10  # of a motion's largest rate: motions come of differences between poses


def singularity_blocks(found: Singularity, *, length: float | None = None) -> Iterator[Block]:
    """Show the ranks, and the motions that are free or forbidden.

    Parameters
    ----------
    found : Singularity
    length : float, optional
        What a radian counts as, m, where that is known.
    """
    counts = () if length is None else (("a radian counts as", f"{brief(length)} m"),)
    yield Table("", ("", ""), (*_ranks(found), *counts), "<<")
    if free := by_name(found.passive_names, found.free_motions):
        heading = "Passive motions that come free here with all motors locked (largest rate 1)"
        yield _motions_table(heading, list(map(_largest_rate_one, free)), found.passive_units)
    if idle := by_name(found.passive_names, found.idle_motions):
        heading = "Idle passive motions, free at every pose (largest rate 1)"
        yield _motions_table(heading, list(map(_largest_rate_one, idle)), found.passive_units)
    yield from _screws_table(
        "What the tool can do with all motors locked", found.free_screws, "m/rad"
    )
    yield from _screws_table(
        "Wrenches on the tool that only here need no motor", found.lost_screws, "m"
    )
    yield from margin_blocks(found.margins)
    if forbidden := by_name(found.actuated_names, found.forbidden_rates):
        yield _motions_table("Motor rates that the loops forbid", forbidden, found.actuated_units)


def _ranks(found: Singularity) -> Iterator[tuple[str, str]]:
    yield "kind", found.kind
    yield "types", found.in_words
    yield "rank of K*", f"{found.rank} of {found.generic_rank}"
    yield "rank of [K K*]", f"{found.constraint_rank} of {found.generic_constraint_rank}"
    more = found.tool_rank > found.generic_tool_rank
    rank = f"{found.tool_rank}, more than the" if more else f"{found.tool_rank} of"
    yield "tool motions", f"{rank} {found.generic_tool_rank}"
    yield "judged on", str(found.tool_rows)
    yield "idle passive motions", str(found.idle)
    yield "motions gained here", str(found.gained)
    yield "motions lost here", str(found.lost)
    if found.generic_rank:
        yield "smallest σ of K* relative to [K K*]", brief(found.smallest)
    yield "counts as zero up to", brief(found.tolerance)


def _screws_table(heading: str, screws: Sequence[Screw], unit: str) -> Iterator[Table]:
    """Show screws, one a row; a pitch that is infinite is a translation, or a moment alone."""
    if screws:
        rows = tuple(
            (
                str(number),
                *_coordinates(screw.direction),
                *_coordinates(screw.point),
                _pitch_in_words(screw),
            )
            for number, screw in enumerate(screws, start=1)
        )
        columns = ("", "x", "y", "z", "px [m]", "py [m]", "pz [m]", f"pitch [{unit}]")
        yield Table(heading + ": directions and points of axes", columns, rows, "<" + ">" * 7)


def _coordinates(vector: Array) -> tuple[str, ...]:
    return tuple(brief(x if abs(x) > _STILL else 0.0) for x in vector.tolist())


def _pitch_in_words(screw: Screw) -> str:
    return "infinite" if np.isinf(screw.pitch) else brief(screw.pitch)


def _largest_rate_one(rates: Mapping[str, float]) -> dict[str, float]:
    largest = max(rates.values(), key=abs)
    shares = {name: rate / largest for name, rate in rates.items()}
    return {name: share if abs(share) > _STILL else 0.0 for name, share in shares.items()}


def _motions_table(
    heading: str, motions: Sequence[Mapping[str, float]], units: Sequence[str]
) -> Table:
    """Show motions side by side, one joint a row; matrices from elsewhere have no units."""
    names = tuple(motions[0])
    in_units = [f"{name} [{unit}/s]" for name, unit in zip(names, units, strict=False)]
    rates = matrix_numbers([[motion[name] for motion in motions] for name in names])
    return Table(
        heading,
        ("", *(str(k) for k in range(1, len(motions) + 1))),
        tuple((label, *row) for label, row in zip(in_units or names, rates, strict=True)),
        "<" + ">" * len(motions),
    )
