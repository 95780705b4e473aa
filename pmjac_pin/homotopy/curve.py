"""The curve of solutions over a line of machines, and its points in planes.

The machines p(t), γ(t) of a line and their solutions x are a curve in (x, t). A plane cuts it in
as many points as its degree; the plane t = 0 cuts out the solutions of one machine.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pmjac_pin.homotopy.machines import Line

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]
Mask = NDArray[np.bool_]

SAME = 1e-6  # relative distance of two points that are one
FAR = 1e6  # a point beyond is on its way to infinity
_FIRST_STEP, _SMALLEST_STEP = 0.1, 1e-6  # of a path
_MOST_STEPS = 500
_CORRECTIONS = 2  # of Newton, after each step
_CLOSE = 1e-4  # first correction, relative to the point: further away the step was too long
_EXACT = 1e-9


@dataclass(frozen=True, slots=True, eq=False)
class Planes:
    """a · (x, t) = b, for each point of a batch: normals (b, n) and offsets (b,)."""

    normals: Complex
    offsets: Complex

    @classmethod
    def all_at(cls, normal: Complex, offset: complex, count: int) -> Planes:
        """Return the same plane for `count` points."""
        return cls(np.tile(normal, (count, 1)), np.full(count, offset, dtype=complex))

    @classmethod
    def at_machine(cls, t: float, unknowns: int, count: int) -> Planes:
        """Return the plane of one machine of the line, for `count` points."""
        return cls.all_at(np.eye(unknowns + 1, dtype=complex)[-1], t, count)

    def __getitem__(self, index: NDArray[np.intp] | Mask) -> Planes:
        return Planes(self.normals[index], self.offsets[index])

    def __sub__(self, other: Planes) -> Planes:
        return Planes(self.normals - other.normals, self.offsets - other.offsets)

    def moved(self, share: Array, pull: Planes) -> Planes:
        """Return the planes that far along a straight line in their numbers."""
        normals = self.normals + share[:, None] * pull.normals
        return Planes(normals, self.offsets + share * pull.offsets)

    def missed(self, points: Complex) -> Complex:
        """Return a · (x, t) − b."""
        return np.asarray((self.normals * points).sum(axis=1) - self.offsets)


@dataclass(frozen=True, slots=True, eq=False)
class Curve:
    """The curve F(x, t) = 0, and the walk of its points from some planes to others."""

    line: Line

    @property
    def size(self) -> int:
        """How many coordinates a point has."""
        return self.line.count + 1

    def corrected(self, points: Complex, planes: Planes, steps: int) -> tuple[Complex, Array]:
        """Return the points after some of Newton's steps, and the relative size of the last."""
        size: Array = np.full(len(points), np.inf)
        with np.errstate(all="ignore"):
            for _ in range(steps):
                residual, jacobian = self._system(points, planes)
                step = _solved(jacobian, residual)
                points = points - step
                size = _relative(step, points)
        return points, np.where(np.isfinite(size), size, np.inf)

    def walk(self, points: Complex, start: Planes, end: Planes) -> tuple[Complex, Mask]:
        """Follow points from planes to planes; return them, and which arrived."""
        count, points, pull = len(points), points.copy(), end - start
        share, step = np.zeros(count), np.full(count, _FIRST_STEP)
        going = np.ones(count, dtype=bool)
        for _ in range(_MOST_STEPS):
            now = np.flatnonzero(going)
            if not now.size:
                break
            length = np.minimum(step[now], 1.0 - share[now])
            leg = _Stretch(start[now], pull[now], share[now], length)
            trial, good = self._stepped(points[now], leg)
            points[now[good]] = trial[good]
            share[now[good]] += length[good]
            step[now] = np.where(good, step[now] * 2.0, step[now] * 0.5)
            lost = (step < _SMALLEST_STEP) | (np.abs(points).max(axis=1) > FAR)
            going &= (share < 1.0 - 1e-14) & ~lost
        return points, share >= 1.0 - 1e-14

    def _stepped(self, points: Complex, stretch: _Stretch) -> tuple[Complex, Mask]:
        """Return the points a step further, and which of them are certainly there."""
        with np.errstate(all="ignore"):
            trial = self._predicted(points, stretch)
            return self._onto(trial, stretch.planes(1.0))

    def _predicted(self, points: Complex, stretch: _Stretch) -> Complex:
        """Return the points a step further, by Runge and Kutta's fourth-order rule."""

        def velocity(at: Complex, part: float) -> Complex:
            _, jacobian = self._system(at, stretch.planes(part))
            change = np.zeros_like(at)
            change[:, -1] = -stretch.pull.missed(at)
            return _solved(jacobian, change)

        h = stretch.length[:, None]
        one = velocity(points, 0.0)
        two = velocity(points + 0.5 * h * one, 0.5)
        three = velocity(points + 0.5 * h * two, 0.5)
        four = velocity(points + h * three, 1.0)
        return np.asarray(points + h / 6.0 * (one + 2.0 * two + 2.0 * three + four))

    def _onto(self, points: Complex, planes: Planes) -> tuple[Complex, Mask]:
        """Correct points by Newton; tell which were near and converged."""
        points, first = self.corrected(points, planes, 1)
        points, last = self.corrected(points, planes, _CORRECTIONS - 1)
        return points, (first < _CLOSE) & (last < _EXACT)

    def _system(self, points: Complex, planes: Planes) -> tuple[Complex, Complex]:
        """Return F and the plane's equation (b, n), and their derivatives (b, n, n)."""
        residual, jacobian = self.line.evaluate(points[:, :-1], points[:, -1])
        return (
            np.concatenate([residual, planes.missed(points)[:, None]], axis=1),
            np.concatenate([jacobian, planes.normals[:, None]], axis=1),
        )


@dataclass(frozen=True, slots=True, eq=False)
class _Stretch:
    """A step of each point along its path of planes."""

    start: Planes
    pull: Planes
    share: Array
    length: Array

    def planes(self, part: float) -> Planes:
        return self.start.moved(self.share + part * self.length, self.pull)


def distinct(points: Complex, known: Complex) -> Complex:
    """Return the known points and those of `points` that are not among them."""
    kept = list(known)
    for point in points:
        scale = SAME * (1.0 + np.linalg.norm(point))
        if not kept or np.linalg.norm(np.array(kept) - point, axis=1).min() > scale:
            kept.append(point)
    return np.array(kept).reshape(len(kept), points.shape[1])


def _solved(matrices: Complex, vectors: Complex) -> Complex:
    """Return A⁻¹ b for each; nothing where A is singular."""
    try:
        return np.asarray(np.linalg.solve(matrices, vectors[:, :, None])[:, :, 0])
    except np.linalg.LinAlgError:
        tame = np.where(np.isfinite(matrices), matrices, 0.0)
        return np.asarray((np.linalg.pinv(tame) @ vectors[:, :, None])[:, :, 0])


def _relative(step: Complex, points: Complex) -> Array:
    return np.asarray(np.linalg.norm(step, axis=1) / (1.0 + np.linalg.norm(points, axis=1)), float)
