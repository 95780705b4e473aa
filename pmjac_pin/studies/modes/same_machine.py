"""SameMachine: which closed poses differ only in bodies that are turned over unseen.

The axle of a delta's leg fits its hinges turned by half a turn as well. Its body is then in
another pose, and the machine is not: the tool, all points and all axes, as lines, are where they
were, so that J_eq is the same; and what is drawn looks the same.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pmjac_pin.configuration import Configuration
from pmjac_pin.kinematics.many import WorldPoses
from pmjac_pin.mechanism import Mechanism
from pmjac_pin.studies.modes.drawings import Drawings
from pmjac_pin.studies.modes.idling import Idling
from pmjac_pin.studies.modes.marks import marks
from pmjac_pin.studies.modes.search_problem import search_problem
from pmjac_pin.values.arrays import Array


def same_machines(mechanism: Mechanism, found: Sequence[Configuration]) -> list[list[int]]:
    """Return the poses in groups that are the same machine, in each the nearest to home first.

    Parameters
    ----------
    mechanism : Mechanism
    found : sequence of Configuration
        Closed poses at the same motor values, each once.
    """
    if len(found) < 2:
        return [[index] for index in range(len(found))]
    looks = _all_looks(mechanism, found)
    groups: list[list[int]] = []
    for index in _from_home([bodies[0] for bodies in looks]):
        for group in groups:
            if all(any(one.same(group[0], index) for one in bodies) for bodies in looks):
                group.append(index)
                break
        else:
            groups.append([index])
    return groups


def _all_looks(mechanism: Mechanism, found: Sequence[Configuration]) -> list[list[_Looks]]:
    """Return what poses look like from the world, and from the bodies of each group that idles.

    From any body of a group: which of them is not turned over, is not known.
    """
    problem = search_problem(mechanism, found[0].q)
    rows = np.array([problem.without_legs(one.q) for one in found])
    home = problem.tree.poses(problem.without_legs(mechanism.home.q)[None])
    idling = Idling.of(problem, rows)
    drawings, marked = Drawings(mechanism, problem.model, problem.length), marks(problem)
    poses = problem.tree.poses(rows)

    def looks(body: int) -> _Looks:
        def seen(poses: WorldPoses) -> list[Array]:
            there = poses.seen_from(body)
            places = [mark(there)[:, None] for mark in marked]
            return [*places, there.rotations.swapaxes(0, 1), drawings(there)]

        blocks = seen(poses)
        rest = idling.at_rest(blocks, seen)
        *places, turns, drawn = (block[:, still] for block, still in zip(blocks, rest, strict=True))
        return _Looks(
            places=np.hstack([place.reshape(len(rows), -1) for place in places]),
            turns=turns,
            home=seen(home)[-2][0, rest[-2]],
            drawn=drawn,
            within=idling.sameness,
        )

    return [[looks(0)], *([looks(body) for body in group] for group in idling.groups()[1:])]


def _from_home(looks: Sequence[_Looks]) -> list[int]:
    """Return the poses' order by how little their bodies are turned from home.

    Rounded, so that rounding errors do not decide between those that are equally near.
    """
    far = sum(np.square(one.turns - one.home).sum(axis=(1, 2, 3)) for one in looks)
    turns = [one.turns.reshape(len(one.turns), -1) for one in looks]
    keys = np.column_stack([far, *turns]).round(6) + 0.0
    return sorted(range(len(keys)), key=lambda index: tuple(keys[index]))


@dataclass(frozen=True, slots=True, eq=False)
class _Looks:
    """What is compared of each pose, seen from the world or from a body that idles.

    Attributes
    ----------
    places : ndarray, shape (b, entries)
        Of the tool, of loops, and of the joints' motions, without dimension.
    turns : ndarray, shape (b, bodies, 3, 3)
        Of bodies that do not idle, seen from there.
    home : ndarray, shape (bodies, 3, 3)
    drawn : ndarray, shape (b, pieces, entries)
    within : float
        What differs by less is the same.
    """

    places: Array
    turns: Array
    home: Array
    drawn: Array
    within: float

    def same(self, one: int, other: int) -> bool:
        """Tell whether two poses look the same, bodies being where they were or turned over.

        Half a turn is its own inverse, its matrix symmetric. A small turn's is not: beside a
        singularity, two modes that are about to meet stay two.
        """
        if np.abs(self.places[one] - self.places[other]).max(initial=0.0) > self.within:
            return False
        between = self.turns[one] @ self.turns[other].swapaxes(1, 2)
        if np.abs(between - between.swapaxes(1, 2)).max(initial=0.0) > self.within:
            return False
        return _each_in(self.drawn[one], self.drawn[other], self.within)


def _each_in(pieces: Array, others: Array, within: float) -> bool:
    """Tell whether each drawn piece is one of others: two ends of a bar may change places."""
    return all(np.abs(others - piece).max(axis=1).min() <= within for piece in pieces)
