"""transmission_table: from the points of a map to a table whose error is bounded."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import ArrayLike

from pmjac_pin.errors import ArgumentError
from pmjac_pin.mechanism import Mechanism
from pmjac_pin.studies.evidence import Evidence
from pmjac_pin.studies.transmissions.enclosure import SheetBounds, bounds_of
from pmjac_pin.studies.transmissions.map_maker import newton_program, transmission_map
from pmjac_pin.studies.transmissions.newton_program import NewtonProgram, RatesTold
from pmjac_pin.studies.transmissions.sheet import Sheet
from pmjac_pin.studies.transmissions.transmission_map import TransmissionMap
from pmjac_pin.studies.transmissions.transmission_table import TransmissionTable
from pmjac_pin.values.arrays import Array
from pmjac_pin.values.brief import with_names
from pmjac_pin.values.checks import as_flag

_BETWEEN = (0.25, 0.5, 0.75)  # of a cell, where an error is looked for
_MARGIN = 4.0  # of an estimate
_ROUNDING = 1e-9  # rad or m


def transmission_table(
    mechanism: Mechanism,
    over: Mapping[str, ArrayLike],
    points: int = 17,
    *,
    guess: str = "home",
    enforce_limits: bool | str = "all",
    proof: bool = True,
) -> TransmissionTable:
    """Return the transmission of a mechanism over a rectangle, as a table whose error is bounded.

    Parameters
    ----------
    mechanism, over, points, guess, enforce_limits
        As of `transmission_map`. The error goes with the fourth power of the points' distance.
    proof : bool
        Bound the error by interval arithmetic: existence, regularity and rates, too, are then
        proven all over the rectangle. Where that does not reach, or is not wanted, the largest
        error at points between is taken four times: an estimate, and `evidence` says so.

    Raises
    ------
    ArgumentError
        Somewhere in the rectangle the transmission does not exist or is singular; the message
        says where, and for which rectangle it exists.
    UnknownNameError, ArgumentError, ForbiddenRatesError
        As `transmission_map`.

    Examples
    --------
    >>> import pmjac_pin as pj
    >>> table = pj.transmission_table(pj.load("four_bar"), {"phi1": (2.2, 2.4)})
    >>> table
    TransmissionTable(phi1 2.2 to 2.4; error theta1 ...: proof)
    >>> exact, ratio = table.exact([2.3])
    >>> bool(abs(table.motor_values([2.3]) - exact) < table.error)
    True
    """
    proof = as_flag(proof, "proof")
    found = transmission_map(mechanism, over, points, guess=guess, enforce_limits=enforce_limits)
    found.check_whole()
    rows = found.q.reshape(-1, found.q.shape[-1])
    program = newton_program(found.transmission, rows)
    sheet = _sheet(found, program, rows)
    bounds = bounds_of(program, sheet) if proof else None
    if bounds is None or bounds.failed:
        why = "no proof was asked for" if bounds is None else bounds.failed
        bounds, evidence = _estimated(found, program, sheet, why)
    else:
        evidence = Evidence("proof", _proven(found, bounds))
    told = (bounds.error, bounds.alone, bounds.lower, bounds.upper)
    return TransmissionTable(found, sheet, program, *told, evidence)


def _sheet(found: TransmissionMap, program: NewtonProgram, rows: Array) -> Sheet:
    """Return the polynomials of exact poses at the points of a map."""
    x = np.stack(np.meshgrid(*found.axes, indexing="ij"), axis=-1).reshape(len(rows), -1)
    q, shape = program.polished(rows, x), found.status.shape
    told = program.run(program.ways, q)
    slopes, twist = (
        told[name].reshape(*shape, *told[name].shape[1:]) for name in ("slopes", "twist")
    )
    return Sheet.of(found.axes, q.reshape(*shape, -1), slopes, twist)


def _estimated(
    found: TransmissionMap, program: NewtonProgram, sheet: Sheet, why: str
) -> tuple[SheetBounds, Evidence]:
    """Return error and bounds on R as they are seen between the points, and that they are so."""
    between = [
        (axis[:-1, None] + np.diff(axis)[:, None] * np.array(_BETWEEN)).ravel()
        for axis in sheet.axes
    ]
    x = np.stack(np.meshgrid(*between, indexing="ij"), axis=-1).reshape(-1, len(between))
    seen = sheet.at(x)
    exact = program.polished(seen, x)
    rates = program.judged(program.run(program.rates_outputs, exact))
    _check_regular(found, x, rates)
    coordinates, columns = program.mechanism.coordinates, program.followers
    motors = [coordinates.values_of(q, columns) for q in (seen, exact)]
    turns = coordinates.wraps[columns]
    off = np.abs(motors[0] - motors[1])
    off = np.where(turns, np.minimum(off, 2.0 * np.pi - off), off)
    statement = (
        f"an estimate: four times the largest error at {len(x)} points between those of the "
        f"table, and the rates at these; {why}"
    )
    error, alone = _MARGIN * off.max(axis=0), _MARGIN**2 * np.abs(seen - exact).max(axis=0)
    lower, upper = rates.ratio.min(axis=0), rates.ratio.max(axis=0)
    return SheetBounds(error, alone + _ROUNDING, lower, upper), Evidence("tolerance", statement)


def _check_regular(found: TransmissionMap, x: Array, rates: RatesTold) -> None:
    """Raise ArgumentError where the transmission is singular at, or between, some points."""
    sign = np.sign(np.linalg.det(found.ratio.reshape(-1, *rates.ratio.shape[1:])[0]))
    wrong = ~(rates.regular & rates.allowed & (np.sign(np.linalg.det(rates.ratio)) == sign))
    for row in x[wrong][:1].tolist():
        where = with_names(found.joints, row)
        raise ArgumentError(f"the transmission is singular inside {found.rectangle}, near {where}")


def _proven(found: TransmissionMap, bounds: SheetBounds) -> str:
    parts = [
        f"all over {found.rectangle} there is one pose next to the table's, and it is regular, by "
        f"interval arithmetic over {bounds.pieces} pieces"
    ]
    if bounds.one_to_one:
        parts.append("no two of them have the same motor values")
    if bounds.left_out:
        parts.append(
            f"of all rows but {bounds.left_out} that depend on the others, which they solve to "
            f"{bounds.left_out_gap:.2g}"
        )
    return "; ".join(parts)
