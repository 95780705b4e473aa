"""One path of the motors where something idles: in pieces, at whose ends that is brought back."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from pmjac_pin.closing.closed import Closed
from pmjac_pin.closing.closure import LARGEST_STEP, MOST_STEPS, Followed, follow, is_singular
from pmjac_pin.closing.closure_problem import ClosureProblem
from pmjac_pin.closing.idle_way import IdleWay, pieces_of
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

        Pieces are halved until all are short enough for that; where none are, the smallest rates
        say where idle motions are.
        """
        partition = self.problem.partition
        distance = norm(self.displacement / partition.motor_scale) / partition.length
        if distance > MOST_STEPS * LARGEST_STEP:
            return self._piece(self.start, 1, 1)
        count = int(pieces_of(np.array(distance)))
        for _ in range(_HALVINGS):
            if (path := self._in_pieces(count, self._settled)) is not None:
                return path
            count *= 2
        path = self._in_pieces(count, lambda start, end: self._settled(start, end) or end)
        assert path is not None
        return path

    def _in_pieces(
        self, count: int, ending: Callable[[Closed, Closed], Closed | None]
    ) -> Followed | None:
        """Walk in so many pieces; None where one of them is too long for its end to be settled."""
        point, iterations = self.start, 0
        for number in range(1, count + 1):
            path = self._piece(point, number, count)
            iterations += path.iterations
            if path.share < 1.0:
                share = (number - 1 + path.share) / count
                return path._replace(share=share, iterations=iterations)
            if (end := ending(point, path.point)) is None:
                return None
            point = end
        return Followed(point, 1.0, iterations)

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
