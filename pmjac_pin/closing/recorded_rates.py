"""The rates of a mechanism at one pose as programs: φ̇ = −K*⁻¹ K θ̇, J_eq, and how certain they are.

K* is taken on kept columns, as many as it has rank, independent where the ranks are from. Where
something idles, motions are the smallest of those that differ by that (`recorded_idle`). That K*
has this rank at a pose is certain where 1/‖R⁻¹‖, which is no more than its
smallest singular value, is above the rank tolerance; where it is not, nothing is said.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from pmjac_pin.algebra.arrays import Numbers
from pmjac_pin.algebra.programs import PROGRAMS, largest, objects, zeros
from pmjac_pin.algebra.recordings import Recordings
from pmjac_pin.algebra.tangents import tangents
from pmjac_pin.algebra.tape import Tape
from pmjac_pin.algebra.terms import Term
from pmjac_pin.closing.closure_problem import ClosureProblem
from pmjac_pin.closing.recorded_idle import IdleColumn, idle_columns, idle_motions, smallest
from pmjac_pin.kinematics.joint_steps import entry_rates, moved_by
from pmjac_pin.kinematics.recorded import RecordedKinematics, RecordedRows, Recorder
from pmjac_pin.model.twist_frame import FrameName, change_frame
from pmjac_pin.rates.partition import Partition
from pmjac_pin.rates.sparse_qr import Triangle, norm
from pmjac_pin.values.arrays import Array, Index, read_only
from pmjac_pin.values.ties import pivots

DOUBTS = 7  # numbers that say whether a J_eq holds
SPREAD = 1e-6  # of points that span a tool: where they span less, the single call decides


@dataclass(frozen=True, slots=True, eq=False)
class RecordedEquivalent:
    """J_eq and what says whether it exists.

    Attributes
    ----------
    gap : number
        How far the loops are open, m.
    inverse, size : number
        ‖K*⁻¹‖ and ‖[K K*]‖, dimensionless.
    forbidden, felt, tool : number
        What K* cannot follow of K; what idle motions do to the tool, and what all joints do.
    spread : number
        The sine of the angle at the first of the three points that span a tool; 1 for a frame.
    turning : number
        What all joints do to the tool's orientation, rad/s per scaled rate.
    motions : number
        ‖G‖ on scaled rates, idle motions at rest.
    J_eq : ndarray, shape (6, n)
    likeness : ndarray, shape (k, m_p)
        Has the singular values of K*.
    """

    gap: Any
    inverse: Any
    size: Any
    forbidden: Any
    felt: Any
    tool: Any
    spread: Any
    turning: Any
    motions: Any
    J_eq: Numbers
    likeness: Numbers

    def judged(self) -> list[Any]:
        """Return J_eq's entries after `DOUBTS` numbers, which say whether they hold."""
        sizes = [self.gap, self.inverse, self.size, self.forbidden, self.felt, self.tool]
        return [*sizes, self.spread, *self.J_eq.ravel()]

    def sizes(self) -> list[Any]:
        """Return what the linear and the angular entries of J_eq are compared with."""
        return [self.tool * self.motions, self.turning * self.motions]


@dataclass(frozen=True, slots=True, eq=False)
class RecordedRates:
    """What programs are recorded of.

    Attributes
    ----------
    recorder : Recorder
    partition : Partition
    kept : ndarray of int
        Passive columns, as many as K* has rank.
    idle : tuple of IdleColumn
        The other passive columns.
    recordings : Recordings
        What was recorded for machines of other dimensions.
    """

    recorder: Recorder
    partition: Partition
    kept: Index
    idle: tuple[IdleColumn, ...] = ()
    recordings: Recordings = field(default_factory=Recordings)

    @classmethod
    def at(
        cls,
        recorder: Recorder,
        problem: ClosureProblem,
        q: Array,
        recordings: Recordings | None = None,
    ) -> RecordedRates:
        """Keep the columns of K* that are independent best at one regular pose."""
        partition, (_, rates) = problem.partition, problem.evaluate(q)
        passive, rank = partition.passive, partition.passive_rank
        columns = partition.scaled(rates)[:, passive]
        kept = read_only(passive[pivots(columns, rank)])
        idle = idle_columns(problem, q, kept) if partition.idles else ()
        return cls(recorder, partition, kept, idle, recordings or Recordings())

    def scaled(self, rates: Numbers) -> Numbers:
        """Return ∂η/∂v (p, nv) without dimension."""
        scale = np.outer(self.partition.row_scale, self.partition.column_scale)
        scaled: Numbers = rates * scale
        return scaled

    def gap(self, kinematics: RecordedRows) -> Any:
        """Return how far the loops are open, m.

        Where tilts or turns vanish at half a turn, by mistake, that is a length.
        """
        gap = norm(kinematics.residual * self.partition.row_scale)
        for cosine in kinematics.cosines:
            gap = largest(gap, -self.partition.length * cosine)
        return gap

    def move_tape(self) -> Tape:
        """Return (q, v) ↦ q ⊕ v."""
        return self.recordings.tape("move", self.recorder.nq + self.recorder.nv, self.move)

    def move(self, inputs: Sequence[Term]) -> list[Any]:
        """Record `move_tape`."""
        q, v = np.split(objects(inputs), [self.recorder.nq])
        outputs: list[Any] = moved_by(PROGRAMS, self.recorder.tree, q, v).tolist()
        return outputs

    def arrival_tape(self) -> Tape:
        """Return (q, v, θ̇) ↦ what `Points` holds of q ⊕ v.

        That is q ⊕ v, the gap in m, ‖K*⁻¹‖, ‖[K K*]‖, the sizes of two motions, a rad counted as
        one length, and these, (nv,) in the units of v: Newton's step, and −K*⁻¹ K θ̇ beside θ̇.
        """
        return self.recordings.tape("arrival", self.arrival_inputs, self.arrival)

    @property
    def arrival_inputs(self) -> int:
        """How many numbers `arrival_tape` is a function of."""
        return int(self.recorder.nq + self.recorder.nv + self.partition.actuated.size)

    def arrival(self, inputs: Sequence[Term]) -> list[Any]:
        """Record `arrival_tape`."""
        nq, nv = self.recorder.nq, self.recorder.nv
        start, v, rates = np.split(objects(inputs), [nq, nq + nv])
        q = moved_by(PROGRAMS, self.recorder.tree, start, v)
        known, motions = self._point(q.tolist(), rates)
        sizes = [norm(motion) for motion in motions]
        moves = (motions * self.partition.column_scale).ravel()
        return [*q, *known, *sizes, *moves]

    def _point(self, q: Sequence[Any], rates: Numbers) -> tuple[list[Any], Numbers]:
        """Return gap and norms, and the dimensionless Newton step and path velocity, (2, nv)."""
        motors, scale = self.partition.actuated, self.partition.column_scale
        kinematics = self.recorder.loops_at(q)
        matrix = self.scaled(kinematics.rates)
        error = kinematics.residual * self.partition.row_scale
        gap = self.gap(kinematics)
        driven = matrix[:, motors] @ (rates / scale[motors])
        count = self.kept.size
        triangle = Triangle.of(np.column_stack([matrix[:, self.kept], error, driven]), count)
        motions = zeros(2, scale.size)
        motions[:, self.kept] = -triangle.solve([count, count + 1]).T
        if self.idle:
            motions = smallest(motions.T, idle_motions(matrix, self.idle)[0]).T
        motions[1, motors] = rates / scale[motors]
        return [gap, triangle.inverse_norm(), norm(matrix)], motions

    def jacobian_tape(self, frame: FrameName) -> Tape:
        """Return q ↦ (gap, ‖K*⁻¹‖, ‖[K K*]‖, forbidden, felt, ‖J‖, spread, J_eq).

        `forbidden` is what K* cannot follow of K, `felt` what idle motions do to the tool: norms
        that vanish where J_eq exists. J_eq is (6, n), in a frame.
        """

        def make(q: Sequence[Term]) -> list[Any]:
            return self.equivalent(self.recorder.at(q), frame).judged()

        return self.recordings.tape(f"jacobian {frame}", self.recorder.nq, make)

    def pose_tape(self) -> Tape:
        """Return q ↦ (those of `jacobian_tape`, tool (12,), and in a second stage sizes (2,)).

        Of the tool the position and the rotation (3, 3); sizes as of `ellipsoids_tape`: they need
        the rates of all joints, J_eq of those alone that carry the tool.
        """

        def make(q: Sequence[Term]) -> list[Any]:
            kinematics = self.recorder.at(q)
            found = self.equivalent(kinematics, "LOCAL_WORLD_ALIGNED")
            tool = [*kinematics.position, *kinematics.rotation.ravel()]
            return [*found.judged(), *tool, *found.sizes()]

        first = DOUBTS + 6 * self.partition.actuated.size + 12
        return self.recordings.tape("pose", self.recorder.nq, make, (first, first + 2))

    def ellipsoids_tape(self) -> Tape:
        """Return q ↦ (those of `jacobian_tape`, sizes (2,)).

        Sizes are what the entries of J_eq are compared with, linear and angular.
        """

        def make(q: Sequence[Term]) -> list[Any]:
            found = self.equivalent(self.recorder.at(q), "LOCAL_WORLD_ALIGNED")
            return [*found.judged(), *found.sizes()]

        return self.recordings.tape("ellipsoids", self.recorder.nq, make)

    def measures_tape(self) -> Tape:
        """Return q ↦ (those of `jacobian_tape`, sizes (3,), tool (12,), (k, m_p) entries).

        Sizes are ‖[K K*]‖, and what the entries of J_eq are compared with, linear and angular;
        of the tool the position and the rotation (3, 3); the last are of a matrix that has the
        singular values of the dimensionless K*.
        """
        return self.recordings.tape("measures", self.recorder.nq, self.measures)

    def measures(self, q: Sequence[Term]) -> list[Any]:
        """Record `measures_tape`."""
        kinematics = self.recorder.at(q)
        found = self.equivalent(kinematics, "LOCAL_WORLD_ALIGNED")
        sizes = [found.size, *found.sizes()]
        tool = [*kinematics.position, *kinematics.rotation.ravel()]
        return [*found.judged(), *sizes, *tool, *found.likeness.ravel()]

    def slopes_tape(self) -> Tape:
        """Return (q, v) ↦ how [K K*] (p, nv) and the tool change along v, and the tool.

        In world axes; of the tool the Jacobian (6, nv) in LOCAL_WORLD_ALIGNED, the rotation (3, 3)
        and the position.
        """
        nq = self.recorder.nq

        def make(inputs: Sequence[Term]) -> list[Any]:
            kinematics = self.recorder.at(inputs[:nq])
            tool = [*kinematics.tool.ravel(), *kinematics.rotation.ravel(), *kinematics.position]
            of = [*kinematics.in_world()[1].ravel(), *tool]
            along = entry_rates(self.recorder.tree, objects(inputs[:nq]), objects(inputs[nq:]))
            return [*tangents(of, inputs[:nq], along.tolist()), *tool]

        return self.recordings.tape("slopes", nq + self.recorder.nv, make)

    def equivalent(self, kinematics: RecordedKinematics, frame: FrameName) -> RecordedEquivalent:
        """Return J_eq in a frame, and what says whether it exists."""
        partition, motors = self.partition, self.partition.actuated
        matrix = self.scaled(kinematics.rates)
        idle = np.setdiff1d(partition.passive, self.kept)
        followed, count = np.concatenate([idle, motors]), self.kept.size
        triangle = Triangle.of(np.hstack([matrix[:, self.kept], matrix[:, followed]]), count)
        rates = triangle.solve(range(count, count + followed.size))
        tool = in_frame(kinematics, frame) * partition.column_scale
        carried = tool[:, followed] - tool[:, self.kept] @ rates
        scale = partition.column_scale[motors]
        judged = np.vstack([tool[:3], tool[3:] * partition.length])
        felt = np.vstack([carried[:3], carried[3:] * partition.length])[:, : idle.size]
        forbidden = triangle.matrix[
            np.ix_(triangle.left_over, range(count + idle.size, count + followed.size))
        ]
        return RecordedEquivalent(
            gap=self.gap(kinematics),
            inverse=triangle.inverse_norm(),
            size=norm(matrix),
            forbidden=norm(forbidden),
            felt=norm(felt),
            tool=norm(judged),
            spread=kinematics.spread,
            turning=norm(tool[3:]),
            motions=norm(np.vstack([np.eye(motors.size), rates[:, idle.size :]]) / scale),
            J_eq=carried[:, idle.size :] / scale,
            likeness=matrix[:, partition.passive] if idle.size else triangle.triangle(),
        )


def in_frame(kinematics: RecordedKinematics, frame: FrameName) -> Numbers:
    """Return the tool's Jacobian in one of Pinocchio's frames."""
    return change_frame(kinematics.tool, frame, kinematics.rotation, kinematics.position)
