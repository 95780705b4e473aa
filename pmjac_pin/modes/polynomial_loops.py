"""The loop equations as polynomials in complex unknowns, on a line of machines.

A joint that turns has its cosine and sine as unknowns, with c² + s² = 1; a ball a quaternion of
length 1; slides are unknowns themselves, in characteristic lengths. Every pose is then a product
of matrices of polynomials, and so are the rows of η. F(x, t) = η(x) + t c with a random complex c
is a line of machines whose loops are shut with offsets; at t = 0 it is the mechanism itself.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from pmjac_pin.errors import ArgumentError
from pmjac_pin.factorisation import RANK_TOLERANCE
from pmjac_pin.frames import find_frame
from pmjac_pin.linkage import Edge, edges_of
from pmjac_pin.loop_rows import Along, Distance, Gap, RightAngle, Rows, Tilt
from pmjac_pin.loop_spec import JointLoop
from pmjac_pin.loops import loop_blocks
from pmjac_pin.modes.search_problem import SearchProblem
from pmjac_pin.partition import independent_rows

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]

_UNKNOWNS = {"revolute": 2, "continuous": 2, "prismatic": 1, "spherical": 4, "planar": 4, "free": 7}
# Where a joint's unknowns of length 1 begin: cosine and sine, or a quaternion.
_UNIT = {"revolute": 0, "continuous": 0, "spherical": 0, "planar": 2, "free": 3}


@dataclass(frozen=True, slots=True, eq=False)
class _Moving:
    """A matrix (b, m, n), and its derivative (k, b, m, n) by the unknowns and t."""

    value: Complex
    rate: Complex

    def __matmul__(self, other: _Moving) -> _Moving:
        rate = self.rate @ other.value + self.value @ other.rate
        return _Moving(self.value @ other.value, rate)

    def __add__(self, other: _Moving) -> _Moving:
        return _Moving(self.value + other.value, self.rate + other.rate)

    def __sub__(self, other: _Moving) -> _Moving:
        return _Moving(self.value - other.value, self.rate - other.rate)

    @property
    def across(self) -> _Moving:
        return _Moving(self.value.swapaxes(-1, -2), self.rate.swapaxes(-1, -2))

    def times(self, constant: Array) -> _Moving:
        return _Moving(self.value @ constant, self.rate @ constant)

    def left(self, constant: Array) -> _Moving:
        return _Moving(constant @ self.value, constant @ self.rate)


@dataclass(frozen=True, slots=True, eq=False)
class _Body:
    turn: _Moving
    place: _Moving

    def at(self, placement: pin.SE3, length: float) -> _Body:
        """Return a frame of the body; places are in characteristic lengths."""
        origin = self.turn.times(placement.translation[:, None] / length)
        return _Body(self.turn.times(placement.rotation), self.place + origin)


@dataclass(frozen=True, slots=True, eq=False)
class _Loop:
    joints: tuple[int, int]
    placements: tuple[pin.SE3, pin.SE3]
    blocks: list[Rows]


class PolynomialLoops:
    """F(x, t) = 0: unit lengths and independent rows of η, in `count` unknowns x, and t.

    Parameters
    ----------
    problem : SearchProblem
        With the motors at their values.
    closed : ndarray, shape (b, nq)
        Closed poses: rows of η that are independent at the most regular of them are kept.
    rng : numpy.random.Generator
        For the direction of the line.

    Raises
    ------
    ArgumentError
        Idle motions, geared joints: what has no isolated solutions or no polynomials.
    """

    def __init__(self, problem: SearchProblem, closed: Array, rng: np.random.Generator) -> None:
        self._q, self._length = problem.base, problem.length
        self._joints = list(problem.model.joints)[1:]
        edges = edges_of(problem.model)
        self._edges = [edges[name] for name in list(problem.model.names)[1:]]
        self._unknowns: dict[str, slice] = {}
        self.count = 0
        for _, edge in problem.passive:
            size = _UNKNOWNS[edge.kind]
            self._unknowns[edge.name] = slice(self.count, self.count + size)
            self.count += size
        self._loops = list(_loops_of(problem))
        self._kept = _independent_rows(problem, closed)
        self._check(problem.model.name)
        self._offsets = rng.normal(size=self._kept.size) + 1j * rng.normal(size=self._kept.size)

    def evaluate(self, x: Complex, t: Complex) -> tuple[Complex, Complex]:
        """Return F (b, count) and its derivative by (x, t), (b, count, count + 1)."""
        bodies = self._bodies(x)
        rows = [row for loop in self._loops for row in self._rows(loop, bodies)]
        whole = np.concatenate([row.value[:, :, 0] for row in rows], axis=1)[:, self._kept]
        rates = np.concatenate([row.rate[:, :, :, 0] for row in rows], axis=2)[:, :, self._kept]
        units, unit_rates = self._unit_lengths(x)
        jacobian = np.zeros((len(x), self.count, self.count + 1), dtype=complex)
        first = units.shape[1]
        jacobian[:, :first, :-1], jacobian[:, first:, :-1] = unit_rates, rates.transpose(1, 2, 0)
        jacobian[:, first:, -1] = self._offsets
        shut = whole + t[:, None] * self._offsets
        return np.concatenate([units, shut], axis=1), jacobian

    def unknowns(self, q: Array) -> Complex:
        """Return x of real poses, rows of q."""
        x = np.zeros((len(q), self.count), dtype=complex)
        for joint, edge in zip(self._joints, self._edges, strict=True):
            if edge.name in self._unknowns:
                x[:, self._unknowns[edge.name]] = self._entries(joint, edge, q)
        return x

    def poses(self, x: Array) -> Array:
        """Return the rows of q of real solutions."""
        q = np.tile(self._q, (len(x), 1))
        for joint, edge in zip(self._joints, self._edges, strict=True):
            if edge.name in self._unknowns:
                entries = x[:, self._unknowns[edge.name]].copy()
                unit = _UNIT.get(edge.kind, 1)
                entries[:, :unit] *= self._length
                if edge.kind in _UNIT:
                    entries[:, unit:] /= np.linalg.norm(entries[:, unit:], axis=1, keepdims=True)
                if edge.kind == "revolute":
                    entries = np.arctan2(entries[:, 1:], entries[:, :1])
                q[:, joint.idx_q : joint.idx_q + joint.nq] = entries
        return q

    def twins(self, x: Complex) -> list[Complex]:
        """Return x with the signs of its quaternions turned in every combination."""
        found = [x]
        for edge in self._edges:
            columns = self._unknowns.get(edge.name)
            if columns is not None and edge.kind in ("spherical", "free"):
                turned = np.ones(self.count)
                turned[columns.start + _UNIT[edge.kind] : columns.stop] = -1.0
                found += [turned * other for other in found]
        return found

    def _check(self, name: str) -> None:
        moving = [edge for edge in self._edges if edge.name in self._unknowns]
        units = sum(edge.kind in _UNIT for edge in moving)
        if units + self._kept.size != self.count:
            why = "passive motions that idle leave no isolated solutions"
            raise ArgumentError(f"{name}: no homotopy for this mechanism: {why}")

    def _bodies(self, x: Complex) -> list[_Body]:
        size = len(x)
        still = np.zeros((self.count, size, 3, 3), dtype=complex)
        world = np.broadcast_to(np.eye(3, dtype=complex), (size, 3, 3))
        origin = _Moving(np.zeros((size, 3, 1), dtype=complex), still[..., :1])
        bodies = [_Body(_Moving(world, still), origin)]
        for joint, edge in zip(self._joints, self._edges, strict=True):
            base = bodies[edge.parent].at(edge.before, self._length)
            turn, slide = self._motion(joint, edge, x)
            moved = _Body(base.turn @ turn, base.place + base.turn @ slide)
            bodies.append(moved.at(edge.after, self._length))
        return bodies

    def _motion(self, joint: pin.JointModel, edge: Edge, x: Complex) -> tuple[_Moving, _Moving]:
        """Return a joint's rotation and translation, with their derivatives."""
        size = len(x)
        turn = np.broadcast_to(np.eye(3, dtype=complex), (size, 3, 3)).copy()
        turn_rate = np.zeros((self.count, size, 3, 3), dtype=complex)
        slide = np.zeros((size, 3, 1), dtype=complex)
        slide_rate = np.zeros((self.count, size, 3, 1), dtype=complex)
        columns = self._unknowns.get(edge.name)
        known = self._entries(joint, edge, self._q[None]).astype(complex)
        entries = np.tile(known, (size, 1)) if columns is None else x[:, columns]
        unit = _UNIT.get(edge.kind, entries.shape[1])
        axes = {"prismatic": [2], "planar": [0, 1], "free": [0, 1, 2]}.get(edge.kind, [])
        for entry, axis in enumerate(axes):
            slide[:, axis, 0] = entries[:, entry]
            if columns is not None:
                slide_rate[columns.start + entry, :, axis, 0] = 1.0
        if unit < entries.shape[1]:
            turn, rates = _rotation(entries[:, unit:])
            if columns is not None:
                turn_rate[columns.start + unit : columns.stop] = rates
        return _Moving(turn, turn_rate), _Moving(slide, slide_rate)

    def _entries(self, joint: pin.JointModel, edge: Edge, q: Array) -> Array:
        """Return a joint's unknowns (b, size) from rows of q."""
        entries = q[:, joint.idx_q : joint.idx_q + joint.nq].copy()
        if edge.kind == "revolute":
            return np.hstack([np.cos(entries), np.sin(entries)])
        entries[:, : _UNIT.get(edge.kind, 1)] /= self._length
        return entries

    def _rows(self, loop: _Loop, bodies: list[_Body]) -> Iterator[_Moving]:
        one, other = (
            bodies[joint].at(placement, self._length)
            for joint, placement in zip(loop.joints, loop.placements, strict=True)
        )
        gap, seen = one.place - other.place, other.turn.across
        for block in loop.blocks:
            match block:
                case Gap():
                    yield gap
                case Distance():
                    square = gap.across @ gap
                    rod = (block.length / self._length) ** 2
                    yield _Moving(square.value - rod, square.rate)
                case Along():
                    yield (seen @ gap).left(block.directions)
                case Tilt():
                    yield (seen @ one.turn).times(block.axis[:, None]).left(block.across)
                case RightAngle():
                    cosine = (seen @ one.turn).times(block.first[:, None])
                    yield cosine.left(block.second[None])
                case _:
                    yield _turning(one.turn @ seen)

    def _unit_lengths(self, x: Complex) -> tuple[Complex, Complex]:
        """Return c² + s² − 1 or |quaternion|² − 1 of each joint, and the derivatives by x."""
        units = [
            slice(columns.start + _UNIT[edge.kind], columns.stop)
            for edge in self._edges
            if (columns := self._unknowns.get(edge.name)) is not None and edge.kind in _UNIT
        ]
        values = np.zeros((len(x), len(units)), dtype=complex)
        rates = np.zeros((len(x), len(units), self.count), dtype=complex)
        for row, unit in enumerate(units):
            values[:, row] = (x[:, unit] ** 2).sum(axis=1) - 1.0
            rates[:, row, unit] = 2.0 * x[:, unit]
        return values, rates


def _loops_of(problem: SearchProblem) -> Iterator[_Loop]:
    for loop in problem.closures:
        if isinstance(loop, JointLoop):
            why = "geared joints are no polynomials in their cosines and sines"
            raise ArgumentError(f"{problem.model.name}: no homotopy for this mechanism: {why}")
        one, other = (find_frame(problem.model, name) for name in loop.frames)
        places = (one.placement, other.placement)
        yield _Loop((one.joint, other.joint), places, loop_blocks(loop, problem.values))


def _rotation(unit: Complex) -> tuple[Complex, Complex]:
    """Return the rotation (b, 3, 3) of (c, s) about z or of a quaternion, and its rates."""
    if unit.shape[1] == 2:
        rates = np.zeros((2, len(unit), 3, 3), dtype=complex)
        rates[0, :, [0, 1], [0, 1]] = 1.0
        rates[1, :, 0, 1], rates[1, :, 1, 0] = -1.0, 1.0
        turn = unit[:, 0, None, None] * rates[0] + unit[:, 1, None, None] * rates[1]
        turn[:, 2, 2] = 1.0
        return turn, rates
    turn = np.einsum("bi,ijmn,bj->bmn", unit, _QUATERNION, unit)
    return turn, 2.0 * np.einsum("ijmn,bj->ibmn", _QUATERNION, unit)


def _quaternion_form() -> Array:
    """Return Q (4, 4, 3, 3), symmetric in its first two, with R = Q[q, q] for q = (x, y, z, w)."""
    form = np.zeros((4, 4, 3, 3))
    for axis in range(3):
        form[axis, axis] = -np.eye(3)
        form[axis, axis, axis, axis] = 1.0
        following = (axis + 1) % 3
        form[axis, following, axis, following] = form[axis, following, following, axis] = 2.0
        form[axis, 3] = 2.0 * pin.skew(np.eye(3)[axis])
    form[3, 3] = np.eye(3)
    return 0.5 * (form + form.swapaxes(0, 1))


_QUATERNION = _quaternion_form()


def _turning(relative: _Moving) -> _Moving:
    """Return the vector of the skew part of a rotation: zero where it is none, or half a turn."""

    def vector(matrix: Complex) -> Complex:
        skew = matrix - matrix.swapaxes(-1, -2)
        return 0.5 * np.stack([skew[..., 2, 1], skew[..., 0, 2], skew[..., 1, 0]], axis=-1)

    return _Moving(vector(relative.value)[..., None], vector(relative.rate)[..., None])


def _independent_rows(problem: SearchProblem, closed: Array) -> NDArray[np.intp]:
    """Return rows of η that are independent at the closed pose where K* has most of them."""
    _, jacobian = problem.loops.evaluate(closed)
    scale = problem.column_scale[problem.columns]
    K_star = jacobian[:, :, problem.columns] * problem.row_scale[:, None] * scale
    values = np.linalg.svd(K_star, compute_uv=False)
    ranks = (values > RANK_TOLERANCE * values[:, :1]).sum(axis=1)
    best = int(np.argmax(ranks))
    return independent_rows(K_star[best], int(ranks[best]))
