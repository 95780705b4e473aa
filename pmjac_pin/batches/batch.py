"""Many poses of one mechanism at once: closed, and with their J_eq, by a recorded program.

What a program certifies is what the single call says; where it cannot, the single call is made.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import cached_property
from typing import Any, TypeVar

import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike

from pmjac_pin.algebra.tape_runner import tape_kernel
from pmjac_pin.batches.at_poses import AtPoses, RatesWork
from pmjac_pin.batches.closing import Closing
from pmjac_pin.batches.filled_again import Refillable
from pmjac_pin.batches.gathering import Manner, gathered, gathered_together
from pmjac_pin.batches.grid import Grid
from pmjac_pin.batches.path_starts import closed_q
from pmjac_pin.batches.paths_request import PathsRequest, PathsRequests
from pmjac_pin.batches.pieces import Piece, Progress
from pmjac_pin.batches.results import (
    ManyClosed,
    ManyEllipsoids,
    ManyInGrid,
    ManyJacobians,
    ManyMeasures,
)
from pmjac_pin.batches.sound_rows import SoundRows, rows_of_q
from pmjac_pin.batches.wanted import Wanted
from pmjac_pin.configuration import Configuration
from pmjac_pin.errors import ArgumentError, quoted
from pmjac_pin.mechanism import Mechanism
from pmjac_pin.model.limits import enforced
from pmjac_pin.model.reference_frame import frame_name
from pmjac_pin.values.arrays import Array, Index
from pmjac_pin.values.checks import check_callable, check_kind

ManyRatesKind = TypeVar("ManyRatesKind", bound=ManyJacobians)


def batch(mechanism: Mechanism, *, compiled: bool = False) -> Batch:
    """Return what computes many poses of a mechanism at once.

    Parameters
    ----------
    mechanism : Mechanism
    compiled : bool
        Whether its programs are compiled by a C compiler, the machine's or PyPI's `ziglang`: that
        takes some seconds, once for these dimensions and this machine, and the same numbers come
        sooner.

    Raises
    ------
    MissingDependencyError
        No C compiler, or no kernel that was built with the package.
    OutputError
        No cache for what is compiled, or one that others can write or lead to.

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
        # Home is there before programs of many poses are: the next single pose after these has its
        # own recorded.
        _ = mechanism.home
        programs = None
        if compiled:
            # Who asks for no compiler waits for none of what calls it.
            from pmjac_pin.algebra.compiled_programs import CompiledPrograms  # noqa: PLC0415

            programs = CompiledPrograms()
        self.runs_on = "NumPy" if tape_kernel() is None else "kernel"
        if compiled:
            self.runs_on = "compiled programs"
        self._closing = Closing.of(mechanism, programs)
        self._at_poses = AtPoses(mechanism, programs)
        self._sound = SoundRows(mechanism)

    def close(
        self,
        actuated: ArrayLike,
        guess: str | Configuration | ArrayLike = "home",
        *,
        enforce_limits: bool | str = True,
        threads: int | None = None,
        progress: Progress | None = None,
        out: ManyClosed | None = None,
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
        out : ManyClosed, optional
            What a call has returned for as many poses, to be filled again and returned: no memory
            is taken for results. Arrays that were taken from it then hold the new numbers, too.
            Where something is raised, what is not done says so.

        Raises
        ------
        ArgumentError, UnknownNameError
            Values or guesses that are no numbers of that shape; no such pose; an `out` of other
            shapes, or whose arrays are not to be written to, or are what is read. Of single values
            and guesses the status tells.
        """
        request, given = self._requested(ManyClosed, actuated, guess, enforce_limits)
        poses: ManyClosed = gathered(
            request.wanted[0], request.work, (threads, progress), out, given
        )
        return poses

    def grid(
        self,
        over: Mapping[str, ArrayLike],
        guess: str | Configuration = "home",
        *,
        enforce_limits: bool | str = True,
        threads: int | None = None,
        progress: Progress | None = None,
    ) -> ManyInGrid:
        """Close the loops all over a grid of motor values, from cell to neighbouring cell.

        Parameters
        ----------
        over : mapping of str to array_like, shape (k,), or Dataset
            Values of motors, m or rad: the axes. Other motors stay where the guess has them.
        guess : str or Configuration
            Where the first path begins; it leads to the nearest cell that it reaches.
        enforce_limits, threads
            As for `close`; cells outside limits are not walked through.
        progress : callable, optional
            Called with (cells of which it is known what became of them, all cells).

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
        check_callable(progress, "progress")
        whose, home = enforced(enforce_limits), closed_q(self.mechanism, begin)

        def close(which: Index, start: Array | None, most_steps: int | None) -> ManyClosed:
            targets = grid.cells[which]
            begin = np.broadcast_to(home, (which.size, home.size)) if start is None else start
            return self._toward(targets, begin, whose, most_steps, threads)

        return grid.walk(self.mechanism.nq, close, progress)

    def _toward(
        self,
        targets: Array,
        start: Array,
        whose: str,
        most_steps: int | None,
        threads: int | None,
    ) -> ManyClosed:
        """Close from closed q (N, nq), NOT_DONE where it takes more steps."""

        def work(piece: Piece, paths: tuple[Array, Array], *found: Any) -> None:
            self._closing.close(piece, paths, whose, found, most_steps=most_steps)

        wanted = Wanted.of(self.mechanism, ManyClosed, len(start))
        return gathered(wanted, work, (threads, None), None, (start, targets))

    def jacobian(
        self,
        q: ArrayLike,
        frame: str | pin.ReferenceFrame = "LOCAL_WORLD_ALIGNED",
        *,
        threads: int | None = None,
        progress: Progress | None = None,
        out: ManyJacobians | None = None,
    ) -> ManyJacobians:
        """Return J_eq at many closed poses.

        Parameters
        ----------
        q : array_like, shape (N, nq)
        frame : {"LOCAL_WORLD_ALIGNED", "LOCAL", "WORLD"} or pin.ReferenceFrame
        threads, progress, out
            As for `close`.
        """
        name, poses = frame_name(frame), rows_of_q(q, self.mechanism.nq)
        work, how = self._at_poses.jacobian(name), (threads, progress)
        return self._gathered(ManyJacobians, work, poses, how, out)

    def ellipsoids(
        self,
        q: ArrayLike,
        *,
        threads: int | None = None,
        progress: Progress | None = None,
        out: ManyEllipsoids | None = None,
    ) -> ManyEllipsoids:
        """Return J_eq and its singular values: of `measures` what takes the least time.

        Parameters
        ----------
        q : array_like, shape (N, nq)
        threads, progress, out
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
        poses, work = rows_of_q(q, self.mechanism.nq), self._at_poses.ellipsoids()
        return self._gathered(ManyEllipsoids, work, poses, (threads, progress), out)

    def measures(
        self,
        q: ArrayLike,
        *,
        threads: int | None = None,
        progress: Progress | None = None,
        out: ManyMeasures | None = None,
    ) -> ManyMeasures:
        """Return J_eq, its singular values, how near K* is to singular, and where the tool is.

        Parameters
        ----------
        q : array_like, shape (N, nq)
        threads, progress, out
            As for `close`.

        Examples
        --------
        >>> import pmjac_pin as pj
        >>> home = pj.load("five_bar").home
        >>> found = pj.batch(home.mechanism).measures([home.q])
        >>> bool(abs(found.smallest[0] - home.singularity().smallest) < 1e-12)
        True
        """
        poses, work = rows_of_q(q, self.mechanism.nq), self._at_poses.measures()
        return self._gathered(ManyMeasures, work, poses, (threads, progress), out)

    def ellipsoids_at(
        self,
        actuated: ArrayLike,
        guess: str | Configuration | ArrayLike = "home",
        *,
        enforce_limits: bool | str = True,
        threads: int | None = None,
        progress: Progress | None = None,
        out: tuple[ManyClosed, ManyEllipsoids] | None = None,
    ) -> tuple[ManyClosed, ManyEllipsoids]:
        """Return what `close` gives, and what `ellipsoids` gives at its poses, in one go.

        The same numbers, sooner: poses are not looked at twice, and are near the processor.

        Parameters
        ----------
        actuated, guess, enforce_limits, threads, progress
            As for `close`.
        out : (ManyClosed, ManyEllipsoids), optional
            What a call has returned for as many poses, to be filled again and returned.

        Raises
        ------
        ArgumentError, UnknownNameError
            As `close`.

        Examples
        --------
        >>> import pmjac_pin as pj
        >>> many = pj.batch(pj.load("five_bar"))
        >>> poses, found = many.ellipsoids_at([[2.1, 0.9], [2.2, 1.0]])
        >>> bool((found.velocity_radii == many.ellipsoids(poses.q).velocity_radii).all())
        True
        """
        request, given = self._requested(ManyEllipsoids, actuated, guess, enforce_limits)
        both: tuple[ManyClosed, ManyEllipsoids]
        both = self._gathered_at(request, (threads, progress), out, given)
        return both

    def measures_at(
        self,
        actuated: ArrayLike,
        guess: str | Configuration | ArrayLike = "home",
        *,
        enforce_limits: bool | str = True,
        threads: int | None = None,
        progress: Progress | None = None,
        out: tuple[ManyClosed, ManyMeasures] | None = None,
    ) -> tuple[ManyClosed, ManyMeasures]:
        """Return what `close` gives, and what `measures` gives at its poses, in one go.

        Parameters
        ----------
        actuated, guess, enforce_limits, threads, progress
            As for `close`.
        out : (ManyClosed, ManyMeasures), optional
            As for `ellipsoids_at`.

        Raises
        ------
        ArgumentError, UnknownNameError
            As `close`.

        Examples
        --------
        >>> import pmjac_pin as pj
        >>> many = pj.batch(pj.load("five_bar"))
        >>> poses, found = many.measures_at([[2.1, 0.9], [2.2, 1.0]])
        >>> bool((found.smallest == many.measures(poses.q).smallest).all())
        True
        """
        request, given = self._requested(ManyMeasures, actuated, guess, enforce_limits)
        both: tuple[ManyClosed, ManyMeasures]
        both = self._gathered_at(request, (threads, progress), out, given)
        return both

    def _gathered(
        self,
        kind: type[ManyRatesKind],
        work: RatesWork,
        poses: Array,
        how: Manner,
        out: ManyRatesKind | None,
    ) -> ManyRatesKind:
        """Return what is found at the poses that are given."""

        def of_piece(piece: Piece, given: tuple[Array], *found: Any) -> None:
            self._sound.fill(work, piece, *given, *found)

        wanted = Wanted.of(self.mechanism, kind, len(poses))
        return gathered(wanted, of_piece, how, out, (poses,))

    def _gathered_at(
        self,
        request: PathsRequest,
        how: Manner,
        out: tuple[Any, ...] | None,
        given: tuple[Array, ...],
    ) -> Any:
        """Return closed poses, and what is found there while they are at hand."""
        if not (out is None or (isinstance(out, tuple) and len(out) == 2)):
            pair = f"({', '.join(wanted.kind.__name__ for wanted in request.wanted)})"
            raise ArgumentError(f"`out` is {pair} to be filled again, got {quoted(out)}")
        return gathered_together(request.wanted, request.work, how, out, given)

    def _requested(
        self, kind: type[Refillable], actuated: ArrayLike, guess: Any, enforce_limits: bool | str
    ) -> tuple[PathsRequest, tuple[Array, ...]]:
        values = self.mechanism.motors.table(actuated)
        return self._requests.of(kind, values, guess, enforce_limits)

    @cached_property
    def _requests(self) -> PathsRequests:
        return PathsRequests(self.mechanism, self._closing, self._sound, self._at_poses)
