"""ParameterHomotopy: all complex solutions of one random machine, led to those at motor values.

1. A random machine (motors p*, loops shut with offsets) and one solution are drawn. Over a random
   line of offsets through it, `monodromy` finds all its solutions, and the trace says so.
2. The offsets are led to zero: what arrives are all solutions of the mechanism at the motors p*.
3. From there, the motors are led along a straight line to any real values: as p* is random and
   complex, each isolated solution there is the end of a path.

References
----------
.. [1] A. P. Morgan, A. J. Sommese: Coefficient-parameter polynomial continuation. Appl. Math.
   Comput. 29 (1989).
"""

from __future__ import annotations

import logging
import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pmjac_pin.configuration import Configuration
from pmjac_pin.homotopy.curve import SAME, Curve, Planes
from pmjac_pin.homotopy.endpoints import proven
from pmjac_pin.homotopy.machines import ClosedForm, Line, Machine, Machines
from pmjac_pin.homotopy.monodromy import STRAIGHT, PlaneSection
from pmjac_pin.homotopy.operation_modes import OperationModes, find_operation_modes
from pmjac_pin.homotopy.polynomial_loops import PolynomialLoops
from pmjac_pin.modes.assembly_modes import Completeness
from pmjac_pin.modes.closed_pose import closed_pose, generator, order

if TYPE_CHECKING:
    from pmjac_pin.mechanism import Mechanism

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]
Index = NDArray[np.intp]
Mask = NDArray[np.bool_]

_log = logging.getLogger(__name__)

_REAL = 1e-7  # imaginary part of a solution that is real
_MET = 1e-7  # rows left out that hold
# A path is followed to a share 1 − 4⁻ᵏ of it, for one k after the other. If it is lost, it was
# one to infinity where it last grew by more than this from one stop to the next.
_STOPS = (*(1.0 - 0.25**k for k in range(1, 9)), 1.0)
_GROWING = 1.5
_EXACT = 1e-9
_ARRIVED, _TO_INFINITY, _LOST = range(3)  # what became of a path


@dataclass(frozen=True, eq=False)
class ComplexModes:
    """All isolated complex solutions of the loop equations at given motor values.

    Attributes
    ----------
    real : tuple of Configuration
        The real ones, sorted as `AssemblyModes` are; joints may be beyond their limits.
    count : int
        All of them, complex ones too. Where orientations are quaternions, each counts once.
    certified : int
        How many of them are proven to be near exact solutions, all different.
    at_infinity : int
        Paths that went beyond all bounds.
    singular : int
        Paths that ended at a solution where K* is singular, or were lost: not counted above.
    generic : tuple of int
        For each real one, the solution of the random machine whose path ended there.
    complete : Completeness
        Whether these are all, and what this rests on.
    """

    real: tuple[Configuration, ...]
    count: int
    certified: int
    at_infinity: int
    singular: int
    generic: tuple[int, ...]
    complete: Completeness

    def __repr__(self) -> str:
        return f"ComplexModes({self.count} solutions, {len(self.real)} real, {self.complete})"


@dataclass(frozen=True, eq=False)
class ParameterHomotopy:
    """All solutions of a mechanism at random complex motors, and paths from there.

    Attributes
    ----------
    mechanism : Mechanism
    count : int
        Solutions at almost all motor values, complex ones too; of quaternions with opposite
        signs one counts.
    degree : int
        Of the curve whose points were found by monodromy.
    bend : float
        How far the trace of these points is from a straight line, relative to its terms.
    """

    mechanism: Mechanism
    count: int
    degree: int
    bend: float
    _machines: Machines
    _machine: Machine
    _solutions: Complex

    def __reduce__(self) -> tuple[Any, ...]:
        """Let it be kept in a file: what the mechanism is made of can be made again."""
        known = (self.count, self.degree, self.bend, self._machine, self._solutions)
        return _restored, (self.mechanism, *known)

    def __repr__(self) -> str:
        return f"ParameterHomotopy({self.mechanism.name}, {self.count} solutions)"

    def at(self, actuated: ArrayLike) -> ComplexModes:
        """Return all complex solutions at given motor values.

        Parameters
        ----------
        actuated : array_like, shape (n,)
            Motor values, m or rad.

        Raises
        ------
        ArgumentError
            The motor values are not n numbers.

        Examples
        --------
        >>> import pmjac_pin as pj
        >>> found = pj.parameter_homotopy(pj.load("four_bar"), rng=0).at([0.9])
        >>> found.count, len(found.real), found.certified, found.complete.kind
        (2, 2, 2, 'tolerance')
        """
        machine, form = self._machines.at(actuated)
        loops = self._machines.loops
        ends, fate = _led(Curve(Line(loops, self._machine, machine)), self._solutions)
        met = np.flatnonzero(fate == _ARRIVED)
        met = met[loops.unmet(ends[met], np.tile(machine.p, (met.size, 1))) <= _MET]
        met = met[_first_of_each(loops, ends[met])]
        x = ends[met]
        real = np.abs(x.imag).max(axis=1, initial=0.0) <= _REAL
        x[real] = x[real].real
        found = self._configurations(form, x[real].real, met[real])
        infinite = int((fate == _TO_INFINITY).sum())
        certified = int(proven(loops, machine.p, x).sum())
        return ComplexModes(
            real=tuple(configuration for configuration, _ in found),
            count=met.size,
            certified=certified,
            at_infinity=infinite,
            singular=self.count - met.size - infinite,
            generic=tuple(index for _, index in found),
            complete=self._completeness(met.size, infinite, certified),
        )

    def operation_modes(
        self, *, rng: np.random.Generator | int = 0, most_rounds: int = 200
    ) -> OperationModes:
        """Return which solutions hang together when all motors move, complex values included.

        Parameters
        ----------
        rng : numpy.random.Generator or int
        most_rounds : int
            Of closed paths, after which it gives up.

        Examples
        --------
        >>> import pmjac_pin as pj
        >>> pj.parameter_homotopy(pj.load("four_bar"), rng=0).operation_modes().sizes
        (2,)
        """
        return find_operation_modes(
            self._machines.loops, self._machine, self._solutions, generator(rng), most_rounds
        )

    def _configurations(
        self, form: ClosedForm, x: Array, generic: Index
    ) -> list[tuple[Configuration, int]]:
        """Return the real solutions as Configurations, each with where its path began."""
        pairs = [
            (closed_pose(self.mechanism, q, limits=False), int(index))
            for q, index in zip(form.poses(x), generic, strict=True)
        ]
        found = [(configuration, index) for configuration, index in pairs if configuration]
        length = self._machines.loops.length
        return sorted(found, key=lambda pair: order(pair[0], length))

    def _completeness(self, met: int, infinite: int, certified: int) -> Completeness:
        trace = f"monodromy; the trace of {self.degree} points is"
        if self.bend > STRAIGHT:
            statement = f"neither: {trace} bent by {self.bend:.1g}, solutions are missing"
            return Completeness("neither", statement, 1.0, math.nan)
        singular = self.count - met - infinite
        kind: Literal["neither", "tolerance"] = "neither" if singular else "tolerance"
        ends = [f"{met} end at isolated solutions, {certified} of which are proven"]
        if infinite:
            ends.append(f"{infinite} at infinity")
        if singular:
            ends.append(f"{singular} at singular solutions, or are lost")
        statement = (
            f"{kind}: of {self.count} paths of complex solutions ({trace} straight to "
            f"{self.bend:.1g}) {', '.join(ends)}"
        )
        return Completeness(kind, statement, 0.0, math.nan)


def parameter_homotopy(
    mechanism: Mechanism, *, rng: np.random.Generator | int = 0, most_rounds: int = 100
) -> ParameterHomotopy:
    """Find all complex solutions of the loop equations at random complex motor values.

    It takes seconds to minutes, once for a mechanism; `ParameterHomotopy.at` then gives those at
    any motor values in a fraction of a second.

    Parameters
    ----------
    mechanism : Mechanism
    rng : numpy.random.Generator or int
    most_rounds : int
        Of closed paths, after which the search for more solutions gives up; the trace then
        tells that some are missing.

    Raises
    ------
    ArgumentError
        Idle motions, geared joints, motors of several degrees of freedom.

    References
    ----------
    .. [1] T. Duff, C. Hill, A. Jensen, K. Lee, A. Leykin, J. Sommars: Solving polynomial systems
       via homotopy continuation and monodromy. IMA J. Numer. Anal. 39 (2019).

    Examples
    --------
    >>> import pmjac_pin as pj
    >>> homotopy = pj.parameter_homotopy(pj.load("four_bar"), rng=0)
    >>> homotopy.count, homotopy.degree
    (2, 4)
    """
    machines, random = Machines(mechanism), generator(rng)
    loops = machines.loops
    target = machines.home.near(random)
    first = loops.somewhere(random)
    start = machines.offset(target, first)
    curve = Curve(Line.through(loops, start, random))
    section, bend = _all_points(curve, np.append(first, 0.0), random, most_rounds)
    at_start = Planes.at_machine(0.0, loops.count, len(section.points))
    ends, arrived = curve.walk(section.points, section.planes(), at_start)
    ends, fate = _led(Curve(Line(loops, start, target)), ends[arrived][:, :-1])
    x = ends[fate == _ARRIVED]
    x = x[loops.unmet(x, np.tile(target.p, (len(x), 1))) <= _MET]
    x = x[_first_of_each(loops, x)]
    return ParameterHomotopy(
        mechanism=mechanism,
        count=len(x),
        degree=len(section.points),
        bend=bend,
        _machines=machines,
        _machine=target,
        _solutions=x,
    )


def _restored(mechanism: Mechanism, *known: Any) -> ParameterHomotopy:
    count, degree, bend, machine, solutions = known
    machines = Machines(mechanism)
    return ParameterHomotopy(mechanism, count, degree, bend, machines, machine, solutions)


def _all_points(
    curve: Curve, point: Complex, rng: np.random.Generator, most_rounds: int
) -> tuple[PlaneSection, float]:
    """Return all points of an irreducible curve in a plane through one, and the trace's bend."""
    section, bend = PlaneSection.through(curve, point, rng), np.inf
    for _ in range(most_rounds):
        before = len(section.points)
        section = section.grown(rng)
        _log.info("monodromy: %d points", len(section.points))
        if len(section.points) == before:
            bend = section.bends(np.zeros(before, dtype=np.intp))[0]
            if bend < STRAIGHT:
                break
    return section, bend


def _led(curve: Curve, solutions: Complex) -> tuple[Complex, Index]:
    """Lead solutions x from the line's first machine to its last; return them and their fate.

    A path that does not arrive is judged by whether it grew.
    """
    here, share = np.hstack([solutions, np.zeros((len(solutions), 1))]), 0.0
    fate = np.full(len(here), _ARRIVED)
    size = np.abs(here).max(axis=1, initial=0.0)
    growth = np.ones(len(here))
    for stop in _STOPS:
        going = np.flatnonzero(fate == _ARRIVED)
        start, end = (Planes.at_machine(t, curve.line.count, going.size) for t in (share, stop))
        here[going], arrived = curve.walk(here[going], start, end)
        fate[going[~arrived]] = np.where(growth[going[~arrived]] > _GROWING, _TO_INFINITY, _LOST)
        before, size = size, np.abs(here).max(axis=1, initial=0.0)
        growth[going] = size[going] / np.maximum(before[going], 1.0)
        share = stop
    arrived = fate == _ARRIVED
    there = Planes.at_machine(1.0, curve.line.count, int(arrived.sum()))
    here[arrived], last = curve.corrected(here[arrived], there, 3)
    fate[np.flatnonzero(arrived)[last > _EXACT]] = _LOST
    return here[:, :-1], fate


def _first_of_each(loops: PolynomialLoops, x: Complex) -> Index:
    """Return the rows that are not, but for the signs of quaternions, an earlier one."""
    kept: list[int] = []
    for index, one in enumerate(x):
        twins, size = loops.twins(one), SAME * (1.0 + np.abs(one).max(initial=0.0))
        if not any(np.abs(twin - x[other]).max() <= size for twin in twins for other in kept):
            kept.append(index)
    return np.array(kept, dtype=np.intp)
