"""Paths: how much a point of a chain can bend when its joints move, from its lengths alone.

A point that a chain of joints carries is at p = Σₖ R₁⋯Rₖ dₖ, with Rᵢ the turn of the i-th joint
and dₖ what leads from the k-th joint to the next, the last to the point. A turn by a rotation
vector hᵢ changes Rᵢ by at most |hᵢ| in its first and |hᵢ|² in its second derivative (1-dof
joint or ball: `docs/certificates.md`), a slide hₛ changes dₖ by |hₛ| and not in the second. So

    |Dp[h]| ≤ c·|h|,    |D²p[h, h]| ≤ |h|ᵀ M |h|

with cⱼ, Mⱼₖ the length of the path from joint j, from the deeper of j and k, to the point;
1 for a slide, 1 for a turn above a slide, and 0 for all other pairs with a slide.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Path:
    """A chain of turns that carries a point.

    Attributes
    ----------
    turns : tuple of int
        The unknowns that turn, by their group, from the base to the point.
    lengths : tuple of float
        Of the way from the base to the first turn, to the next, ..., to the point, m; one more
        than turns.
    slides : tuple of tuple of int
        The unknowns that slide on each of these ways.
    """

    turns: tuple[int, ...]
    lengths: tuple[float, ...]
    slides: tuple[tuple[int, ...], ...]

    def first(self, groups: int, reach: float) -> Array:
        """Return c, shape (groups,), where slides are at most `reach` m from where they are."""
        c = np.zeros(groups)
        for length, above, slides in self._ways(groups):
            c += (length + reach * slides.sum()) * above + slides
        return c

    def second(self, groups: int, reach: float) -> Array:
        """Return M, shape (groups, groups), where slides are at most `reach` m from here."""
        M = np.zeros((groups, groups))
        for length, above, slides in self._ways(groups):
            M += (length + reach * slides.sum()) * np.outer(above, above)
            M += np.outer(above, slides) + np.outer(slides, above)
        return M

    def _ways(self, groups: int) -> list[tuple[float, Array, Array]]:
        """Return each way's length, and which groups turn above it and slide on it."""
        ways = []
        for k, (length, slides) in enumerate(zip(self.lengths, self.slides, strict=True)):
            ways.append((length, _marks(self.turns[:k], groups), _marks(slides, groups)))
        return ways


def _marks(members: Sequence[int], groups: int) -> Array:
    marks = np.zeros(groups)
    marks[list(members)] = 1.0
    return marks
