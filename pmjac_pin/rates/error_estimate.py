"""How far J_eq may be from that of the pose that closes the loops exactly.

A pose closes its loops to rounding only. Of a gap δ the pose is off by up to δ/σ, with σ the
smallest singular value of K*, and beside a singularity J_eq changes by 1/σ² of that again: its
relative error grows with the square of the condition number.

Linear algebra on arrays; what is asked of a pose is in `RoundedPose`.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Protocol

import numpy as np

from pmjac_pin.rates.factorisation import Factorisation
from pmjac_pin.rates.partition import Partition
from pmjac_pin.values.arrays import Array, norm

EPS = float(np.finfo(float).eps)
_SUMS = 16.0  # units in the last place, for an entry that is a sum of a few products


class RoundedPose(Protocol):
    """A pose whose loops are closed but for rounding."""

    def opened(self) -> float:
        """Return by how much its loops are open, m: the gap, and what rounding hides of it."""
        ...

    def slopes(self, motions: Array) -> Iterator[tuple[Array, Array]]:
        """Yield how the constraint and the tool Jacobian change along each motion, per metre.

        Parameters
        ----------
        motions : ndarray, shape (nv, k)
            In columns, on the scaled rates.
        """
        ...


def error_estimate(
    constraint_jacobian: Array,
    tool_jacobian: Array,
    motion_map: Array,
    partition: Partition,
    pose: RoundedPose,
) -> Array:
    """Return a bound for |J_eq − that of the closed pose|, entry by entry, shape (6, n).

    With K* = U Σ Vᵀ on dimensionless rows and columns, a pose whose loops are open by δ is off by
    V Σ⁻¹ Uᵀ e for some |e| ≤ δ, and, to first order, with dJ, dC the changes of the tool and of
    the constraint Jacobian C along a passive motion and G the motion map,

        dJ_eq = (dJ − J* K*⁺ dC) G.

    By Cauchy and Schwarz its entries are at most δ (Σᵢ (dJ_eq[vᵢ] / σᵢ)²)^½. The rounding of J
    and C themselves adds |δJ| |G| + |J* K*⁺| |δC| |G|. What the second order adds is estimated by
    1/(1 − κ), κ = 2 δ max|dK*| / σ²; the bound is infinite where κ ≥ 1: there the nearest closed
    pose may be anywhere, or none.
    """
    passive, rank = partition.passive, partition.passive_rank
    scaled, _, factors = partition.loop_rates(constraint_jacobian)
    tool = tool_jacobian * partition.column_scale
    rates = motion_map / partition.column_scale[:, None]
    felt = tool.take(passive, axis=1) @ (factors.right[:rank].T / factors.singular_values[:rank])
    opened = pose.opened()
    entries = opened / partition.length + _SUMS * EPS * norm(scaled)
    linear = opened / partition.length + _SUMS * EPS * norm(tool[:3])
    rows = np.repeat([linear, _SUMS * EPS * norm(tool[3:])], 3)
    rounding = np.outer(
        rows + entries * np.linalg.norm(felt, axis=1), np.linalg.norm(rates, axis=0)
    )
    moved, bend = _by_the_pose(factors, felt @ factors.left[:, :rank].T, rates, partition, pose)
    curvature = 2.0 * opened * bend
    if not curvature < 1.0:
        return np.full(rounding.shape, np.inf)
    estimate: Array = (rounding + opened * moved) / (1.0 - curvature)
    return estimate


def _by_the_pose(
    factors: Factorisation,
    felt: Array,
    rates: Array,
    partition: Partition,
    pose: RoundedPose,
) -> tuple[Array, float]:
    """Return (Σᵢ (dJ_eq[vᵢ] / σᵢ)²)^½, shape (6, n), and the largest |dK*[vᵢ]| over σ²."""
    rank = partition.passive_rank
    motions = np.zeros((rates.shape[0], rank))
    motions[partition.passive] = factors.right[:rank].T
    squares, bend = np.zeros((6, rates.shape[1])), 0.0
    values = factors.singular_values[:rank].tolist()
    for value, (dC, dJ) in zip(values, pose.slopes(motions), strict=True):
        turned = partition.scaled(dC)
        change = (dJ * partition.column_scale - felt @ turned) @ rates
        squares += (change / value) ** 2
        bend = max(bend, norm(turned.take(partition.passive, axis=1)))
    return np.sqrt(squares), bend / min(values, default=np.inf) ** 2
