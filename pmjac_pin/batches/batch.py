"""Many poses of one mechanism at once: closed, and with their J_eq, by a recorded program.

What a program certifies is what the single call says; where it cannot, the single call is made.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from typing import Any

import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike

from pmjac_pin.algebra.compiled_programs import CompiledPrograms
from pmjac_pin.algebra.tape import Tape
from pmjac_pin.algebra.tape_runner import run, tape_kernel
from pmjac_pin.batches.closing import Closing
from pmjac_pin.batches.grid import Grid
from pmjac_pin.batches.judge import Judge
from pmjac_pin.batches.measures import measured, with_extremes, with_radii
from pmjac_pin.batches.pieces import PIECE, Piece, PieceWork, Progress, gathered
from pmjac_pin.batches.results import (
    ManyClosed,
    ManyEllipsoids,
    ManyInGrid,
    ManyJacobians,
    ManyMeasures,
    Statuses,
)
from pmjac_pin.closing.motor_values import motor_table
from pmjac_pin.closing.recorded_rates import DOUBTS
from pmjac_pin.configuration import Configuration
from pmjac_pin.errors import ArgumentError, quoted
from pmjac_pin.mechanism import Mechanism
from pmjac_pin.model.limits import enforced
from pmjac_pin.model.reference_frame import frame_name
from pmjac_pin.model.unit_turns import unit_rows
from pmjac_pin.values.arrays import Array, Index
from pmjac_pin.values.checks import as_numbers, check_kind


def batch(mechanism: Mechanism, *, compiled: bool = False) -> Batch:
    """Return what computes many poses of a mechanism at once.

    Parameters
    ----------
    mechanism : Mechanism
    compiled : bool
        Whether its programs are compiled by the machine's C compiler: that takes some seconds, once
        for these dimensions and this machine, and the same numbers come sooner.

    Raises
    ------
    MissingDependencyError
        No C compiler, or no kernel that was built with the package.
    OutputError
        No cache for what is compiled.

    Examples
    --------
    >>> import numpy as np, pmjac_pin as pj
    >>> many = pj.batch(pj.load("five_bar"))
    >>> poses = many.close(many.mechanism.home.actuated + np.linspace(0, 0.1, 1000)[:, None])
    >>> many.jacobian(poses.q).J_eq.shape, int(poses.status.max())
    ((1000, 6, 2), 0)
    """
    check_kind(mechanism, Mechanism)
    return Batch(mechanism, compiled=compiled)


class Batch:
    """Many poses of one mechanism.

    Attributes
    ----------
    mechanism : Mechanism
    runs_on : str
        "kernel", "compiled programs", or "NumPy" where no kernel was built when the package was
        installed.
    """

    def __init__(self, mechanism: Mechanism, *, compiled: bool = False) -> None:
        self.mechanism = mechanism
        self._compiled = CompiledPrograms() if compiled else None
        self.runs_on = "NumPy" if tape_kernel() is None else "kernel"
        if compiled:
            self.runs_on = "compiled programs"
        self._recorded = mechanism.recorded
        self._closing = Closing.of(mechanism, self._compiled)
        self._judge = Judge(mechanism, self._recorded.rates.partition)

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
        values = motor_table(self.mechanism.spec, self.mechanism.coordinates, actuated)
        whose, (start, known) = enforced(enforce_limits), self._start(guess, len(values))

        def work(piece: Piece) -> tuple[Array, Array, Statuses]:
            if not known:
                self._closing.check(start[piece.at])
            return self._closing.close(piece, start[piece.at], values[piece.at], whose)

        return self._closed(start, work, threads, progress)

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
        grid = Grid.over(
            over, self.mechanism.problem.partition, self.mechanism.coordinates, begin.actuated
        )
        whose, home = enforced(enforce_limits), self.mechanism.configuration(begin.q).q

        def close(which: Index, start: Array | None, most_steps: int | None) -> ManyClosed:
            targets = grid.cells[which]
            begin = np.broadcast_to(home, (which.size, home.size)) if start is None else start
            return self._toward(targets, begin, whose, most_steps, threads)

        return grid.walk(self.mechanism.nq, close)

    def _toward(
        self,
        targets: Array,
        start: Array,
        whose: str,
        most_steps: int | None,
        threads: int | None,
    ) -> ManyClosed:
        """Close from closed q (N, nq), NOT_DONE where it takes more steps."""

        def work(piece: Piece) -> tuple[Array, Array, Statuses]:
            at = piece.at
            return self._closing.close(piece, start[at], targets[at], whose, most_steps)

        return self._closed(start, work, threads)

    def _closed(
        self, start: Array, work: PieceWork, threads: int | None, progress: Progress | None = None
    ) -> ManyClosed:
        count = len(start)
        shapes = (start.shape, (count,), (count,))
        coordinates = self.mechanism.coordinates
        return gathered(ManyClosed, shapes, work, threads, progress, coordinates=coordinates)

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
        self.mechanism.need_tool()
        poses, name = self._poses(q), frame_name(frame)
        by, count, n = (
            self._by(self._recorded.jacobian(name)),
            len(poses),
            len(self.mechanism.actuated),
        )

        def work(piece: Piece) -> tuple[Array, Statuses]:
            part = poses[piece.at]
            J_eq, status = self._judge.judged(piece, part, by(part.T), name)
            return J_eq.transpose(2, 0, 1), status

        return gathered(ManyJacobians, ((count, 6, n), (count,)), work, threads, progress)

    def ellipsoids(
        self, q: ArrayLike, *, threads: int | None = None, progress: Progress | None = None
    ) -> ManyEllipsoids:
        """Return J_eq and its singular values: of `measures` what takes the least time.

        Parameters
        ----------
        q : array_like, shape (N, nq)
        threads, progress
            As for `close`.

        Examples
        --------
        >>> import pmjac_pin as pj
        >>> home = pj.load("five_bar").home
        >>> found = pj.batch(home.mechanism).ellipsoids([home.q])
        >>> of_one = home.jacobian().velocity_ellipsoid().radii
        >>> bool(abs(found.velocity_radii[0] - of_one).max() < 1e-12)
        True
        """
        self.mechanism.need_tool()
        poses, by = self._poses(q), self._by(self._recorded.ellipsoids)
        n = len(self.mechanism.actuated)

        def work(piece: Piece) -> list[Array]:
            part = poses[piece.at]
            told = by(part.T)
            judged = self._judge.judged(piece, part, told, "LOCAL_WORLD_ALIGNED")
            return list(vars(with_radii(*judged, told[DOUBTS + 6 * n :])).values())

        shapes = ((6, n), (), (3,), (3,))  # in the order of ManyEllipsoids
        whole = [(len(poses), *shape) for shape in shapes]
        return gathered(ManyEllipsoids, whole, work, threads, progress)

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
        self.mechanism.need_tool()
        poses, by = self._poses(q), self._by(self._recorded.measures)
        n, partition = len(self.mechanism.actuated), self._recorded.rates.partition
        shapes = ((6, n), (), (3,), (3,), (), (), (3,), (3, 3))  # in the order of ManyMeasures

        def work(piece: Piece) -> list[Array]:
            part = poses[piece.at]
            told, extremes = with_extremes(by, part.T, DOUBTS + 6 * n + 15, partition)
            judged = self._judge.judged(piece, part, told, "LOCAL_WORLD_ALIGNED")
            found = measured(*judged, told[DOUBTS + 6 * n :], extremes, partition)
            return list(vars(found).values())

        whole = [(len(poses), *shape) for shape in shapes]
        return gathered(ManyMeasures, whole, work, threads, progress)

    def _by(self, tape: Tape) -> Callable[[Array], Array]:
        """Return what computes a tape's outputs, (outputs, N), of inputs (inputs, N)."""
        return partial(run, tape) if self._compiled is None else self._compiled.of(tape).run

    def _start(self, guess: Any, count: int) -> tuple[Array, bool]:
        """Return where the paths begin, and whether it is known that the loops are closed there."""
        if isinstance(guess, str):
            guess = self.mechanism.pose(guess)
        if isinstance(guess, Configuration):
            q = self.mechanism.configuration(guess.q).q
            return np.broadcast_to(q, (count, q.size)), True
        start = self._poses(guess)
        if len(start) != count:
            raise ArgumentError(f"{count} guesses expected, one for each target; got {len(start)}")
        return start, False

    def _poses(self, q: Any) -> Array:
        """Return q as it is where nothing in it is changed: what is looked at stays in caches."""
        given: Array = q if type(q) is np.ndarray and q.dtype == np.float64 else as_numbers(q, "q")
        if given.ndim != 2 or given.shape[1] != self.mechanism.nq:
            wanted = f"(N, {self.mechanism.nq})"
            raise ArgumentError(f"q of shape {wanted} expected, got {given.shape}")
        poses = given
        for at in range(0, len(given), PIECE):
            part = as_numbers(given[at : at + PIECE], "q")
            unit = unit_rows(self.mechanism.kinematics.model, part)
            if unit is not part:
                poses = given.copy() if poses is given else poses
                poses[at : at + PIECE] = unit
        return poses
