"""The mechanisms by their numbers: freedoms, motors, loops, rank and what each of them teaches."""

from __future__ import annotations

from collections.abc import Iterable

from pmjac_pin.mechanism import Mechanism
from pmjac_pin.words.blocks import Table

_HEADER = ("name", "degrees\nof\nfreedom", "motors", "loops\n(rows)", "rank", "what it is")


def catalogue_table(mechanisms: Iterable[Mechanism]) -> Table:
    """Show mechanisms, one a row: nv − rank degrees of freedom, and the rank of [K K*] at home.

    Where the rank is below the number of rows, some of the loop equations are redundant.
    """
    return Table("", _HEADER, tuple(map(_mechanism_row, mechanisms)), "<>>>><")


def poses_table(mechanisms: Iterable[Mechanism]) -> Table:
    """Show the named poses of mechanisms: what ``--from`` takes."""
    rows = tuple((mechanism.name, ", ".join(mechanism.poses)) for mechanism in mechanisms)
    return Table("", ("name", "poses"), rows, "<<")


def _mechanism_row(mechanism: Mechanism) -> tuple[str, ...]:
    loops, rows, mobility = len(mechanism.spec.loops), len(mechanism.rows), mechanism.mobility
    return (
        mechanism.name,
        "?" if mobility is None else str(mobility),
        str(len(mechanism.actuated)),
        f"{loops} ({rows})" if loops else "0",
        "?" if mobility is None else str(mechanism.nv - mobility),
        mechanism.spec.description,
    )
