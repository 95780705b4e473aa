"""LoopEquations: all loop equations of a mechanism, enclosed at a pose."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np
import pinocchio as pin
from flint import arb
from numpy.typing import NDArray

from pmjac_pin.algebra.balls import ZERO, exactly
from pmjac_pin.kinematics.joints import Motion
from pmjac_pin.kinematics.loops import pair_of
from pmjac_pin.kinematics.tree import Link, Poses, Tree
from pmjac_pin.model.coupling import Coupling, couple
from pmjac_pin.model.loop_spec import JointLoop, Loop
from pmjac_pin.model.rows import Rows
from pmjac_pin.studies.certificates.chains import BALLS, Chain
from pmjac_pin.studies.certificates.kantorovich import System
from pmjac_pin.studies.certificates.rows import Bend, Enclosed, enclosed_rows
from pmjac_pin.studies.certificates.unknowns import Unknowns

Array = NDArray[np.float64]


class LoopEquations:
    """The loop equations as functions of the passive joints, the motors held.

    Parameters
    ----------
    model : pin.Model
    loops : sequence of Loop
    values : mapping of str to float
        The parameters' values, for lengths that depend on them.
    passive : sequence of int
        Columns of the unknowns, in their order.

    Raises
    ------
    ArgumentError
        A joint of a kind that cannot be taken apart.

    Attributes
    ----------
    unknowns : Unknowns
    """

    __slots__ = ("_loops", "_passive", "_tree", "unknowns")

    def __init__(
        self,
        model: pin.Model,
        loops: Sequence[Loop],
        values: Mapping[str, float],
        passive: Sequence[int],
    ) -> None:
        self._tree = Tree(model)
        self._passive = {column: k for k, column in enumerate(passive)}
        links = self._tree.links
        edges = {body: link.edge for body, link in links.items()}
        starts = {
            body: self._passive[link.column]
            for body, link in links.items()
            if link.column in self._passive
        }
        self.unknowns = Unknowns(edges, starts)
        self._loops: list[tuple[Chain, Chain, list[Rows]] | Coupling] = []
        for loop in loops:
            if isinstance(loop, JointLoop):
                self._loops.append(couple(model, loop))
                continue
            pair = pair_of(model, self._tree, loop, values)
            one, other = (
                Chain(self._tree, pair.base, frame, self.unknowns)
                for frame in (pair.first, pair.second)
            )
            self._loops.append((one, other, [block for _, block in pair.blocks]))

    def enclosed(self, q: Array) -> list[Enclosed]:
        """Enclose the blocks of rows at q, in the order of `Mechanism.rows`."""
        entries = exactly(q)[:, None, None]

        def motion(link: Link) -> Motion:
            return link.kind.motion(BALLS, entries[link.entries], link.edge.pitch)

        poses, blocks = Poses(self._tree, BALLS, motion), []
        for loop in self._loops:
            if isinstance(loop, Coupling):
                blocks.append(self._coupled(loop, q))
                continue
            first, second, rows = loop
            one, other = first.seen(poses), second.seen(poses)
            blocks += [enclosed_rows(block, one, other, self._passive) for block in rows]
        return blocks

    def system(self, blocks: Sequence[Enclosed], length: float) -> System:
        """Return all rows together, one unit of the unknowns being 1 rad or the length in m."""
        unit, count = self.unknowns.scale(length), self.unknowns.count
        groups = [group.columns for group in self.unknowns.groups]
        scale = np.empty(count)
        for group, size in zip(groups, unit.tolist(), strict=True):
            scale[list(group)] = size
        nothing = np.zeros((0, count), dtype=object)
        return System(
            np.concatenate([np.zeros(0, dtype=object), *(block.residual for block in blocks)]),
            np.vstack([nothing, *(block.jacobian for block in blocks)]) * exactly(scale),
            groups,
            np.repeat(np.arange(len(blocks)), [block.residual.size for block in blocks]),
            [block.bend.bound(unit, unit, length) for block in blocks],
        )

    def _coupled(self, coupling: Coupling, q: Array) -> Enclosed:
        """Enclose a gear's equation, which is linear."""
        first, second = (self._value(column, q) for column in coupling.columns.tolist())
        residual = second - arb(coupling.ratio) * first - arb(coupling.offset)
        if coupling.coordinates.wraps[coupling.columns[1]]:
            turns = round((float(residual.mid())) / math.tau)
            residual -= 2 * turns * arb.pi()
        jacobian = np.full((1, self.unknowns.count), ZERO, dtype=object)
        for column, slope in enumerate(exactly(coupling.gradient)):
            if column in self._passive:
                jacobian[0, self._passive[column]] = slope
        return Enclosed(np.array([residual], dtype=object), jacobian, Bend())

    def _value(self, column: int, q: Array) -> arb:
        """Return the value of a joint of one degree of freedom."""
        link = next(one for one in self._tree.links.values() if one.column == column)
        entries = exactly(q[link.entries])
        return entries[0] if entries.size == 1 else arb.atan2(entries[1], entries[0])
