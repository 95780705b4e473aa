"""Homotopy: all complex solutions, by monodromy on a curve of machines and a trace test.

The machines of `polynomial_loops` and their solutions make a curve in (x, t). A random plane
cuts it in as many points as its degree. Moved round closed paths of planes, the known points
change places with others (monodromy); the sum of all of them, and of no smaller part, moves
along a straight line when the plane is shifted parallel to itself (trace test). The plane t = 0
at last cuts out the solutions of the mechanism itself.

References
----------
.. [1] A. J. Sommese, J. Verschelde, C. W. Wampler: Symmetric functions applied to decomposing
   solution sets of polynomial systems. SIAM J. Numer. Anal. 40 (2002).
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pmjac_pin.direct_kinematics import motor_values
from pmjac_pin.modes.polynomial_loops import PolynomialLoops
from pmjac_pin.modes.search_problem import search_problem

if TYPE_CHECKING:
    from pmjac_pin.mechanism import Mechanism

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]
Mask = NDArray[np.bool_]

_SAME = 1e-6  # relative distance of two points that are one
_FIRST_STEP, _SMALLEST_STEP = 0.1, 1e-6  # of a path
_MOST_STEPS = 500
_CORRECTIONS = 3  # of Newton, after each step
_CLOSE = 1e-4  # first correction, relative to the point: further away the step was too long
_EXACT = 1e-9
_FAR = 1e6  # a point beyond is on its way to infinity
_REAL = 1e-7  # imaginary part of a solution that is real
_STRAIGHT = 1e-8  # what is left of the trace's bend, relative to its terms


@dataclass(frozen=True, slots=True, eq=False)
class Plane:
    """a · (x, t) = b."""

    normal: Complex
    offset: complex

    @classmethod
    def random(cls, size: int, rng: np.random.Generator) -> Plane:
        """Return a plane with standard normal complex numbers."""
        normal, offset = (rng.normal(size=k) + 1j * rng.normal(size=k) for k in (size, 1))
        return cls(normal, complex(offset[0]))

    def shifted(self, share: float) -> Plane:
        """Return a parallel plane."""
        return Plane(self.normal, self.offset + share)


@dataclass(frozen=True, slots=True, eq=False)
class _Path:
    """From one plane to another, along a straight line in their numbers."""

    start: Plane
    end: Plane

    @property
    def bend(self) -> Complex:
        return self.end.normal - self.start.normal

    @property
    def pull(self) -> complex:
        return self.end.offset - self.start.offset

    def plane(self, share: Array) -> tuple[Complex, Complex]:
        """Return normals (b, n) and offsets (b,) at these shares of the path."""
        normals = self.start.normal + share[:, None] * self.bend
        return normals, np.asarray(self.start.offset + share * self.pull, dtype=complex)


@dataclass(frozen=True, slots=True, eq=False)
class Curve:
    """The curve F(x, t) = 0, and the walk of its points from one plane to another."""

    loops: PolynomialLoops

    def corrected(self, points: Complex, plane: Plane, steps: int) -> tuple[Complex, Array]:
        """Return the points after some of Newton's steps, and the relative size of the last."""
        size: Array = np.full(len(points), np.inf)
        for _ in range(steps):
            residual, jacobian = self._system(points, *_flat(plane, len(points)))
            step = _solved(jacobian, residual)
            points = points - step
            size = _relative(step, points)
        return points, size

    def walk(self, points: Complex, start: Plane, end: Plane) -> tuple[Complex, Mask]:
        """Follow points from one plane to another; return them, and which arrived."""
        count = len(points)
        share, step = np.zeros(count), np.full(count, _FIRST_STEP)
        going = np.ones(count, dtype=bool)
        path = _Path(start, end)
        points = points.copy()
        for _ in range(_MOST_STEPS):
            now = np.flatnonzero(going)
            if not now.size:
                break
            length = np.minimum(step[now], 1.0 - share[now])
            trial = self._predicted(points[now], path, share[now], length)
            trial, good = self._on_plane(trial, *path.plane(share[now] + length))
            points[now[good]] = trial[good]
            share[now[good]] += length[good]
            step[now] = np.where(good, step[now] * 2.0, step[now] * 0.5)
            lost = (step < _SMALLEST_STEP) | (np.abs(points).max(axis=1) > _FAR)
            going &= (share < 1.0 - 1e-14) & ~lost
        return points, share >= 1.0 - 1e-14

    def _predicted(self, points: Complex, path: _Path, share: Array, length: Array) -> Complex:
        """Return the points a step further, by Runge and Kutta's fourth-order rule."""

        def velocity(at: Complex, ahead: Array) -> Complex:
            _, jacobian = self._system(at, *path.plane(ahead))
            change = np.zeros_like(at)
            change[:, -1] = path.pull - at @ path.bend
            return _solved(jacobian, change)

        h = length[:, None]
        one = velocity(points, share)
        two = velocity(points + 0.5 * h * one, share + 0.5 * length)
        three = velocity(points + 0.5 * h * two, share + 0.5 * length)
        four = velocity(points + h * three, share + length)
        return np.asarray(points + h / 6.0 * (one + 2.0 * two + 2.0 * three + four))

    def _on_plane(
        self, points: Complex, normals: Complex, offsets: Complex
    ) -> tuple[Complex, Mask]:
        """Correct points by Newton; tell which were near and converged."""
        near = np.ones(len(points), dtype=bool)
        size = np.full(len(points), np.inf)
        for correction in range(_CORRECTIONS):
            residual, jacobian = self._system(points, normals, offsets)
            step = _solved(jacobian, residual)
            points = points - step
            size = _relative(step, points)
            if correction == 0:
                near = size < _CLOSE
        return points, near & (size < _EXACT)

    def _system(
        self, points: Complex, normals: Complex, offsets: Complex
    ) -> tuple[Complex, Complex]:
        """Return F and the plane's equation (b, n), and their derivatives (b, n, n)."""
        residual, jacobian = self.loops.evaluate(points[:, :-1], points[:, -1])
        plane = (normals * points).sum(axis=1) - offsets
        return (
            np.concatenate([residual, plane[:, None]], axis=1),
            np.concatenate([jacobian, normals[:, None]], axis=1),
        )


@dataclass(frozen=True, slots=True, eq=False)
class ComplexModes:
    """All complex solutions of the loop equations at given motor values.

    Attributes
    ----------
    count : int
        How many there are; where orientations are quaternions, each is counted once.
    q : ndarray, shape (r, nq)
        The real ones among them.
    degree : int
        Of the curve of machines: points in a random plane.
    bend : float
        How far the trace of these points is from a straight line, relative to its terms.
    complete : bool
        Whether it is straight: no point is missing on the components of the curve that were
        met. This rests on floating-point path tracking, and is no proof.
    """

    count: int
    q: Array
    degree: int
    bend: float
    complete: bool


def complex_modes(
    mechanism: Mechanism, actuated: ArrayLike, rng: np.random.Generator | int, most_rounds: int = 60
) -> ComplexModes:
    """Find all solutions of direct kinematics, complex ones too.

    Parameters
    ----------
    mechanism : Mechanism
    actuated : array_like, shape (n,)
        Motor values, m or rad.
    rng : numpy.random.Generator or int
    most_rounds : int
        Closed paths of planes after which it gives up.

    Raises
    ------
    ArgumentError
        Idle motions or geared joints; or no closed pose near these motor values is known.

    Examples
    --------
    >>> import pmjac_pin as pj
    >>> found = complex_modes(pj.load("four_bar"), [0.9], rng=0)
    >>> found.count, len(found.q), found.complete
    (2, 2, True)
    """
    parts, generator = mechanism._parts, np.random.default_rng(rng)
    values = motor_values(parts, actuated)
    base = parts.coordinates.with_values(parts.home_q, parts.problem.partition.actuated, values)
    problem, _ = search_problem(parts, base)
    home, _ = search_problem(parts, parts.home_q)
    loops = PolynomialLoops(problem, home.base[None], generator)
    points, bend = _all_points(Curve(loops), generator, most_rounds)
    x = _at_the_mechanism(Curve(loops), points[0], points[1])
    real = x[np.abs(x.imag).max(axis=1, initial=0.0) <= _REAL].real
    return ComplexModes(
        count=len(_once(loops, x)),
        q=loops.poses(_once(loops, real).real),
        degree=len(points[0]),
        bend=float(bend),
        complete=bool(bend < _STRAIGHT),
    )


def _all_points(
    curve: Curve, rng: np.random.Generator, most_rounds: int
) -> tuple[tuple[Complex, Plane], float]:
    """Return the points of the curve in a random plane, that plane, and the trace's bend."""
    base, bend = Plane.random(curve.loops.count + 1, rng), np.inf
    points = _first_points(curve, base, rng)
    for _ in range(most_rounds):
        before = len(points)
        points = _round(curve, points, base, rng)
        if len(points) == before and (bend := _bend(curve, points, base)) < _STRAIGHT:
            break
    return (points, base), bend


def _at_the_mechanism(curve: Curve, points: Complex, base: Plane) -> Complex:
    """Return the solutions x at t = 0, where the points of a plane end that stay finite."""
    target = Plane(np.eye(points.shape[1], dtype=complex)[-1], 0.0)
    ends, arrived = curve.walk(points, base, target)
    ends, last = curve.corrected(ends[arrived], target, 3)
    finite = np.abs(ends).max(axis=1, initial=0.0) <= _FAR
    return _distinct(ends[finite & (last < _EXACT)], ends[:0])[:, :-1]


def _once(loops: PolynomialLoops, x: Complex) -> Complex:
    """Return the solutions, of each pair with opposite quaternions one."""
    kept: list[Complex] = []
    for one in x:
        twins = loops.twins(one)
        if not any(np.abs(twin - other).max() <= _SAME for twin in twins for other in kept):
            kept.append(one)
    return np.array(kept).reshape(len(kept), x.shape[1])


def _first_points(curve: Curve, plane: Plane, rng: np.random.Generator) -> Complex:
    """Return points of the curve in a plane: Newton from random complex numbers."""
    shape = (200, curve.loops.count + 1)
    starts = rng.normal(size=shape) + 1j * rng.normal(size=shape)
    points, size = curve.corrected(starts, plane, 60)
    good = (size < 1e-12) & (np.linalg.norm(points, axis=1) < _FAR)
    return _distinct(points[good], points[:0])


def _round(curve: Curve, points: Complex, base: Plane, rng: np.random.Generator) -> Complex:
    """Lead the points round a closed path of three planes; return them with those they became."""
    size, moved = points.shape[1], points
    stations = [base, Plane.random(size, rng), Plane.random(size, rng), base]
    for start, end in itertools.pairwise(stations):
        moved, arrived = curve.walk(moved, start, end)
        moved = moved[arrived]
    return _distinct(moved, points)


def _bend(curve: Curve, points: Complex, base: Plane) -> float:
    """Return the second difference of the trace over parallel planes, relative to its terms."""
    sums = [points.sum(axis=0)]
    for share in (1.0, 2.0):
        moved, arrived = curve.walk(points, base, base.shifted(share))
        if not arrived.all():
            return np.inf
        sums.append(moved.sum(axis=0))
    second = sums[0] - 2.0 * sums[1] + sums[2]
    return float(np.abs(second).max() / np.abs(points).sum(axis=0).max())


def _distinct(points: Complex, known: Complex) -> Complex:
    """Return the known points and those of `points` that are not among them."""
    kept = list(known)
    for point in points:
        scale = _SAME * (1.0 + np.linalg.norm(point))
        if not kept or np.linalg.norm(np.array(kept) - point, axis=1).min() > scale:
            kept.append(point)
    return np.array(kept).reshape(len(kept), points.shape[1])


def _solved(matrices: Complex, vectors: Complex) -> Complex:
    """Return A⁻¹ b for each; nothing where A is singular."""
    try:
        return np.asarray(np.linalg.solve(matrices, vectors[:, :, None])[:, :, 0])
    except np.linalg.LinAlgError:
        return np.asarray((np.linalg.pinv(matrices) @ vectors[:, :, None])[:, :, 0])


def _flat(plane: Plane, count: int) -> tuple[Complex, Complex]:
    return np.tile(plane.normal, (count, 1)), np.full(count, plane.offset)


def _relative(step: Complex, points: Complex) -> Array:
    return np.asarray(np.linalg.norm(step, axis=1) / (1.0 + np.linalg.norm(points, axis=1)), float)
