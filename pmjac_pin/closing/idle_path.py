"""One path of the motors where something idles: in pieces, at whose ends that is brought back."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass

import numpy as np

from pmjac_pin.closing.closed import Closed, is_singular
from pmjac_pin.closing.closure_problem import ClosureProblem
from pmjac_pin.closing.idle_way import IdleWay, parts_of
from pmjac_pin.closing.step_guard import StepGuard
from pmjac_pin.closing.straight_path import LARGEST_STEP, MOST_STEPS, Followed, follow
from pmjac_pin.values.arrays import Array, norm

_HALVINGS = 6  # of pieces that go too far
_STEPS_BACK = 100  # tried: beside a fold they are short


@dataclass(frozen=True, slots=True, eq=False)
class IdlePath:
    """A straight path of the motors.

    Attributes
    ----------
    problem : ClosureProblem
    guard : StepGuard
    idle : IdleWay
    start : Closed
    displacement : ndarray, shape (n,)
        Of the motors, over the whole path.
    target : callable
        (q, share) ↦ q with the motors there.
    """

    problem: ClosureProblem
    guard: StepGuard
    idle: IdleWay
    start: Closed
    displacement: Array
    target: Callable[[Array, float], Array]

    def walk(self) -> Followed:
        """Walk as `follow` does, staying where idle motions are those of the start.

        A piece that is too long for that is halved, six times at most: then smallest rates say
        where idle motions are.
        """
        partition = self.problem.partition
        distance = norm(self.displacement / partition.motor_scale) / partition.length
        if distance > MOST_STEPS * LARGEST_STEP:
            return self._piece(self.start, 1, 1)
        count = int(parts_of(np.array(distance)))
        return self._pieces(Followed(self.start, 0.0, 0), range(1, count + 1), count, _HALVINGS)

    def _pieces(
        self, before: Followed, numbers: Iterable[int], count: int, halvings: int
    ) -> Followed:
        """Walk on by some of so many pieces, as far as they lead."""
        for number in numbers:
            path = self._piece(before.point, number, count)
            if path.share < 1.0:
                share = (number - 1 + path.share) / count
                return path._replace(share=share, iterations=before.iterations + path.iterations)
            end = self._settled(before.point, path.point)
            if end is None and halvings:
                halves = (2 * number - 1, 2 * number)
                before = self._pieces(before, halves, 2 * count, halvings - 1)
            else:
                iterations = before.iterations + path.iterations
                before = Followed(end or path.point, number / count, iterations)
            if before.share < number / count:
                return before
        return before

    def _piece(self, point: Closed, number: int, count: int) -> Followed:
        share = number / count
        return follow(
            self.problem,
            self.guard,
            point,
            self.displacement / count,
            lambda q: self.target(q, share),
        )

    def _settled(self, start: Closed, end: Closed) -> Closed | None:
        """Return the pose at which what idled has not moved, in steps back that are covered.

        None where that is too far, or needs too many of them.
        """
        if is_singular(end, self.problem.partition):
            return end  # more comes free there than idles
        here, share = end, 1.0
        for _ in range(_STEPS_BACK):
            found = self.idle.settled(self.problem, start, here, share)
            if found is not None and self._is_covered(start, here, found):
                if share == 1.0:
                    return found
                here, share = found, min(1.0, 2.0 * share)
            elif found is None and here is end and share == 1.0:
                return None
            else:
                share *= 0.5
        return None

    def _is_covered(self, start: Closed, here: Closed, found: Closed) -> bool:
        return not is_singular(found, self.problem.partition) and self.idle.is_covered(
            self.problem, self.guard, start, (here, found)
        )
