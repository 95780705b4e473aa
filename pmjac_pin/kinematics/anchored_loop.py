"""AnchoredLoop: one frame of a loop seen from the other, by Pinocchio's anchor constraints."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

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
    gap: slice | None  # the rows of a loop whose only equation is p, as most have it

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


def relative(scratch: Any, rates: Array) -> Relative:
    """Return the first frame seen from the second, of what its constraint has computed."""
    if len(rates) == 3:
        return Relative(scratch.constraint_position_error, rates)
    gap, turning = scratch.c1Mc2.translation, rates[3:]
    gap_rates = rates[:3] - pin.skew(gap).dot(turning)  # ṗ = v + ω × p
    return Relative(gap, gap_rates, scratch.c1Mc2.rotation, turning)


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
    gap = vectors[0] if len(blocks) == 1 and isinstance(blocks[0][1], Gap) else None
    return AnchoredLoop(constraint, blocks, second.joint, base, vectors, indices, gap)
