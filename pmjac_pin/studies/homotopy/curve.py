"""The curve of solutions over a line of machines, and its points in planes.

The machines p(t), γ(t) of a line and their solutions x are a curve in (x, t). A plane cuts it in
as many points as its degree; the plane t = 0 cuts out the solutions of one machine.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pmjac_pin.studies.homotopy.curve_kernel import StepRules
from pmjac_pin.studies.homotopy.machines import Line
from pmjac_pin.values.arrays import Array, Complex, Mask

SAME = 1e-6  # relative distance of two points that are one
_FAR_AWAY = 1e-12  # of h: no point is further away than its inverse
_RULES = StepRules(
    first=0.1,
    smallest=1e-6,
    arrived=1.0 - 1e-14,
    close=1e-4,
    exact=1e-9,
    most=3000,
    corrections=2,
)


def same_plane(numbers: Complex, count: int) -> Complex:
    """Return a plane a · (x, t) = b, numbers (a, b), for each of `count` points, a row each."""
    return np.tile(np.asarray(numbers, dtype=complex), (count, 1))


def machine_plane(t: float, unknowns: int, count: int) -> Complex:
    """Return the plane of one machine of the line, for `count` points."""
    return same_plane(np.append(np.eye(unknowns + 1)[-1], t), count)


def _missed_by_rays(planes: Complex, points: Complex) -> Complex:
    """Return a · (X, h t) − b h of points (X, h, t)."""
    X, h, t = points[:, :-2], points[:, -2], points[:, -1]
    height = planes[:, -2] * t - planes[:, -1]
    return np.asarray((planes[:, :-2] * X).sum(axis=1) + height * h)


@dataclass(frozen=True, slots=True, eq=False)
class Curve:
    """The curve F(x, t) = 0, and the walk of its points from some planes to others.

    Inside, a point is (X, h, t) with x = X/h and |(X, h)| = 1; over a step, (X, h) stays in the
    plane through it that is perpendicular to it.
    """

    line: Line

    @property
    def size(self) -> int:
        """How many coordinates (x, t) a point has."""
        return self.line.count + 1

    def walk(self, points: Complex, start: Complex, end: Complex) -> tuple[Complex, Mask]:
        """Follow points (x, t) from planes to planes; return them, and which arrived.

        Those that arrive at infinity come back with entries of 1e8 and more.
        """
        points, pull, lanes = _rays(points), end - start, self.line.lanes()
        if lanes is None:
            points, share = self._followed(points, start, pull)
        else:
            points, share = lanes.follow(points, start, pull, _RULES)
        return _affine(points), share >= _RULES.arrived

    def _followed(self, points: Complex, start: Complex, pull: Complex) -> tuple[Complex, Array]:
        """Return where points (X, h, t) are led, and the shares of the way that they went."""
        share, step = np.zeros(len(points)), np.full(len(points), _RULES.first)
        going = np.ones(len(points), dtype=bool)
        for _ in range(_RULES.most):
            now = np.flatnonzero(going)
            if not now.size:
                break
            length = np.minimum(step[now], 1.0 - share[now])
            here, ahead = start[now] + share[now, None] * pull[now], length[:, None] * pull[now]
            trial, good = self._stepped(points[now], here, ahead)
            points[now[good]] = _unit_points(trial[good])
            share[now[good]] += length[good]
            step[now] = np.where(good, step[now] * 2.0, step[now] * 0.5)
            going &= (share < _RULES.arrived) & (step >= _RULES.smallest)
        return points, share

    def corrected(self, points: Complex, planes: Complex, steps: int) -> tuple[Complex, Array]:
        """Return points (x, t) after some of Newton's steps, and the size of the last."""
        rays = _rays(points)
        with np.errstate(all="ignore"):
            rays, size = self._newton(rays, rays[:, :-1].conj(), planes, steps)
        return _affine(rays), size

    def _stepped(self, points: Complex, here: Complex, ahead: Complex) -> tuple[Complex, Mask]:
        """Return the points in planes a step ahead, and which of them are certainly there."""
        across = points[:, :-1].conj()
        with np.errstate(all="ignore"):
            trial = self._predicted(points, across, here, ahead)
            trial, first = self._newton(trial, across, here + ahead, 1)
            trial, last = self._newton(trial, across, here + ahead, _RULES.corrections - 1)
        return trial, (first < _RULES.close) & (last < _RULES.exact)

    def _predicted(
        self, points: Complex, across: Complex, here: Complex, ahead: Complex
    ) -> Complex:
        """Return the points in planes a step ahead, by Runge and Kutta's fourth-order rule."""

        def moved(at: Complex, part: float) -> Complex:
            _, jacobian = self._system(at, across, here + part * ahead)
            change = np.zeros_like(at)
            change[:, -2] = -_missed_by_rays(ahead, at)
            return _each_solved(jacobian, change)

        one = moved(points, 0.0)
        two = moved(points + 0.5 * one, 0.5)
        three = moved(points + 0.5 * two, 0.5)
        four = moved(points + three, 1.0)
        return np.asarray(points + (one + 2.0 * two + 2.0 * three + four) / 6.0)

    def _newton(
        self, points: Complex, across: Complex, planes: Complex, steps: int
    ) -> tuple[Complex, Array]:
        """Return points after some steps, and how long the last was: t relative to its size."""
        size: Array = np.full(len(points), np.inf)
        for _ in range(steps):
            residual, jacobian = self._system(points, across, planes)
            step = _each_solved(jacobian, residual)
            points = points - step
            t, dt = np.abs(points[:, -1]), np.abs(step[:, -1])
            size = np.linalg.norm(step[:, :-1], axis=1) + dt / (1.0 + t)
        return points, np.where(np.isfinite(size), size, np.inf)

    def _system(self, points: Complex, across: Complex, planes: Complex) -> tuple[Complex, Complex]:
        """Return F, the plane's equation and that of (X, h)'s own, and their derivatives."""
        X, t = points[:, :-1], points[:, -1]
        residual, jacobian = self.line.evaluate(X, t)
        plane, patch = _missed_by_rays(planes, points), (across * X).sum(axis=1) - 1.0
        rows = np.zeros((len(points), 2, points.shape[1]), dtype=complex)
        rows[:, 0, :-2], rows[:, 0, -2] = planes[:, :-2], planes[:, -2] * t - planes[:, -1]
        rows[:, 0, -1] = planes[:, -2] * X[:, -1]
        rows[:, 1, :-1] = across
        return (
            np.concatenate([residual, plane[:, None], patch[:, None]], axis=1),
            np.concatenate([jacobian, rows], axis=1),
        )


def place_of(point: Complex, points: Complex) -> int | None:
    """Return which of some points (m, n) is this one, None where none is."""
    gap = np.linalg.norm(points - point, axis=1)
    same = gap.min(initial=np.inf) <= SAME * (1.0 + np.linalg.norm(point))
    return int(np.argmin(gap)) if same else None


def distinct(points: Complex, known: Complex) -> Complex:
    """Return the known points and those of `points` that are not among them."""
    kept = list(known)
    for point in points:
        if place_of(point, np.array(kept).reshape(-1, len(point))) is None:
            kept.append(point)
    return np.array(kept).reshape(len(kept), points.shape[1])


def _each_solved(matrices: Complex, vectors: Complex) -> Complex:
    """Return A⁻¹ b for each; nothing where A is singular."""
    try:
        return np.asarray(np.linalg.solve(matrices, vectors[:, :, None])[:, :, 0])
    except np.linalg.LinAlgError:
        tame = np.where(np.isfinite(matrices), matrices, 0.0)
        return np.asarray((np.linalg.pinv(tame) @ vectors[:, :, None])[:, :, 0])


def _rays(points: Complex) -> Complex:
    """Return points (x, t) as (X, h, t)."""
    ones = np.ones((len(points), 1))
    return _unit_points(np.hstack([points[:, :-1], ones, points[:, -1:]]))


def _unit_points(points: Complex) -> Complex:
    points = points.copy()
    points[:, :-1] /= np.linalg.norm(points[:, :-1], axis=1, keepdims=True)
    return points


def _affine(points: Complex) -> Complex:
    """Return points (X, h, t) as (x, t)."""
    h = points[:, -2:-1]
    h = np.where(np.abs(h) > _FAR_AWAY, h, _FAR_AWAY)
    return np.hstack([points[:, :-2] / h, points[:, -1:]])
