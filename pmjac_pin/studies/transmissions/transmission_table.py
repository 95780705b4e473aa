"""TransmissionTable: a transmission over a rectangle by interpolation, its error bounded."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from pmjac_pin.errors import ArgumentError
from pmjac_pin.mechanism import Mechanism
from pmjac_pin.studies.evidence import Evidence
from pmjac_pin.studies.transmissions.enclosure import Enclosure, enclose
from pmjac_pin.studies.transmissions.newton_program import NewtonProgram, RatesTold
from pmjac_pin.studies.transmissions.rectangle import Rectangle
from pmjac_pin.studies.transmissions.sheet import Sheet
from pmjac_pin.studies.transmissions.transmission import Transmission
from pmjac_pin.studies.transmissions.transmission_map import (
    TransmissionMap,
    newton_program,
    transmission_map,
)
from pmjac_pin.values.arrays import Array, ReadOnlyArrays
from pmjac_pin.values.checks import as_flag, as_numbers

_STEPS = 4  # of Newton's, from what is near: each doubles the digits
_ENDED = 1e-9  # rad: the next step is rounding
_BETWEEN = (0.25, 0.5, 0.75)  # of a cell, where an error is looked for
_MARGIN = 2.0  # of an estimate


@dataclass(frozen=True, eq=False, repr=False)
class TransmissionTable(ReadOnlyArrays):
    """A transmission over a rectangle of joint values.

    Made by `pmjac_pin.transmission_table`. The closed pose is interpolated between the points of
    a grid by polynomials that are cubic in each joint, of exact values and derivatives there.

    Attributes
    ----------
    map : TransmissionMap
        The points.
    sheet : Sheet
        The polynomials, of the entries of q.
    program : NewtonProgram
        What leads from them to the exact pose.
    error : ndarray, shape (n,)
        How far each motor's interpolated value is from the exact one at most, m or rad; rounding,
        of some 1e-15, comes on top.
    lower, upper : ndarray, shape (n, n)
        Between which R is, all over the rectangle.
    evidence : Evidence
        Whether that is proven, or an estimate.
    """

    map: TransmissionMap
    sheet: Sheet
    program: NewtonProgram
    error: Array
    lower: Array
    upper: Array
    evidence: Evidence

    @property
    def transmission(self) -> Transmission:
        """Motors and joints."""
        return self.map.transmission

    @property
    def joints(self) -> tuple[str, ...]:
        """Names of the n joints."""
        return self.transmission.joints

    @property
    def motors(self) -> tuple[str, ...]:
        """Names of the n motors."""
        return self.transmission.motors

    @property
    def rectangle(self) -> Rectangle:
        """The joint values that the table is for."""
        return self.map.rectangle

    def motor_values(self, joints: ArrayLike) -> Array:
        """Return θ by interpolation, shape (..., n), as near the exact values as `error` says.

        Parameters
        ----------
        joints : array_like, shape (..., n)
            x, m or rad.

        Raises
        ------
        ArgumentError
            Values outside the rectangle.
        """
        rows, shape = self._rows(joints)
        return self._motors(self.sheet.at(rows)).reshape(shape)

    def exact(self, joints: ArrayLike) -> tuple[Array, Array]:
        """Return θ (..., n) and R (..., n, n), by Newton's steps from the interpolated pose.

        Raises
        ------
        ArgumentError
            Values outside the rectangle.
        """
        rows, shape = self._rows(joints)
        q = polished(self.program, self.sheet.at(rows))
        ratio = self.program.run({"ratio": self.program.step["ratio"]}, q)["ratio"]
        return self._motors(q).reshape(shape), ratio.reshape(*shape, shape[-1])

    def _motors(self, q: Array) -> Array:
        coordinates = self.transmission.by_motors.coordinates
        return coordinates.values_of(q, self.program.followers)

    def _rows(self, joints: ArrayLike) -> tuple[Array, tuple[int, ...]]:
        values, n = as_numbers(joints, "joint values"), len(self.joints)
        if not values.ndim or values.shape[-1] != n:
            raise ArgumentError(f"joint values of shape (..., {n}) expected, got {values.shape}")
        rows, (lower, upper) = values.reshape(-1, n), (self.rectangle.lower, self.rectangle.upper)
        outside = np.flatnonzero(((rows < lower) | (rows > upper)).any(axis=1))
        if outside.size:
            given = zip(self.joints, rows[outside[0]].tolist(), strict=True)
            where = ", ".join(f"{name}={value:.6g}" for name, value in given)
            raise ArgumentError(f"{where} is outside the table, which is for {self.rectangle}")
        return rows, values.shape

    def __repr__(self) -> str:
        error = ", ".join(
            f"{name} {value:.2g}"
            for name, value in zip(self.motors, self.error.tolist(), strict=True)
        )
        return f"TransmissionTable({self.rectangle}; error {error}: {self.evidence.kind})"


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
        error at points between is doubled: an estimate, and `evidence` says so.

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
    bounds = enclose(program, sheet) if proof else None
    if bounds is None or bounds.failed:
        why = "no proof was asked for" if bounds is None else bounds.failed
        error, lower, upper, evidence = _estimated(found, program, sheet, why)
    else:
        error, lower, upper = bounds.error, bounds.lower, bounds.upper
        evidence = Evidence("proof", _proven(found, bounds))
    return TransmissionTable(found, sheet, program, error, lower, upper, evidence)


def polished(program: NewtonProgram, q: Array) -> Array:
    """Return closed poses near some others, by Newton's steps.

    Raises
    ------
    ArgumentError
        The steps do not end.
    """
    outputs = {name: program.step[name] for name in ("next", "size")}
    for _ in range(_STEPS):
        told = program.run(outputs, q)
        q = told["next"]
    if not (told["size"] < _ENDED).all():
        raise ArgumentError("Newton's steps from the table do not end: take more `points`")
    return q


def _sheet(found: TransmissionMap, program: NewtonProgram, rows: Array) -> Sheet:
    """Return the polynomials of exact poses at the points of a map."""
    q, shape = polished(program, rows), found.status.shape
    told = program.run(program.ways, q)
    slopes, twist = (
        told[name].reshape(*shape, *told[name].shape[1:]) for name in ("slopes", "twist")
    )
    return Sheet.of(found.axes, q.reshape(*shape, -1), slopes, twist)


def _estimated(
    found: TransmissionMap, program: NewtonProgram, sheet: Sheet, why: str
) -> tuple[Array, Array, Array, Evidence]:
    """Return error and bounds on R as they are seen between the points."""
    between = [
        (axis[:-1, None] + np.diff(axis)[:, None] * np.array(_BETWEEN)).ravel()
        for axis in sheet.axes
    ]
    x = np.stack(np.meshgrid(*between, indexing="ij"), axis=-1).reshape(-1, len(between))
    seen = sheet.at(x)
    exact = polished(program, seen)
    rates = program.judged(program.run(program.rates_outputs, exact))
    _check_regular(found, x, rates)
    coordinates, columns = program.mechanism.coordinates, program.followers
    motors = [coordinates.values_of(q, columns) for q in (seen, exact)]
    turns = coordinates.wraps[columns]
    off = np.abs(motors[0] - motors[1])
    off = np.where(turns, np.minimum(off, 2.0 * np.pi - off), off)
    statement = (
        f"an estimate: twice the largest error at {len(x)} points between those of the table, and "
        f"the rates at these; {why}"
    )
    error = _MARGIN * off.max(axis=0)
    ratio, evidence = rates.ratio, Evidence("tolerance", statement)
    return error, ratio.min(axis=0), ratio.max(axis=0), evidence


def _check_regular(found: TransmissionMap, x: Array, rates: RatesTold) -> None:
    """Raise ArgumentError where the transmission is singular at, or between, some points."""
    sign = np.sign(np.linalg.det(found.ratio.reshape(-1, *rates.ratio.shape[1:])[0]))
    wrong = ~(rates.regular & rates.allowed & (np.sign(np.linalg.det(rates.ratio)) == sign))
    for row in x[wrong][:1].tolist():
        where = ", ".join(
            f"{name}={value:.6g}" for name, value in zip(found.joints, row, strict=True)
        )
        raise ArgumentError(f"the transmission is singular inside {found.rectangle}, near {where}")


def _proven(found: TransmissionMap, bounds: Enclosure) -> str:
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
