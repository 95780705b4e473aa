"""RandomSearch: batches of random starts, and the bound on what they have not met."""

from __future__ import annotations

import numpy as np

from pmjac_pin.studies.evidence import Evidence
from pmjac_pin.studies.modes.aim import Aim
from pmjac_pin.studies.modes.distinct import Distinct, Signatures
from pmjac_pin.studies.modes.idling import isolated, raised
from pmjac_pin.studies.modes.search import Ends, ManyClosures, unseen_share
from pmjac_pin.studies.modes.search_problem import SearchProblem
from pmjac_pin.studies.modes.starts import StartSpace
from pmjac_pin.values.arrays import Array

_STARTS_AT_ONCE = 2048
_MOST_MODES = 2000  # more is a motion, not a set of poses
_ENOUGH_NEAR = 32  # poses that are nearly closed: that there are any is what counts
_ENOUGH_END = 0.25  # of the starts: where fewer end, what is known of these says little


class RandomSearch:
    """The closed poses that random starts lead to.

    Attributes
    ----------
    met : Distinct
        Closed poses.
    near : Distinct
        Where starts were given up at a gap as small as rounded numbers leave.
    starts : int
        Tried so far.
    moving : bool
        The loops move with all motors locked: poses without end were met. Those that are
        separate from that motion are left in `modes`.
    undecided : int
        Starts that neither closed nor came to where no step brings them nearer.
    """

    def __init__(self, problem: SearchProblem, space: StartSpace, rng: np.random.Generator) -> None:
        self._closures = ManyClosures(problem, space.strides(problem))
        self._problem, self._space, self._rng = problem, space, rng
        self.met = Distinct(Signatures.of(problem, problem.base[None][:0]))
        self.near = Distinct(Signatures.of(problem, problem.base[None][:0]))
        self.starts = 0
        self.moving = False
        self.undecided = 0
        self._unfinished: list[Ends] = []
        self._in_a_row, self._question = 0, 0

    @property
    def raised(self) -> bool:
        """Whether K* was met with more rank than at home: on another branch."""
        return raised(self._problem, np.array(self.met.q)) is not self._problem

    def modes(self) -> list[tuple[Array, float]]:
        """Return the poses that are modes, each with the share of the starts that led there."""
        modes = [(q, hits / self.starts) for q, hits in zip(self.met.q, self.met.hits, strict=True)]
        if not self.moving:
            return modes
        separate = isolated(self._problem, np.array(self.met.q))
        return [mode for mode, alone in zip(modes, separate, strict=True) if alone]

    def run(self, count: int) -> None:
        """Try that many further starts."""
        ends = self._closures.ends(self._space.draw(self._rng, count))
        self._unfinished.append(ends)
        self._meet_near(ends)
        new = self._meet(ends.closed)
        self.starts += count
        if new or not self._question:
            self._in_a_row, self._question = 0, self._question + 1
        else:
            self._in_a_row += count
        self.moving = len(self.met.q) > _MOST_MODES

    def finish(self) -> None:
        """Go on with the starts that did not end; those that still do not count for nothing."""
        ends = [self._closures.finished(one) for one in self._unfinished]
        self._unfinished = []
        undecided = sum(len(one.spent) for one in ends)
        self.undecided += undecided
        self._in_a_row = max(0, self._in_a_row - undecided)
        for one in ends:
            self._meet_near(one)
            if self._meet(one.closed):
                self._in_a_row, self._question = 0, self._question + 1

    def until(self, aim: Aim) -> None:
        """Go on until the aim is met, its budget is spent, or few starts end."""
        self.finish()
        while self.starts < aim.most_starts and self._bound(aim) > aim.unseen and aim.wanted():
            self.run(_STARTS_AT_ONCE)
            self.finish()
            if self.moving or self._few_end:
                break

    def _meet(self, closed: Array) -> bool:
        """Count closed poses; tell whether any of them is new."""
        if not self.met.q:
            self.met = Distinct(Signatures.of(self._problem, closed))
        new = self.met.add(closed)
        if new and self._problem.idle:  # each mode shows what idles
            self.met = self.met.by(Signatures.of(self._problem, np.array(self.met.q)))
        return new

    def _meet_near(self, ends: Ends) -> None:
        """Keep some of the starts that were given up where the loops are nearly closed."""
        if len(self.near.q) < _ENOUGH_NEAR:
            self.near.add(self._closures.nearly(ends)[:_ENOUGH_NEAR])

    @property
    def _few_end(self) -> bool:
        return self.starts - self.undecided < _ENOUGH_END * self.starts

    def evidence(self, aim: Aim) -> Evidence:
        """Return what it rests on, by the search alone, that no mode is missing."""
        if self.moving:
            left_out = len(self.met.q) - len(self.modes())
            moves = "the loops also move with all motors locked"
            return Evidence("nothing", f"{moves}, and {left_out} poses of that motion are left out")
        if self._few_end:
            neither = "neither closed nor where no step brings them nearer"
            of_all = f"{self.undecided} of {self.starts} random starts did not end"
            where = f"{of_all}, {neither}: slides may have too far to go"
            return Evidence("nothing", f"{where}; what they lead to is not known")
        bound = self._bound(aim)
        uncounted = f"; {self.undecided} did not end and are not counted" if self.undecided else ""
        if bound <= aim.unseen:
            only = f" ({self._space.cut_off})" if self._space.cut_off else ""
            statement = (
                f"with confidence {aim.confidence:g}, at most {bound:.2g} of the start space{only} "
                f"leads to modes not found, after {self.starts} random starts{uncounted}"
            )
            return Evidence("statistics", statement, bound, aim.confidence)
        statement = (
            f"new modes were met among the last of {self.starts} random starts; the share not "
            f"seen is bounded by {bound:.2g} only{uncounted}"
        )
        return Evidence("nothing", statement, bound, aim.confidence)

    def _bound(self, aim: Aim) -> float:
        return unseen_share(self._in_a_row, self._question, aim.confidence)
