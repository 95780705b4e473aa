"""All complex solutions at given motor values as plain data: what a homotopy tells."""

from __future__ import annotations

from collections.abc import Sequence

import msgspec

from pmjac_pin.configuration import Configuration
from pmjac_pin.studies.evidence import Evidence
from pmjac_pin.studies.homotopy.complex_modes import ComplexModes
from pmjac_pin.studies.homotopy.operation_modes import OperationModes
from pmjac_pin.studies.modes.recognition import Recognition


class SolutionsReport(msgspec.Struct, frozen=True, kw_only=True):
    """The complex solutions at given motor values: see `ComplexModes` and `OperationModes`.

    Attributes
    ----------
    count, real, certified, at_infinity, singular : int
    evidence : Evidence
        What it rests on that these are all.
    operation_modes : tuple of int
        How many of the solutions each has; empty where they were not asked for.
    operation_evidence : Evidence or None
        What that rests on.
    """

    count: int
    real: int
    certified: int
    at_infinity: int
    singular: int
    evidence: Evidence
    operation_modes: tuple[int, ...]
    operation_evidence: Evidence | None


def make_solutions_report(
    found: ComplexModes, operation_modes: OperationModes | None
) -> SolutionsReport:
    """Collect what a homotopy tells of the solutions at some motor values.

    Examples
    --------
    >>> import pmjac_pin as pj
    >>> found = pj.parameter_homotopy(pj.load("four_bar")).at([0.9])
    >>> make_solutions_report(found, None).count
    2
    """
    return SolutionsReport(
        count=found.count,
        real=len(found.real),
        certified=found.certified,
        at_infinity=found.at_infinity,
        singular=found.singular,
        evidence=found.evidence,
        operation_modes=operation_modes.sizes if operation_modes else (),
        operation_evidence=operation_modes.evidence if operation_modes else None,
    )


def operation_mode_numbers(
    modes: Sequence[Configuration], found: ComplexModes, operation_modes: OperationModes
) -> tuple[int | None, ...]:
    """Return the number of each mode's operation mode, from 1; None where it is unknown."""
    recognition, labels = Recognition(found.real), operation_modes.of(found)
    places = (recognition.index(mode) for mode in modes)
    return tuple(None if place is None else labels[place] + 1 for place in places)
