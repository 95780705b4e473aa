"""Starts: random values of the passive joints, over all the space that they may be in."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from pmjac_pin.linkage import Edge
from pmjac_pin.modes.search_problem import SearchProblem

Array = NDArray[np.float64]

_REACH = 2.0  # characteristic lengths to either side of home, for slides without limits


@dataclass(frozen=True, slots=True, eq=False)
class StartSpace:
    """The space of passive joint values at given motor values.

    Angles are uniform over a full turn or between narrower limits, slides between their limits
    or within 2 characteristic lengths of home, orientations uniform over all rotations.

    Attributes
    ----------
    base : ndarray, shape (nq,)
        The home pose, with the motors at their values.
    passive : tuple of (slice, Edge)
        Each passive joint's entries in q.
    reach : float
        How far slides without limits go to either side of home, m.
    """

    base: Array
    passive: tuple[tuple[slice, Edge], ...]
    reach: float

    @classmethod
    def of(cls, problem: SearchProblem, limits: bool) -> StartSpace:
        """Return the start space of a problem, within the joints' limits or not."""
        passive = problem.passive
        if not limits:
            passive = tuple((entries, replace(edge, limits=None)) for entries, edge in passive)
        return cls(problem.base, passive, _REACH * problem.length)

    def draw(self, rng: np.random.Generator, count: int) -> Array:
        """Return `count` random rows of q."""
        q = np.tile(self.base, (count, 1))
        for entries, edge in self.passive:
            q[:, entries] = self._drawn(rng, edge, self.base[entries], count)
        return q

    def _drawn(self, rng: np.random.Generator, edge: Edge, home: Array, count: int) -> Array:
        match edge.kind:
            case "revolute":
                return rng.uniform(*_turn(edge), (count, 1))
            case "prismatic":
                return rng.uniform(*self._slide(edge, home), (count, 1))
            case "continuous":
                return _on_circle(rng, count)
            case "spherical":
                return _rotations(rng, count)
        slides = home[:2] if edge.kind == "planar" else home[:3]
        turns = _on_circle(rng, count) if edge.kind == "planar" else _rotations(rng, count)
        reached = slides + rng.uniform(-self.reach, self.reach, (count, slides.size))
        return np.column_stack([reached, turns])

    def _slide(self, edge: Edge, home: Array) -> tuple[Array, Array]:
        lower, upper = edge.limits or (home - self.reach, home + self.reach)
        return np.maximum(lower, home - self.reach), np.minimum(upper, home + self.reach)


def _turn(edge: Edge) -> tuple[Array, Array]:
    lower, upper = edge.limits or (-np.inf, np.inf)
    if np.all(upper / 2.0 - lower / 2.0 < np.pi):
        return np.asarray(lower), np.asarray(upper)
    return np.array([-np.pi]), np.array([np.pi])


def _on_circle(rng: np.random.Generator, count: int) -> Array:
    angle = rng.uniform(-np.pi, np.pi, count)
    return np.column_stack([np.cos(angle), np.sin(angle)])


def _rotations(rng: np.random.Generator, count: int) -> Array:
    quaternions: Array = Rotation.random(count, rng).as_quat()
    return quaternions
