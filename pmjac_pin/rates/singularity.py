"""Singularity: the ranks at one pose, what kind of singularity it is, what moves freely there.

A singularity is a drop below the generic rank, never an absolute rank: a mechanism with
redundant loop equations or with an idle rod has a rank-deficient [K K*] or K* at every pose.
Judged on singular values of the dimensionless matrices (see `Partition.scaled`).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Literal, TypeAlias

import numpy as np

from pmjac_pin.model.tool_rows import ToolRows
from pmjac_pin.rates.factorisation import Factorisation
from pmjac_pin.rates.lost_wrenches import JacobianSlopes, lost_wrenches
from pmjac_pin.rates.margins import Margins
from pmjac_pin.rates.partition import LoopRates, Partition
from pmjac_pin.rates.screw import Screw, principal_screws
from pmjac_pin.rates.singularity_types import MotionDimensions, SingularityTypes
from pmjac_pin.values.arrays import Array, ReadOnlyArrays, norm
from pmjac_pin.values.found_once import found_once
from pmjac_pin.values.shown import Shown
from pmjac_pin.values.ties import first_largest

SingularityKind = Literal[
    "regular", "gain", "loss", "gain and loss", "configuration space", "isolated"
]
#: rank of K* ↦ the bases of what is gained and of what is idle in null K*, on the scaled rates.
Split: TypeAlias = Callable[[int], tuple[Array, Array]]


@dataclass(frozen=True, eq=False, repr=False)
class Singularity(ReadOnlyArrays, Shown):
    """What the ranks say at one closed pose. In a notebook it shows as a table.

    Attributes
    ----------
    singular_values : ndarray, shape (min(p, m_p),)
        Of the dimensionless K* (all rows), divided by the Frobenius norm of the dimensionless
        [K K*], descending.
    tolerance : float
        Singular values up to this count as zero.
    rank, generic_rank : int
        Of K*, here and in general.
    constraint_rank, generic_constraint_rank : int
        Of [K K*].
    tool_rows : ToolRows
        The rows of the tool's twist that are judged.
    tool_rank, generic_tool_rank : int
        Dimension of the tool twists that the loops allow, on these rows.
    linear_rank, angular_rank : int
        Dimensions of the linear and of the angular velocities that the loops allow, on all rows.
    free_motions : ndarray, shape (m_p, gained)
        The passive rates, in m/s or rad/s, that come free here with all motors locked: columns
        span null(K*) modulo the idle motions, orthogonal to these on dimensionless rates. Where
        `isolated`, to first order only: they may lead nowhere.
    idle_motions : ndarray, shape (m_p, idle)
        Columns span the passive rates that are free at every pose. Where nothing tells them from
        what is gained (matrices of a singular pose alone, or all poses nearby singular as well)
        there are none, and `free_motions` has all of null(K*).
    forbidden_rates : ndarray, shape (n, k)
        Orthonormal columns: directions of θ̇ outside what the loops allow here.
    actuated_names, passive_names : tuple of str
    actuated_units, passive_units : tuple of str
        "m" or "rad"; empty for matrices from elsewhere.
    types : SingularityTypes
        Which of Zlatanov's six types, and of Gosselin and Angeles' three, the pose has.
    free_twists : ndarray, shape (6, k)
        Columns span the twists that the tool can have here with all motors locked, on all six rows:
        of its origin, in m/s and rad/s, linear rows first, in the world's axes.
    borne_wrenches : ndarray, shape (6, k)
        Columns span the wrenches on the judged rows that the loops bear here without the motors:
        N and N m about the tool's origin, in the world's axes. They are those of every pose, as
        many as rows less `generic_tool_rank`, and `lost` more.
    lost_wrenches : ndarray, shape (6, k)
        Of these, columns span such as need motors beside this pose: the shortest, a rad counting as
        `length`, modulo those of every pose. They do work on the `lost` twists. None for matrices
        from elsewhere, and where the first order does not tell them.
    tool_point : ndarray, shape (3,)
        Where the tool's origin is in the world, m; 0 for matrices from elsewhere.
    length : float
        The machine's characteristic length, m.
    isolated : bool
        No pose near home closes, so that nothing is known of what is generic: the generic ranks
        are home's.
    find_margins : callable, optional
        Of this, what `margins` has; None for matrices from elsewhere.
    """

    singular_values: Array
    tolerance: float
    rank: int
    generic_rank: int
    constraint_rank: int
    generic_constraint_rank: int
    tool_rows: ToolRows
    tool_rank: int
    generic_tool_rank: int
    linear_rank: int
    angular_rank: int
    free_motions: Array
    idle_motions: Array
    forbidden_rates: Array
    actuated_names: tuple[str, ...]
    passive_names: tuple[str, ...]
    types: SingularityTypes
    free_twists: Array
    borne_wrenches: Array
    lost_wrenches: Array
    tool_point: Array
    length: float
    actuated_units: tuple[str, ...] = ()
    passive_units: tuple[str, ...] = ()
    isolated: bool = False
    find_margins: Callable[[Singularity], Margins] | None = None

    @found_once
    def margins(self) -> Margins:
        """How far joints, motors and tool are from a singular pose, in m and rad, at this one.

        Arms and angles by which forces hold them: see `Margins`. None, all empty, for matrices
        from elsewhere.

        Examples
        --------
        A four-bar's transmission angle, between coupler and rocker, by the rocker's pivot, and
        the arm at which the coupler pushes it:

        >>> import math, pmjac_pin as pj
        >>> bar = pj.load("four_bar", {"l0": 4.0, "l1": 1.0, "l2": 3.0, "l3": 3.5}).close([0.0])
        >>> margin = bar.singularity().margins.gain["phi1"]
        >>> cosine = (3.0**2 + 3.5**2 - 3.0**2) / (2 * 3.0 * 3.5)
        >>> abs(margin.transmission - math.acos(cosine)) < 1e-9, round(margin.arm, 4)
        (True, 2.8425)
        """
        return Margins() if self.find_margins is None else self.find_margins(self)

    @property
    def idle(self) -> int:
        """Number of passive motions that are free at every pose; 0 where that is not known."""
        return 0 if self.isolated else len(self.passive_names) - self.generic_rank

    @property
    def gained(self) -> int:
        """Number of passive motions that come free here with all motors locked."""
        return self.generic_rank - self.rank

    @property
    def lost(self) -> int:
        """Number of independent tool twists that are lost here, on the judged rows.

        Where branches meet, more of them may be possible than on any branch: none is lost then.
        """
        return max(0, self.generic_tool_rank - self.tool_rank)

    @property
    def smallest(self) -> float:
        """The singular value of K* that decides, σ at the generic rank; infinite without loops."""
        return float(self.singular_values[self.generic_rank - 1]) if self.generic_rank else np.inf

    @property
    def condition(self) -> float:
        """σ_max over the σ that decides; 1 without loops."""
        if not self.generic_rank:
            return 1.0
        return float(self.singular_values[0]) / self.smallest if self.smallest else np.inf

    @property
    def kind(self) -> SingularityKind:
        """What kind of singularity this is.

        "gain": K* drops, motions come free with the motors locked (second kind, parallel);
        "loss": the tool loses a motion (first kind, serial), judged on `tool_rows`;
        "configuration space": [K K*] itself drops, where branches of the configuration space
        meet; "isolated": no pose near home closes, a structure, or a singular home; "regular":
        none.
        """
        if self.isolated:
            return "isolated"
        if self.constraint_rank < self.generic_constraint_rank:
            return "configuration space"
        if self.gained > 0:
            return "gain and loss" if self.lost > 0 else "gain"
        return "loss" if self.lost > 0 else "regular"

    @property
    def is_singular(self) -> bool:
        """Whether K* is below its generic rank or that is not known: SingularError by `jacobian`.

        What a mechanism suffers from at every pose (forbidden motor rates, idle motions that
        the tool feels) is no singularity.
        """
        return self.gained > 0 or self.isolated

    @property
    def free_screws(self) -> tuple[Screw, ...]:
        """The principal screws of what the tool can do here with all motors locked."""
        linear, angular = self.free_twists[:3], self.free_twists[3:]
        return principal_screws(angular, linear, self.tool_point, self.length)

    @property
    def borne_screws(self) -> tuple[Screw, ...]:
        """The principal screws of `borne_wrenches`, those that have a force last."""
        force, moment = self.borne_wrenches[:3], self.borne_wrenches[3:]
        return principal_screws(force, moment, self.tool_point, self.length)

    @property
    def lost_screws(self) -> tuple[Screw, ...]:
        """The principal screws of `lost_wrenches`."""
        force, moment = self.lost_wrenches[:3], self.lost_wrenches[3:]
        return principal_screws(force, moment, self.tool_point, self.length)

    @property
    def in_words(self) -> str:
        """One sentence: what kind of singularity this is, in the field's names."""
        if self.isolated:
            return "not known: no pose near home closes, a structure or a singular home"
        return self.types.in_words

    def free_motion(self) -> dict[str, float]:
        """Return one motion that comes free here, largest rate 1, by name; empty where none does.

        Of the motions that differ from it by idle ones it is the smallest: idle joints rest.
        """
        if not self.free_motions.size:
            return {}
        rates = self.free_motions[:, 0]
        rates = rates / rates[first_largest(rates)]
        return dict(zip(self.passive_names, map(float, rates), strict=True))

    def __repr__(self) -> str:
        idle = f", {self.idle} idle" if self.idle else ""
        judged = "" if self.tool_rows.is_whole else f", judged on {self.tool_rows}"
        return (
            f"Singularity(kind={self.kind!r}, rank={self.rank} of {self.generic_rank}{idle}, "
            f"smallest={self.smallest:.3g}, tolerance={self.tolerance:g}{judged})"
        )


def analyse_singularity(
    constraint_jacobian: Array,
    tool_jacobian: Array,
    partition: Partition,
    split: Split | None = None,
    *,
    loops: LoopRates | None = None,
    tool_pose: tuple[Array, Array] | None = None,
    slopes: JacobianSlopes | None = None,
    find_margins: Callable[[Singularity], Margins] | None = None,
) -> Singularity:
    """Read the ranks off the constraint and tool Jacobians of one closed pose.

    Parameters
    ----------
    constraint_jacobian : ndarray, shape (p, nv)
    tool_jacobian : ndarray, shape (6, nv)
        Linear rows first, in the axes of the partition's `tool_rows`.
    partition : Partition
    split : callable, optional
        Tells what is idle at a singular pose, as `gained_and_idle` does, where these matrices do
        not.
    loops : LoopRates, optional
        Of the constraint Jacobian, where these are known.
    tool_pose : tuple of ndarray, shapes (3, 3) and (3,), optional
        From the axes of the tool Jacobian to the world's, and where the tool's origin is there;
        as if they were the world's, with the tool at its origin, where it is not given.
    slopes : callable, optional
        How these Jacobians change, for `lost_wrenches`.
    find_margins : callable, optional
        Of the result, its `margins`.
    """
    found = loops or partition.loop_rates(constraint_jacobian)
    scaled, size, passive = found.scaled, found.size, found.passive
    whole, free = partition.factorise(scaled, size), passive.null_space
    tool = partition.tool_motion(tool_jacobian)
    borne, ranks = tool.borne(whole.null_space), tool.ranks(whole.null_space)
    judged = len(partition.tool_rows.names) - borne.shape[1]
    felt = tool.felt_rank(free, partition.passive) if free.size else 0
    here = _dimensions(whole, free, judged, ranks.twist, felt)
    lost = lost_wrenches(whole, tool, partition, slopes, partition.tool_rank - judged)
    scale = partition.column_scale[partition.passive, None]
    gained, idle = _free(passive, partition, split)
    return Singularity(
        **_of_all_poses(partition),
        singular_values=passive.singular_values / (size or 1.0),
        rank=passive.rank,
        constraint_rank=whole.rank,
        tool_rank=judged,
        linear_rank=ranks.linear,
        angular_rank=ranks.angular,
        free_motions=scale * gained,
        idle_motions=scale * idle,
        forbidden_rates=forbidden_rates(passive.left_null_space, scaled, partition),
        types=SingularityTypes(here, partition.generic_dimensions, partition.actuated.size),
        free_twists=_to_world_axes(tool_pose, tool.twists(free, partition.passive)),
        borne_wrenches=_to_world_axes(tool_pose, borne),
        lost_wrenches=_to_world_axes(tool_pose, lost),
        tool_point=np.zeros(3) if tool_pose is None else tool_pose[1],
        find_margins=find_margins,
    )


def _of_all_poses(partition: Partition) -> dict[str, Any]:
    """Return what a `Singularity` tells that is the same at all poses."""
    return {
        "tolerance": partition.rank_tolerance,
        "generic_rank": partition.passive_rank,
        "generic_constraint_rank": partition.constraint_rank,
        "tool_rows": partition.tool_rows,
        "generic_tool_rank": partition.tool_rank,
        "actuated_names": partition.actuated_names,
        "passive_names": partition.passive_names,
        "length": partition.length,
        "actuated_units": partition.units_of(partition.actuated),
        "passive_units": partition.units_of(partition.passive),
        "isolated": partition.isolated,
    }


def _dimensions(
    whole: Factorisation, free: Array, judged: int, twist: int, felt: int
) -> MotionDimensions:
    """Count free motions as giving those judged twists that motors cannot, at least.

    Where motors can move in fewer ways than the tool does, these do the rest.
    """
    allowed, locked = whole.null_space.shape[1], free.shape[1]
    given = max(0, judged - (allowed - locked), felt) if locked else 0
    return MotionDimensions(allowed, locked, judged, locked - given, twist)


def _to_world_axes(pose: tuple[Array, Array] | None, columns: Array) -> Array:
    if pose is None or not columns.size:
        return columns
    return np.vstack([pose[0] @ columns[:3], pose[0] @ columns[3:]])


def _free(passive: Factorisation, partition: Partition, split: Split | None) -> tuple[Array, Array]:
    """Return bases of what is gained and of what is idle in null K*, on the scaled rates."""
    gained, free = max(partition.passive_rank - passive.rank, 0), passive.null_space
    if partition.isolated:
        return free, free[:, :0]
    if gained in (0, free.shape[1]) or passive.tells_apart(partition.passive_rank):
        return free[:, :gained], free[:, gained:]
    return (free, free[:, :0]) if split is None else split(passive.rank)


def forbidden_rates(left_null_space: Array, scaled: Array, partition: Partition) -> Array:
    """Return orthonormal directions of θ̇ (n, k) for which no φ̇ satisfies K θ̇ + K* φ̇ = 0.

    With Wᵀ K* = 0, these are the θ̇ with Wᵀ K θ̇ ≠ 0.
    """
    actuated = partition.actuated
    defect = left_null_space.T @ scaled[:, actuated]
    size = partition.size_of(scaled)
    if norm(defect) <= partition.rank_tolerance * size:
        return np.zeros((actuated.size, 0))
    row_space = partition.factorise(defect, size)
    directions = row_space.right[: row_space.rank].T / partition.column_scale[actuated, None]
    orthonormal: Array = np.linalg.qr(directions)[0]
    largest = first_largest(orthonormal)
    orthonormal *= np.sign(orthonormal[largest, np.arange(largest.size)])
    return orthonormal
