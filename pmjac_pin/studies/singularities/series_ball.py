"""SeriesBall: Krawczyk's test over a cube of motor values, along polynomials of degree 2.

Let φ̃(θ) be polynomials for the passive joints, F(v) = η(θ, φ̃(θ) ⊕ v), A about the inverse of K* at
the pose, and component by component, for all |θ| ≤ ρ,

    Y ≥ |A F(0)|,    E ≥ |I − A K*| for all |v| ≤ r.

Where Y + E r ≤ r there is a closed pose within r of the polynomials, and with Z = max (E r / r) < 1
and what turns of several axes add to it, only one; K* is regular there. Y is of third order in ρ,
and E is bounded by its Taylor polynomial (`RateSeries`). As many rows of loops and tool stay
independent where E w < w for such a bound E on |I − A M| and some weights w > 0.

By steps v of constant twists, F(v) − F(0) = ∫ K*(φ̃ ⊕ s v) v ds, and ∂F/∂v = K* (1 + D) with D of at
most 2 and a little times the largest turn.
"""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from pmjac_pin.algebra.balls import OUTWARDS
from pmjac_pin.algebra.intervals import Intervals
from pmjac_pin.algebra.series import Exponents, largest_sizes
from pmjac_pin.configuration import Configuration
from pmjac_pin.studies.certificates.certificate import independent_square
from pmjac_pin.studies.certificates.tool_rates import ToolRates
from pmjac_pin.studies.singularities.rate_series import Coefficients, RateSeries, SeriesRates
from pmjac_pin.values.arrays import Array, Index

_TO_DOUBLE, _TIMES = 4, 24  # steps until ρ is twice as large, and in all
_ROUNDS, _WIDER = 3, 1.2
_BY_TURNS = 3.0  # more than 2
_WEIGHED = 8  # times: a weight for each unknown by which ‖I − A M‖ is nearly least
_LEAST_RADIUS = 1e-3  # of the largest


class SeriesBall:
    """The test about a pose.

    Parameters
    ----------
    configuration : Configuration
    kept : tuple of ndarray of int
        Rows and passive columns of the square K*.
    groups : ndarray, shape (g, m_p)
        1 for the passive freedoms that are turns of one joint, or its slides.
    tool : ToolRates, optional
        What the tool may not lose either.

    Raises
    ------
    ArgumentError
        As `RateSeries`.
    """

    def __init__(
        self,
        configuration: Configuration,
        kept: tuple[Index, Index],
        groups: Array,
        tool: ToolRates | None,
    ) -> None:
        self._series = RateSeries(configuration, tool)
        self._partition, self._tool = configuration.problem.partition, tool
        partition, nv = self._partition, configuration.mechanism.nv
        self._unit = partition.length * partition.column_scale
        self._rows, self._columns = kept[0], partition.passive[kept[1]]
        self._groups = groups[:, kept[1]]
        self._constant: Exponents = (0,) * partition.actuated.size
        here = self._series.over({}, np.zeros(nv))
        square = self._square(here.rates[self._constant]).middle
        self._A = np.asarray(np.linalg.inv(square)) if len(square) else square
        self._here = here

    def largest(self, radius: float) -> tuple[float, float]:
        """Return the largest ρ that is proven, beginning near one, and how far passive joints go.

        Zeros where none is.
        """
        found, begin = (0.0, 0.0), math.ceil(math.log2(radius) * _TO_DOUBLE)
        for k in range(begin, begin + _TIMES):
            tried = 2.0 ** (k / _TO_DOUBLE)
            far = self._proven(tried)
            if far is None:
                break
            found = tried, far
        return found

    def _proven(self, radius: float) -> float | None:
        """Return how far passive joints go where it holds, rad or lengths; None where it fails."""
        ways = self._ways(radius)
        still = np.zeros(self._unit.size)
        second = self._series.over(ways, still)
        ways |= self._bent(second)
        along = self._series.over(ways, still)
        own = (term[self._rows][:, None] for term in along.residual.values())
        Y = largest_sizes(term.after(self._A)[:, 0] for term in own)
        radii = self._alike(_WIDER * Y + _LEAST_RADIUS * Y.max(initial=0.0))
        for _ in range(_ROUNDS):
            around = self._series.over(ways, self._radii(radii))
            E = self._contraction(around.rates)
            reached = OUTWARDS * (Y + OUTWARDS * (E @ radii))
            if (reached <= radii).all():
                return self._far(ways, radii) if self._holds(around, E, radii) else None
            if not np.isfinite(reached).all() or (reached > 10.0 * radius).any():
                return None
            radii = np.maximum(radii, _WIDER * self._alike(reached))
        return None

    def _ways(self, radius: float) -> dict[Exponents, Array]:
        """Return how joints move to first order, by each motor, over the cube."""
        K = self._here.rates[self._constant].middle[self._rows]
        found: dict[Exponents, Array] = {}
        for k, column in enumerate(self._partition.actuated.tolist()):
            way = np.zeros(self._unit.size)
            way[column] = radius * self._unit[column]
            way[self._columns] = -self._unit[self._columns] * (
                self._A @ (K[:, column] * way[column])
            )
            found[tuple(int(j == k) for j in range(len(self._constant)))] = way
        return found

    def _bent(self, along: SeriesRates) -> dict[Exponents, Array]:
        """Return how joints move to second order."""
        found: dict[Exponents, Array] = {}
        for key, term in along.residual.items():
            if sum(key) > 1:
                found[key] = np.zeros(self._unit.size)
                bent = self._A @ term.middle[self._rows]
                found[key][self._columns] = -self._unit[self._columns] * bent
        return found

    def _radii(self, radii: Array) -> Array:
        """Return radii of the unknowns as those of all joints, m or rad."""
        found = np.zeros(self._unit.size)
        found[self._columns] = OUTWARDS * radii * self._unit[self._columns]
        return found

    def _alike(self, radii: Array) -> Array:
        """Return radii that are the same for the turns of a joint, and for its slides."""
        marked = np.where(self._groups > 0.0, radii, 0.0).max(axis=1, initial=0.0)
        return np.asarray((self._groups * marked[:, None]).max(axis=0, initial=0.0))

    def _square(self, rates: Intervals) -> Intervals:
        """Return the square K*, by the units of its unknowns: rad, or lengths."""
        unit = Intervals.exact(self._unit[self._columns])
        return rates[self._rows][:, self._columns] * unit

    def _contraction(self, rates: Coefficients) -> Array:
        """Return E."""
        squares = {key: self._square(term) for key, term in rates.items()}
        return _away_from_identity(self._A, squares, self._constant)

    def _holds(self, around: SeriesRates, E: Array, radii: Array) -> bool:
        """Tell whether there is one closed pose only, and loops and tool keep their rank."""
        Z = float(OUTWARDS * (OUTWARDS * (E @ radii) / radii).max(initial=0.0))
        turned = _BY_TURNS * OUTWARDS * radii.max(initial=0.0)
        alone = OUTWARDS * (Z + (1.0 + Z) * turned) < 1.0
        return alone and around.cosine > 0.0 and (self._tool is None or self._keeps(around))

    def _keeps(self, around: SeriesRates) -> bool:
        """Tell whether as many rows of loops and tool stay independent as at the pose."""
        unit = Intervals.exact(self._unit)
        partition, middle = self._partition, self._here.rates[self._constant].middle
        scale = np.concatenate(
            [partition.row_scale, np.ones(len(middle) - partition.row_scale.size)]
        )
        rank = partition.constraint_rank + partition.tool_rank
        rows, columns = independent_square(middle * self._unit * scale[:, None], rank)
        own = {key: (term * unit)[rows][:, columns] for key, term in around.rates.items()}
        A = np.asarray(np.linalg.inv((middle * self._unit)[np.ix_(rows, columns)]))
        E = _away_from_identity(A, own, self._constant)
        weights = np.ones(len(E))
        for _ in range(_WEIGHED):
            weights = E @ weights + _LEAST_RADIUS * weights.max()
        return bool((OUTWARDS * (E @ weights) < weights).all())

    def _far(self, ways: Mapping[Exponents, Array], radii: Array) -> float:
        """Return how far passive joints go at most, rad or lengths."""
        sizes = [np.abs(way[self._columns]) / self._unit[self._columns] for way in ways.values()]
        return float(OUTWARDS * (np.sum(sizes, axis=0) + radii).max(initial=0.0))


def _away_from_identity(A: Array, terms: Coefficients, constant: Exponents) -> Array:
    """Return bounds on |I − A M| of M by its coefficients, entry by entry."""
    found = {key: term.after(A) for key, term in terms.items()}
    found[constant] = Intervals.exact(np.eye(len(A))) - found[constant]
    return largest_sizes(found.values())
