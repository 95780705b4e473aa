"""PolynomialTable: polynomials expanded once, evaluated over many points at once.

All monomials of the polynomials and of their derivatives are products of the same few variables;
the values are a sparse matrix of coefficients times the monomials.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from flint import acb, fmpq, fmpq_mpoly
from numpy.typing import NDArray
from scipy.sparse import csr_array

from pmjac_pin.algebra.arrays import Numbers
from pmjac_pin.algebra.series import Exponents
from pmjac_pin.values.arrays import Complex

BallMatrix = NDArray[Any]


class PolynomialTable:
    """Polynomials with rational coefficients, and their derivatives by each variable.

    Parameters
    ----------
    polynomials : sequence of fmpq_mpoly
        All in the same variables.
    variables : int
        How many those are.
    """

    def __init__(self, polynomials: Sequence[fmpq_mpoly], variables: int) -> None:
        self._rows, self._variables = len(polynomials), variables
        whole = [
            *polynomials,
            *(one.derivative(index) for one in polynomials for index in range(variables)),
        ]
        terms = [{_small(exponents): c for exponents, c in one.to_dict().items()} for one in whole]
        monomials = sorted({exponents for row in terms for exponents in row})
        number = {exponents: index for index, exponents in enumerate(monomials)}
        self._factors = _factors(monomials, variables)
        self._exact = [[(number[exponents], c) for exponents, c in row.items()] for row in terms]
        self._coefficients = _sparse(self._exact, len(monomials))

    def evaluate(self, points: Complex) -> tuple[Complex, Complex]:
        """Return the values (b, rows) at points (b, variables), and (b, rows, variables)."""
        factors = np.vstack([points.T, np.ones((1, len(points)))])
        monomials = factors[self._factors[0]]
        for column in self._factors[1:]:
            monomials *= factors[column]
        found = np.asarray((self._coefficients @ monomials).T)
        shape = (len(points), self._rows, self._variables)
        return found[:, : self._rows], found[:, self._rows :].reshape(shape)

    def record(self, points: Numbers) -> tuple[Numbers, Numbers]:
        """Return what `evaluate` does, of numbers of a program."""
        found = np.array([self._over(self._exact, point, float) for point in points])
        shape = (len(points), self._rows, self._variables)
        return found[:, : self._rows], found[:, self._rows :].reshape(shape)

    def values_in_balls(self, point: BallMatrix) -> BallMatrix:
        """Return enclosures of the values (rows,) over one point's balls."""
        return self._over(self._exact[: self._rows], point, acb)

    def slopes_in_balls(self, point: BallMatrix) -> BallMatrix:
        """Return enclosures of the derivatives (rows, variables) over one point's balls."""
        slopes = self._over(self._exact[self._rows :], point, acb)
        return slopes.reshape(self._rows, self._variables)

    def _over(
        self, rows: Sequence[Sequence[tuple[int, fmpq]]], point: Numbers, number: type
    ) -> Numbers:
        """Return sums of one point's monomials, whose coefficients become such numbers."""
        factors = np.concatenate([point, [number(1)]])
        monomials = np.multiply.reduce(factors[self._factors], axis=0)
        found = np.empty(len(rows), dtype=object)
        for index, row in enumerate(rows):
            found[index] = sum((monomials[place] * number(c) for place, c in row), number(0))
        return found


def _small(exponents: Sequence[Any]) -> Exponents:
    return tuple(int(exponent) for exponent in exponents)


def _factors(monomials: Sequence[Exponents], variables: int) -> NDArray[np.intp]:
    """Return for each monomial which variables to multiply; `variables` stands for 1."""
    degree = max((sum(exponents) for exponents in monomials), default=0)
    found = np.full((max(1, degree), len(monomials)), variables, dtype=np.intp)
    for column, exponents in enumerate(monomials):
        each = [index for index, exponent in enumerate(exponents) for _ in range(exponent)]
        found[: len(each), column] = each
    return found


def _sparse(rows: Sequence[Sequence[tuple[int, fmpq]]], columns: int) -> csr_array:
    """Return the coefficients, rounded to doubles, as a matrix (rows, columns)."""
    entries = [(float(c), row, k) for row, terms in enumerate(rows) for k, c in terms]
    values, row, column = zip(*entries, strict=True) if entries else ((), (), ())
    data = np.array(values, dtype=complex)
    return csr_array((data, (row, column)), shape=(len(rows), columns))
