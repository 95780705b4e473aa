"""Loops: which rows each kind of loop has, and all rows of a mechanism over any number type."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import pinocchio as pin

from pmjac_pin.algebra.jets import Jets
from pmjac_pin.kinematics.tree import Poses, Tree
from pmjac_pin.model.coupling import Coupling, couple
from pmjac_pin.model.frames import Frame, find_frame
from pmjac_pin.model.loop_between_frames import LoopBetweenFrames
from pmjac_pin.model.loop_spec import JointLoop, Loop
from pmjac_pin.model.rows import (
    Equations,
    Rows,
)


@dataclass(frozen=True, slots=True, eq=False)
class Pair:
    """Two frames of the tree and the rows between them.

    Attributes
    ----------
    first, second : Frame
    base : int
        The last body that carries both: the rows are seen from it.
    blocks : tuple of (slice, Rows)
        And which of all rows they are.
    """

    first: Frame
    second: Frame
    base: int
    blocks: tuple[tuple[slice, Rows], ...]


class Loops:
    """The loops of a model as functions of numbers, their rows in the order of the loops.

    Attributes
    ----------
    tree : Tree
    count : int
        Of all rows.
    pairs : tuple of Pair
    couplings : mapping of int to Coupling
        The geared joints, by their row.
    """

    __slots__ = ("count", "couplings", "pairs", "tree")

    def __init__(
        self, model: pin.Model, tree: Tree, loops: Sequence[Loop], values: Mapping[str, float]
    ) -> None:
        self.tree, self.count = tree, 0
        self.couplings: dict[int, Coupling] = {}
        pairs: list[Pair] = []
        for loop in loops:
            if isinstance(loop, JointLoop):
                self.couplings[self.count] = couple(model, loop)
                self.count += 1
            else:
                pairs.append(pair_of(model, tree, loop, values, self.count))
                self.count = pairs[-1].blocks[-1][0].stop
        self.pairs = tuple(pairs)


def pair_of(
    model: pin.Model,
    tree: Tree,
    loop: LoopBetweenFrames,
    values: Mapping[str, float],
    start: int = 0,
) -> Pair:
    """Return a loop's frames and rows, numbered from `start`."""
    first, second = (find_frame(model, name) for name in loop.frames)
    blocks = []
    for block in loop.rows(values):
        rows = slice(start, start + len(block.names))
        blocks.append((rows, block))
        start = rows.stop
    return Pair(first, second, tree.base(first, second), tuple(blocks))


def by_twists(pair: Pair, poses: Poses) -> list[Equations]:
    """Return a pair's blocks with derivatives by all freedoms that move its frames apart."""
    one, other = (poses.twisted(pair.base, frame) for frame in (pair.first, pair.second))
    jets = Jets(poses.algebra)
    return [block.equations(jets, one, other) for _, block in pair.blocks]


def riding(pair: Pair, poses: Poses) -> list[Equations]:
    """Return a pair's blocks with derivatives by the freedoms that ride on the poses."""
    one, other = (poses.riding(pair.base, frame) for frame in (pair.first, pair.second))
    jets = Jets(poses.algebra)
    return [block.equations(jets, one, other) for _, block in pair.blocks]
