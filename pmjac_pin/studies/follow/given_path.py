"""From waypoints, splines and functions, as a caller gives them, to a `MotorPath`."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import pairwise
from math import factorial
from typing import Any

import numpy as np
from numpy.polynomial.chebyshev import cheb2poly, chebvander
from scipy.constants import golden

from pmjac_pin.errors import ArgumentError, quoted
from pmjac_pin.mechanism import Mechanism
from pmjac_pin.studies.follow.motor_path import MotorPath, PathPiece
from pmjac_pin.values.arrays import Array
from pmjac_pin.values.checks import LARGEST, as_numbers

_DEGREE = 7  # of the polynomials that stand for a function
_AGREES = 1e-12  # m or rad, or of its largest value: those with the function, in between
_NOISE = 2e-15  # of its largest value: rounding
_LOOKS = 256  # at a function, all over its range: a short motion between nodes is seen
_FINEST = 24  # of the range, until a function is not smooth enough
_JUMP = 1e-9  # m or rad: rounding makes smaller ones
_LARGEST_TIME = 1e9
_TOLD_APART = 1e-9  # of the parameter, ten times what events are located to
_TIME_ROUNDING = 1e-13  # of the largest one


def motor_path(mechanism: Mechanism, path: Any, times: Any = None) -> MotorPath:
    """Return the polynomials of a path of the motors.

    Parameters
    ----------
    mechanism : Mechanism
    path : array_like (N, n), table by the motors' names, scipy spline or callable t ↦ (n,)
    times : array_like, optional
        Of the waypoints, ascending; or where a spline or a function begins and ends, with what is
        between where the function has kinks.

    Raises
    ------
    ArgumentError, UnknownNameError
    """
    coordinates, motors = mechanism.coordinates, mechanism.problem.partition.actuated
    if coordinates.curved[motors].any():
        message = "a motor of several degrees of freedom turns along no path of its values"
        raise ArgumentError(f"{mechanism.name}: {message}; give it as joints of one each")

    def table(given: Any) -> Array:
        values = as_numbers(mechanism.motors.table(given), "motor values")
        wraps = coordinates.wraps[motors]
        values[:, wraps] = np.unwrap(values[:, wraps], axis=0)
        return values

    return path_of(path, times, mechanism.actuated, table)


def path_of(
    path: Any, times: Any, names: Sequence[str], table: Callable[[Any], Array]
) -> MotorPath:
    """Return the polynomials of a path of these values.

    Parameters
    ----------
    path, times
        As of `motor_path`.
    names : sequence of str
        Of the values.
    table : callable
        Waypoints as a caller gives them ↦ numbers (N, n).
    """
    ascending = None if times is None else ascending_times(times)
    if callable(path):
        pieces = _spline_pieces(path, ascending) or _by_polynomials(path, ascending, len(names))
    else:
        pieces = _straight(table(path), ascending)
    _check_pieces(pieces, names)
    return MotorPath(tuple(pieces))


def ascending_times(times: Any) -> Array:
    """Return times as a caller gives them, or raise ArgumentError where they do not ascend."""
    found = np.atleast_1d(as_numbers(times, "times", _LARGEST_TIME))
    if found.ndim != 1 or found.size < 2 or not (np.diff(found) > 0.0).all():
        raise ArgumentError(f"times are two or more numbers that ascend, got {quoted(times)}")
    _check_apart(found)
    return found


def waypoint_times(count: int, times: Array | None) -> Array:
    """Return the times of so many waypoints: 0, 1, 2, ... where a caller gives none."""
    if count < 2:
        raise ArgumentError(f"a path has two waypoints or more, got {count}")
    found = np.arange(float(count)) if times is None else times
    if len(found) != count:
        raise ArgumentError(f"{count} waypoints and {len(found)} times do not fit")
    return found


def _check_apart(times: Array) -> None:
    """Raise ArgumentError where an event between two times could not be told from them."""
    nearest = max(_TOLD_APART, _TIME_ROUNDING * float(np.abs(times).max(initial=0.0)))
    near = np.flatnonzero(np.diff(times) < nearest)
    if near.size:
        one, other = times[near[0] : near[0] + 2].tolist()
        message = f"times are {nearest:.1g} apart or more, got {one!r} and {other!r}"
        raise ArgumentError(f"{message}: leave one out, or count in a smaller unit")


def _straight(values: Array, times: Array | None) -> list[PathPiece]:
    """Return straight pieces between waypoints."""
    times = waypoint_times(len(values), times)
    slopes = np.diff(values, axis=0) / np.diff(times)[:, None]
    return [
        PathPiece(start, end, start, np.array([slope, value]))
        for start, end, slope, value in zip(
            times[:-1].tolist(), times[1:].tolist(), slopes, values[:-1], strict=True
        )
    ]


def _spline_pieces(path: Any, times: Array | None) -> list[PathPiece] | None:
    """Return the pieces of scipy's splines; None for other functions."""
    if hasattr(path, "tck") and hasattr(path, "k"):
        knots = np.unique(path.t[path.k : len(path.t) - path.k])
        powers = [path(knots[:-1], nu) / factorial(nu) for nu in range(path.k, -1, -1)]
        return _of_powers(np.array(powers), knots, times)
    if hasattr(path, "c") and hasattr(path, "x") and np.ndim(path.c) > 1:
        if len(path.c) and type(path).__name__ == "BPoly":
            return None
        return _of_powers(path.c, path.x, times)
    return None


def _of_powers(c: Any, x: Any, times: Array | None) -> list[PathPiece]:
    """Return the pieces of local powers, highest first, within the times that are given."""
    knots, powers = np.asarray(x, dtype=float), as_numbers(c, "coefficients of a spline", np.inf)
    powers = powers.reshape(*powers.shape[:2], -1)
    first, last = (knots[0], knots[-1]) if times is None else (times[0], times[-1])
    if first < knots[0] or last > knots[-1]:
        reach = f"[{knots[0]:g}, {knots[-1]:g}]"
        raise ArgumentError(f"times [{first:g}, {last:g}] are not within the spline's {reach}")
    _check_apart(np.unique([first, last, *knots[(knots > first) & (knots < last)]]))
    return [
        PathPiece(max(start, first), min(end, last), start, powers[:, k])
        for k, (start, end) in enumerate(zip(knots[:-1].tolist(), knots[1:].tolist(), strict=True))
        if start < last and end > first and start < end
    ]


def _by_polynomials(
    path: Callable[[float], Any], times: Array | None, count: int
) -> list[PathPiece]:
    """Return polynomials that agree with a function, halved until they do."""
    if times is None:
        raise ArgumentError("a path that is a function needs `times`, where it begins and ends")

    def at(t: float) -> Array:
        values = np.atleast_1d(as_numbers(path(t), f"the path at t = {t:g}"))
        if values.shape != (count,):
            raise ArgumentError(f"the path at t = {t:g} is {count} values, got {values.shape}")
        return values

    least = (times[-1] - times[0]) * 2.0**-_FINEST
    waiting = list(zip(times[:-1].tolist(), times[1:].tolist(), strict=True))[::-1]
    spread = np.sort(np.arange(1, _LOOKS + 1) * golden % 1.0)  # evenly, without a period
    looks = times[0] + (times[-1] - times[0]) * spread
    seen = np.array([at(t) for t in looks.tolist()])
    pieces: list[PathPiece] = []
    while waiting:
        start, end = waiting.pop()
        piece = _fitted_piece(at, start, end)
        within = slice(*np.searchsorted(looks, [start, end]).tolist())
        if piece is not None and _agrees(piece, looks[within], seen[within]):
            pieces.append(piece)
            continue
        middle = 0.5 * (start + end)
        if end - start < least:
            message = f"the path is not smooth near t = {middle:.9g}"
            raise ArgumentError(f"{message}: name where it has kinks in `times`")
        waiting += [(middle, end), (start, middle)]
    return pieces


def _agrees(piece: PathPiece, times: Array, seen: Array) -> bool:
    """Tell whether a piece has the values that were seen of its function."""
    off = [np.abs(piece.values(t) - one).max() for t, one in zip(times.tolist(), seen, strict=True)]
    return max(off, default=0.0) <= 2.0 * _AGREES * max(1.0, float(np.abs(seen).max(initial=0.0)))


def _fitted_piece(at: Callable[[float], Array], start: float, end: float) -> PathPiece | None:
    middle, half = 0.5 * (start + end), 0.5 * (end - start)
    angles = np.pi * np.arange(_DEGREE + 1) / _DEGREE
    nodes, between = -np.cos(angles), -np.cos(0.5 * (angles[1:] + angles[:-1]))
    values = np.array([at(middle + half * s) for s in nodes.tolist()])
    # Of Chebyshev's polynomials, what is rounding is left out: its derivatives are not small.
    shares = np.linalg.solve(chebvander(nodes, _DEGREE), values)
    shares[np.abs(shares) <= _NOISE * np.abs(values).max(axis=0)] = 0.0
    there = np.array([at(middle + half * s) for s in between.tolist()])
    off = np.abs(chebvander(between, _DEGREE) @ shares - there).max()
    if off > _AGREES * max(1.0, float(np.abs(values).max())):
        return None
    count = 1 + int(np.flatnonzero(shares.any(axis=1)).max(initial=0))
    powers = np.array([_by_powers(column, count) for column in shares.T]).T
    scale = half ** -np.arange(count - 1.0, -1.0, -1.0)
    return PathPiece(start, end, middle, powers * scale[:, None])


def _by_powers(shares: Array, count: int) -> Array:
    """Return a polynomial of so many coefficients by powers, highest first."""
    powers = cheb2poly(shares[:count])[::-1]
    return np.concatenate([np.zeros(count - len(powers)), powers])


def _largest(piece: PathPiece) -> float:
    """Return a bound of all values of a piece."""
    far = max(abs(piece.start - piece.origin), abs(piece.end - piece.origin))
    powers = far ** np.arange(len(piece.coefficients) - 1.0, -1.0, -1.0)
    with np.errstate(over="ignore", invalid="ignore"):
        return float((np.abs(piece.coefficients) * powers[:, None]).sum(axis=0).max(initial=0.0))


def _check_pieces(pieces: list[PathPiece], names: Sequence[str]) -> None:
    """Raise ArgumentError where pieces are of another number of values, or do not meet."""
    for piece in pieces:
        if piece.coefficients.shape[1] != len(names):
            got = piece.coefficients.shape[1]
            wanted = f"{len(names)} values ({', '.join(names)})"
            raise ArgumentError(f"a path of {wanted} is wanted, got one of {got} values")
        if not _largest(piece) <= LARGEST:
            where = f"between t = {piece.start:g} and {piece.end:g}"
            raise ArgumentError(f"the path's values must be {LARGEST:g} or less {where}")
    for before, after in pairwise(pieces):
        jump = np.abs(after.values(after.start) - before.values(before.end)).max(initial=0.0)
        if not jump <= _JUMP:
            raise ArgumentError(f"the path jumps by {jump:.3g} at t = {after.start:g}")
