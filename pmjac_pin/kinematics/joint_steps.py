"""Steps q ⊕ v, the motions that lead from one q to another, and their rates, over number types.

As Pinocchio's `integrate` and `difference`: joint by joint, slides along the axes before, then a
turn. Of q and v components come first, then whatever axes; no case is decided by a number, so that
the same is a program.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Protocol

import numpy as np

from pmjac_pin.algebra.arrays import Numbers
from pmjac_pin.kinematics.tree import Link
from pmjac_pin.model.joint_kind import Waves, rotation_of

_NO_TURN = 1e-150  # rad: a turn of less is none, and yet is divided by
_TINY = 1e-30  # rad²: what (½α)² is divided by at least


class Angles(Waves, Protocol):
    """An algebra that knows lengths and angles."""

    def vanishes(self, x: Numbers) -> bool:
        """Tell whether x is zero whatever the numbers are."""
        ...

    def sqrt(self, x: Any) -> Any: ...  # noqa: D102
    def atan2(self, sine: Any, cosine: Any) -> Any: ...  # noqa: D102
    def largest(self, x: Any, y: Any) -> Any: ...  # noqa: D102
    def with_sign(self, x: Any, of: Any) -> Any: ...  # noqa: D102


class Joints(Protocol):
    """A tree, or whatever has joints."""

    @property
    def links(self) -> Mapping[int, Link]:
        """By their bodies."""
        ...


def moved_by(algebra: Angles, tree: Joints, q: Numbers, v: Numbers) -> Numbers:
    """Return q ⊕ v, shape (nq, ...)."""
    found = q.copy()
    for link in tree.links.values():
        slides, turn, way = _slides(link), q[_turn_part(link)], v[_turn_columns(link)]
        found[slides] = q[slides] + _turned_slides(link, turn, v[_slide_columns(link)])
        found[_turn_part(link)] = _turned_on(algebra, link, turn, way)
    return found


def entry_rates(tree: Joints, q: Numbers, v: Numbers) -> Numbers:
    """Return how the entries of q change along a motion v, shape (nq, ...)."""
    found = np.empty((len(q), *v.shape[1:]), dtype=np.result_type(q, v))
    for link in tree.links.values():
        turn, way = q[_turn_part(link)], v[_turn_columns(link)]
        found[_slides(link)] = _turned_slides(link, turn, v[_slide_columns(link)])
        found[_turn_part(link)] = _turn_rates(link, turn, way)
    return found


def between(algebra: Angles, tree: Joints, q: Numbers, other: Numbers) -> Numbers:
    """Return v with q ⊕ v = other, shape (nv, ...)."""
    found = np.empty((_freedoms(tree), *q.shape[1:]), dtype=q.dtype)
    for link in tree.links.values():
        slides, turn = _slides(link), q[_turn_part(link)]
        slid = other[slides] - q[slides]
        found[_slide_columns(link)] = _turned_slides(link, _back(turn), slid)
        found[_turn_columns(link)] = _turn_between(algebra, link, turn, other[_turn_part(link)])
    return found


def arriving(algebra: Angles, tree: Joints, way: Numbers, v: Numbers) -> Numbers:
    """Return the rates of `between` where the second pose moves by v, shape (nv, ...)."""
    found = v.copy()
    for link in tree.links.values():
        if link.kind.curved:
            turn, rates = way[_turn_columns(link)], v[_turn_columns(link)]
            on = _exponential(algebra, turn) if link.kind.turns == 3 else _wave(algebra, turn[0])
            found[_slide_columns(link)] = _turned_slides(link, on, v[_slide_columns(link)])
            if link.kind.turns == 3:
                found[_turn_columns(link)] = _log_rates(algebra, turn, rates)
    return found


def _freedoms(tree: Joints) -> int:
    return sum(link.kind.nv for link in tree.links.values())


def _slides(link: Link) -> slice:
    return slice(link.entries.start, link.entries.start + link.kind.slides)


def _turn_part(link: Link) -> slice:
    return slice(link.entries.start + link.kind.slides, link.entries.stop)


def _slide_columns(link: Link) -> slice:
    return slice(link.column, link.column + link.kind.slides)


def _turn_columns(link: Link) -> slice:
    return slice(link.column + link.kind.slides, link.column + link.kind.nv)


def _back(turn: Numbers) -> Numbers:
    """Return a turn's inverse, of a cosine and sine or a quaternion."""
    if len(turn) == 2:
        return _side_by_side(turn[0], -turn[1])
    return _side_by_side(*-turn[:3], turn[3]) if len(turn) == 4 else turn


def _turned_slides(link: Link, turn: Numbers, slid: Numbers) -> Numbers:
    """Return slides in the axes before as slides in those that a turn leads to."""
    if link.kind.axial or not (link.kind.slides and link.kind.turns):
        return slid
    if link.kind.turns == 3:
        x, y, z = slid
        rows = rotation_of(tuple(turn))
        return _side_by_side(*(a * x + b * y + c * z for a, b, c in rows))
    (x, y), (c, s) = slid, turn
    return _side_by_side(c * x - s * y, s * x + c * y)


def _turned_on(algebra: Angles, link: Link, turn: Numbers, way: Numbers) -> Numbers:
    if algebra.vanishes(way):
        return turn
    if link.kind.angle or not link.kind.turns:
        return turn + way
    if link.kind.turns == 3:
        return _unit(algebra, _quaternion_product(turn, _exponential(algebra, way)))
    (c, s), (cosine, sine) = turn, _wave(algebra, way[0])
    return _unit(algebra, _side_by_side(c * cosine - s * sine, s * cosine + c * sine))


def _turn_rates(link: Link, turn: Numbers, way: Numbers) -> Numbers:
    if link.kind.angle or not link.kind.turns:
        return way
    if link.kind.turns == 3:
        return np.asarray(0.5 * _quaternion_product(turn, (*way, 0.0)))
    c, s = turn
    return _side_by_side(-(s * way[0]), c * way[0])


def _turn_between(algebra: Angles, link: Link, turn: Numbers, other: Numbers) -> Numbers:
    if link.kind.angle or not link.kind.turns:
        return other - turn
    if link.kind.turns == 3:
        *vector, cosine = _quaternion_product(_back(turn), other)
        sine = _vector_length(algebra, vector)
        half = algebra.atan2(sine, abs(cosine))
        factor = 2.0 * algebra.with_sign(half, cosine) / sine
        return _side_by_side(*(x * factor for x in vector))
    (a, b), (c, s) = turn, other
    return _side_by_side(algebra.atan2(a * s - b * c, a * c + b * s))


def _exponential(algebra: Angles, vector: Numbers) -> Numbers:
    """Return the quaternion (x, y, z, w) of a rotation vector."""
    size = _vector_length(algebra, vector)
    cosine, sine = _wave(algebra, 0.5 * size)
    return _side_by_side(*(vector * (sine / size)), cosine)


def _log_rates(algebra: Angles, vector: Numbers, omega: Numbers) -> Numbers:
    """Return x' = ω + ½ x × ω + (1 − ½α cot ½α)/α² x × (x × ω), with α = |x|.

    What cancels where α is small is as small beside ω as rounding.
    """
    half = 0.5 * _vector_length(algebra, vector)
    cosine, sine = _wave(algebra, half)
    factor = (1.0 - half * cosine / sine) / (4.0 * algebra.largest(half * half, _TINY))
    once = algebra.cross(vector, omega)
    return np.asarray(omega + 0.5 * once + algebra.cross(vector, once) * factor)


def _quaternion_product(p: Any, q: Any) -> Numbers:
    (a, b, c, w), (x, y, z, v) = p, q
    return _side_by_side(
        w * x + a * v + b * z - c * y,
        w * y + b * v + c * x - a * z,
        w * z + c * v + a * y - b * x,
        w * v - a * x - b * y - c * z,
    )


def _vector_length(algebra: Angles, vector: Any) -> Any:
    """Return the length of a vector, of none a tiny one."""
    x, y, z = vector
    return algebra.largest(algebra.sqrt(x * x + y * y + z * z), _NO_TURN)


def _unit(algebra: Angles, entries: Numbers) -> Numbers:
    return np.asarray(entries / algebra.sqrt(sum(x * x for x in entries)))


def _wave(algebra: Angles, angle: Any) -> Numbers:
    return _side_by_side(algebra.cos(angle), algebra.sin(angle))


def _side_by_side(*components: Any) -> Numbers:
    """Return numbers as the components of one."""
    return np.array(components)
