"""AnchoredLoop: one frame of a loop seen from the other, by Pinocchio's anchor constraints."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple, TypeAlias

import numpy as np
import pinocchio as pin

from pmjac_pin.errors import ArgumentError
from pmjac_pin.model.frames import Frame
from pmjac_pin.model.loop_between_frames import LoopBetweenFrames
from pmjac_pin.model.rows import Distance, Gap, Rows
from pmjac_pin.values.arrays import Array


class Relative(NamedTuple):
    """The first frame seen from the second, (R, p), with ṗ = P v and Ṙ = [W v]ₓ R.

    Attributes
    ----------
    gap, gap_rates : ndarray, shapes (3,) and (3, nv)
        p and P, m.
    rotation, turning : ndarray, shapes (3, 3) and (3, nv)
        R and W, rad; for frames only.
    """

    gap: Array
    gap_rates: Array
    rotation: Array | None = None
    turning: Array | None = None

    def axis(self, given: Array) -> tuple[Array, Array]:
        """Return R·given (3,), and its derivative (3, nv)."""
        axis = np.asarray(self.rotation).dot(given)
        return axis, -pin.skew(axis).dot(np.asarray(self.turning))

    def turn(self) -> tuple[Array, Array]:
        """Return log R and J_log(R) Rᵀ W: Pinocchio's J_log takes the rate in R's own axes."""
        rotation = np.asarray(self.rotation)
        return pin.log3(rotation), pin.Jlog3(rotation) @ rotation.T @ self.turning


@dataclass(frozen=True, slots=True)
class AnchoredLoop:
    """One loop between two frames: its anchors, its blocks, and the row where each starts."""

    constraint: Any  # pin.PointAnchorConstraintModel or pin.FrameAnchorConstraintModel
    blocks: tuple[tuple[slice, Rows], ...]
    body: int  # Pinocchio's index of the joint that carries the second frame
    base: int  # ... of the last joint that carries both frames, 0 for the world
    vectors: tuple[slice, ...]  # the rows of blocks that turn with the axes
    frames: tuple[int, int]  # Pinocchio's indices of the first frame and the second

    def placed(
        self, model: pin.Model, places: Mapping[int, pin.SE3], rows: Sequence[Rows]
    ) -> AnchoredLoop:
        """Return the loop with these rows, its frames at these places where they have one."""
        here, (first, second) = self.constraint, self.frames
        ends = (
            (here.joint1_id, places.get(second, here.joint1_placement)),
            (here.joint2_id, places.get(first, here.joint2_placement)),
        )
        there = type(here)(model, *ends[0], *ends[1])
        slices = (own for own, _ in self.blocks)
        return replace(self, constraint=there, blocks=tuple(zip(slices, rows, strict=True)))

    def relative(self, model: pin.Model, data: pin.Data, scratch: Any) -> Relative:
        """Return the first frame seen from the second, as `data` has them."""
        # Without `calc` the constraint's Jacobian is silently the one of another q.
        self.constraint.calc(model, data, scratch)
        rates = self.constraint.jacobian(model, data, scratch)
        rates = rates.reshape(rates.shape[0], -1)  # a vector where there is one degree of freedom
        if rates.shape[0] == 3:
            return Relative(scratch.constraint_position_error, rates)
        gap, turning = scratch.c1Mc2.translation, rates[3:]
        gap_rates = rates[:3] - pin.skew(gap).dot(turning)  # ṗ = v + ω × p
        return Relative(gap, gap_rates, scratch.c1Mc2.rotation, turning)


Axes: TypeAlias = Callable[[AnchoredLoop, pin.Data, Any], Array | None]


def in_anchors(closure: AnchoredLoop, data: pin.Data, loop_data: Any) -> Array | None:
    """Return None: the rows stay as they are."""
    return None


def in_world(closure: AnchoredLoop, data: pin.Data, loop_data: Any) -> Array | None:
    """Return the axes of the second frame in the world."""
    rotation: Array = loop_data.oMc1.rotation
    return rotation


def from_base(closure: AnchoredLoop, data: pin.Data, loop_data: Any) -> Array | None:
    """Return the same seen from the last body that carries both frames; None where it is one."""
    if closure.base == closure.body:
        return None
    rotation: Array = loop_data.oMc1.rotation
    return data.oMi[closure.base].rotation.T.dot(rotation) if closure.base else rotation


def anchored(
    model: pin.Model,
    loop: LoopBetweenFrames,
    frames: Sequence[Frame],
    blocks: tuple[tuple[slice, Rows], ...],
) -> AnchoredLoop:
    """Build the anchors. Pinocchio's gap is its second minus its first, ours opposite."""
    first, second = frames
    if first.joint == second.joint:
        names = " and ".join(map(repr, loop.frames))
        raise ArgumentError(
            f"the frames {names} of a loop are on one body: nothing moves them apart"
        )
    points_only = all(isinstance(block, Gap | Distance) for _, block in blocks)
    anchors = pin.PointAnchorConstraintModel if points_only else pin.FrameAnchorConstraintModel
    constraint = anchors(model, second.joint, second.placement, first.joint, first.placement)
    one, other = (list(model.supports[frame.joint]) for frame in (first, second))
    base = [a for a, b in zip(one, other, strict=False) if a == b][-1]
    vectors = tuple(rows for rows, block in blocks if block.vector)
    indices = first.index, second.index
    return AnchoredLoop(constraint, blocks, second.joint, base, vectors, indices)
