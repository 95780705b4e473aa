"""transmission_map: the loops followed to all points of a rectangle, and measured there."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import ArrayLike

from pmjac_pin.batches.batch import batch
from pmjac_pin.batches.results import Status, Statuses
from pmjac_pin.errors import ArgumentError, SingularError, quoted
from pmjac_pin.mechanism import Mechanism
from pmjac_pin.studies.transmissions.newton_program import NewtonProgram
from pmjac_pin.studies.transmissions.rectangle import Rectangle
from pmjac_pin.studies.transmissions.transmission import Transmission, transmission
from pmjac_pin.studies.transmissions.transmission_map import TransmissionMap
from pmjac_pin.values.arrays import Array

_FEWEST, _MOST_POINTS = 2, {1: 1000, 2: 200}  # along each joint, of one or two
_TRIED = 9  # poses, until one is regular


def transmission_map(
    mechanism: Mechanism,
    over: Mapping[str, ArrayLike],
    points: int = 17,
    *,
    guess: str = "home",
    enforce_limits: bool | str = "all",
) -> TransmissionMap:
    """Return the transmission of a mechanism at points of a rectangle of joint values.

    Parameters
    ----------
    mechanism : Mechanism
    over : mapping of str to (float, float)
        Where each of the joints begins and ends, m or rad: one joint or two, as many as there are
        motors.
    points : int
        How many along each.
    guess : str
        The pose from which the loops are followed, from point to point.
    enforce_limits : bool or "all"
        As for `Mechanism.close`: by default no motor and no other joint is beyond its limits.

    Raises
    ------
    UnknownNameError, ArgumentError
        No such joints, or not so many; no rectangle; joints that leave motors undetermined.
    ForbiddenRatesError
        The loops forbid some rates of these joints everywhere.

    Examples
    --------
    >>> import pmjac_pin as pj
    >>> found = pj.transmission_map(pj.load("four_bar"), {"phi1": (2.1, 2.5)}, points=5)
    >>> found
    TransmissionMap(Transmission(theta1 ↔ phi1) over phi1 2.1 to 2.5: exists at 5 of 5 points)
    >>> found.ratio.shape, found.efforts_alone([1.0]).shape
    ((5, 1, 1), (5, 1))
    """
    rectangle = Rectangle.of(over)
    known = transmission(mechanism, rectangle.joints)
    axes = rectangle.axes(_count(points, len(rectangle.joints)))
    grid = batch(known.by_joints).grid(
        dict(zip(rectangle.joints, axes, strict=True)), guess, enforce_limits=enforce_limits
    )
    shape, rows = grid.status.shape, grid.q.reshape(-1, grid.q.shape[-1])
    status = grid.status.flatten()
    measured = _measured(known, rows, status)
    motors, ratio, condition, loops = (x.reshape(*shape, *x.shape[1:]) for x in measured)
    return TransmissionMap(
        transmission=known,
        rectangle=rectangle,
        axes=axes,
        q=grid.q,
        status=status.reshape(shape),
        motors=motors,
        ratio=ratio,
        condition=condition,
        loops_condition=loops,
    )


def newton_program(known: Transmission, rows: Array) -> NewtonProgram:
    """Return what is recorded of the joints that drive, at the first regular one of some poses.

    Raises
    ------
    SingularError, ForbiddenRatesError, ArgumentError
        None is regular; the loops forbid rates of the joints; a motor idles.
    """
    driven = known.by_joints
    tried = rows[np.linspace(0, len(rows) - 1, min(len(rows), _TRIED)).round().astype(int)]
    for q in tried:
        try:
            _ = known.at(driven.configuration(q)).ratio
        except SingularError:
            if q is tried[-1]:
                raise
        else:
            break
    return NewtonProgram(driven, known.by_motors.problem.partition.actuated, q)


def _measured(
    known: Transmission, rows: Array, status: Statuses
) -> tuple[Array, Array, Array, Array]:
    """Return motors, ratio and both conditions of closed rows; tell what is singular."""
    n, closed = len(known.joints), np.flatnonzero(status == Status.CLOSED)
    motors, ratio = np.full((len(rows), n), np.nan), np.full((len(rows), n, n), np.nan)
    condition, loops = np.full((2, len(rows)), np.nan)
    if closed.size:
        program = newton_program(known, rows[closed])
        told = program.judged(program.run(program.rates_outputs, rows[closed]))
        motors[closed] = known.by_motors.coordinates.values_of(rows[closed], program.followers)
        ratio[closed], condition[closed] = told.ratio, told.condition
        loops[closed] = told.loops_condition
        status[closed[~told.allowed]] = Status.NO_JACOBIAN
        status[closed[~told.regular]] = Status.SINGULAR
    gone = status != Status.CLOSED
    motors[gone], ratio[gone] = np.nan, np.nan
    return motors, ratio, condition, loops


def _count(points: object, joints: int) -> int:
    if isinstance(points, bool) or not isinstance(points, int | np.integer):
        raise ArgumentError(f"`points` is a number, 2 or more, got {quoted(points)}")
    most = _MOST_POINTS[joints]
    if not _FEWEST <= points <= most:
        raise ArgumentError(f"`points` is {_FEWEST} to {most} along each joint, got {points}")
    return int(points)
