"""SingularEquations: the closed poses at which a matrix of rates loses rank, as a regular system.

With M(q) the dimensionless matrix that loses rank and u a motion that it does not hold,

    η(q) = 0,    M(q) u = 0,    Nᵀ u = 0,    ½ (uᵀ u − 1) = 0.

M is K* for what is gained with the motors locked (second kind), and [K K*] above the judged rows
of the tool's Jacobian for what the tool loses (first kind). N spans what M never holds, the idle
motions: it borders the system, so that u is what is free here alone. Redundant rows of η, and
those of M, vanish with the others, so that least squares of the known rank are Newton's method
still. The derivative by q, (∂M/∂q · e) u from `kinematics/slopes.py`, is exact along motions that
the loops allow, and so are tangents and row space; across them it may be another one, by a multiple
of the rows of [K K*], which Newton's method corrects a step later.

At a singular pose w, the left null vector with wᵀ [K K*] on the passive columns 0 that is not
redundant, is normal to what the motors may do: wᵀ K θ̇ = 0 on the image of the locus in motor
space. The pose is a fold where wᵀ (∂K*/∂q · u) u ≠ 0, and a cusp where that passes zero.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from pmjac_pin.closing.idle_motions import gained_and_idle
from pmjac_pin.errors import ArgumentError
from pmjac_pin.kinematics.slopes import Slopes
from pmjac_pin.mechanism import Mechanism
from pmjac_pin.rates.factorisation import Factorisation
from pmjac_pin.values.arrays import Array, Index, norm

Freed = Literal["gain", "loss"]

EXACT = 1e-13  # of all equations, without dimension: the next step would be rounding
_MOST_STEPS = 30
_LARGEST_STEP = 0.5  # lengths or rad: Newton's first steps may be wild
_REDUNDANT = 1e-7  # of the matrix: what redundant rows and columns have at a pose near closure


@dataclass(frozen=True, slots=True, eq=False)
class SingularPoint:
    """A pose and the motion that M does not hold there, singular where the equations vanish.

    Attributes
    ----------
    q : ndarray, shape (nq,)
    u : ndarray, shape (k,)
        On the scaled rates, of unit length.
    idle : ndarray, shape (k, d)
        N, orthonormal columns: to which u is orthogonal.
    """

    q: Array
    u: Array
    idle: Array


@dataclass(frozen=True, slots=True, eq=False)
class Fold:
    """How a mechanism folds at a singular pose of the second kind.

    Attributes
    ----------
    normal : ndarray, shape (n,)
        wᵀ K on the scaled rates of the motors: zero where branches meet.
    curvature : float
        wᵀ (∂K*/∂q · u) u, dimensionless: zero at a cusp. It changes its sign with u or w.
    left : ndarray, shape (p,)
        w, of unit length.
    """

    normal: Array
    curvature: float
    left: Array


class SingularEquations:
    """The equations of the singular poses of one kind.

    Parameters
    ----------
    mechanism : Mechanism
    freed : {"gain", "loss"}
        Whether passive joints come free with the motors locked, or the tool loses a motion.

    Raises
    ------
    ArgumentError
        A mechanism whose generic ranks are not known, a joint that is not in the table of joints,
        or nothing that could lose rank.
    NoToolError
        A loss, and no frame is named as the tool.

    Examples
    --------
    >>> import pmjac_pin as pj
    >>> from pmjac_pin.studies.singularities.singular_equations import SingularEquations
    >>> bar = pj.load("five_bar")
    >>> equations = SingularEquations(bar, "gain")
    >>> found = equations.corrected(equations.begin(bar.home.q))
    >>> bar.configuration(found.q).singularity().kind
    'gain'
    """

    def __init__(self, mechanism: Mechanism, freed: Freed = "gain") -> None:
        self.mechanism, self.freed, self.problem = mechanism, freed, mechanism.problem
        partition = self.partition = mechanism.problem.partition
        if partition.isolated:
            raise ArgumentError(f"of {mechanism.name} no generic rank is known, nothing drops")
        if (slopes := mechanism._slopes) is None:
            raise ArgumentError(f"{mechanism.name} has a joint that is not in the table of joints")
        self._by_complex_steps = slopes
        self._tool = partition.tool_rows.linear + partition.tool_rows.angular
        self.rank = partition.passive_rank
        self.columns: Index = partition.passive
        if freed == "loss":
            mechanism.need_tool()
            self.rank = partition.constraint_rank + partition.tool_rank
            self.columns = np.arange(partition.column_scale.size)
        if not self.rank:
            raise ArgumentError(f"{mechanism.name} has nothing that could lose rank by {freed}")

    def matrix(self, q: Array) -> Array:
        """Return M at a q, dimensionless, shape (rows, k)."""
        return self._of(q)[1]

    def begin(self, q: Array) -> SingularPoint:
        """Return the first guess from a closed q: the motion that M holds least."""
        factors = self._factorised(q)
        values, right = factors.singular_values, factors.right
        if (
            self.freed == "gain"
            and right.shape[0] > self.rank
            and values[self.rank - 1] <= (_REDUNDANT * factors.size)
        ):
            gained, idle = gained_and_idle(self.problem, q, self.rank - 1)
            return SingularPoint(q, gained[:, 0], idle)
        return SingularPoint(q, right[self.rank - 1], right[self.rank :].T)

    def turned(self, point: SingularPoint) -> SingularPoint:
        """Return a singular point with N, and u with it, turned to what idles at its own pose."""
        if not point.idle.shape[1]:
            return point
        found = self.begin(point.q)
        return found if found.u @ point.u >= 0.0 else replace(found, u=-found.u)

    def residual(self, point: SingularPoint) -> Array:
        """Return what vanishes at a singular pose, dimensionless, all equations."""
        gap, matrix = self._of(point.q)
        u = point.u
        return np.concatenate([gap, matrix @ u, point.idle.T @ u, [0.5 * (u @ u - 1.0)]])

    def evaluate(self, point: SingularPoint) -> tuple[Array, Array]:
        """Return the residual and its derivative by q, in lengths or rad, and by u.

        Returns
        -------
        residual : ndarray, shape (r,)
        jacobian : ndarray, shape (r, nv + k)
            Unknowns are those of `moved`.
        """
        residual, u, idle = self.residual(point), point.u, point.idle
        constraint, slopes = self.slopes(point.q)
        nv, k = constraint.shape[1], u.size
        jacobian = np.zeros((residual.size, nv + k))
        p, rows = len(constraint), slopes.shape[1]
        jacobian[:p, :nv] = constraint
        jacobian[p : p + rows, :nv] = (slopes @ u).T
        jacobian[p : p + rows, nv:] = self.matrix(point.q)
        jacobian[p + rows : -1, nv:] = idle.T
        jacobian[-1, nv:] = u
        return residual, jacobian

    def moved(self, point: SingularPoint, step: Array) -> SingularPoint:
        """Return the point moved by a step (nv + k,): of q in lengths or rad, then of u."""
        nv = self.partition.column_scale.size
        return replace(
            point,
            q=self.problem.integrate(point.q, self._stride * step[:nv]),
            u=point.u + step[nv:],
        )

    def dimension(self, held: Index) -> int:
        """Return how many ways lead along the locus, with some columns of q held: 1 for a curve.

        Ways on which joints idle alone are none: N borders them.
        """
        partition = self.partition
        idle = partition.passive.size - partition.passive_rank
        return partition.column_scale.size - partition.constraint_rank - idle - held.size - 1

    def bordered(self, point: SingularPoint, held: Index) -> tuple[Array, Array]:
        """Return residual and derivative with columns of q held, and what idles at rest.

        Below those of `evaluate` stand rows that are zero but for the derivative.
        """
        residual, jacobian = self.evaluate(point)
        resting = self._resting(point)
        rows = np.zeros((held.size + resting.shape[1], jacobian.shape[1]))
        rows[np.arange(held.size), held] = 1.0
        rows[held.size :, : resting.shape[0]] = resting.T
        return np.append(residual, np.zeros(len(rows))), np.vstack([jacobian, rows])

    def corrected(
        self, point: SingularPoint, held: Index | None = None, most: float = np.inf
    ) -> SingularPoint | None:
        """Return the singular point near a guess by Newton's method, None where there is none.

        Parameters
        ----------
        point : SingularPoint
        held : ndarray of int, optional
            Columns of q that stay: motors of a slice.
        most : float
            How far all steps may lead together, lengths or rad.
        """
        held = np.zeros(0, dtype=np.intp) if held is None else held
        rank = self.partition.column_scale.size + self.columns.size - self.dimension(held)
        spent, before = 0.0, np.inf
        for _ in range(_MOST_STEPS):
            residual, jacobian = self.bordered(point, held)
            size = norm(residual)
            if not np.isfinite(size) or spent > most:
                return None
            if size <= EXACT or (size <= 1e2 * EXACT and size > 0.5 * before):
                return point
            left, values, right = np.linalg.svd(jacobian, full_matrices=False)
            if values.size < rank or not values[rank - 1]:
                return None
            step = -right[:rank].T @ ((left[:, :rank].T @ residual) / values[:rank])
            length = norm(step)
            if length > _LARGEST_STEP:
                step *= _LARGEST_STEP / length
            spent, before = spent + min(length, _LARGEST_STEP), size
            point = self.moved(point, step)
        return None

    def tangent(self, point: SingularPoint, held: Index) -> Array:
        """Return the ways that lead along the locus from a singular point, (d, nv + k), rows."""
        _, jacobian = self.bordered(point, held)
        right = np.linalg.svd(jacobian)[2]
        return np.asarray(right[right.shape[0] - self.dimension(held) :])

    def fold(self, point: SingularPoint) -> Fold:
        """Return how the mechanism folds at a singular point of the second kind.

        Raises
        ------
        ArgumentError
            Of a loss there is none: ask the machine that is driven by its tool.
        """
        if self.freed == "loss":
            raise ArgumentError("what folds is a gain: ask the machine driven by its tool")
        partition = self.partition
        constraint, slopes = self.slopes(point.q)
        left = np.linalg.svd(constraint[:, partition.passive])[0][:, self.rank - 1 :]
        turned, _, _ = np.linalg.svd(left.T @ constraint[:, partition.actuated])
        w = left @ turned[:, 0]
        along = np.tensordot(point.u, slopes[partition.passive], axes=1)
        return Fold(w @ constraint[:, partition.actuated], float(w @ along @ point.u), w)

    def slopes(self, q: Array) -> tuple[Array, Array]:
        """Return [K K*] (p, nv), and how M changes, (nv, rows, k), by lengths or rad of q."""
        partition, nv = self.partition, self.partition.column_scale.size
        snapshot = self.mechanism.kinematics.snapshot(q)
        by = self.mechanism._recorded.slopes() or self._by_complex_steps
        changed = by.at(q, np.diag(self._stride))
        constraint = partition.scaled(snapshot.constraint_jacobian)
        slopes = partition.scaled(changed.constraint)[:, :, self.columns]
        if self.freed == "gain":
            return constraint, slopes
        return constraint, np.concatenate([slopes, self._tool_slopes(changed, nv)], axis=1)

    @property
    def _stride(self) -> Array:
        """What an unknown of 1 is of each column, m or rad."""
        return np.asarray(self.partition.length * self.partition.column_scale)

    def _of(self, q: Array) -> tuple[Array, Array]:
        """Return η without dimension, and M."""
        partition = self.partition
        snapshot = self.mechanism.kinematics.snapshot(q)
        gap = snapshot.residual * partition.row_scale / partition.length
        constraint = partition.scaled(snapshot.constraint_jacobian)
        if self.freed == "gain":
            return gap, constraint[:, self.columns]
        tool = snapshot.judged_jacobian(partition.tool_rows)
        return gap, np.vstack([constraint, partition.scaled_tool(tool)[self._tool]])

    def _tool_slopes(self, changed: Slopes, nv: int) -> Array:
        axes = self.partition.tool_rows.axes
        rows = np.array([self.partition.scaled_tool(one) for one in changed.tool(axes)])
        return rows.reshape(-1, 6, nv)[:, self._tool]

    def _resting(self, point: SingularPoint) -> Array:
        """Return the idle motions of the joints on all columns, (nv, d)."""
        partition = self.partition
        idle = partition.passive.size - partition.passive_rank
        found = np.zeros((partition.column_scale.size, idle))
        if not idle:
            return found
        if self.freed == "gain":
            found[self.columns] = point.idle
        else:
            snapshot = self.mechanism.kinematics.snapshot(point.q)
            passive = partition.scaled(snapshot.constraint_jacobian)[:, partition.passive]
            found[partition.passive] = np.linalg.svd(passive)[2][partition.passive_rank :].T
        return found

    def _factorised(self, q: Array) -> Factorisation:
        matrix = self.matrix(q)
        return self.partition.factorise(matrix, norm(matrix))
