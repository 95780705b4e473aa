"""FreeCells: a box of motor values about a pose, covered by cells on each of which K* is regular.

A cell has a closed pose in its middle from which `BallBounds` proves one closed pose for all motor
values in it, or is halved. On the face between two cells both proofs must speak of the same pose:
with r the least radius about the first that holds the pose over all of its cell, and R the largest
about the second that holds no other, they do where their middles are at most R − r apart. As each
is continuous on the face, once is enough. So what motors lead to from the pose, however they move
in the box, is in these balls, and K* is regular there.

Cells lie on a grid with the pose in the middle of one, and shells of them are added.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product

import numpy as np
import pinocchio as pin

from pmjac_pin.configuration import Configuration
from pmjac_pin.errors import PmjacError
from pmjac_pin.kinematics.tree import Tree
from pmjac_pin.studies.certificates.equations import LoopEquations
from pmjac_pin.studies.certificates.tool_rates import ToolRates
from pmjac_pin.studies.singularities.ball_bounds import BallBounds
from pmjac_pin.values.arrays import Array

_HALVED = 4  # times, a cell of the grid
_MORE_THAN_ROUNDED = 1e-9  # rad: more than that of motor values and of changes between poses


@dataclass(frozen=True, slots=True, eq=False)
class Cell:
    """A box of motor values with one closed pose for each.

    Attributes
    ----------
    middle : ndarray, shape (n,)
        From the pose, rad or lengths.
    half : float
        Half of its width.
    q : ndarray, shape (nq,)
        The closed pose in the middle.
    least, alone : float
        Within which of it the closed poses of the cell are, and no others: r and R.
    """

    middle: Array
    half: float
    q: Array
    least: float
    alone: float


class FreeCells:
    """The cells about a pose.

    Parameters
    ----------
    equations : LoopEquations
    configuration : Configuration
    bounds : BallBounds
        About the pose.
    most : int
        How many balls may be tried.
    tool : ToolRates, optional
        What the tool may not lose either.
    """

    def __init__(
        self,
        equations: LoopEquations,
        configuration: Configuration,
        bounds: BallBounds,
        most: int,
        tool: ToolRates | None = None,
    ) -> None:
        self._equations, self._here, self._kept = equations, configuration, bounds.kept
        self._most, self.tried, self._tool = most, 1, tool
        mechanism = configuration.mechanism
        self._model, partition = mechanism.kinematics.model, mechanism.problem.partition
        self._links = list(Tree(self._model).links.values())
        self._passive = partition.passive
        units = np.array(partition.units_of(partition.actuated))
        self._stride = np.where(units == "m", partition.length, 1.0)
        self._unit = equations.unknowns.scale(partition.length)[: self._passive.size]
        self._groups = equations.unknowns.groups[:, : self._passive.size]

    def grown(self, half: float) -> tuple[float, float]:
        """Return half the width of the largest box that is proven, and how far its poses are.

        The latter counts from the pose, for passive joints.

        Parameters
        ----------
        half : float
            Half the width of the grid's cells, proven for the one about the pose.
        """
        found = self._proven(np.zeros(self._stride.size), half)
        cells = [] if found is None else [found]
        shells = 0
        while cells and (more := self._agreeing(cells, shells + 1, half)) is not None:
            cells, shells = cells + more, shells + 1
        passive = max((self._apart(cells[0], cell) + cell.least for cell in cells), default=0.0)
        return (2 * shells + 1) * half if cells else 0.0, passive

    def _agreeing(self, before: list[Cell], number: int, half: float) -> list[Cell] | None:
        """Return a shell that agrees with the cells before it, of cells as large as will do."""
        for halved in range(_HALVED):
            more = self._shell(number, half, halved)
            if more is None or self._agree(before, more):
                return more
        return None

    def _shell(self, number: int, half: float, halved: int) -> list[Cell] | None:
        """Return the cells around those before, None where one is not proven."""
        steps, found = range(-number, number + 1), []
        for place in product(steps, repeat=self._stride.size):
            if max(map(abs, place)) == number:
                cells = self._covered(2.0 * half * np.array(place, dtype=float), half, halved)
                if cells is None:
                    return None
                found += cells
        return found

    def _covered(
        self, middle: Array, half: float, halved: int, most: int = _HALVED
    ) -> list[Cell] | None:
        """Return proven cells that make up one, halved so often at least, None for too many."""
        if halved <= 0 and (cell := self._proven(middle, half)) is not None:
            return [cell]
        if not most or self.tried >= self._most:
            return None
        found: list[Cell] = []
        for side in product((-0.5, 0.5), repeat=middle.size):
            part = middle + half * np.array(side)
            cells = self._covered(part, 0.5 * half, halved - 1, most - 1)
            if cells is None:
                return None
            found += cells
        return found

    def _proven(self, middle: Array, half: float) -> Cell | None:
        if self.tried >= self._most:
            return None
        self.tried += 1
        target = self._here.actuated + self._stride * middle
        try:
            there = self._here.mechanism.close(target, self._here, enforce_limits=False)
        except PmjacError:
            return None
        bounds = BallBounds(self._equations, there, self._kept, self._tool)
        least, alone = bounds.passive_radii(half + _MORE_THAN_ROUNDED)
        return Cell(middle, half, there.q, least, alone) if alone else None

    def _agree(self, before: list[Cell], more: list[Cell]) -> bool:
        """Tell whether new cells speak of the same poses as all that they have a face with."""
        pairs = [(one, other) for k, one in enumerate(more) for other in before + more[:k]]
        return all(self._same(*pair) for pair in pairs if _touch(*pair))

    def _same(self, one: Cell, other: Cell) -> bool:
        far = self._apart(one, other) + _MORE_THAN_ROUNDED
        return far + one.least <= other.alone or far + other.least <= one.alone

    def _apart(self, one: Cell, other: Cell) -> float:
        """Return how far the passive joints of two poses are from each other: the largest group."""
        change = pin.difference(self._model, one.q, other.q)
        for link in self._links:
            if link.kind.nv > 1 and link.kind.slides:  # along axes that stand still
                entries = range(link.entries.start, link.entries.start + link.kind.slides)
                slid = other.q[list(entries)] - one.q[list(entries)]
                change[link.column : link.column + link.kind.slides] = slid
        steps = change[self._passive] / self._unit
        return float(np.sqrt(self._groups @ steps**2).max(initial=0.0))


def _touch(one: Cell, other: Cell) -> bool:
    """Tell whether two cells have a face in common, of which more than an edge."""
    gaps = np.abs(one.middle - other.middle) - (one.half + other.half)
    tiny = _MORE_THAN_ROUNDED * (one.half + other.half)
    return bool((gaps <= tiny).all() and np.count_nonzero(gaps > -tiny) <= 1)
