"""Where idle motions are at the end of a path, whatever steps have led there.

No motor decides how far a rod has spun that spins about itself between two balls. The smallest
rates at each pose, −K*⁺ K θ̇, let it spin as little as they can; but where these lead to depends on
the length of the steps, by more than rounding. So a path leads to one of the closed poses that
differ in what idles: with N₀ (m_p, d) spanning null K* at its start q₀, without dimension, to where

    N₀ᵀ x = 0,    x = q ⊖ q₀ on the passive joints,

joint by joint, a joint's slides in its axes at q₀, its turn as a rotation vector. What idled at the
start has then not moved, measured there. From near by Newton's method finds it, on this and the
loops: with u its step on the loops alone, N spanning null K* at q, and L v the rates of x at v,

    v = u − P (x + L u),    P = N (N₀ᵀ L N)⁻¹ N₀ᵀ:

v = −B⁺ (η, N₀ᵀ x) with N₀ᵀ L below K* in B, whose last columns of B⁺ are N (N₀ᵀ L N)⁻¹.
Near a fold of the loops these steps may lead to another assembly mode: what they find counts where
a step guard covers the way there, with the motors at rest.
P depends on no choice of bases; where nothing has turned it is orthogonal, ‖P‖² = d. Where idle
motions are not those of the start any more, or x is near half a turn, P grows: there, a path is too
long for this, and is cut in two.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
import pinocchio as pin

from pmjac_pin.algebra.floats import Floats
from pmjac_pin.closing.closed import Closed, closed_point, passive_motion
from pmjac_pin.closing.closure_problem import ClosureProblem
from pmjac_pin.closing.step_guard import StepGuard
from pmjac_pin.kinematics.joint_steps import arriving, between
from pmjac_pin.kinematics.tree import Link, Tree
from pmjac_pin.rates.partition import Partition
from pmjac_pin.values.arrays import Array, Index, Mask, norm

# Lengths, a rad counted as one:
LONGEST_PART = 1.0  #: how far motors go before the idle motions are looked at
LARGEST_RETURN = 0.5  #: of the first step back
SETTLED = 1e-12  #: of the step that would be next
UNRESOLVED = 1e-7  #: of a step that does not become smaller: beside a fold, it is rounding
MOST_RETURNS = 20
TURNED = 3.0  #: by how much ‖P‖² may grow

_LEAST_PART = 1e-14  # of an idle motion: less is rounding

_NUMBERS = Floats()


def parts_of(distance: Array) -> Index:
    """Return into how many pieces paths are cut that go so far, in lengths.

    Where that is a whole number, rounding does not decide.
    """
    return np.maximum(1, np.ceil(distance / LONGEST_PART - 1e-6)).astype(np.intp)


class IdleWay:
    """Brings idle motions back to where a path's start had them.

    Parameters
    ----------
    model : pin.Model

    Raises
    ------
    ArgumentError
        A joint that is not in the table of joints.
    """

    __slots__ = ("_loose", "_model")

    def __init__(self, model: pin.Model) -> None:
        self._model, self._loose = model, list[_Alike]()
        loose: dict[str, list[Link]] = {}
        for link in Tree(model).links.values():
            if link.kind.curved and link.kind.slides:
                loose.setdefault(link.kind.name, []).append(link)
        self._loose = [_Alike.of(links) for links in loose.values()]

    def settled(
        self, problem: ClosureProblem, start: Closed, end: Closed, share: float = 1.0
    ) -> Closed | None:
        """Return the closed pose beside the end of a path at which what idled has not moved.

        None where Newton's method does not find it, or where it is too far from the start. With a
        share, the one where of N₀ᵀ x so much is left out.
        """
        here, before = self._seen(problem.partition, start, end), 2.0 * LARGEST_RETURN
        left = np.zeros(len(here.error))
        left[-here.idle :] = (1.0 - share) * here.error[-here.idle :]
        for _ in range(MOST_RETURNS):
            if (inverse := here.inverse()) is None:
                return None
            back = -inverse.dot(here.error - left)
            size = norm(back) / problem.partition.length
            if not (size <= 0.5 * before or size <= UNRESOLVED):
                return None
            here = self._seen(problem.partition, start, _gone_by(problem, here.point, back))
            off = norm(inverse.dot(here.error - left)) / problem.partition.length
            resolved = off <= SETTLED or not size <= 0.5 * before
            if resolved and here.point.gap <= problem.tolerance:
                turned = norm(inverse[:, -here.idle :]) ** 2
                return here.point if turned <= here.idle + TURNED else None
            before = size
        return None

    def is_covered(
        self, problem: ClosureProblem, guard: StepGuard, start: Closed, ends: tuple[Closed, Closed]
    ) -> bool:
        """Tell whether a guard covers what idles between two poses with the motors at rest.

        As a path whose N₀ᵀ x goes straight from that of the one to that of the other.
        """
        here, there = (self._seen(problem.partition, start, end) for end in ends)
        moved = (there.error - here.error)[-here.idle :]
        leaving, arriving = here.idling(moved), there.idling(moved)
        if leaving is None or arriving is None:
            return False
        return guard.covers(problem, *ends, leaving, arriving)

    def _seen(self, partition: Partition, start: Closed, point: Closed) -> _Seen:
        """Return what is known of a pose beside those that a path leads to from its start."""
        passive, scale = partition.passive, partition.passive_scale[:, None]
        idle = start.factors.right[partition.passive_rank :]
        takes_part = np.zeros(partition.column_scale.size, dtype=bool)
        takes_part[passive] = (np.abs(idle) > _LEAST_PART).any(axis=0)
        way, rates = self._way(start.q, point.q, takes_part)
        seen = idle.dot((rates * partition.column_scale).take(passive, axis=0) / scale)
        return _Seen(
            partition,
            point,
            np.vstack([point.scaled, seen]).take(passive, axis=1),
            np.concatenate([point.residual, idle.dot(way.take(passive) / scale[:, 0])]),
            len(idle),
        )

    def _way(self, start: Array, end: Array, takes_part: Mask) -> tuple[Array, Array]:
        """Return the way from a q to another (nv,), and L (nv, nv), of what takes part."""
        model = self._model
        way = pin.difference(model, start, end)
        rates = pin.dDifference(model, start, end, pin.ArgumentPosition.ARG1)
        for joints in self._loose:  # which Pinocchio lets slide and turn at once
            columns = joints.columns
            if not takes_part[columns].any():
                continue
            way[columns], rates[columns[:, None], columns] = joints.way(start, end)
        return way, rates


@dataclass(frozen=True, slots=True, eq=False)
class _Seen:
    """A pose, B with N₀ᵀ L below K*, and how far the loops are open and what idles has moved.

    The last d rows are those of what idles.
    """

    partition: Partition
    point: Closed
    both: Array
    error: Array
    idle: int

    def inverse(self) -> Array | None:
        """Return B⁺, None where its columns depend on each other: K* has all its rank if not."""
        partition, columns = self.partition, self.both.shape[1]
        factors = partition.factorise(self.both, partition.size_of(self.point.scaled))
        return factors.inverse(columns) if factors.rank == columns else None

    def idling(self, moved: Array) -> Array | None:
        """Return v (nv,), with the loops closed, that lets N₀ᵀ x (d,) move so; None: no inverse."""
        if (inverse := self.inverse()) is None:
            return None
        return passive_motion(inverse[:, -self.idle :].dot(moved), self.partition)


def _gone_by(problem: ClosureProblem, point: Closed, moves: Array) -> Closed:
    """Return the pose that moves (m_p,) of the passive joints lead to, without dimension."""
    v = passive_motion(moves, problem.partition)
    return closed_point(problem, problem.integrate(point.q, v), point.iterations + 1)


@dataclass(frozen=True, slots=True, eq=False)
class _Alike:
    """Joints of one kind: steps of all of them are those of one, with more numbers in each place.

    Attributes
    ----------
    links : mapping of int to Link
        One of them, as if there were no other.
    entries, columns : ndarray of int, shapes (nq of one, joints) and (nv of one, joints)
        Of q and v.
    """

    links: Mapping[int, Link]
    entries: Index
    columns: Index

    @classmethod
    def of(cls, links: Sequence[Link]) -> _Alike:
        """Gather links of one kind."""
        kind = links[0].kind
        entries = [range(link.entries.start, link.entries.stop) for link in links]
        columns = [range(link.column, link.column + kind.nv) for link in links]
        one = replace(links[0], entries=slice(0, len(entries[0])), column=0)
        return cls({0: one}, np.array(entries, dtype=np.intp).T, np.array(columns, dtype=np.intp).T)

    def way(self, start: Array, end: Array) -> tuple[Array, Array]:
        """Return the way from the start (nv, joints), and its rates (nv, nv, joints) at the end."""
        way = between(_NUMBERS, self, start[self.entries], end[self.entries])
        count, joints = way.shape
        one_by_one = np.broadcast_to(np.eye(count)[:, :, None], (count, count, joints))
        each = np.broadcast_to(way[:, None], one_by_one.shape)
        return way, arriving(_NUMBERS, self, each, one_by_one)
