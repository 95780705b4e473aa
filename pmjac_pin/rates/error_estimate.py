"""How far J_eq may be from that of the pose that closes the loops exactly.

A pose closes its loops to rounding only. Of a gap δ the pose is off by up to δ/σ, with σ the
smallest singular value of K*, and beside a singularity J_eq changes by 1/σ² of that again: its
relative error grows with the square of the condition number.

Linear algebra on arrays; what is asked of a pose is in `JacobianPose`.
"""

from __future__ import annotations

from typing import Protocol

import numpy as np

from pmjac_pin.rates.factorisation import REFINED, Factorisation
from pmjac_pin.rates.partition import LoopRates, Partition
from pmjac_pin.values.arrays import Array, Mask, norm

EPS = float(np.finfo(float).eps)
_SUMS = 16.0  # units in the last place, for an entry that is a sum of a few products


class JacobianPose(Protocol):
    """What a Jacobian asks of the pose that it is of: closed but for rounding."""

    def loop_rates(self) -> LoopRates:
        """Return [K K*] there without dimension, and K* factorised."""
        ...

    def opened(self) -> Array:
        """Return by how much each row is open, m, shape (p,): its gap, and what rounding hides.

        Each is counted as `Partition.row_scale` does, of a loop as large as the mechanism.
        """
        ...

    def sizes(self) -> Array | None:
        """Return `TwistMap.sizes` of J_eq there, None where no program has told them."""
        ...

    def places(self) -> float:
        """Return what rounding of places moves the tool by, m."""
        ...

    def moving(self) -> tuple[Mask, Mask]:
        """Return which columns are not always 0, in each row, (p, nv), and of the tool, (nv,)."""
        ...

    def slopes(self, motions: Array) -> tuple[Array, Array]:
        """Return how the constraint and the tool Jacobian change along motions, (nv, k).

        In one unit of time each: shapes (k, p, nv) and (k, 6, nv).
        """
        ...


def error_estimate(
    constraint_jacobian: Array,
    tool_jacobian: Array,
    motion_map: Array,
    partition: Partition,
    pose: JacobianPose,
) -> Array:
    """Return a bound for |J_eq − that of the closed pose|, entry by entry, shape (6, n).

    With K* = U Σ Vᵀ on dimensionless rows and columns, a pose whose rows are open by δ (p,) is off
    by V Σ⁻¹ Uᵀ D u with every |uᵣ| ≤ 1, D = diag(δ), and, to first order, with dJ, dC the changes
    of the tool and of the constraint Jacobian C along a passive motion and G the motion map,

        dJ_eq = (dJ − J* K*⁺ dC) G.

    So its entries are at most Σᵣ |Σᵢ D uᵢ dJ_eq[vᵢ] / σᵢ|, all rows being open at once: a loop
    much smaller than the mechanism adds what it is open by, and no other. The rounding of J
    and C themselves adds |δJ| |G| + |J* K*⁺| |δC| |G|, where they can be other than 0, and that of
    the elimination, where rates are not refined, some ε |J* K*⁺| |G|. What the second order adds is
    estimated by 1/(1 − κ), κ = 2 Σᵣ |D U Σ⁻¹| max|dK*| / σ_min; the bound is infinite where κ ≥ 1:
    there the nearest closed pose may be anywhere, or none.
    """
    passive, rank = partition.passive, partition.passive_rank
    loops = partition.loop_rates(constraint_jacobian)
    scaled, size, factors = loops.scaled, loops.size, loops.passive
    tool = tool_jacobian * partition.column_scale
    rates = motion_map / partition.column_scale[:, None]
    inverse = factors.right[:rank].T / factors.singular_values[:rank]
    felt = tool.take(passive, axis=1) @ inverse @ factors.left[:, :rank].T
    in_loops, of_tool = pose.moving()
    entries = pose.opened() / partition.length + _SUMS * EPS * np.linalg.norm(scaled, axis=1)
    linear = pose.places() / partition.length + _SUMS * EPS * norm(tool[:3])
    twists = np.repeat([linear, _SUMS * EPS * norm(tool[3:])], 3)
    rounding = np.outer(twists, np.linalg.norm(rates[of_tool | tool.any(axis=0)], axis=0))
    rounding += (np.abs(felt) * entries) @ np.sqrt((in_loops | (scaled != 0.0)) @ rates**2)
    if factors.exceeds(rank, REFINED * size):
        # Elimination that is not refined knows nothing of which entries are 0.
        sizes = np.linalg.norm(felt, axis=1), np.linalg.norm(rates, axis=0)
        rounding += _SUMS * EPS * norm(scaled) * np.outer(*sizes)
    moved, curvature = _by_the_pose(factors, felt, rates, partition, pose)
    if not curvature < 1.0:
        return np.full(rounding.shape, np.inf)
    estimate: Array = (rounding + moved) / (1.0 - curvature)
    return estimate


def _by_the_pose(
    factors: Factorisation, felt: Array, rates: Array, partition: Partition, pose: JacobianPose
) -> tuple[Array, float]:
    """Return Σᵣ |Σᵢ D uᵢ dJ_eq[vᵢ] / σᵢ|, shape (6, n), and κ."""
    opened, rank = pose.opened(), partition.passive_rank
    motions = np.zeros((rates.shape[0], rank))
    motions[partition.passive] = factors.right[:rank].T
    values = factors.singular_values[:rank]
    off = opened[:, None] * factors.left[:, :rank] / values
    moved, bend = np.zeros((opened.size, 6, rates.shape[1])), 0.0
    slopes = pose.slopes(partition.column_scale[:, None] * motions)
    for by, dC, dJ in zip(off.T, *slopes, strict=True):
        turned = partition.scaled(dC)
        moved += np.multiply.outer(by, (dJ * partition.column_scale - felt @ turned) @ rates)
        bend = max(bend, norm(turned.take(partition.passive, axis=1)))
    farthest = np.linalg.norm(off, axis=1).sum()
    return np.abs(moved).sum(axis=0), 2.0 * farthest * bend / values.min(initial=np.inf)
