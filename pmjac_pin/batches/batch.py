"""Many poses of one mechanism at once: closed, and with their J_eq, by a recorded program.

What a program certifies is what the single call says; where it cannot, the single call is made.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike

from pmjac_pin.algebra.tape_runner import kernel, run
from pmjac_pin.batches.chunks import Progress, fill
from pmjac_pin.batches.grid import spread, walk_grid
from pmjac_pin.batches.measures import measured
from pmjac_pin.batches.results import (
    ManyClosed,
    ManyInGrid,
    ManyJacobians,
    ManyMeasures,
    Status,
    Statuses,
)
from pmjac_pin.closing.many_paths import Walker
from pmjac_pin.closing.motor_values import motor_table
from pmjac_pin.configuration import Configuration, frame_name
from pmjac_pin.errors import (
    ArgumentError,
    ClosureError,
    NoJacobianError,
    SingularError,
    quoted,
)
from pmjac_pin.kinematics.many import ManyPoses
from pmjac_pin.mechanism import Mechanism
from pmjac_pin.model.limits import beyond_limits, enforced
from pmjac_pin.model.twist_frame import FrameName
from pmjac_pin.values.arrays import Array, Index, Mask
from pmjac_pin.values.checks import as_numbers

_FELT = 1e-13  # of the tool's motion: what idle motions may do to it by rounding


def batch(mechanism: Mechanism) -> Batch:
    """Return what computes many poses of a mechanism at once.

    Examples
    --------
    >>> import numpy as np, pmjac_pin as pj
    >>> many = pj.batch(pj.load("five_bar"))
    >>> poses = many.close(many.mechanism.home.actuated + np.linspace(0, 0.1, 1000)[:, None])
    >>> many.jacobian(poses.q).J_eq.shape, int(poses.status.max())
    ((1000, 6, 2), 0)
    """
    return Batch(mechanism)


class Batch:
    """Many poses of one mechanism.

    Attributes
    ----------
    mechanism : Mechanism
    runs_on : str
        "kernel", or "NumPy" where none was built when the package was installed.
    """

    def __init__(self, mechanism: Mechanism) -> None:
        self.mechanism = mechanism
        self.runs_on = "NumPy" if kernel() is None else "kernel"
        parts, recorded = mechanism._parts, mechanism._recorded
        self._recorded, self._rates = recorded, recorded.rates
        self._walker = Walker(
            parts.problem, ManyPoses(parts.model), recorded.point, recorded.step, run
        )
        self._coordinates = parts.coordinates
        partition = parts.problem.partition
        self._tied = partition.constraint_rank > partition.passive_rank

    def close(
        self,
        actuated: ArrayLike,
        guess: str | Configuration | ArrayLike = "home",
        *,
        enforce_limits: bool | str = True,
        threads: int | None = None,
        progress: Progress | None = None,
    ) -> ManyClosed:
        """Close the loops at many motor values, each on the assembly mode of its guess.

        Parameters
        ----------
        actuated : array_like, shape (N, n), or columns by their names
            Motor values, m or rad; columns of a mapping, a DataFrame or records go by the names
            of the motors.
        guess : str, Configuration or array_like
            Where the paths begin: one pose, or closed q of shape (N, nq).
        enforce_limits : bool or "all"
            As for `Mechanism.close`.
        threads : int, optional
            All cores by default; the result is the same to the last bit.
        progress : callable, optional
            Called with (poses done, N) now and then, in the caller's thread.

        Raises
        ------
        ArgumentError, UnknownNameError
            Values that are no finite numbers of that shape; no such pose.
        ClosureError
            A guess that is not closed.
        """
        values = motor_table(self.mechanism.spec, self._coordinates, actuated)
        whose = enforced(enforce_limits)
        start = self._start(guess, len(values))
        found = (np.empty(start.shape), np.empty(len(start)), np.empty(len(start), dtype=np.int8))
        fill(found, lambda at: self._closed(start[at], values[at], whose), threads, progress)
        return ManyClosed(*found, coordinates=self._coordinates)

    def grid(
        self,
        over: Mapping[str, ArrayLike],
        guess: str | Configuration = "home",
        *,
        enforce_limits: bool | str = True,
        threads: int | None = None,
    ) -> ManyInGrid:
        """Close the loops all over a grid of motor values, from cell to neighbouring cell.

        Parameters
        ----------
        over : mapping of str to array_like, shape (k,)
            Values of motors, m or rad: the axes. Other motors stay where the guess has them.
        guess : str or Configuration
            Where the first path begins; it leads to the nearest cell that it reaches.
        enforce_limits, threads
            As for `close`; cells outside limits are not walked through.

        Raises
        ------
        ArgumentError, UnknownNameError
            Axes that are no motors, or no values; no such pose.

        Examples
        --------
        >>> import numpy as np, pmjac_pin as pj
        >>> many = pj.batch(pj.load("five_bar"))
        >>> found = many.grid({"theta1": np.linspace(0.5, 2.5, 9), "theta2": [0.9, 1.0]})
        >>> found.q.shape
        (9, 2, 4)
        """
        begin = self.mechanism.pose(guess) if isinstance(guess, str) else guess
        if not isinstance(begin, Configuration):
            raise ArgumentError(f"`guess` is a pose's name or a Configuration, got {quoted(guess)}")
        values = spread(over, self.mechanism.actuated, begin.actuated)
        cells = values.reshape(-1, begin.actuated.size)

        def close(which: Index, start: Array | None) -> ManyClosed:
            where = begin if start is None else start
            return self.close(cells[which], where, enforce_limits=enforce_limits, threads=threads)

        scale = self._rates.partition.column_scale[self._rates.partition.actuated]
        away = np.linalg.norm((cells - begin.actuated) / scale, axis=1)
        shape = values.shape[:-1]
        found = walk_grid(shape, np.argsort(away, kind="stable"), self.mechanism.nq, close)
        return ManyInGrid(
            q=found.q.reshape(*shape, -1),
            share=found.share.reshape(shape),
            status=found.status.reshape(shape),
            actuated=values,
            source=found.source.reshape(shape),
            coordinates=self._coordinates,
        )

    def _closed(self, start: Array, values: Array, whose: str) -> tuple[Array, Array, Statuses]:
        """Return q, share and status of one piece."""
        q, share, settled = self._together(start, values)
        # Another branch may have more rank than home's, of which the program knows nothing.
        full = self.mechanism.problem.partition.full
        settled &= (share == 1.0) | (full & (share > 0.0))
        for index in np.flatnonzero(~settled).tolist():
            q[index], share[index] = self._alone(start[index], values[index])
        status = np.where(share == 1.0, Status.CLOSED, Status.STOPPED).astype(np.int8)
        if whose != "none":
            motors = self._rates.partition.actuated
            status[self._coordinates.beyond(values, motors).any(axis=1)] = Status.LIMITS
        if whose == "all":
            beyond = beyond_limits(self._coordinates, q)
            status[beyond & (status == Status.CLOSED)] = Status.LIMITS
        return q, share, status

    def _together(self, start: Array, values: Array) -> tuple[Array, Array, Mask]:
        """Walk all paths by the program; return q, share, and of which this is certain."""
        if self._tied:  # some motors lead and others are led: the single call knows which
            return start.copy(), np.zeros(len(values)), np.zeros(len(values), dtype=bool)
        coordinates, motors = self._coordinates, self._rates.partition.actuated
        displacement = values - coordinates.values_of(start, motors)
        turns = np.round(displacement / (2.0 * np.pi)) * coordinates.wraps[motors]
        paths = self._walker.walk(
            start,
            displacement - 2.0 * np.pi * turns,
            lambda q, which: coordinates.with_values(q, motors, values[which]),
        )
        return paths.points.q, paths.share, paths.settled

    def _alone(self, start: Array, values: Array) -> tuple[Array, float]:
        """Walk a path by the single call; return its end, and the share of the way."""
        guess = self.mechanism.configuration(start)
        try:
            return self.mechanism.close(values, guess, enforce_limits=False).q, 1.0
        except ClosureError as error:
            return (start if error.reached is None else error.reached.q), error.share

    def jacobian(
        self,
        q: ArrayLike,
        frame: str | pin.ReferenceFrame = "LOCAL_WORLD_ALIGNED",
        *,
        threads: int | None = None,
        progress: Progress | None = None,
    ) -> ManyJacobians:
        """Return J_eq at many closed poses.

        Parameters
        ----------
        q : array_like, shape (N, nq)
        frame : {"LOCAL_WORLD_ALIGNED", "LOCAL", "WORLD"} or pin.ReferenceFrame
        threads, progress
            As for `close`.
        """
        poses, name = self._poses(q), frame_name(frame)
        tape, count, n = self._recorded.jacobian(name), len(poses), len(self.mechanism.actuated)
        found = (np.empty((count, 6, n)), np.empty(count, dtype=np.int8))

        def work(at: slice) -> tuple[Array, Statuses]:
            return self._judged(poses[at], run(tape, poses[at].T), name)

        fill(found, work, threads, progress)
        return ManyJacobians(*found)

    def measures(
        self, q: ArrayLike, *, threads: int | None = None, progress: Progress | None = None
    ) -> ManyMeasures:
        """Return J_eq, its singular values, how near K* is to singular, and where the tool is.

        Parameters
        ----------
        q : array_like, shape (N, nq)
        threads, progress
            As for `close`.

        Examples
        --------
        >>> import pmjac_pin as pj
        >>> home = pj.load("five_bar").home
        >>> found = pj.batch(home.mechanism).measures([home.q])
        >>> bool(abs(found.smallest[0] - home.singularity().smallest) < 1e-12)
        True
        """
        poses, tape, n = self._poses(q), self._recorded.measures, len(self.mechanism.actuated)
        shapes = ((6, n), (), (3,), (3,), (), (), (3,), (3, 3))  # in the order of ManyMeasures
        found: list[Any] = [np.empty((len(poses), *shape)) for shape in shapes]
        found[1] = np.empty(len(poses), dtype=np.int8)

        def work(at: slice) -> list[Array]:
            told = run(tape, poses[at].T)
            J_eq, status = self._judged(poses[at], told, "LOCAL_WORLD_ALIGNED")
            return [
                *vars(measured(J_eq, status, told[6 + 6 * n :], self._rates.partition)).values()
            ]

        fill(found, work, threads, progress)
        return ManyMeasures(*found)

    def _judged(self, poses: Array, found: Array, frame: FrameName) -> tuple[Array, Statuses]:
        """Return J_eq of what a tape found, where that is certain, else of the single call."""
        partition, n = self._rates.partition, len(self.mechanism.actuated)
        gap, inverse, size, forbidden, felt, tool = found[:6]
        least = partition.rank_tolerance * np.maximum(size, partition.least_size)
        certain = (gap <= self.mechanism.problem.tolerance) & (inverse * least < 1.0)
        certain &= (forbidden <= least) & (felt <= _FELT * tool) & (not partition.isolated)
        J_eq = found[6 : 6 + 6 * n].T.reshape(-1, 6, n).copy()
        status = np.zeros(len(poses), dtype=np.int8)
        for index in np.flatnonzero(~certain).tolist():
            J_eq[index], status[index] = self._single(poses[index], frame)
        return J_eq, status

    def _single(self, q: Array, frame: str) -> tuple[Any, Status]:
        """Return what the single call says at a pose."""
        try:
            return self.mechanism.configuration(q).jacobian(frame).J_eq, Status.CLOSED
        except ClosureError:
            return np.nan, Status.OPEN
        except SingularError:
            return np.nan, Status.SINGULAR
        except NoJacobianError:
            return np.nan, Status.NO_JACOBIAN

    def _start(self, guess: Any, count: int) -> Array:
        if isinstance(guess, str):
            guess = self.mechanism.pose(guess)
        if isinstance(guess, Configuration):
            return np.tile(self.mechanism.configuration(guess.q).q, (count, 1))
        start = self._poses(guess)
        if len(start) != count:
            raise ArgumentError(f"{count} guesses expected, one for each target; got {len(start)}")
        gap = self._walker.at(start, np.zeros((count, len(self.mechanism.actuated)))).gap
        for index in np.flatnonzero(gap > self.mechanism.problem.tolerance)[:1].tolist():
            self.mechanism.configuration(start[index])  # says how far the loops are open
        return start

    def _poses(self, q: Any) -> Array:
        poses = as_numbers(q, "q")
        if poses.ndim != 2 or poses.shape[1] != self.mechanism.nq:
            wanted = f"(N, {self.mechanism.nq})"
            raise ArgumentError(f"q of shape {wanted} expected, got {poses.shape}")
        return poses
