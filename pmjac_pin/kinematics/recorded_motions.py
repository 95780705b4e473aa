"""q ⊕ v, what leads from one q to another, and its rates, over recorded numbers.

As `JointKind.moved`: slides, then a turn, without a case that is decided at a pose.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from pmjac_pin.algebra.arrays import Numbers
from pmjac_pin.algebra.programs import Programs, largest, objects, root, with_sign
from pmjac_pin.kinematics.tree import Link, Tree
from pmjac_pin.model.joint_kind import rotation_of

_PROGRAMS = Programs()
_NO_TURN = 1e-150  # rad: a turn of less is none, and yet is divided by
_TINY = 1e-30  # rad²: what (½α)² is divided by at least


def moved_by(tree: Tree, q: Numbers, v: Numbers) -> Numbers:
    """Return q ⊕ v, shape (nq,)."""
    found = q.copy()
    for link in tree.links.values():
        slides, turn, way = _slides(link), q[_turn_part(link)], v[_turning(link)]
        found[slides] = q[slides] + _turned_slides(link, turn, v[_sliding(link)])
        found[_turn_part(link)] = _turned_on(link, turn, way)
    return found


def recorded_entry_rates(tree: Tree, q: Numbers, v: Numbers) -> Numbers:
    """Return how the entries of q change along a motion v, shape (nq,)."""
    found = q.copy()
    for link in tree.links.values():
        turn, way = q[_turn_part(link)], v[_turning(link)]
        found[_slides(link)] = _turned_slides(link, turn, v[_sliding(link)])
        found[_turn_part(link)] = _turn_rates(link, turn, way)
    return found


def between(tree: Tree, q: Numbers, other: Numbers) -> Numbers:
    """Return v with q ⊕ v = other, shape (nv,)."""
    found = np.empty(_freedoms(tree), dtype=object)
    for link in tree.links.values():
        slides, turn = _slides(link), q[_turn_part(link)]
        found[_sliding(link)] = _turned_slides(link, _back(turn), other[slides] - q[slides])
        found[_turning(link)] = _turn_between(link, turn, other[_turn_part(link)])
    return found


def arriving(tree: Tree, way: Numbers, v: Numbers) -> Numbers:
    """Return the rates of `between` where the second pose moves by v, shape (nv,)."""
    found = v.copy()
    for link in tree.links.values():
        if link.kind.curved:
            turn, rates = way[_turning(link)], v[_turning(link)]
            on = _exponential(turn) if link.kind.turns == 3 else objects(_wave(turn[0]))
            found[_sliding(link)] = _turned_slides(link, on, v[_sliding(link)])
            if link.kind.turns == 3:
                found[_turning(link)] = _log_rates(turn, rates)
    return found


def _freedoms(tree: Tree) -> int:
    return sum(link.kind.nv for link in tree.links.values())


def _slides(link: Link) -> slice:
    return slice(link.entries.start, link.entries.start + link.kind.slides)


def _turn_part(link: Link) -> slice:
    return slice(link.entries.start + link.kind.slides, link.entries.stop)


def _sliding(link: Link) -> slice:
    return slice(link.column, link.column + link.kind.slides)


def _turning(link: Link) -> slice:
    return slice(link.column + link.kind.slides, link.column + link.kind.nv)


def _back(turn: Numbers) -> Numbers:
    """Return a turn's inverse, of a cosine and sine or a quaternion."""
    if turn.size == 2:
        return objects([turn[0], -turn[1]])
    return objects([*-turn[:3], turn[3]]) if turn.size == 4 else turn


def _turned_slides(link: Link, turn: Numbers, slid: Numbers) -> Numbers:
    """Return slides in the axes before as slides in those that a turn leads to."""
    if link.kind.axial or not (link.kind.slides and link.kind.turns):
        return slid
    if link.kind.turns == 3:
        rows = objects([0.0] * 9).reshape(3, 3)
        rows[:] = rotation_of(_PROGRAMS, turn.tolist())
        return np.asarray(rows @ slid)
    (x, y), (c, s) = slid, turn
    return objects([c * x - s * y, s * x + c * y])


def _turned_on(link: Link, turn: Numbers, way: Numbers) -> Numbers:
    if all(x == 0.0 for x in way):  # at every pose
        return turn
    if link.kind.angle or not link.kind.turns:
        return turn + way
    if link.kind.turns == 3:
        return _unit_quaternion(_quaternion_product(turn, _exponential(way)))
    (c, s), (cosine, sine) = turn, _wave(way[0])
    return _unit_quaternion(objects([c * cosine - s * sine, s * cosine + c * sine]))


def _turn_rates(link: Link, turn: Numbers, way: Numbers) -> Numbers:
    if link.kind.angle or not link.kind.turns:
        return way
    if link.kind.turns == 3:
        return np.asarray(0.5 * _quaternion_product(turn, objects([*way, 0.0])))
    c, s = turn
    return objects([-(s * way[0]), c * way[0]])


def _turn_between(link: Link, turn: Numbers, other: Numbers) -> Numbers:
    if link.kind.angle or not link.kind.turns:
        return other - turn
    if link.kind.turns == 3:
        *vector, cosine = _quaternion_product(_back(turn), other)
        sine = _vector_length(vector)
        half = _angle(sine, abs(cosine))
        factor = 2.0 * with_sign(half, cosine) / sine
        return objects([x * factor for x in vector])
    (a, b), (c, s) = turn, other
    return objects([_angle(a * s - b * c, a * c + b * s)])


def _exponential(vector: Numbers) -> Numbers:
    """Return the quaternion (x, y, z, w) of a rotation vector."""
    size = _vector_length(vector)
    cosine, sine = _wave(0.5 * size)
    return objects([*(vector * (sine / size)), cosine])


def _log_rates(vector: Numbers, omega: Numbers) -> Numbers:
    """Return x' = ω + ½ x × ω + (1 − ½α cot ½α)/α² x × (x × ω), with α = |x|.

    What cancels where α is small is as small beside ω as rounding.
    """
    half = 0.5 * _vector_length(vector)
    cosine, sine = _wave(half)
    factor = (1.0 - half * cosine / sine) / (4.0 * largest(half * half, _TINY))
    once = _PROGRAMS.cross(vector, omega)
    return np.asarray(omega + 0.5 * once + _PROGRAMS.cross(vector, once) * factor)


def _quaternion_product(p: Numbers, q: Numbers) -> Numbers:
    (a, b, c, w), (x, y, z, v) = p, q
    return objects(
        [
            w * x + a * v + b * z - c * y,
            w * y + b * v + c * x - a * z,
            w * z + c * v + a * y - b * x,
            w * v - a * x - b * y - c * z,
        ]
    )


def _vector_length(vector: Any) -> Any:
    """Return the length of a vector, of none a tiny one."""
    x, y, z = vector
    return largest(root(x * x + y * y + z * z), _NO_TURN)


def _unit_quaternion(entries: Numbers) -> Numbers:
    return np.asarray(entries / root(sum(x * x for x in entries)))


def _wave(angle: Any) -> tuple[Any, Any]:
    term = angle.recording.term
    return term("cos", angle), term("sin", angle)


def _angle(sine: Any, cosine: Any) -> Any:
    return sine.recording.term("atan2", sine, cosine)
