"""Lost: which of the wrenches that loops bear at a pose need motors beside it.

Let A span the motions that the loops allow, C A = 0 with C = [K K*], and T be the judged rows of
the tool's Jacobian. The wrenches W with Wᵀ T A = 0 need no motor. Of a motion n of A that leaves
the tool at rest, T n = 0, the tool's twist where the joints have moved by t v is

    t (T'[v] − T C⁺ C'[v]) n    beside twists T A    and what is of order t²,

so that D(v) = Wᵀ (T'[v] − T C⁺ C'[v]) n is what comes back: the wrenches that do work on it need
motors beside the pose, and those of every pose do none.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeAlias

import numpy as np

from pmjac_pin.rates.factorisation import Factorisation, factorise
from pmjac_pin.rates.partition import Partition
from pmjac_pin.rates.tool_motion import ToolMotion
from pmjac_pin.values.arrays import Array

#: Motions (nv, k) ↦ how the constraint and the tool Jacobian, in the axes of the judged rows,
#: change along them, shapes (k, p, nv) and (k, 6, nv).
JacobianSlopes: TypeAlias = Callable[[Array], tuple[Array, Array]]
_COMES_BACK = 1e-3  # of what all Jacobians change by along a motion of one length or rad


def lost_wrenches(
    whole: Factorisation,
    tool: ToolMotion,
    partition: Partition,
    slopes: JacobianSlopes | None,
    lost: int,
) -> Array:
    """Return independent wrenches (6, lost), N and N m: the shortest, modulo those of every pose.

    None, (6, 0), where the first order does not tell them, as where branches meet.
    """
    if slopes is None or lost <= 0 or whole.rank < partition.constraint_rank:
        return np.zeros((6, 0))
    allowed, units = whole.null_space, tool.units
    borne = tool.borne(allowed) / units
    resting = tool.resting(allowed)
    stride = partition.length * partition.column_scale[:, None]
    by_loops, by_tool = slopes(stride * allowed)
    taken = tool.scaled @ whole.inverse(whole.rank)
    back = [
        borne.T @ (partition.scaled_tool(of_tool) - taken @ partition.scaled(of_loops)) @ resting
        for of_loops, of_tool in zip(by_loops, by_tool, strict=True)
    ]
    found = factorise(np.hstack(back), tool.size, _COMES_BACK)
    return borne @ found.left[:, :lost] * units if found.rank == lost else borne[:, :0]
