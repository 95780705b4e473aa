"""The mechanisms by their numbers: freedoms, motors, loops, rank and what each of them teaches."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

from pmjac_pin.files.catalogue_numbers import MechanismNumbers
from pmjac_pin.words.blocks import Table

if TYPE_CHECKING:
    from pmjac_pin.mechanism import Mechanism

_HEADER = ("name", "degrees\nof\nfreedom", "motors", "loops\n(rows)", "rank", "what it is")


def catalogue_table(mechanisms: Iterable[MechanismNumbers]) -> Table:
    """Show mechanisms, one a row: nv − rank degrees of freedom, and the rank of [K K*] at home.

    Where the rank is below the number of rows, some of the loop equations are redundant.
    """
    return Table("", _HEADER, tuple(map(_mechanism_row, mechanisms)), "<>>>><")


def poses_table(mechanisms: Iterable[MechanismNumbers]) -> Table:
    """Show the named poses of mechanisms: what ``--from`` takes."""
    rows = tuple((mechanism.name, ", ".join(mechanism.poses)) for mechanism in mechanisms)
    return Table("", ("name", "poses"), rows, "<<")


def numbers_of(mechanism: Mechanism) -> MechanismNumbers:
    """Return what the tables show of a mechanism."""
    return MechanismNumbers(
        name=mechanism.name,
        mobility=mechanism.mobility,
        freedoms=mechanism.nv,
        motors=len(mechanism.actuated),
        loops=len(mechanism.spec.loops),
        rows=len(mechanism.rows),
        description=mechanism.spec.description,
        poses=tuple(mechanism.poses),
    )


def _mechanism_row(mechanism: MechanismNumbers) -> tuple[str, ...]:
    loops, mobility = mechanism.loops, mechanism.mobility
    return (
        mechanism.name,
        "?" if mobility is None else str(mobility),
        str(mechanism.motors),
        f"{loops} ({mechanism.rows})" if loops else "0",
        "?" if mobility is None else str(mechanism.freedoms - mobility),
        mechanism.description,
    )
