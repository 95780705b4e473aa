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

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from pmjac_pin.closing.motor_values import MotorValues
from pmjac_pin.configuration import Configuration
from pmjac_pin.mechanism import Mechanism
from pmjac_pin.studies.evidence import Evidence
from pmjac_pin.studies.homotopy.complex_modes import ComplexModes
from pmjac_pin.studies.homotopy.curve import Curve, machine_plane
from pmjac_pin.studies.homotopy.endpoints import proven, told_real
from pmjac_pin.studies.homotopy.machines import ClosedForm, Line, Machine, Machines
from pmjac_pin.studies.homotopy.monodromy import STRAIGHT, PlaneSection, all_points, random_turn
from pmjac_pin.studies.homotopy.operation_modes import OperationModes, find_operation_modes
from pmjac_pin.studies.homotopy.paths import PathEnds, led, led_to_end
from pmjac_pin.studies.homotopy.solving import near, solutions_of
from pmjac_pin.studies.modes.closed_pose import closed_pose, generator, order
from pmjac_pin.studies.modes.recognition import Recognition
from pmjac_pin.values.arrays import Array, Complex, Index, read_only
from pmjac_pin.values.checks import as_count, check_kind

_SINGULAR = 1e-4  # smallest relative singular value of K* beside which home is not asked for
_TRIES = 4  # of ways to lead all points to one machine


@dataclass(frozen=True, eq=False)
class ParameterHomotopy:
    """All solutions of a mechanism at random complex motors, and paths from there.

    Attributes
    ----------
    mechanism : Mechanism
    count : int
        Solutions at almost all motor values, complex ones too, but for those farther than 100
        characteristic lengths; of quaternions with opposite signs one counts.
    degree : int
        Of the curve of machines whose points were found by monodromy: it has more points in a
        plane than the mechanism has solutions.
    bend : float
        How far the trace of these points is from a straight line, relative to its terms.
    lost : int
        Paths from these points that neither arrived nor went to infinity: solutions may be
        missing.
    home_met : bool
        Whether the home pose is among the ends of paths, as it must be if it is regular.
    """

    mechanism: Mechanism
    count: int
    degree: int
    bend: float
    lost: int
    home_met: bool
    _machines: Machines
    _machine: Machine
    _solutions: Complex

    def __reduce__(self) -> tuple[Any, ...]:
        """Let it be kept in a file: what the mechanism is made of can be made again."""
        counts = (self.count, self.degree, self.bend, self.lost, self.home_met)
        return _restored, (self.mechanism, counts, self._machine, self._solutions)

    def __repr__(self) -> str:
        return f"ParameterHomotopy({self.mechanism.name}, {self.count} solutions)"

    @property
    def evidence(self) -> Evidence:
        """What it rests on that these are all solutions at almost all motor values."""
        trace = f"the trace of {self.degree} points found by monodromy"
        if self.bend > STRAIGHT:
            return Evidence("nothing", f"{trace} is bent by {self.bend:.1g}, solutions are missing")
        if self.lost:
            ends = f"{self.lost} end at solutions that are not isolated, or are lost"
            return Evidence("nothing", f"of {self.degree} paths to random motor values {ends}")
        if not self.home_met:
            return Evidence("nothing", "no path ends at the home pose, solutions are missing")
        straight = f"{trace} is straight to {self.bend:.1g}"
        return Evidence("tolerance", f"{straight}, and no path from there was lost")

    def at(self, actuated: MotorValues) -> ComplexModes:
        """Return all complex solutions at given motor values.

        Parameters
        ----------
        actuated : array_like, shape (n,), or mapping of str to float
            Motor values, m or rad; by name where they have names.

        Returns
        -------
        ComplexModes
            The solutions, the real ones as Configurations; `evidence` says what it rests on
            that these are all.

        Raises
        ------
        ArgumentError
            The motor values are not n numbers.

        Examples
        --------
        >>> import pmjac_pin as pj
        >>> found = pj.parameter_homotopy(pj.load("four_bar"), rng=0).at([0.9])
        >>> found.count, len(found.real), found.certified, found.evidence.kind
        (2, 2, 2, 'tolerance')
        """
        machine, form = self._machines.at(actuated)
        loops = self._machines.loops
        ends = led_to_end(Curve(Line(loops, self._machine, machine)), self._solutions)
        met = solutions_of(loops, machine, ends)
        close = near(ends.points[met])
        infinite = int(ends.to_infinity.sum() + (~close).sum())
        met = met[close]
        x = told_real(loops, form.driven, ends.points[met])
        real = np.abs(x.imag).max(axis=1, initial=0.0) == 0.0
        found = self._configurations(form, x[real].real, met[real])
        certified = int(proven(loops, form.driven, x).sum())
        return ComplexModes(
            real=tuple(configuration for configuration, _ in found),
            solutions=read_only(x),
            unknowns=loops.names,
            count=met.size,
            certified=certified,
            at_infinity=infinite,
            singular=len(self._solutions) - met.size - infinite,
            generic=tuple(index for _, index in found),
            evidence=self._evidence_of(met.size, infinite, certified),
            key=self._key,
        )

    def operation_modes(
        self, *, rng: np.random.Generator | int | None = None, most_rounds: int = 200
    ) -> OperationModes:
        """Return which solutions hang together when all motors move, complex values included.

        Parameters
        ----------
        rng : numpy.random.Generator or int, optional
            For planes and paths; a seed makes a generator.
        most_rounds : int
            Of closed paths, after which it gives up; `evidence` then says so.

        Returns
        -------
        OperationModes
            Sets of solutions, the largest first.

        Raises
        ------
        ArgumentError
            `most_rounds` is no whole number ≥ 1.

        Examples
        --------
        >>> import pmjac_pin as pj
        >>> pj.parameter_homotopy(pj.load("four_bar"), rng=0).operation_modes().sizes
        (2,)
        """
        most_rounds = as_count(most_rounds, "most_rounds")
        found = find_operation_modes(
            self._machines.loops, self._machine, self._solutions, generator(rng), most_rounds
        )
        evidence = found.evidence if self.evidence.kind == "tolerance" else self.evidence
        return replace(found, evidence=evidence, key=self._key)

    @property
    def _key(self) -> int:
        """What tells the solutions of one homotopy from those of another."""
        return hash(self._solutions.tobytes())

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

    def _evidence_of(self, met: int, infinite: int, certified: int) -> Evidence:
        """Return what it rests on that so many ends are all solutions at some motor values."""
        if self.evidence.kind == "nothing":
            return self.evidence
        total = len(self._solutions)
        singular = total - met - infinite
        ends = [f"{met} end at solutions, {certified} of them proven to be there and isolated"]
        if infinite:
            ends.append(f"{infinite} at infinity or far away")
        if singular:
            ends.append(f"{singular} at singular solutions, or are lost")
        paths = f"of {total} paths of complex solutions {', '.join(ends)}"
        settled = not singular and certified == met
        return Evidence(
            "tolerance" if settled else "nothing", f"{paths}; {self.evidence.statement}"
        )


def parameter_homotopy(
    mechanism: Mechanism, *, rng: np.random.Generator | int | None = None, most_rounds: int = 100
) -> ParameterHomotopy:
    """Find all complex solutions of the loop equations at random complex motor values.

    By monodromy [1]_: closed paths of the motor values lead from solutions to others. It takes
    a fraction of a second to a minute, once for a mechanism; `ParameterHomotopy.at` then gives
    those at any motor values sooner.

    Parameters
    ----------
    mechanism : Mechanism
    rng : numpy.random.Generator or int
        For the machine, planes and paths; a seed makes a generator.
    most_rounds : int
        Of closed paths, after which the search for more solutions gives up; the trace then
        tells that some are missing.

    Returns
    -------
    ParameterHomotopy

    Raises
    ------
    ArgumentError
        Idle motions, geared joints, motors of several degrees of freedom, or more of them than
        can be moved one by one.

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
    check_kind(mechanism, Mechanism)
    most_rounds = as_count(most_rounds, "most_rounds")
    machines, random = Machines(mechanism), generator(rng)
    loops = machines.loops
    target = machines.home.near(random)
    first = loops.somewhere(random)
    start = machines.offset(target, first)
    curve = Curve(Line.through(loops, start, random))
    section, bend = all_points(curve, np.append(first, 0.0), random, most_rounds)
    shut = _at_start(section, random)
    ends = led_to_end(Curve(Line(loops, start, target)), shut.points[shut.arrived, :-1])
    solutions = ends.points[solutions_of(loops, target, ends)]
    found = ParameterHomotopy(
        mechanism=mechanism,
        count=int(near(solutions).sum()),
        degree=len(section.points),
        bend=bend,
        lost=shut.lost + ends.lost,
        home_met=True,
        _machines=machines,
        _machine=target,
        _solutions=solutions,
    )
    return replace(found, home_met=_meets_home(found))


def _meets_home(homotopy: ParameterHomotopy) -> bool:
    """Tell whether the home pose is an end of a path; a singular one need not be."""
    home = homotopy.mechanism.home
    if home.singularity().smallest < _SINGULAR:
        return True
    return Recognition(homotopy.at(home.actuated).real).index(home) is not None


def _at_start(section: PlaneSection, rng: np.random.Generator) -> PathEnds:
    """Lead all points of a section to t = 0, on other paths if some are lost on the first."""
    count = len(section.points)
    there = machine_plane(0.0, section.curve.line.count, count)
    tries: list[PathEnds] = []
    while not tries or (tries[-1].lost and len(tries) < _TRIES):
        turn = random_turn(rng)
        tries.append(led(section.curve, section.points, section.planes(), turn * there))
    return min(tries, key=lambda ends: ends.lost)


def _restored(
    mechanism: Mechanism,
    counts: tuple[int, int, float, int, bool],
    machine: Machine,
    solutions: Complex,
) -> ParameterHomotopy:
    return ParameterHomotopy(mechanism, *counts, Machines(mechanism), machine, solutions)
