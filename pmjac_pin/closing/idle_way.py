"""Where idle motions are at the end of a path, whatever steps have led there.

No motor decides how far a rod has spun that spins about itself between two balls. The smallest
rates at each pose, −K*⁺ K θ̇, let it spin as little as they can; but where these lead to depends on
the length of the steps, by more than rounding. So a path leads to one of the closed poses that
differ in what idles: with N₀ (m_p, d) spanning null K* at its start q₀, without dimension, to where

    N₀ᵀ x = 0,    x = q ⊖ q₀ on the passive joints,

joint by joint, a joint's slides in its axes at q₀, its turn as a rotation vector. What idled at the
start has then not moved, measured there. From near by Newton's method finds it, on this and the
loops: with u its step on the loops alone, N spanning null K* at q, and L v the rates of x at v,

    v = u − P (x + L u),    P = N (N₀ᵀ L N)⁻¹ N₀ᵀ.

P depends on no choice of bases; where nothing has turned it is orthogonal, ‖P‖² = d. Where idle
motions are not those of the start any more, or x is near half a turn, P grows: there, a path is too
long for this, and is cut in two.
"""

from __future__ import annotations

import numpy as np
import pinocchio as pin

from pmjac_pin.algebra.floats import Floats
from pmjac_pin.closing.closed import Closed, closed_point
from pmjac_pin.closing.closure_problem import ClosureProblem
from pmjac_pin.kinematics.joint_steps import arriving, between
from pmjac_pin.kinematics.tree import Tree
from pmjac_pin.rates.partition import Partition
from pmjac_pin.values.arrays import Array, Index, norm

# Lengths, a rad counted as one:
PIECE = 1.0  #: how far motors go before the idle motions are looked at
LARGEST_RETURN = 0.5  #: of the first step back
SETTLED = 1e-10  #: of the last step: what that leaves is rounding
UNRESOLVED = 1e-7  # of a step that does not become smaller: beside a fold, it is rounding
MOST_RETURNS = 20
TURNED = 3.0  #: by how much ‖P‖² may grow

_FLOATS = Floats()


def pieces_of(distance: Array) -> Index:
    """Return into how many pieces paths are cut that go so far, in lengths.

    Where that is a whole number, rounding does not decide.
    """
    return np.maximum(1, np.ceil(distance / PIECE - 1e-6)).astype(np.intp)


def idles(partition: Partition) -> bool:
    """Tell whether passive joints move that no motor moves, at every pose."""
    return partition.passive_rank < partition.passive.size


class IdleWay:
    """Brings idle motions back to where a path's start had them.

    Parameters
    ----------
    model : pin.Model

    Raises
    ------
    ArgumentError
        A joint that is not in the table of joints.
    """

    __slots__ = ("_tree",)

    def __init__(self, model: pin.Model) -> None:
        self._tree = Tree(model)

    def settled(self, problem: ClosureProblem, start: Closed, end: Closed) -> Closed | None:
        """Return the closed pose beside the end of a path at which what idled has not moved.

        None where Newton's method does not find it, or where it is too far from the start.
        """
        partition = problem.partition
        length, rank = partition.length, partition.passive_rank
        idle = start.factors.right[rank:]
        point, before = end, 2.0 * LARGEST_RETURN * length
        for _ in range(MOST_RETURNS):
            if point.factors.rank < rank:
                return None
            back, turned = self._back(partition, start.q, point, idle)
            size = norm(back)
            smaller = size <= 0.5 * before
            done = size <= (SETTLED if smaller else UNRESOLVED) * length
            done &= point.gap <= problem.tolerance
            if not (smaller or done):
                return None
            v = np.zeros(partition.column_scale.size)
            v[partition.passive] = back * partition.passive_scale
            point = closed_point(problem, problem.integrate(point.q, v), point.iterations + 1)
            before = size
            if done:
                return point if turned <= len(idle) + TURNED else None
        return None

    def _back(
        self, partition: Partition, start: Array, point: Closed, idle: Array
    ) -> tuple[Array, float]:
        """Return Newton's step (m_p,), without dimension, and ‖P‖²."""
        rank, scale = partition.passive_rank, partition.column_scale[:, None]
        way = between(_FLOATS, self._tree, start[:, None], point.q[:, None])
        motions = np.zeros((scale.size, 1 + len(idle)))
        on_loops, free = -point.factors.solve(point.residual, rank), point.factors.right[rank:].T
        motions[partition.passive] = np.column_stack([on_loops, free])
        rates = arriving(_FLOATS, self._tree, np.repeat(way, 1 + len(idle), 1), motions * scale)
        rates[:, 0] += way[:, 0]
        seen = idle.dot((rates / scale)[partition.passive])
        try:
            back = np.linalg.solve(seen[:, 1:], np.column_stack([seen[:, :1], idle]))
        except np.linalg.LinAlgError:
            return np.full(len(free), np.nan), np.inf
        return on_loops - free.dot(back[:, 0]), norm(free.dot(back[:, 1:])) ** 2
