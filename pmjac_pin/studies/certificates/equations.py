"""LoopEquations: all loop equations of a mechanism at a pose, and their derivatives around it."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import pinocchio as pin
from flint import arb

from pmjac_pin.algebra.balls import ZERO, BallArray, exactly
from pmjac_pin.algebra.intervals import Intervals
from pmjac_pin.algebra.jets import Jets
from pmjac_pin.kinematics.loops import Loops
from pmjac_pin.kinematics.tree import Link, Poses, Tree
from pmjac_pin.model.coupling import Coupling
from pmjac_pin.model.joint_kind import JointMotion
from pmjac_pin.model.loop_spec import Loop
from pmjac_pin.studies.certificates.chains import BALLS, WIDE_BOXES, Chain
from pmjac_pin.studies.certificates.neighbourhoods import Neighbourhoods
from pmjac_pin.studies.certificates.unknowns import Unknowns
from pmjac_pin.values.arrays import Array


@dataclass(frozen=True, slots=True, eq=False)
class Around:
    """The derivatives of all rows over nested neighbourhoods of a pose.

    Attributes
    ----------
    jacobian : Intervals, shape (b, p, n)
        One unit of the unknowns is 1 rad or the characteristic length.
    cosine : ndarray, shape (b,)
        The least cosine between axes that the rows want to coincide.
    """

    jacobian: Intervals
    cosine: Array


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

    __slots__ = ("_chains", "_loops", "_tree", "unknowns")

    def __init__(
        self,
        model: pin.Model,
        loops: Sequence[Loop],
        values: Mapping[str, float],
        passive: Sequence[int],
    ) -> None:
        self._tree = Tree(model)
        self._loops = Loops(model, self._tree, loops, values)
        self.unknowns = Unknowns(self._tree.links.values(), passive)
        self._chains = [
            tuple(
                Chain(self._tree, pair.base, frame, self.unknowns)
                for frame in (pair.first, pair.second)
            )
            for pair in self._loops.pairs
        ]

    @property
    def geared(self) -> bool:
        """Whether gears tie joints."""
        return bool(self._loops.couplings)

    def at(self, q: Array) -> Poses:
        """Return the poses at q, in balls."""
        entries = exactly(q)[:, None, None]

        def motion(link: Link) -> JointMotion:
            return link.kind.motion(BALLS, entries[link.entries], link.edge.pitch)

        return Poses(self._tree, BALLS, motion)

    def residual(self, at: Poses, q: Array) -> BallArray:
        """Return the rows at q, in the order of `Mechanism.rows`, shape (p,)."""
        found = np.full(self._loops.count, ZERO, dtype=object)
        jets = Jets(BALLS)
        for pair, chains in zip(self._loops.pairs, self._chains, strict=True):
            one, other = (chain.at(at) for chain in chains)
            for rows, block in pair.blocks:
                found[rows] = block.equations(jets, one, other).rows.value[:, 0, 0]
        for row, coupling in self._loops.couplings.items():
            found[row] = self._coupled(coupling, q)
        return found

    def around(self, at: Poses, radii: Array, length: float) -> Around:
        """Return the derivatives up to some radii, shape (b,), from a pose.

        Parameters
        ----------
        at : Poses
        radii : ndarray
            rad
        length : float
            How far one unit slides, m.
        """
        places = self.unknowns.places
        poses = Neighbourhoods(WIDE_BOXES, at, places, radii, np.nextafter(radii * length, np.inf))
        shape = (len(radii), self._loops.count, len(places))
        lower, upper = np.zeros(shape), np.zeros(shape)
        cosine, jets = np.ones(len(radii)), Jets(WIDE_BOXES)
        for pair, chains in zip(self._loops.pairs, self._chains, strict=True):
            one, other = (chain.around(poses) for chain in chains)
            for rows, block in pair.blocks:
                found = block.equations(jets, one, other)
                columns = [places[column] for column in found.rows.columns]
                if columns:
                    lower[:, rows, columns] = np.moveaxis(found.rows.rates.lower, -1, 0)
                    upper[:, rows, columns] = np.moveaxis(found.rows.rates.upper, -1, 0)
                if found.cosine is not None:
                    cosine = np.minimum(cosine, found.cosine.value.lower[0])
        for row, coupling in self._loops.couplings.items():
            for column, place in places.items():
                lower[:, row, place] = upper[:, row, place] = coupling.gradient[column]
        scale = Intervals.exact(self.unknowns.scale(length))
        return Around(Intervals(lower, upper) * scale, cosine)

    def _coupled(self, coupling: Coupling, q: Array) -> arb:
        """Enclose a gear's equation, which is linear."""
        first, second = (self._value(column, q) for column in coupling.columns.tolist())
        return coupling.equation(first, second, _less_whole_turns)

    def _value(self, column: int, q: Array) -> arb:
        """Return the value of a joint of one degree of freedom."""
        link = next(one for one in self._tree.links.values() if one.column == column)
        entries = exactly(q[link.entries])
        return entries[0] if entries.size == 1 else arb.atan2(entries[1], entries[0])


def _less_whole_turns(angle: arb) -> arb:
    return angle - 2 * round(float(angle.mid()) / math.tau) * arb.pi()
