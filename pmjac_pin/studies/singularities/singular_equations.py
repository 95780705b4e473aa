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
from pmjac_pin.kinematics.pinocchio import Snapshot
from pmjac_pin.kinematics.slopes import Slopes
from pmjac_pin.mechanism import Mechanism
from pmjac_pin.rates.factorisation import Factorisation
from pmjac_pin.studies.singularities.curve_equations import CurveEquations, SingularPoint
from pmjac_pin.values.arrays import Array, Index, norm

Freed = Literal["gain", "loss"]
FREED: tuple[Freed, ...] = ("gain", "loss")  #: What a pose may be singular by.

_REDUNDANT = 1e-7  # of the matrix: what redundant rows and columns have at a pose near closure


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


@dataclass(frozen=True, slots=True, eq=False)
class RateBlock:
    """A block of [K K*] that loses rank: K* of a machine within one that has more loops.

    Attributes
    ----------
    rows : int
        The first so many rows.
    columns : ndarray of int, shape (k,)
    rank : int
        Generic.
    """

    rows: int
    columns: Index
    rank: int


class SingularEquations(CurveEquations):
    """The equations of the singular poses of one kind.

    Parameters
    ----------
    mechanism : Mechanism
    freed : {"gain", "loss"}
        Whether passive joints come free with the motors locked, or the tool loses a motion.
    block : RateBlock, optional
        What loses rank instead, for a gain.

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

    def __init__(
        self, mechanism: Mechanism, freed: Freed = "gain", *, block: RateBlock | None = None
    ) -> None:
        super().__init__(mechanism)
        partition, self.freed, self._block = self.partition, freed, block
        if partition.isolated:
            raise ArgumentError(f"of {mechanism.name} no generic rank is known, nothing drops")
        if (slopes := mechanism.slopes) is None:
            raise ArgumentError(f"{mechanism.name} has a joint that is not in the table of joints")
        self._by_complex_steps = slopes
        self._tool = partition.tool_rows.linear + partition.tool_rows.angular
        self.rank, self.columns = partition.passive_rank, partition.passive
        self._rows = slice(None)
        if block is not None:
            self.rank, self.columns, self._rows = block.rank, block.columns, slice(block.rows)
        elif freed == "loss":
            mechanism.need_tool()
            self.rank = partition.constraint_rank + partition.tool_rank
            self.columns = np.arange(partition.column_scale.size)
        if not self.rank:
            raise ArgumentError(f"{mechanism.name} has nothing that could lose rank by {freed}")

    @property
    def folds(self) -> bool:
        """Whether the mechanism's motors turn back where these hold: M is its K*."""
        return self.freed == "gain" and self._block is None

    def matrix(self, q: Array) -> Array:
        """Return M at a q, dimensionless, shape (rows, k)."""
        return self._of(self.mechanism.kinematics.snapshot(q))[1]

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
        return self._vanishing(point, *self._of(self.mechanism.kinematics.snapshot(point.q)))

    def evaluate(self, point: SingularPoint) -> tuple[Array, Array]:
        """Return the residual and its derivative by q, in lengths or rad, and by u.

        Returns
        -------
        residual : ndarray, shape (r,)
        jacobian : ndarray, shape (r, nv + k)
            Unknowns are those of `moved`.
        """
        snapshot, u, idle = self.mechanism.kinematics.snapshot(point.q), point.u, point.idle
        constraint, slopes = self._slopes_at(point.q, snapshot)
        gap, matrix = self._of(snapshot)
        residual = self._vanishing(point, gap, matrix)
        nv, k, p, rows = constraint.shape[1], u.size, gap.size, len(matrix)
        jacobian = np.zeros((residual.size, nv + k))
        jacobian[:p, :nv] = constraint
        jacobian[p : p + rows, :nv] = (slopes @ u).T
        jacobian[p : p + rows, nv:] = matrix
        jacobian[p + rows : -1, nv:] = idle.T
        jacobian[-1, nv:] = u
        return residual, jacobian

    def fold(self, point: SingularPoint) -> Fold:
        """Return how the mechanism folds at a singular point of the second kind.

        Raises
        ------
        ArgumentError
            Of a loss there is none: ask the machine that is driven by its tool.
        """
        if not self.folds:
            raise ArgumentError("what folds is a gain: ask the machine driven by its tool")
        partition = self.partition
        constraint, slopes = self.slopes(point.q)
        size = partition.size_of(constraint)
        factors = partition.factorise(constraint[:, partition.passive], size)
        left = factors.left[:, self.rank - 1 :]
        turned = partition.factorise(left.T @ constraint[:, partition.actuated], size).left
        w = left @ turned[:, 0]
        along = np.tensordot(point.u, slopes[partition.passive], axes=1)
        return Fold(w @ constraint[:, partition.actuated], float(w @ along @ point.u), w)

    def slopes(self, q: Array) -> tuple[Array, Array]:
        """Return [K K*] (p, nv), and how M changes, (nv, rows, k), by lengths or rad of q."""
        return self._slopes_at(q, self.mechanism.kinematics.snapshot(q))

    def _slopes_at(self, q: Array, snapshot: Snapshot) -> tuple[Array, Array]:
        partition, nv = self.partition, self.partition.column_scale.size
        by = self.mechanism.recorded.slopes() or self._by_complex_steps
        changed = by.at(q, self._strides)
        constraint = partition.scaled(snapshot.constraint_jacobian)
        slopes = partition.scaled(changed.constraint)[:, self._rows, self.columns]
        if self.freed == "gain":
            return constraint, slopes
        return constraint, np.concatenate([slopes, self._tool_slopes(changed, nv)], axis=1)

    def _of(self, snapshot: Snapshot) -> tuple[Array, Array]:
        """Return η without dimension, and M."""
        partition = self.partition
        gap = snapshot.residual * partition.row_scale / partition.length
        constraint = partition.scaled(snapshot.constraint_jacobian)
        if self.freed == "gain":
            return gap, constraint[self._rows, self.columns]
        tool = snapshot.judged_jacobian(partition.tool_rows)
        return gap, np.vstack([constraint, partition.scaled_tool(tool)[self._tool]])

    @staticmethod
    def _vanishing(point: SingularPoint, gap: Array, matrix: Array) -> Array:
        u = point.u
        return np.concatenate([gap, matrix @ u, point.idle.T @ u, [0.5 * (u @ u - 1.0)]])

    def _tool_slopes(self, changed: Slopes, nv: int) -> Array:
        axes = self.partition.tool_rows.axes
        rows = np.array([self.partition.scaled_tool(one) for one in changed.tool(axes)])
        return rows.reshape(-1, 6, nv)[:, self._tool]

    def _resting(self, point: SingularPoint) -> Array:
        if self.freed == "loss" or self._block is not None:
            return super()._resting(point)
        found = np.zeros((self.partition.column_scale.size, point.idle.shape[1]))
        found[self.columns] = point.idle
        return found

    def _factorised(self, q: Array) -> Factorisation:
        matrix = self.matrix(q)
        return self.partition.factorise(matrix, norm(matrix))
