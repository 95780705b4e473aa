"""Partition: what does not change from pose to pose when rates are split into θ̇ and φ̇.

Which columns are actuated and which passive, the scales that make K and K* dimensionless,
the generic ranks, and the rows of η that are shown.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from pmjac_pin.errors import ArgumentError, quoted
from pmjac_pin.model.tool_rows import WHOLE_TWIST, ToolRows
from pmjac_pin.rates.factorisation import RANK_TOLERANCE, Factorisation, decompose, factorise
from pmjac_pin.rates.pose_ranks import PoseRanks
from pmjac_pin.rates.singularity_types import MotionDimensions
from pmjac_pin.rates.tool_motion import ToolMotion
from pmjac_pin.values.arrays import Array, Index, ReadOnlyArrays, norm, read_only
from pmjac_pin.values.checks import SMALLEST, as_number, as_numbers
from pmjac_pin.values.found_once import found_once
from pmjac_pin.values.ties import pivots

_LEAST_SIZE = 0.1  # of [K K*], beside its generic size


class LoopRates:
    """What the loops allow at one pose: [K K*] without dimension, its size, K* factorised.

    Attributes
    ----------
    scaled : ndarray, shape (p, nv)
    size : float
    passive : Factorisation
    driving : ndarray, shape (p, n)
        K without dimension.
    """

    def __init__(self, scaled: Array, size: float, passive: Factorisation, actuated: Index) -> None:
        self.scaled, self.size, self.passive = scaled, size, passive
        self.driving = scaled.take(actuated, axis=1)

    @property
    def following(self) -> Array:
        """What K* solves K to, shape (m_p, n), without dimension: −φ̇ for each motor's rate."""
        return self._followed[0]

    @property
    def not_followed(self) -> float:
        """How much of K no motion of the passive joints follows."""
        return self._followed[1]

    @found_once
    def _followed(self) -> tuple[Array, float]:
        passive, driving = self.passive, self.driving
        following = passive.solve(driving)
        if passive.rank == len(driving):
            return following, 0.0
        return following, passive.left_over(driving, following)


@dataclass(frozen=True, eq=False)
class Partition(ReadOnlyArrays):
    """The split of the nv rates into n actuated and m_p passive ones.

    Attributes
    ----------
    actuated, passive : ndarray of int, shapes (n,) and (m_p,)
        Columns, in the order of K and K*.
    actuated_names, passive_names : tuple of str
    units : tuple of str, length nv
        Of each column's freedom, "m" or "rad"; empty for matrices from elsewhere.
    row_names, row_units : tuple of str, length p
        Of η, the units "m", "rad" or "m²"; empty for matrices from elsewhere.
    length : float
        The mechanism's characteristic length, m: it makes a rad and a m comparable.
    row_scale : ndarray, shape (p,)
        Turns the rows of η into m, of a loop as large as the mechanism.
    column_scale : ndarray, shape (nv,)
        A unit rate of a column, in the scaled problem: 1/length rad or 1 m.
    loop_sizes : tuple of float
        Of each loop, m: `length`, or its own where it is much smaller.
    passive_rank, constraint_rank, tool_rank : int
        Generic ranks of K*, of [K K*] and of the tool's motion: those of one regular pose.
    unfelt, twist_rank : int
        Generic dimensions as well: of the passive motions that move no motor and no judged row of
        the tool, and of the tool's twists on all six rows.
    kept_rows : ndarray of int, shape (m,)
        Independent rows of η, chosen at the home pose, or at that one where home is singular.
    reach : float
        How far from a pose near home all joints were seen to move, rad or a share of `length`;
        infinite where none may, or nobody has looked.
    rank_tolerance : float
        Relative size up to which singular values count as zero.
    tool_rows : ToolRows
        The rows of the tool's twist on which `tool_rank` rests.
    size : float
        Of [K K*], the largest seen where the ranks are from.
    smallest_size : float
        Below it [K K*] is rounding of a machine whose loops close nothing.
    strokes : ndarray, shape (nv,)
        How far a rod lets slides go that nothing turns with it, a share of `length`; 1 elsewhere,
        and for all where it is empty.
    gap : float
        Up to which loops count as closed, as a share of `length`.
    tool_rates : ndarray, shape (nv,)
        Scaled rates by which the tool generically moves as fast as all else; empty where they are
        1 (`ToolMotion.rates`).
    rate_limits, effort_limits : ndarray, shape (nv,)
        Of the model, m/s or rad/s and N or N m; infinite where it states none. Empty where the
        matrices came from elsewhere.
    """

    actuated: Index
    passive: Index
    actuated_names: tuple[str, ...]
    passive_names: tuple[str, ...]
    length: float
    row_scale: Array
    column_scale: Array
    passive_rank: int = 0
    constraint_rank: int = 0
    tool_rank: int = 0
    unfelt: int = 0
    twist_rank: int = 0
    kept_rows: Index = field(default_factory=lambda: np.zeros(0, dtype=np.intp))
    rank_tolerance: float = RANK_TOLERANCE
    size: float = 0.0
    reach: float = np.inf
    loop_sizes: tuple[float, ...] = ()
    tool_rows: ToolRows = WHOLE_TWIST
    smallest_size: float = 0.0
    strokes: Array = field(default_factory=lambda: np.zeros(0))
    gap: float = 1e-12
    tool_rates: Array = field(default_factory=lambda: np.zeros(0))
    rate_limits: Array = field(default_factory=lambda: np.zeros(0))
    effort_limits: Array = field(default_factory=lambda: np.zeros(0))
    units: tuple[str, ...] = ()
    row_names: tuple[str, ...] = ()
    row_units: tuple[str, ...] = ()

    @cached_property
    def scale(self) -> Array:
        """What `scaled` multiplies by, shape (p, nv)."""
        return read_only(np.outer(self.row_scale, self.column_scale))

    @cached_property
    def motor_scale(self) -> Array:
        """Natural rates of the motors, shape (n,): of `column_scale`."""
        return read_only(self.column_scale[self.actuated])

    @cached_property
    def passive_scale(self) -> Array:
        """Natural rates of the passive joints, shape (m_p,): of `column_scale`."""
        return read_only(self.column_scale[self.passive])

    @property
    def isolated(self) -> bool:
        """Whether a joint cannot be moved though its rates are not forbidden, near home either.

        It is part of a structure, or home is singular. What is generic is not known then.
        """
        return not self.reach

    @property
    def generic_ranks(self) -> tuple[int, int, int]:
        """The generic ranks of [K K*], of K* and of the tool's motion."""
        return self.constraint_rank, self.passive_rank, self.tool_rank

    @property
    def generic_dimensions(self) -> MotionDimensions:
        """What the loops allow generically."""
        return MotionDimensions(
            allowed=self.column_scale.size - self.constraint_rank,
            locked=self.passive.size - self.passive_rank,
            tool=self.tool_rank,
            unfelt=self.unfelt,
            twist=self.twist_rank,
        )

    @property
    def idles(self) -> bool:
        """Whether K* has fewer independent columns than passive ones, at every pose."""
        return self.passive_rank < self.passive.size

    @cached_property
    def full(self) -> bool:
        """Whether K* has all the rank that its shape allows: it has more nowhere."""
        return self.passive_rank == min(self.passive.size, self.row_scale.size)

    @cached_property
    def tool_full(self) -> bool:
        """Whether the tool moves in all ways that its rows and the motors allow: in more nowhere.

        Without loops there are no branches on which it could.
        """
        idle = self.passive.size - self.passive_rank
        motions = self.column_scale.size - self.constraint_rank - idle
        ways = min(len(self.tool_rows.names), motions)
        return not self.row_scale.size or self.tool_rank >= ways

    @property
    def columns(self) -> dict[str, int]:
        """The column of each degree of freedom by its name, in the order of K and K*."""
        names = self.actuated_names + self.passive_names
        columns = [*self.actuated.tolist(), *self.passive.tolist()]
        return dict(zip(names, columns, strict=True))

    def units_of(self, columns: Index) -> tuple[str, ...]:
        """Return the units of these columns' freedoms; none for matrices from elsewhere."""
        return tuple(self.units[k] for k in columns.tolist()) if self.units else ()

    @cached_property
    def rate_scale(self) -> Array:
        """Turns −(scaled solution of K* X = K) into φ̇ per θ̇, shape (m_p, n)."""
        return read_only(-np.outer(self.passive_scale, 1.0 / self.motor_scale))

    @classmethod
    def from_matrices(
        cls,
        constraint_jacobian: ArrayLike,
        tool_jacobian: ArrayLike,
        actuated: Sequence[int],
        passive: Sequence[int],
        *,
        length: float = 1.0,
    ) -> Partition:
        """Return the partition for matrices from elsewhere, its ranks those of this one pose.

        Parameters
        ----------
        constraint_jacobian : array_like, shape (p, nv)
            ∂η/∂v, rows in m.
        tool_jacobian : array_like, shape (6, nv)
            Linear rows first.
        actuated, passive : sequence of int
            Columns; all of them, each once.
        length : float
            A length in m that is large for this mechanism's linear, and one rad for its
            angular motion; 1 m where all columns are comparable already.

        Raises
        ------
        ArgumentError
            Shapes or columns that do not fit.

        Examples
        --------
        Two loop equations, one motor and two passive joints:

        >>> import numpy as np, pmjac_pin as pj
        >>> C = np.array([[-2.0, 1.0, -1.0], [1.0, 0.5, 2.0]])
        >>> J = np.vstack([np.eye(3), np.zeros((2, 3)), np.ones((1, 3))])
        >>> partition = pj.Partition.from_matrices(C, J, [0], [1, 2])
        >>> split = pj.SplitJacobian(C, J, "LOCAL_WORLD_ALIGNED", partition)
        >>> pj.equivalent_jacobian(split).passive_rates.round(3).tolist()
        [[1.2], [-0.8]]
        """
        constraint = as_numbers(constraint_jacobian, "the constraint Jacobian")
        tool = as_numbers(tool_jacobian, "the tool Jacobian")
        _check_shapes(constraint, tool, actuated, passive)
        if not as_number(length, "length") >= SMALLEST:
            raise ArgumentError(f"length must be {SMALLEST:g} m or more, got {quoted(length)}")
        rows, columns = constraint.shape
        partition = cls(
            actuated=np.array(actuated, dtype=np.intp),
            passive=np.array(passive, dtype=np.intp),
            actuated_names=tuple(f"theta{k}" for k in range(len(actuated))),
            passive_names=tuple(f"phi{k}" for k in range(len(passive))),
            length=length,
            row_scale=np.ones(rows),
            column_scale=np.full(columns, 1.0 / length),
        )
        partition = partition.sized([constraint])
        return partition.with_ranks_of([partition.at_pose(constraint, tool)])

    def factorise(self, matrix: Array, size: float) -> Factorisation:
        """Factorise a matrix without dimension; `size` is that of what it is a part of."""
        return factorise(matrix, size, self.rank_tolerance)

    def scaled(self, constraint_jacobian: Array) -> Array:
        """Return [K K*], shape (p, nv), without dimension: rows in m, a rotation by 1/length."""
        scaled: Array = constraint_jacobian * self.scale
        return scaled

    def size_of(self, scaled: Array) -> float:
        """Return what singular values of [K K*] are compared with: its own size, within reason.

        Where a single loop is singular, all of [K K*] may vanish, and would have full rank beside
        itself.
        """
        return max(norm(scaled), self.least_size)

    @cached_property
    def least_size(self) -> float:
        """What the size of [K K*] is taken for where it vanishes."""
        return max(_LEAST_SIZE * self.size, self.smallest_size)

    def loop_rates(self, constraint_jacobian: Array) -> LoopRates:
        """Return [K K*] without dimension at one pose, and K* factorised."""
        scaled = constraint_jacobian * self.scale
        size = max(norm(scaled), self.least_size)
        factors = factorise(scaled.take(self.passive, axis=1), size, self.rank_tolerance)
        return LoopRates(scaled, size, factors, self.actuated)

    def scaled_tool(self, tool_jacobian: Array) -> Array:
        """Return the tool Jacobian (6, nv) on the scaled columns, angular rows times length."""
        scaled: Array = tool_jacobian * self.column_scale
        scaled[3:] *= self.length
        return scaled

    def tool_motion(self, tool_jacobian: Array) -> ToolMotion:
        """Return the tool Jacobian (6, nv), in the axes of `tool_rows`, and how to judge it."""
        scaled = self.scaled_tool(tool_jacobian)
        return ToolMotion(scaled, self.length, self.tool_rows, self.tool_rates, self.rank_tolerance)

    def shown_rows(self, scaled: Array) -> Index:
        """Return the rows of η to show: those kept since home, while they are independent."""
        if self.kept_rows.size == scaled.shape[0]:
            return self.kept_rows
        size = self.size_of(scaled)
        if self.factorise(scaled[self.kept_rows], size).rank == self.kept_rows.size:
            return self.kept_rows
        return independent_rows(scaled, self.factorise(scaled, size).rank)

    def at_pose(self, constraint_jacobian: Array, tool_jacobian: Array) -> PoseRanks:
        """Return what has ranks at one closed pose; the tool's Jacobian is in its rows' axes."""
        rates = self.loop_rates(constraint_jacobian)
        whole = decompose(rates.scaled, rates.size, self.rank_tolerance)
        motion = self.tool_motion(tool_jacobian).commanded(whole, self.gap, self.actuated)
        return PoseRanks(rates.scaled, rates.passive, motion)

    def sized(self, constraint_jacobians: Iterable[Array]) -> Partition:
        """Return the partition with the size of the largest of these [K K*]."""
        return replace(self, size=max(norm(self.scaled(one)) for one in constraint_jacobians))

    def with_ranks_of(self, poses: Sequence[PoseRanks]) -> Partition:
        """Return the partition with the generic ranks and kept rows of these closed poses.

        Ranks are generic where they are largest, but not each for itself: where branches meet,
        [K K*] drops and the tool seems to move in more ways than on any of them. So all three are
        those of one pose, the one whose [K K*] has the largest rank, then K*, then the tool.

        Parameters
        ----------
        poses : sequence of PoseRanks
            Home first, then others near it: home itself may be singular.
        """
        ranks = [pose.ranks for pose in poses]
        regular = max(range(len(poses)), key=ranks.__getitem__)
        whole, passive, tool = ranks[regular]
        shown = 0 if ranks[0][0] == whole else regular
        alike = [pose for pose in poses if pose.ranks == ranks[regular]]
        idle = self.passive.size - passive
        return replace(
            self,
            passive_rank=passive,
            constraint_rank=whole,
            tool_rank=tool,
            unfelt=min(pose.unfelt(self.passive) for pose in alike) if idle else 0,
            twist_rank=max(pose.motion.twist_rank() for pose in alike),
            kept_rows=independent_rows(poses[shown].scaled, whole),
            tool_rates=min(
                (pose.motion.generic_rates() for pose in alike),
                key=lambda rates: float(rates.max(initial=1.0)),
            ),
        )

    def factorise_all(self, constraint_jacobian: Array) -> Factorisation:
        """Factorise [K K*] at one pose, without dimension: for the motions that it allows."""
        scaled = self.scaled(constraint_jacobian)
        return decompose(scaled, self.size_of(scaled), self.rank_tolerance)


def _check_shapes(
    constraint: Array, tool: Array, actuated: Sequence[int], passive: Sequence[int]
) -> None:
    if constraint.ndim != 2 or tool.shape != (6, constraint.shape[-1]):
        raise ArgumentError(
            "a constraint Jacobian (p, nv) and a tool Jacobian (6, nv) expected, got shapes "
            f"{constraint.shape} and {tool.shape}"
        )
    columns = [as_numbers(given, "columns") for given in (actuated, passive)]
    named = sorted(np.concatenate([given.ravel() for given in columns]).tolist())
    if named != list(range(constraint.shape[1])) or columns[0].ndim + columns[1].ndim != 2:
        raise ArgumentError(
            f"actuated and passive must name each of the columns 0 to {constraint.shape[1] - 1} "
            f"once, got {quoted(actuated)} and {quoted(passive)}"
        )


def independent_rows(scaled: Array, rank: int) -> Index:
    """Return `rank` independent rows, in their own order: QR with pivoting finds them."""
    if rank == scaled.shape[0]:
        return np.arange(rank)
    return pivots(scaled.T, rank)
