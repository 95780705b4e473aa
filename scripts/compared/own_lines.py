"""What one writes where a library gives a loop's gap and its Jacobian, and nothing more.

The same lines for all of them, with NumPy and SciPy, so that they differ by what they give alone.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import fsolve

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Loop:
    """A planar loop as a library has it: the gap at q and its Jacobian, x and y in two rows."""

    opened: Callable[[Array], tuple[Array, Array]]
    home: Array
    crank: int  # the number of its joint in q
    rocker: int

    @property
    def others(self) -> list[int]:
        """Return the joints that the loop moves."""
        return [joint for joint in range(len(self.home)) if joint != self.crank]

    def rates(self, q: Array) -> Array:
        """Return the rates of all joints by the crank's."""
        _, jacobian = self.opened(q)
        rates = np.ones(len(q))
        rates[self.others] = -np.linalg.solve(jacobian[:, self.others], jacobian[:, self.crank])
        return rates


def newton(loop: Loop, crank: float, start: Array | None = None) -> tuple[Array, float]:
    """Return q and the gap that is left, from home unless told otherwise."""
    q = np.array(loop.home if start is None else start)
    q[loop.crank] = crank
    for _ in range(100):
        gap, jacobian = loop.opened(q)
        q[loop.others] -= np.linalg.lstsq(jacobian[:, loop.others], gap, rcond=None)[0]
    return q, float(np.linalg.norm(loop.opened(q)[0]))


def end_of_mode(loop: Loop, near: float) -> float:
    """Return the crank's angle where the loop is closed and det K* is zero."""

    def equations(q: Array) -> Array:
        gap, jacobian = loop.opened(q)
        return np.append(gap, np.linalg.det(jacobian[:, loop.others]))

    found: Array = fsolve(equations, newton(loop, near)[0], xtol=1e-12)
    return float(found[loop.crank])


def ways(loop: Loop, crank: float, starts: int = 50) -> int:
    """Count what Newton's method finds from random starts."""
    random, found = np.random.default_rng(0), set()
    for _ in range(starts):
        q, gap = newton(loop, crank, random.uniform(-np.pi, np.pi, len(loop.home)))
        if gap < 1e-9:
            found.add(tuple(np.exp(1j * q).round(6)))
    return len(found)


def mobility(jacobian: Array) -> str:
    """Return how many joint rates the equations leave free: columns less rank."""
    return str(jacobian.shape[1] - np.linalg.matrix_rank(jacobian, tol=1e-9))
