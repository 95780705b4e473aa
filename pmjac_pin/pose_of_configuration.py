"""A configuration as its Jacobians see it: loop rates, rounding, and how they change around it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from pmjac_pin.closing.pose_margins import PoseMargins
from pmjac_pin.model.frames import carrying_columns, find_frame
from pmjac_pin.model.loop_spec import JointLoop
from pmjac_pin.rates.error_estimate import EPS
from pmjac_pin.values.arrays import Array, Mask, norm

if TYPE_CHECKING:
    from pmjac_pin.configuration import Configuration
    from pmjac_pin.model.twist_frame import FrameName
    from pmjac_pin.rates.margins import Margins
    from pmjac_pin.rates.partition import LoopRates
    from pmjac_pin.rates.singularity import Singularity


_PLACES = 16.0  # units in the last place of a length: what chains of joints add up to
_JOINTS = 4.0  # units in the last place of where each joint of a chain is
_DIFFERENCE = 1e-7  # of the length: for differences, between what is curved and what is rounding


class PoseOfConfiguration(NamedTuple):
    """The `JacobianPose` that a configuration is, its twists in a frame."""

    configuration: Configuration
    frame: FrameName

    def loop_rates(self) -> LoopRates:
        """Return [K K*] there without dimension, and K* factorised."""
        return self.configuration._loop_rates

    def opened(self) -> Array:
        """Return by how much each row is open, m, shape (p,): its gap, and what rounding hides.

        Rounding of the places that the loops rest on, where the machine stands; of a length of its
        own; and of the joint values, each times what it moves.
        """
        configuration = self.configuration
        parts, snapshot = configuration.mechanism._parts, configuration._snapshot
        partition = parts.problem.partition
        values = np.abs(parts.coordinates.values(configuration.q))
        rows = partition.row_scale[:, None] * snapshot.constraint_jacobian
        opened = np.abs(partition.row_scale * snapshot.residual)
        opened += _PLACES * EPS * partition.length + EPS * np.linalg.norm(rows * values, axis=1)
        loops = zip(
            parts.kinematics.loops.slices, parts.spec.loops, partition.loop_sizes, strict=True
        )
        for at, loop, size in loops:
            if not isinstance(loop, JointLoop):
                opened[at] += self._rounded_places(loop.frames) * partition.length / size
        return opened

    def sizes(self) -> Array | None:
        """Return `TwistMap.sizes` of J_eq there, None where no program has told them."""
        configuration = self.configuration
        home = configuration._parts.problem
        if configuration._known is None or configuration.problem is not home:
            return None
        return configuration.mechanism.recorded.sizes(configuration.q, self.frame)

    def places(self) -> float:
        """Return what rounding of places moves the tool by, m."""
        parts = self.configuration.mechanism._parts
        return (
            self._rounded_places(parts.spec.tool.names)
            + _PLACES * EPS * parts.problem.partition.length
        )

    def _rounded_places(self, frames: Sequence[str]) -> float:
        """Return what rounding of places moves frames by, m: theirs, and of joints on the way.

        It is no less than that of where the machine stands, as its model was given.
        """
        parts = self.configuration.mechanism._parts
        partition, given = parts.problem.partition, parts.problem.rounding
        given *= min(partition.loop_sizes, default=partition.length) / partition.length
        found = [find_frame(parts.model, name) for name in frames]
        data = parts.kinematics.placed(self.configuration.q)
        joints = {k for frame in found for k in parts.model.supports[frame.joint]}
        far = [norm(data.oMi[k].translation) for k in joints]
        ends = [norm(data.oMf[frame.index].translation) for frame in found]
        return max(given, EPS * (_PLACES * max(far + ends) + _JOINTS * sum(far)))

    def moving(self) -> tuple[Mask, Mask]:
        """Return which columns are not always 0, in each row, (p, nv), and of the tool, (nv,)."""
        parts = self.configuration.mechanism._parts
        loops = parts.kinematics.loops
        rows = np.zeros((len(loops.row_units), parts.model.nv), dtype=bool)
        for at, columns in zip(loops.slices, loops.moving, strict=True):
            rows[at, columns] = True
        for row, coupling in loops.couplings.items():
            rows[row, coupling.columns] = True
        return rows, carrying_columns(parts.model, parts.spec.tool.names)

    def slopes(self, motions: Array) -> tuple[Array, Array]:
        """Return how the constraint and the tool Jacobian change along motions, (nv, k)."""
        here = self.configuration
        along = here.mechanism.recorded.slopes() or here.mechanism.slopes
        if along is not None:
            found = along.at(here.q, motions)
            return found.constraint, found.tool(self.frame)
        return self._by_differences(motions)

    def margins(self, ranks: Singularity) -> Margins:
        """Return the margins of the pose, of its ranks."""
        here = self.configuration
        return PoseMargins(here.mechanism._parts, here.problem.partition, here.q).found(ranks)

    def _by_differences(self, motions: Array) -> tuple[Array, Array]:
        """Return the same of joints that only Pinocchio knows, to half of the digits."""
        here, parts = self.configuration, self.configuration.mechanism._parts
        first = here._jacobians(here._snapshot, self.frame)
        constraint = np.empty((motions.shape[1], *first[0].shape))
        tool = np.empty((motions.shape[1], *first[1].shape))
        for k, motion in enumerate(motions.T):
            size = norm(motion / parts.problem.partition.column_scale)
            step = _DIFFERENCE * parts.problem.partition.length / (size or 1.0)
            snapshot = parts.kinematics.snapshot(parts.problem.integrate(here.q, step * motion))
            second = here._jacobians(snapshot, self.frame)
            constraint[k], tool[k] = ((b - a) / step for a, b in zip(first, second, strict=True))
        return constraint, tool
