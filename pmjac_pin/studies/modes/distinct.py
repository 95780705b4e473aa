"""Distinct: which closed poses are the same machine in the same place.

Two rows of q are one pose where all bodies are: a turn of 2π and the sign of a quaternion do not
show there. Nor does what spins idly: bodies that idle together are compared as they are seen from
one of them, and all the others, as far as they do not idle, as they are seen from the world.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial

import numpy as np

from pmjac_pin.kinematics.many import WorldPoses
from pmjac_pin.studies.modes.idling import Idling
from pmjac_pin.studies.modes.marks import Mark, marks
from pmjac_pin.studies.modes.search_problem import SearchProblem
from pmjac_pin.values.arrays import Array, Mask


@dataclass(frozen=True, slots=True, eq=False)
class Signatures:
    """What tells poses apart: the bodies' positions and axes, without dimension.

    What of these an idle motion changes does not tell; what is left is seen from the world and
    from one body of each group that idles together. The machine's marks are seen, too: a point
    on the axis of an idle spin is at rest, and no body is.

    Attributes
    ----------
    problem : SearchProblem
    sights : tuple of callable
        What there is to see of poses.
    views : tuple of (int, list of int)
        From which body poses are seen, and which sights count there.
    within : float
        What differs by less is the same.
    """

    problem: SearchProblem
    sights: tuple[Mark, ...]
    views: tuple[tuple[int, list[int]], ...]
    within: float

    @classmethod
    def of(cls, problem: SearchProblem, rows: Array) -> Signatures:
        """Return the signatures of a problem.

        Parameters
        ----------
        problem : SearchProblem
        rows : ndarray, shape (b, nq)
            Closed poses, which show what idles.
        """
        idling, sights = Idling.of(problem, rows), tuple(_sights(problem))
        blank, views = [np.zeros((1, 1))] * len(sights), []
        for body, *_ in idling.groups():

            def seen(poses: WorldPoses, body: int = body) -> list[Array]:
                there = poses.seen_from(body)
                return [sight(there)[:, None] for sight in sights]

            rest = np.concatenate(idling.at_rest(blank, seen))
            views.append((body, np.flatnonzero(rest).tolist()))
        return cls(problem, sights, tuple(views), idling.sameness)

    def __call__(self, q: Array) -> Array:
        """Return the signature of each row of q, shape (b, entries)."""
        poses = self.problem.tree.poses(q)
        views = ((poses.seen_from(body), counts) for body, counts in self.views)
        return np.hstack([self.sights[k](there) for there, counts in views for k in counts])

    def alike(self, other: Signatures) -> bool:
        """Tell whether other signatures of the same problem compare the same."""
        return (self.views, self.within) == (other.views, other.within)

    def same(self, signatures: Array, known: Array) -> Mask:
        """Tell which of these signatures (b, entries) are that of one known pose."""
        apart = np.abs(signatures - known).max(axis=1, initial=0.0)
        return np.asarray(apart <= self.within)


def _sights(problem: SearchProblem) -> list[Mark]:
    """Return the bodies' places and axes, and the marks; where nothing idles, bodies tell all."""
    bodies = range(problem.model.njoints)
    places = [partial(_place, body, problem.length) for body in bodies]
    axes = [partial(_body_axes, body) for body in bodies]
    return [*places, *axes, *(marks(problem) if problem.idle else [])]


def _place(body: int, length: float, poses: WorldPoses) -> Array:
    return np.asarray(poses.positions[body] / length)


def _body_axes(body: int, poses: WorldPoses) -> Array:
    return np.asarray(poses.rotations[body].reshape(-1, 9))


class Distinct:
    """The poses met so far, each once, and how often each was met.

    Attributes
    ----------
    q : list of ndarray, shape (nq,)
    hits : list of int
    """

    def __init__(self, signatures: Signatures) -> None:
        self._signatures = signatures
        self._known: list[Array] = []
        self.q: list[Array] = []
        self.hits: list[int] = []

    def add(self, rows: Array, times: int = 1) -> bool:
        """Count closed poses (b, nq), each so many times; tell whether any of them is new."""
        signatures, before = self._signatures(rows), len(self.q)
        for index, known in enumerate(self._known):
            same = self._signatures.same(signatures, known)
            self.hits[index] += times * int(same.sum())
            rows, signatures = rows[~same], signatures[~same]
        while len(rows):
            same = self._signatures.same(signatures, signatures[0])
            self.q.append(rows[0])
            self._known.append(signatures[0])
            self.hits.append(times * int(same.sum()))
            rows, signatures = rows[~same], signatures[~same]
        return len(self.q) > before

    def by(self, signatures: Signatures) -> Distinct:
        """Return the same poses as other signatures tell them apart."""
        if signatures.alike(self._signatures):
            return self
        other = Distinct(signatures)
        for q, hits in zip(self.q, self.hits, strict=True):
            other.add(q[None], hits)
        return other
