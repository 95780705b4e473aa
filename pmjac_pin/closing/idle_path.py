"""One path of the motors where something idles: in pieces, at whose ends that is brought back."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass

import numpy as np

from pmjac_pin.closing.closed import Closed
from pmjac_pin.closing.closure import LARGEST_STEP, MOST_STEPS, Followed, follow, is_singular
from pmjac_pin.closing.closure_problem import ClosureProblem
from pmjac_pin.closing.idle_way import IdleWay, parts_of
from pmjac_pin.closing.step_guard import StepGuard
from pmjac_pin.values.arrays import Array, norm

_HALVINGS = 6  # of pieces that go too far


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
        if is_singular(end, self.problem.partition):
            return end  # more comes free there than idles
        return self.idle.settled(self.problem, start, end)
