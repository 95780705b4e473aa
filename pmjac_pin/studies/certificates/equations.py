"""LoopEquations: all loop equations of a mechanism, enclosed at a pose."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np
import pinocchio as pin
from flint import arb
from numpy.typing import NDArray

from pmjac_pin.kinematics.loops import loop_blocks
from pmjac_pin.kinematics.rows import Rows
from pmjac_pin.model.coupling import Coupling, couple
from pmjac_pin.model.frames import find_frame
from pmjac_pin.model.linkage import edges_of
from pmjac_pin.model.loop_spec import JointLoop, Loop
from pmjac_pin.studies.certificates.chains import Chain, chains_of
from pmjac_pin.studies.certificates.intervals import ZERO, exactly
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

    __slots__ = ("_couplings", "_loops", "_model", "_passive", "unknowns")

    def __init__(
        self,
        model: pin.Model,
        loops: Sequence[Loop],
        values: Mapping[str, float],
        passive: Sequence[int],
    ) -> None:
        edges = {edge.child: edge for edge in edges_of(model).values()}
        self._model = model
        self._passive = {column: k for k, column in enumerate(passive)}
        starts = {
            joint.id: self._passive[joint.idx_v]
            for joint in list(model.joints)[1:]
            if joint.idx_v in self._passive
        }
        self.unknowns = Unknowns(edges, starts)
        self._loops: list[tuple[Chain, Chain, list[Rows]] | Coupling] = []
        for loop in loops:
            if isinstance(loop, JointLoop):
                self._loops.append(couple(model, loop))
                continue
            first, second = (find_frame(model, name) for name in loop.frames)
            chains = chains_of(model, edges, self.unknowns, first, second)
            self._loops.append((*chains, loop_blocks(loop, values)))

    def enclosed(self, q: Array) -> list[Enclosed]:
        """Enclose the blocks of rows at q, in the order of `Mechanism.rows`."""
        blocks = []
        for loop in self._loops:
            if isinstance(loop, Coupling):
                blocks.append(self._coupled(loop, q))
                continue
            first, second, rows = loop
            one, other = first.pose(q), second.pose(q)
            count = self.unknowns.count
            blocks += [enclosed_rows(block, one, other, count) for block in rows]
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
        joint = next(one for one in list(self._model.joints)[1:] if one.idx_v == column)
        entries = exactly(q[joint.idx_q : joint.idx_q + joint.nq])
        return entries[0] if entries.size == 1 else arb.atan2(entries[1], entries[0])
