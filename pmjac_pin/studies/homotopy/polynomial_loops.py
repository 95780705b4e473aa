"""The loop equations as polynomials in complex unknowns x, for motors p that are complex, too.

They are homogeneous in (X, h), with x = X/h, so that solutions far away are as easy to follow as
others. Every pose is a product of matrices of polynomials, and so are the rows of η. Tilts and
turns are taken as t·a = 0 and as the skew part of R, which vanish at half a turn as well: `unmet`
tells. The coefficients are the doubles of the model, exactly, but that entries of a rotation below
rounding are zero.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cached_property

import numpy as np
from flint import Ordering, acb, fmpq_mpoly, fmpq_mpoly_ctx
from numpy.typing import NDArray

from pmjac_pin.algebra.arrays import Numbers
from pmjac_pin.algebra.complex_terms import complex_terms, real_and_imaginary
from pmjac_pin.algebra.polynomials import Symbols, symbols
from pmjac_pin.algebra.tape import Tape
from pmjac_pin.algebra.terms import Recording
from pmjac_pin.errors import ArgumentError
from pmjac_pin.kinematics.loops import pair_of
from pmjac_pin.model.linkage import edges_of
from pmjac_pin.model.loop_spec import JointLoop
from pmjac_pin.rates.partition import independent_rows
from pmjac_pin.studies.homotopy.joint_unknowns import joint_unknowns
from pmjac_pin.studies.homotopy.polynomial_rows import PolynomialRows
from pmjac_pin.studies.homotopy.polynomial_table import PolynomialTable
from pmjac_pin.studies.modes.search_problem import SearchProblem
from pmjac_pin.values.arrays import Array, Complex

_UNKNOWN_SPREAD = 0.3  # of random unknowns about home's


class PolynomialLoops:
    """F(X, h; p, γ) = 0: unit lengths and independent rows of η + γ, over many points at once.

    Parameters
    ----------
    problem : SearchProblem
    rods : sequence of int
        The closures that are rods whose length² is a parameter: legs with motors.

    Attributes
    ----------
    count : int
        Of unknowns, and of equations.
    rows : int
        Of equations that are rows of η: the last ones.
    length : float
        The characteristic length, m.
    tolerance : float
        The gap that counts as closed, in lengths.

    Raises
    ------
    ArgumentError
        Idle motions, geared joints: what has no isolated solutions or no polynomials.
    """

    def __init__(self, problem: SearchProblem, rods: Sequence[int]) -> None:
        self.length = problem.length
        self.tolerance = problem.mechanism.problem.tolerance / problem.length
        edges, passive = edges_of(problem.model), [edge.name for _, edge in problem.passive]
        self._joints = joint_unknowns(problem.model, edges, passive, problem.length)
        self._motors = [joint for joint in self._joints if joint.motor]
        self._passive = [joint for joint in self._joints if not joint.motor]
        self._parameters = len(self._motors) + len(rods)
        self._units = [joint.unit for joint in self._passive if joint.unit is not None]
        self._free = [joint.columns for joint in self._passive if joint.floating]
        self.count = max((joint.columns.stop for joint in self._passive), default=0)
        kept = _independent_rows(problem)
        self.rows = kept.size
        if len(self._units) + len(self._free) + self.rows != self.count:
            why = "passive motions that idle leave no isolated solutions"
            raise ArgumentError(f"{problem.model.name}: no homotopy for this mechanism: {why}")
        self._home = self.unknowns(problem.base[None])[0]
        driven = max((joint.columns.stop for joint in self._joints), default=0)
        size = driven + len(rods) + self.rows + 1
        context = fmpq_mpoly_ctx.get([f"v{index}" for index in range(size)], Ordering.degrevlex)
        variables = symbols(context.gens())
        rows, turned_over = self._equations(problem, variables, driven, rods)
        units = [(variables[unit] * variables[unit]).sum() - 1 for unit in self._units]
        units += [(variables[own][:4] * variables[own][4:]).sum() for own in self._free]
        gaps = variables[driven + len(rods) : -1]
        shut = [rows[kept_row] + gap for kept_row, gap in zip(kept, gaps, strict=True)]
        self._table = PolynomialTable(
            [_homogeneous(one, context, self.count) for one in (*units, *shut)], size
        )
        checks = [context.constant(0) + one for one in (*rows, *turned_over)]
        self._checks = PolynomialTable(checks, size)

    def evaluate(self, X: Complex, machine: Complex, rate: Complex) -> tuple[Complex, Complex]:
        """Return F (b, count), and its derivatives by (X, h) and along `rate`.

        Parameters
        ----------
        X : ndarray, shape (b, count + 1)
            The unknowns, h last.
        machine, rate : ndarray, shape (b, k + rows)
            p and γ, and how they change.
        """
        return self._along(X, machine, rate, self._table.evaluate)

    @cached_property
    def tape(self) -> Tape:
        """The program of the equations over a line of machines, for all lines of a mechanism.

        Inputs are (X, h, t), p and γ at t = 0, and how much these change until t = 1; outputs are
        rows (∂F/∂(X, h, t), F). All are complex: a real and an imaginary part each.
        """
        size, machine = self.count + 2, self._parameters + self.rows
        recording = Recording(2 * (size + 2 * machine))
        numbers = complex_terms(recording.inputs)
        point, start, rate = np.split(numbers, [size, size + machine])
        there = start + rate * point[-1]
        values, slopes = self._along(point[None, :-1], there[None], rate[None], self._table.record)
        rows = np.concatenate([slopes, values[:, :, None]], axis=2)
        return Tape.of(recording, real_and_imaginary(rows.ravel().tolist()))

    def _along(
        self,
        X: Numbers,
        machine: Numbers,
        rate: Numbers,
        table: Callable[[Numbers], tuple[Numbers, Numbers]],
    ) -> tuple[Numbers, Numbers]:
        p, dp = machine[:, : -self.rows or None], rate[:, : -self.rows or None]
        gaps, opening = machine[:, p.shape[1] :], rate[:, p.shape[1] :]
        x, h = X[:, :-1], X[:, -1:]
        values, slopes = table(np.hstack([x, self._driven(p), gaps, h]))
        rates = np.hstack([self._driven_rates(p, dp), opening])
        along = slopes[:, :, self.count : -1] @ rates[:, :, None]
        by_x = (slopes[:, :, : self.count], slopes[:, :, -1:])
        return values, np.concatenate([*by_x, along], axis=2)

    def values_in_balls(self, x: Numbers, driven: Numbers) -> Numbers:
        """Return enclosures of F (count,) over balls; h = 1, γ = 0.

        `driven` are the motors' numbers, as `driven_balls` gives them, and the rods' lengths².
        """
        return self._table.values_in_balls(self._shut(x, driven))

    def slopes_in_balls(self, x: Numbers, driven: Numbers) -> Numbers:
        """Return enclosures of the derivatives of F by x (count, count); see `values_in_balls`."""
        return self._table.slopes_in_balls(self._shut(x, driven))[:, : self.count]

    def _shut(self, x: Numbers, driven: Numbers) -> Numbers:
        """Return the variables' balls with h = 1 and γ = 0."""
        rest = np.array([acb(0)] * self.rows + [acb(1)], dtype=object)
        return np.concatenate([x, driven, rest])

    def gaps(self, x: Complex, p: Complex) -> Complex:
        """Return the offsets γ that shut the loops at one x."""
        values, _ = self._table.evaluate(self._plain(x[None], p[None]))
        return np.asarray(-values[0, self.count - self.rows :])

    def unmet(self, x: Complex, p: Complex) -> Array:
        """Return how far solutions (b, n) are from the rows left out, and from half a turn."""
        values, _ = self._checks.evaluate(self._plain(x, np.tile(p, (len(x), 1))))
        return np.asarray(np.abs(values).max(axis=1, initial=0.0))

    def _plain(self, x: Complex, p: Complex) -> Complex:
        """Return the variables' values with h = 1 and γ = 0."""
        rest = np.zeros((len(x), self.rows + 1))
        rest[:, -1] = 1.0
        return np.hstack([x, self._driven(p), rest])

    @property
    def names(self) -> tuple[str, ...]:
        """What each unknown is."""
        return tuple(name for joint in self._passive for name in joint.names)

    def unknowns(self, q: Array) -> Complex:
        """Return x of real poses, rows of q."""
        x = np.zeros((len(q), self.count), dtype=complex)
        for joint in self._passive:
            x[:, joint.columns] = joint.numbers(q)
        return x

    def motor_parameters(self, q: Array) -> Complex:
        """Return the motors' parameters at one q; those of rods are not among them."""
        return np.array([joint.parameter(q) for joint in self._motors], dtype=complex)

    def driven_balls(self, q: Array) -> Numbers:
        """Return enclosures of the motors' numbers at one q."""
        balls = [ball for joint in self._motors for ball in joint.balls(q)]
        return np.array(balls, dtype=object)

    def poses(self, x: Array, base: Array) -> Array:
        """Return rows of q: `base` with the passive joints of real solutions."""
        q = np.tile(base, (len(x), 1))
        for joint in self._passive:
            joint.put(x, q)
        return q

    def twins(self, x: Numbers) -> list[Numbers]:
        """Return x with the signs of its quaternions turned in every combination."""
        found = [x]
        for joint in self._passive:
            if joint.two_signs:
                turned = np.ones(self.count)
                turned[joint.columns] = -1.0
                found += [turned * other for other in found]
        return found

    def somewhere(self, rng: np.random.Generator) -> Complex:
        """Return random complex unknowns about home whose units have length 1, shape (count,)."""
        x: Complex = rng.normal(size=self.count) + 1j * rng.normal(size=self.count)
        x = self._home + _UNKNOWN_SPREAD * x
        for unit in self._units:
            x[unit] /= np.sqrt((x[unit] * x[unit]).sum())
        for own in self._free:
            g, e = x[own][:4], x[own][4:]
            x[own.start : own.start + 4] -= (g * e).sum() * e
        return x

    def _driven(self, p: Numbers) -> Numbers:
        """Return the variables that follow from the parameters (b, k)."""
        columns = [
            numbers
            for index, joint in enumerate(self._motors)
            for numbers in joint.from_parameter(p[:, index])
        ]
        return np.column_stack([*columns, p[:, len(self._motors) :]])

    def _driven_rates(self, p: Numbers, rate: Numbers) -> Numbers:
        columns = [
            slope * rate[:, index]
            for index, joint in enumerate(self._motors)
            for slope in joint.parameter_rates(p[:, index])
        ]
        return np.column_stack([*columns, rate[:, len(self._motors) :]])

    def _equations(
        self, problem: SearchProblem, variables: Symbols, driven: int, rods: Sequence[int]
    ) -> tuple[list[fmpq_mpoly], list[fmpq_mpoly]]:
        """Return all rows of η, and what is 0 at a closed pose and not at half a turn."""
        polynomials = PolynomialRows(problem.model, self._joints, variables, self.length)
        lengths = {loop: driven + place for place, loop in enumerate(rods)}
        rows: list[fmpq_mpoly] = []
        turned_over: list[fmpq_mpoly] = []
        for index, loop in enumerate(problem.closures):
            if isinstance(loop, JointLoop):
                why = "geared joints are no polynomials in their cosines and sines"
                raise ArgumentError(f"{problem.model.name}: no homotopy for this mechanism: {why}")
            pair = pair_of(problem.model, polynomials.tree, loop, problem.mechanism.parameters)
            place = lengths.get(index)
            square = None if place is None else variables[place : place + 1, None]
            more, over = polynomials.of(pair, square)
            rows += more
            turned_over += over
        return rows, turned_over


def _homogeneous(one: fmpq_mpoly, context: fmpq_mpoly_ctx, unknowns: int) -> fmpq_mpoly:
    """Return a polynomial with each term times hᵏ, so that all have the same degree in (X, h)."""
    terms = {tuple(map(int, powers)): c for powers, c in one.to_dict().items()}
    degree = max((sum(powers[:unknowns]) for powers in terms), default=0)
    raised = {(*powers[:-1], degree - sum(powers[:unknowns])): c for powers, c in terms.items()}
    return context.from_dict(raised)


def _independent_rows(problem: SearchProblem) -> NDArray[np.intp]:
    """Return rows of η that are independent at the problem's base."""
    [jacobian] = problem.loops.evaluate(problem.base[None])[1]
    loops = problem.partition.loop_rates(jacobian)
    scaled, passive = loops.scaled, loops.passive
    return independent_rows(scaled[:, problem.partition.passive], passive.rank)
