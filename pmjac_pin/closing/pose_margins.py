"""The margins of a closed pose: of its passive joints, of its motors and of its tool."""

from __future__ import annotations

from types import MappingProxyType

import numpy as np

from pmjac_pin.closing.held_joints import HeldJoints
from pmjac_pin.closing.parts import Parts
from pmjac_pin.rates.factorisation import factorise
from pmjac_pin.rates.joint_margins import HeldJoint, Holding
from pmjac_pin.rates.margins import JointMargin, Margins
from pmjac_pin.rates.partition import Partition
from pmjac_pin.rates.singularity import Singularity
from pmjac_pin.rates.tool_margins import tool_margins
from pmjac_pin.values.arrays import Array, Index


class PoseMargins:
    """What the margins of a pose are found of.

    Parameters
    ----------
    parts : Parts
    partition : Partition
        With the generic ranks of the pose's branch.
    q : ndarray, shape (nq,)
    """

    def __init__(self, parts: Parts, partition: Partition, q: Array) -> None:
        self._parts, self._partition, self._q = parts, partition, q
        snapshot = parts.kinematics.snapshot(q)
        rows = partition.tool_rows
        self._pose = snapshot.axes_of(rows), snapshot.position + parts.place
        self._tool = partition.tool_motion(snapshot.judged_jacobian(rows))
        self._scaled = partition.scaled(parts.kinematics.evaluate(q)[1])

    def found(self, ranks: Singularity) -> Margins:
        """Return them; none of what is isolated, and of joints none where gears tie some.

        Parameters
        ----------
        ranks : Singularity
            Of the pose.
        """
        if self._partition.isolated:
            return Margins()
        tool = {}
        whole = self._partition.factorise(self._scaled, self._partition.size_of(self._scaled))
        if not self._parts.spec.tool.is_none:
            tool = tool_margins(whole.null_space, self._tool, self._partition, self._pose)
        if self._parts.kinematics.loops.couplings:
            return Margins(tool=MappingProxyType(tool))
        return Margins(
            MappingProxyType(self._gain(ranks)),
            MappingProxyType(self._loss(ranks)),
            MappingProxyType(tool),
        )

    def _joints(self, columns: Index, locked: Index, *, tool: bool) -> list[HeldJoint]:
        """Return the joints all of whose freedoms are among these columns, others locked."""
        coordinates = self._parts.coordinates
        among = set(columns.tolist())
        names = [name for name in coordinates.names if among >= {*coordinates.columns([name])}]
        return HeldJoints(self._parts, self._q, locked.tolist(), tool=tool).of(names)

    def _gain(self, ranks: Singularity) -> dict[str, JointMargin]:
        """Return those of passive joints: rows of K* hold them."""
        partition = self._partition
        columns = partition.passive
        scale = partition.column_scale[columns]
        holding = Holding(
            partition.factorise(self._scaled[:, columns], partition.size_of(self._scaled)),
            ranks.rank,
            columns,
            scale,
            _as_basis(ranks.free_motions / scale[:, None]),
            _as_basis(ranks.idle_motions / scale[:, None]),
            partition.length,
        )
        joints = self._joints(columns, partition.actuated, tool=False)
        return _margins_held(holding, [(one, one.wrenches * partition.row_scale) for one in joints])

    def _loss(self, ranks: Singularity) -> dict[str, JointMargin]:
        """Return those of motors: rows of [K K*] and of the locked tool hold them."""
        if self._parts.spec.tool.is_none:
            return {}
        partition, tool = self._partition, self._tool
        judged = tool.rows.linear + tool.rows.angular
        matrix = np.vstack([self._scaled, tool.scaled[judged]])
        rank = ranks.constraint_rank + ranks.tool_rank
        factors = partition.factorise(matrix, partition.size_of(self._scaled))
        free = factors.right[rank:].T
        none = free[:, :0]
        columns = np.arange(partition.column_scale.size)
        gained, idle = (free, none) if _only_idle(partition) else (none, free)
        scale, length = partition.column_scale, partition.length
        holding = Holding(factors, rank, columns, scale, gained, idle, length)
        joints = self._joints(partition.actuated, columns[:0], tool=True)
        of_tool = [(one.of_tool * tool.units[:, 0])[:, judged] for one in joints]
        of_loops = [one.wrenches * partition.row_scale for one in joints]
        rows = [np.hstack(both) for both in zip(of_loops, of_tool, strict=True)]
        return _margins_held(holding, list(zip(joints, rows, strict=True)))


def _margins_held(
    holding: Holding, joints: list[tuple[HeldJoint, Array]]
) -> dict[str, JointMargin]:
    found = ((joint.name, holding.margin(joint, wrenches)) for joint, wrenches in joints)
    return {name: margin for name, margin in found if margin is not None}


def _only_idle(partition: Partition) -> bool:
    """Tell whether with the tool locked no motor moves generically, but what idles alone."""
    still = partition.column_scale.size - partition.constraint_rank - partition.tool_rank
    return still == partition.unfelt


def _as_basis(motions: Array) -> Array:
    """Return independent motions as orthonormal columns."""
    return factorise(motions, 1.0).left[:, : motions.shape[1]]
