"""RandomSearch: batches of random starts, and the bound on what they have not met."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pmjac_pin.errors import ArgumentError
from pmjac_pin.modes.aim import Aim
from pmjac_pin.modes.assembly_modes import Completeness
from pmjac_pin.modes.distinct import Distinct, Signatures
from pmjac_pin.modes.search import ManyClosures, unseen_share
from pmjac_pin.modes.search_problem import SearchProblem
from pmjac_pin.modes.starts import StartSpace

Array = NDArray[np.float64]

_BATCH = 2048
_MOST_MODES = 2000  # more is a motion, not a set of poses


class RandomSearch:
    """The closed poses that random starts lead to.

    Attributes
    ----------
    met : Distinct
    starts : int
        Tried so far.
    """

    def __init__(self, problem: SearchProblem, space: StartSpace, rng: np.random.Generator) -> None:
        self._closures, self._space, self._rng = ManyClosures(problem), space, rng
        self.met = Distinct(Signatures.of(problem, problem.base[None]))
        self.starts = 0
        self._in_a_row, self._question = 0, 0

    @property
    def shares(self) -> list[float]:
        """The share of the starts that led to each pose."""
        return [hits / self.starts for hits in self.met.hits]

    def run(self, count: int) -> None:
        """Try that many further starts.

        Raises
        ------
        ArgumentError
            Poses without end: the loops move with all motors locked.
        """
        closed = self._closures.closed(self._space.draw(self._rng, count))
        if not self.starts:
            self.met = Distinct(Signatures.of(self._closures.problem, closed))
        new = self.met.add(closed)
        self.starts += count
        if new or not self._question:
            self._in_a_row, self._question = 0, self._question + 1
        else:
            self._in_a_row += count
        if len(self.met.q) > _MOST_MODES:
            why = f"{_MOST_MODES} poses were met, as where the loops move with all motors locked"
            raise ArgumentError(f"there are no separate assembly modes here: {why}")

    def until(self, aim: Aim) -> None:
        """Go on until the aim is met, or its budget is spent."""
        while self.starts < aim.most_starts and self._bound(aim) > aim.unseen and aim.wanted():
            self.run(_BATCH)

    def completeness(self, aim: Aim) -> Completeness:
        """Return what the search alone says about what it may have missed."""
        bound = self._bound(aim)
        if bound <= aim.unseen:
            statement = (
                f"statistics: with confidence {aim.confidence:g}, at most {bound:.2g} of the "
                f"start space leads to modes not found, after {self.starts} random starts"
            )
            return Completeness("statistics", statement, bound, aim.confidence)
        statement = (
            f"neither proof nor statistics: new modes were met among the last of {self.starts} "
            f"random starts; the share not seen is bounded by {bound:.2g} only"
        )
        return Completeness("neither", statement, bound, aim.confidence)

    def _bound(self, aim: Aim) -> float:
        return unseen_share(self._in_a_row, self._question, aim.confidence)
