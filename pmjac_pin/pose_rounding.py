"""What rounding leaves open at a configuration, and how its Jacobians change around it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from pmjac_pin.rates.error_estimate import EPS
from pmjac_pin.values.arrays import Array, norm

if TYPE_CHECKING:
    from pmjac_pin.configuration import Configuration
    from pmjac_pin.model.twist_frame import FrameName


_PLACES = 16.0  # units in the last place of a length: what chains of joints add up to
_DIFFERENCE = 1e-7  # of the length: for differences, between what is curved and what is rounding


@dataclass(frozen=True, slots=True)
class PoseRounding:
    """A configuration as `EquivalentJacobian.error_estimate` sees it, its twists in a frame."""

    configuration: Configuration
    frame: FrameName

    def opened(self) -> float:
        """Return by how much the loops are open, m: the gap, and what rounding hides of it.

        Rounding of the places that the loops rest on, where the machine stands; of a length of its
        own; and of the joint values, each times what it moves.
        """
        configuration = self.configuration
        problem = configuration.mechanism._parts.problem
        values = np.abs(configuration.mechanism._parts.coordinates.values(configuration.q))
        rows = problem.partition.row_scale[:, None] * configuration._snapshot.constraint_jacobian
        places = problem.rounding + _PLACES * EPS * problem.partition.length
        return configuration.residual_norm + places + EPS * norm(rows * values)

    def slopes(self, motions: Array) -> Iterator[tuple[Array, Array]]:
        """Yield how the constraint and the tool Jacobian change along each motion, per metre."""
        here, problem = self.configuration, self.configuration.mechanism._parts.problem
        step = _DIFFERENCE * problem.partition.length
        first = here._jacobians(here._snapshot, self.frame)
        for motion in motions.T:
            q = problem.integrate(here.q, step * problem.partition.column_scale * motion)
            snapshot = here.mechanism._parts.kinematics.snapshot(q)
            second = here._jacobians(snapshot, self.frame)
            constraint, tool = ((b - a) / step for a, b in zip(first, second, strict=True))
            yield constraint, tool
