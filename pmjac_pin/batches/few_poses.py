"""Few poses of one mechanism, as `Batch` has many: by single calls, where recording does not pay.

Programs take as long to record as some tens of closings. A sweep over dimensions has a mechanism,
and so programs, for each of them, and often but a few poses.
"""

from __future__ import annotations

from dataclasses import fields, replace

import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike

from pmjac_pin.batches.batch import Batch
from pmjac_pin.batches.closing import Closing
from pmjac_pin.batches.one_by_one import jacobian_of_one, measures_of_one
from pmjac_pin.batches.pieces import Progress
from pmjac_pin.batches.results import (
    ManyEllipsoids,
    ManyJacobians,
    ManyMeasures,
    Status,
    empty_arrays,
    shapes_of,
)
from pmjac_pin.mechanism import Mechanism
from pmjac_pin.model.reference_frame import frame_name

# Closed while programs are made: so many, and more for each entry of loops' and tool's Jacobians.
_POSES, _POSES_PER_ENTRY = 10.0, 0.07


class FewPoses(Batch):
    """Few poses of one mechanism: what `Batch` says of them, to rounding."""

    def __init__(self, mechanism: Mechanism) -> None:  # nothing is recorded
        # Bits must not depend on calls before: of one's own, its single calls are the first.
        self.mechanism, self.runs_on = replace(mechanism, _poses={}), "single calls"
        self._closing = Closing(self.mechanism, None)

    def jacobian(
        self,
        q: ArrayLike,
        frame: str | pin.ReferenceFrame = "LOCAL_WORLD_ALIGNED",
        *,
        threads: int | None = None,
        progress: Progress | None = None,
    ) -> ManyJacobians:
        """Return J_eq at closed poses."""
        poses, name = self._checked(self._poses(q)), frame_name(frame)
        J_eq = np.empty((len(poses), 6, len(self.mechanism.actuated)))
        status = np.zeros(len(poses), dtype=np.int8)
        for k, pose in enumerate(poses):
            J_eq[k], status[k] = jacobian_of_one(self.mechanism, pose, name)
        return ManyJacobians(J_eq, status)

    def ellipsoids(
        self, q: ArrayLike, *, threads: int | None = None, progress: Progress | None = None
    ) -> ManyEllipsoids:
        """Return what `Batch.ellipsoids` does."""
        found = self.measures(q)
        return ManyEllipsoids(found.J_eq, found.status, found.velocity_radii, found.angular_radii)

    def measures(
        self, q: ArrayLike, *, threads: int | None = None, progress: Progress | None = None
    ) -> ManyMeasures:
        """Return what `Batch.measures` does."""
        poses = self._checked(self._poses(q))
        shapes = shapes_of(ManyMeasures, len(poses), len(self.mechanism.actuated))
        arrays = empty_arrays(ManyMeasures, shapes)
        for array in arrays:
            array[:] = np.nan if array.dtype == np.float64 else Status.CLOSED
        found = dict(zip((one.name for one in fields(ManyMeasures)), arrays, strict=True))
        for k, pose in enumerate(poses):
            for name, value in measures_of_one(self.mechanism, pose).items():
                found[name][k] = value
        return ManyMeasures(**found)


def batch_of(mechanism: Mechanism, poses: int) -> Batch:
    """Return what computes so many poses soonest."""
    partition = mechanism.problem.partition
    entries = (partition.row_scale.size + 6) * partition.column_scale.size
    few = poses < _POSES + _POSES_PER_ENTRY * entries
    return FewPoses(mechanism) if few else Batch(mechanism)
