"""Closing: the paths of many poses, by a program and, where it is not certain, one by one."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, TypeAlias

import numpy as np

from pmjac_pin.batches.one_by_one import close_one
from pmjac_pin.batches.pieces import Piece
from pmjac_pin.batches.results import CLOSED, Status, Statuses
from pmjac_pin.closing.kernel_walk import CommonStart, Following
from pmjac_pin.closing.many_idle_paths import ManyIdlePaths
from pmjac_pin.closing.many_paths import GoOn, Paths, Walker
from pmjac_pin.closing.path_kernel import many_paths_kernel
from pmjac_pin.closing.paths_in_lanes import Outcome, PathsInLanes
from pmjac_pin.closing.straight_path import LARGEST_STEP, MOST_STEPS
from pmjac_pin.errors import ClosureError, MissingDependencyError
from pmjac_pin.mechanism import Mechanism
from pmjac_pin.model.limits import beyond_limits
from pmjac_pin.values.arrays import Array, Mask

if TYPE_CHECKING:
    from pmjac_pin.algebra.compiled_programs import CompiledPrograms

#: Where q, share and status of paths go.
Found: TypeAlias = tuple[Array, Array, Statuses]


@dataclass(frozen=True, slots=True, eq=False)
class Closing:
    """Closes poses of one mechanism.

    Attributes
    ----------
    mechanism : Mechanism
    walker : Walker or None
        None where nothing is recorded: by single calls.
    lanes : PathsInLanes or None
        What walks in its place where a kernel was built, and no motors are led.
    idle : ManyIdlePaths or None
        What walks by them where something idles.
    some_are_led : bool
        Whether some motors lead the others, on ways that programs do not know.
    """

    mechanism: Mechanism
    walker: Walker | None
    lanes: PathsInLanes | None = None
    idle: ManyIdlePaths | None = None
    some_are_led: bool = False

    @classmethod
    def of(cls, mechanism: Mechanism, compiled: CompiledPrograms | None = None) -> Closing:
        """Record what is needed, and compile it; nothing where motors are of several freedoms."""
        if not mechanism.recorded.walks:
            return cls(mechanism, None)
        tapes, library = mechanism.recorded.walking, many_paths_kernel()
        known = mechanism.problem, mechanism.coordinates
        if library is None and compiled is not None:
            raise MissingDependencyError(
                "compiled programs are run by a kernel that is built when pmjac_pin is installed, "
                "and none was: install a C compiler, then pmjac_pin anew (pip install "
                "--force-reinstall --no-deps pmjac_pin)"
            )
        partition, lanes = mechanism.problem.partition, None
        some_are_led = partition.constraint_rank > partition.passive_rank
        if library is not None and not some_are_led:
            programs = [None if compiled is None else compiled.of(tape) for tape in tapes]
            lanes = PathsInLanes(
                library, tapes, *known, programs, limits=mechanism.motors.narrowest
            )
        idling = mechanism.recorded.idling
        idle = None if idling is None else ManyIdlePaths(*known, *idling)
        return cls(mechanism, Walker(*known, *tapes), lanes, idle, some_are_led)

    def is_open(self, start: Array) -> Mask:
        """Tell at which of some q the loops are open."""
        if self.walker is None:
            return np.array([self._is_open(q) for q in start], dtype=bool)
        at_rest = np.zeros((len(self.mechanism.actuated), len(start)))
        gap = self.walker.at(start.T, at_rest).gap
        return np.asarray(gap > self.mechanism.problem.tolerance)

    def _is_open(self, q: Array) -> bool:
        try:
            self.mechanism.configuration(q)
        except ClosureError:
            return True
        return False

    def common_start(self, q: Array) -> CommonStart | None:
        """Return what a kernel knows of one pose (nq,) where paths start.

        None where none finds by itself how far motors go, as it does where these are entries of q.
        """
        if self.lanes is None or self.idle is not None or not self.mechanism.motors.are_entries:
            return None
        return self.lanes.common_start(q)

    def close(
        self,
        piece: Piece,
        paths: tuple[Array, Array],
        whose: str,
        found: Found,
        *,
        most_steps: int | None = None,
        following: Following | None = None,
    ) -> None:
        """Find q, share and status of one piece, of paths from closed q to motor values.

        With so few steps, what is not certain by them has the status NOT_DONE. What follows is done
        only where a kernel has walked, and all have arrived.
        """
        q, share, status = found
        ended = self.together(
            *paths, (q, share), go_on=piece.go_on, most_steps=most_steps, following=following
        )
        status.fill(CLOSED)
        self._settle(piece, paths, ended, found, most_steps)
        if whose != "none":
            self._keep_to_limits(whose, paths[1], found)

    def close_inside(
        self,
        piece: Piece,
        start: CommonStart,
        values: Array,
        whose: str,
        found: Found,
        *,
        following: Following | None = None,
    ) -> bool:
        """Do so by a kernel, of paths from one closed q; what follows, where all arrive.

        Returns
        -------
        bool
            False, and nothing is done, where a target is no number within the motors' limits.
        """
        if self.lanes is None:
            raise RuntimeError("without a kernel no paths have a common start")
        q, share, status = found
        ended = self.lanes.walk_from(start, values, piece.go_on, (q, share), following)
        if ended is Outcome.NONE_SET_OUT:
            return False
        status.fill(CLOSED)
        if isinstance(ended, Paths):
            rows = np.broadcast_to(np.frombuffer(start.q), q.shape)
            self._leave_too_long(rows, values, ended)
            self._settle(piece, (rows, values), ended, found)
        if whose != "none":
            self._keep_to_limits(whose, values, found)
        return True

    def _settle(
        self,
        piece: Piece,
        paths: tuple[Array, Array],
        ended: Paths,
        found: Found,
        most_steps: int | None = None,
    ) -> None:
        """Walk one by one what is not settled, and say what has stopped."""
        (start, values), (q, share, status) = paths, found
        if (share == 1.0).all():
            return
        # Another branch may have more rank than home's, of which the program knows nothing.
        full = self.mechanism.problem.partition.full
        settled = ended.settled & ((share == 1.0) | (full & (share > 0.0)))
        for index in piece.each(~settled) if most_steps is None else ():
            q[index], share[index] = close_one(self.mechanism, start[index], values[index])
        status[share != 1.0] = Status.STOPPED
        if most_steps is not None:
            status[~settled] = Status.NOT_DONE

    def _keep_to_limits(self, whose: str, values: Array, found: Found) -> None:
        """Say of which poses some are beyond."""
        q, _, status = found
        if (beyond := self.mechanism.motors.beyond(values)) is not None:
            status[beyond] = Status.LIMITS
        if whose == "all":
            outside = beyond_limits(self.mechanism.coordinates, q)
            status[outside & (status == Status.CLOSED)] = Status.LIMITS

    def together(
        self,
        start: Array,
        values: Array,
        ends: tuple[Array, Array],
        *,
        go_on: GoOn = lambda: None,
        most_steps: int | None = None,
        following: Following | None = None,
    ) -> Paths:
        """Walk all paths by the program, which says which are settled; find q and share."""
        q, share = ends
        # Where some motors lead and others are led, single calls know the way.
        if self.walker is None or self.some_are_led:
            q[:], share[:] = start, 0.0
            return Paths(q, share, np.zeros(len(values), dtype=bool))
        most = most_steps or MOST_STEPS
        if self.lanes is None or self.idle is not None:
            paths = self._walked(self.lanes or self.walker, (start, values), ends, go_on, most)
        else:
            # It finds by itself how far motors go that are entries of q.
            ways = None if self.mechanism.motors.are_entries else self._ways(start, values)
            paths = self.lanes.walk(
                start, ways, values, go_on, most, ends=ends, following=following
            )
        self._leave_too_long(start, values, paths)
        return paths

    def _leave_too_long(self, start: Array, values: Array, paths: Paths) -> None:
        """Settle no path that is too long for any number of steps: single calls take none."""
        left = np.flatnonzero(paths.share != 1.0)  # the others were within so many steps
        partition = self.mechanism.problem.partition
        ways = self.mechanism.motors.ways(start[left], values[left]) / partition.motor_scale
        farthest = MOST_STEPS * LARGEST_STEP * partition.length
        paths.settled[left] &= np.linalg.norm(ways, axis=1) <= farthest

    def _walked(
        self,
        walker: Walker | PathsInLanes,
        paths: tuple[Array, Array],
        ends: tuple[Array, Array],
        go_on: GoOn,
        most_steps: int,
    ) -> Paths:
        """Walk paths of which it is known how far the motors go, of what idles or not."""
        start, values = paths
        ways = self._ways(start, values)
        if self.idle is None:
            return walker.walk(start, ways, values, go_on, most_steps, ends=ends)

        def walk(q: Array, displacement: Array, target: Array, ends: tuple[Array, Array]) -> Paths:
            return walker.walk(q, displacement, target, go_on, most_steps, ends=ends)

        return Paths(*ends, self.idle.walk(walk, start, ways, values, ends))

    def _ways(self, start: Array, values: Array) -> Array:
        return self.mechanism.motors.ways(start if start.strides[0] else start[0], values)
