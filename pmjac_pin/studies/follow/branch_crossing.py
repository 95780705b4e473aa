"""Going on through a pose where branches meet, along the tangent that goes on."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from pmjac_pin.closing.closed import is_invertible, is_singular
from pmjac_pin.studies.follow.bordered import SingularSpot
from pmjac_pin.studies.follow.branching import along, branch_tangents, on_next_piece, pose_ahead
from pmjac_pin.studies.follow.motor_path import PathPiece
from pmjac_pin.studies.follow.passage import Passage
from pmjac_pin.studies.follow.path_equations import PathEquations
from pmjac_pin.studies.follow.stretch import PathPose
from pmjac_pin.studies.follow.walker import CourseWalker
from pmjac_pin.values.arrays import Array

_SIZES = (1e-3, 1e-4)  # of a length: how far beyond the walk goes on
_NEARER = (1.0, 0.5, 0.25)
_QUADRATIC = 0.3  # of a distance from the tangent, that at half the way: a quarter and its rounding
_OF_ROUNDING = 1e-6  # of the way: a distance from the tangent that is rounding
_MOTORS_REST = 1e-6  # of a tangent: the parameter's share on a branch that turns back
_AT_A_BREAK = 1e-10  # of the parameter


def crossed(walker: CourseWalker, spot: SingularSpot) -> Passage | None:
    """Return the way through a branch point, None where none is told from the other branch.

    The pose beyond is on the tangent's branch: it is nearer to the tangent than a quarter of what
    the other one is away by, and poses half and a quarter as far approach it with the square of
    the distance.
    """
    piece = walker.piece
    if spot.t >= piece.end - _AT_A_BREAK * max(1.0, abs(piece.end)):  # where pieces meet
        piece = walker.course.path.pieces[walker.number + 1]
        equations = PathEquations.near(walker.course, piece, walker.pose.q, walker.pose.t)
        turned = None if equations is None else on_next_piece(spot, equations)
        if turned is None:
            return None
        spot = turned
    if not (both := branch_tangents(spot)):
        return None
    cosines = [along(spot, x, walker.pose.velocity) for x in both]
    best = int(np.argmax(cosines))
    x, other = both[best], both[1 - best]
    if x[-1] <= _MOTORS_REST:
        return None
    found = (_landed(walker, piece, spot, (x, other), size) for size in _SIZES)
    return next((passage for passage in found if passage is not None), None)


def _landed(
    walker: CourseWalker,
    piece: PathPiece,
    spot: SingularSpot,
    tangent: tuple[Array, Array],
    size: float,
) -> Passage | None:
    """Return the way to a pose so far along the first of two tangents, if it is on its branch."""
    course, (x, other) = walker.course, tangent
    problem, rate = course.problem, spot.equations.rate(spot.t, x)
    far: list[tuple[Array, float]] = []
    for part in _NEARER:
        one = pose_ahead(spot, x, other, size * part)
        if one is None or one[1] > piece.end:
            return None
        far.append(one)
    off = [course.size(problem.difference(spot.q, q) - (t - spot.t) * rate) for q, t in far]
    if not all(near <= _QUADRATIC * away + _OF_ROUNDING * size for away, near in pairwise(off)):
        return None
    (q, t), partition = far[0], problem.partition
    if (point := course.close(q, piece, t, problem.difference(spot.q, q))) is None:
        return None
    if is_singular(point, partition) or not is_invertible(point, partition):
        return None
    end = PathPose(t, point, course.velocity(point, piece, t))
    there = PathPose(spot.t, course.pose_at(spot.q), rate)
    return Passage(course, piece, walker.pose, end, there)
