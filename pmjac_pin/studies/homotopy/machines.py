"""Machines: a mechanism with motors that are complex numbers and loops shut with offsets.

F(x; p) + γ = 0, with the motors' parameters p and an offset γ for each row of η. A line of
machines is p(t) = p₀ + t p₁, γ(t) = γ₀ + t γ₁.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from flint import acb

from pmjac_pin.algebra.arrays import Numbers
from pmjac_pin.closing.motor_values import MotorValues, motor_values
from pmjac_pin.errors import ArgumentError
from pmjac_pin.mechanism import Mechanism
from pmjac_pin.studies.homotopy.curve_kernel import CurveInLanes, curve_kernel
from pmjac_pin.studies.homotopy.polynomial_loops import PolynomialLoops
from pmjac_pin.studies.modes.legs import names_of
from pmjac_pin.studies.modes.search_problem import SearchProblem, home_with, search_problem
from pmjac_pin.values.arrays import Array, Complex

_SPREAD = 0.5  # of random machines about a given one, relative


@dataclass(frozen=True, slots=True, eq=False)
class Machine:
    """One machine: parameters p (k,) and offsets γ (rows,)."""

    p: Complex
    gaps: Complex

    @property
    def numbers(self) -> Complex:
        """All of them, (k + rows,)."""
        return np.concatenate([self.p, self.gaps])

    def near(self, rng: np.random.Generator) -> Machine:
        """Return a random machine about this one, its loops shut."""
        size = np.maximum(np.abs(self.p), 0.5)
        return Machine(self.p + _SPREAD * size * complex_normal(rng, self.p.size), 0.0 * self.gaps)


@dataclass(frozen=True, slots=True, eq=False)
class Line:
    """A line of machines through `start` at t = 0 and `end` at t = 1."""

    loops: PolynomialLoops
    start: Machine
    end: Machine

    @property
    def count(self) -> int:
        """Of unknowns x."""
        return self.loops.count

    def evaluate(self, X: Complex, t: Complex) -> tuple[Complex, Complex]:
        """Return F (b, count) and its derivative by (X, h, t), (b, count, count + 2)."""
        rate = self.end.numbers - self.start.numbers
        machines = self.start.numbers + t[:, None] * rate
        return self.loops.evaluate(X, machines, np.broadcast_to(rate, machines.shape))

    def lanes(self) -> CurveInLanes | None:
        """Return what follows points of the line's curve, None where no kernel was built."""
        library = curve_kernel()
        if library is None:
            return None
        start = self.start.numbers
        return CurveInLanes(
            library, self.loops.tape, np.concatenate([start, self.end.numbers - start])
        )

    @classmethod
    def through(cls, loops: PolynomialLoops, start: Machine, rng: np.random.Generator) -> Line:
        """Return a line on which the motors stand still and the gaps open at random."""
        opening = complex_normal(rng, loops.rows)
        return cls(loops, start, Machine(start.p, start.gaps + opening))


class Machines:
    """A mechanism's machines, and the way to them from its motor values.

    Parameters
    ----------
    mechanism : Mechanism

    Raises
    ------
    ArgumentError
        Idle motions, geared joints, motors of several degrees of freedom, or more of them than
        can be moved one by one.
    """

    def __init__(self, mechanism: Mechanism) -> None:
        self.mechanism = mechanism
        problem = search_problem(mechanism, mechanism.home.q)
        _refuse_over_actuated(mechanism)
        # The legs' rods come last; those without a motor keep their length.
        plain, motors = len(problem.closures) - len(problem.legs), mechanism.spec.actuated
        self._names, self._driven = (
            names_of(problem.legs),
            [
                index
                for index, leg in enumerate(problem.legs)
                if any(edge.name in motors for edge in leg.edges)
            ],
        )
        self.loops = PolynomialLoops(problem, [plain + index for index in self._driven])
        self.home = self._machine(problem)

    def at(self, actuated: MotorValues) -> tuple[Machine, ClosedForm]:
        """Return the machine with these motor values, and the way back from its unknowns."""
        mechanism = self.mechanism
        values = motor_values(mechanism.spec, mechanism.coordinates, actuated)
        problem = search_problem(mechanism, home_with(mechanism, values))
        if names_of(problem.legs) != self._names:
            name, given = mechanism.name, ", ".join(f"{value:g}" for value in values)
            raise ArgumentError(f"{name}: at {given} its legs are not those of its home pose")
        squares = [acb(square) for square in self._squares(problem)]
        driven = np.concatenate([self.loops.driven_balls(problem.base), squares])
        return self._machine(problem), ClosedForm(self.loops, problem, driven)

    def offset(self, machine: Machine, x: Complex) -> Machine:
        """Return the machine with these motors whose loops are shut, with offsets, at x."""
        return Machine(machine.p, self.loops.gaps(x, machine.p))

    def _machine(self, problem: SearchProblem) -> Machine:
        motors = self.loops.motor_parameters(problem.base)
        rods = np.array(self._squares(problem), dtype=complex)
        return Machine(np.concatenate([motors, rods]), np.zeros(self.loops.rows, dtype=complex))

    def _squares(self, problem: SearchProblem) -> list[float]:
        """Return the squares of the lengths of the legs that have motors."""
        return [(problem.legs[index].length / problem.length) ** 2 for index in self._driven]


@dataclass(frozen=True, slots=True, eq=False)
class ClosedForm:
    """The way from real unknowns x back to poses of the mechanism at some motor values.

    `driven` are the polynomials' variables that follow from these, as balls.
    """

    loops: PolynomialLoops
    problem: SearchProblem
    driven: Numbers

    def poses(self, x: Array) -> list[Array]:
        """Return the q of each row of x."""
        return [self.problem.with_legs(q) for q in self.loops.poses(x, self.problem.base)]


def _refuse_over_actuated(mechanism: Mechanism) -> None:
    """Raise where the loops close at special motor values only."""
    partition = mechanism.problem.partition
    if partition.constraint_rank > partition.passive_rank:
        why = "its motors cannot be moved one by one: the loops forbid it"
        raise ArgumentError(f"{mechanism.name}: no homotopy for this mechanism: {why}")


def complex_normal(rng: np.random.Generator, *size: int) -> Complex:
    """Return complex numbers whose real and imaginary parts are normal."""
    return np.asarray(rng.normal(size=size) + 1j * rng.normal(size=size))
