"""Second order: how J_eq changes along the motors' motions, and what rates alone accelerate.

With C = [K K*] on all rows, J the tool Jacobian of the cut tree, G the motion map with v = G θ̇,
and dC[w], dJ[w] their derivatives along a motion w,

    ∂J_eq/∂θₖ = (dJ[gₖ] − J* K*⁺ dC[gₖ]) G,   gₖ the k-th column of G,
    φ̈ = −K*⁺ (K θ̈ + γ),                       γ = dC[v] v.

Redundant rows and idle motions are treated as in J_eq: on all rows, with the smallest rates.
Linear algebra on arrays.
"""

from __future__ import annotations

import numpy as np

from pmjac_pin.rates.partition import LoopRates, Partition
from pmjac_pin.values.arrays import Array


def following_rates(opening: Array, loops: LoopRates, partition: Partition) -> Array:
    """Return −K*⁺ b, the passive rates (m_p, k) that undo how motions open the rows, b (p, k).

    Parameters
    ----------
    opening : ndarray, shape (p, k)
        On all rows, in their units.
    loops : LoopRates
        `Partition.loop_rates` of the constraint Jacobian.
    partition : Partition
    """
    scaled = opening * partition.row_scale[:, None]
    rates = loops.passive.solve(scaled, partition.passive_rank)
    return np.asarray(-partition.column_scale[partition.passive][:, None] * rates)


def passive_hessian(
    constraint_slopes: Array, motion_map: Array, loops: LoopRates, partition: Partition
) -> Array:
    """Return ∂Φ/∂θ, shape (m_p, n, n), of φ̇ = Φ θ̇: the last axis says along which motor.

    Parameters
    ----------
    constraint_slopes : ndarray, shape (n, p, nv)
        dC[gₖ].
    motion_map, loops, partition
        As for `hessian`.
    """
    along = [following_rates(dC @ motion_map, loops, partition) for dC in constraint_slopes]
    return np.stack(along, axis=2) if along else np.zeros((partition.passive.size, 0, 0))


def hessian(
    slopes: tuple[Array, Array],
    tool_jacobian: Array,
    motion_map: Array,
    loops: LoopRates,
    partition: Partition,
) -> Array:
    """Return ∂J_eq/∂θ, shape (6, n, n): the last axis says along which motor.

    Parameters
    ----------
    slopes : pair of ndarray, shapes (n, p, nv) and (n, 6, nv)
        dC[gₖ] and dJ[gₖ].
    tool_jacobian : ndarray, shape (6, nv)
    motion_map : ndarray, shape (nv, n)
        G.
    loops, partition
        As for `following_rates`.
    """
    constraint, tool = slopes
    following = passive_hessian(constraint, motion_map, loops, partition)
    own = np.einsum("kiv,vj->ijk", tool, motion_map)
    return np.asarray(
        own + np.einsum("ip,pjk->ijk", tool_jacobian[:, partition.passive], following)
    )
