"""Tubes: a proof that a path's steps follow one branch of closed poses.

About each step there is a tube in which Krawczyk's test (`SeriesProof`) finds exactly one closed
pose for every t, and K* regular there. Where two tubes meet, both are about the same pose, and what
is in the one is so near that it is in the other, too: it is the same. So one closed pose for each t
hangs together from the first to the last.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import groupby, pairwise

import numpy as np

from pmjac_pin.algebra.balls import precise
from pmjac_pin.errors import ArgumentError, ClosureError
from pmjac_pin.rates.partition import independent_rows
from pmjac_pin.studies.follow.course import Course
from pmjac_pin.studies.follow.motor_path import PathPiece
from pmjac_pin.studies.follow.step import CoveredStep, PathPose
from pmjac_pin.studies.follow.tube_equations import TubeEquations
from pmjac_pin.studies.series_proof import SeriesProof
from pmjac_pin.studies.transmissions.sheet_equations import Pieces
from pmjac_pin.values.arrays import Array, Index

_SPLITS = 3  # of a step's tube, before more closed poses on the step are asked for
_FINER = 6  # how often a step is halved so
_NARROWEST = 1e-7  # of t: steps that are narrower are not, as rounding is what fails there
_STEPS_AT_A_TIME = 256


@dataclass(frozen=True, slots=True)
class Tube:
    """A part of a path, and its tube.

    Attributes
    ----------
    start, end : float
    radius, reach : float
        Exactly one closed pose is within the radius, and not farther than the reach; 0 and
        infinite where nothing is proven.
    gap : float
        How far rows that are left out are from 0, in their units.
    """

    start: float
    end: float
    radius: float
    reach: float
    gap: float


@dataclass(frozen=True, slots=True, eq=False)
class ProvenTubes:
    """What is proven of some steps.

    Attributes
    ----------
    radii : ndarray, shape (k,)
        Of the first k steps, which hang together: rad, or shares of the characteristic length.
    left_out, held : tuple of str
        Rows that depend on the others, and freedoms that the loops leave free.
    gap : float
        To what the former hold, in their units.
    failed : str
        Why there are no more of them; empty where all are.
    """

    radii: Array
    left_out: tuple[str, ...]
    held: tuple[str, ...]
    gap: float
    failed: str


def proven_tubes(course: Course, steps: Sequence[CoveredStep]) -> ProvenTubes:
    """Return what interval arithmetic proves of the steps of a course, in their order."""
    if not (steps and course.problem.partition.passive_rank):  # motors alone say where all is
        return ProvenTubes(np.full(len(steps), np.inf), (), (), 0.0, "")
    try:
        with precise():
            prover = _Prover(course, steps[0].start)
            return prover.of(steps)
    except ArgumentError as error:
        return ProvenTubes(np.zeros(0), (), (), 0.0, str(error))


class _Prover:
    """Krawczyk's test on rows and columns of K* that are independent where the course begins."""

    def __init__(self, course: Course, start: PathPose) -> None:
        partition = course.problem.partition
        scaled = start.point.scaled[:, partition.passive]
        self.rows: Index = independent_rows(scaled, partition.passive_rank)
        chosen = independent_rows(scaled[self.rows].T, partition.passive_rank)
        self.columns: Index = partition.passive[chosen]
        self._course, self._equations = course, TubeEquations(course)
        self._krawczyk = SeriesProof(self._equations, partition, 0.0)

    def of(self, steps: Sequence[CoveredStep]) -> ProvenTubes:
        """Return what is proven of some steps."""
        radii: list[float] = []
        failed, last, gap = "", None, 0.0
        length = self._course.problem.partition.length
        joined = steps[: 1 + _first_gap(steps)]
        for tubes in self._by_steps(joined):
            chain = tubes if last is None else [last, *tubes]
            broken = next((b for a, b in pairwise(chain) if not _hang_together(a, b)), None)
            if not tubes[0].radius or broken is not None:
                where = tubes[0] if broken is None else broken
                failed = f"nothing proves where the path goes on from t = {where.start:.9g}"
                break
            radii.append(min(tube.radius for tube in tubes) / length)
            gap, last = max(gap, *(tube.gap for tube in tubes)), tubes[-1]
        if not failed and len(joined) < len(steps):
            failed = f"steps do not meet at t = {steps[len(joined)].start.t:.9g}"
        partition = self._course.problem.partition
        others = np.setdiff1d(np.arange(self._equations.rows), self.rows)
        free = np.setdiff1d(partition.passive, self.columns)
        names = {column: name for name, column in partition.columns.items()}
        rows = tuple(partition.row_names[k] for k in others)
        return ProvenTubes(np.array(radii), rows, tuple(names[k] for k in free), gap, failed)

    def _by_steps(self, steps: Sequence[CoveredStep]) -> Iterator[list[Tube]]:
        for _, group in groupby(steps, key=lambda step: id(step.piece)):
            own = list(group)
            for start in range(0, len(own), _STEPS_AT_A_TIME):
                part = own[start : start + _STEPS_AT_A_TIME]
                poses = [part[0].start, *(step.end for step in part)]
                found = self._between(part[0].piece, poses)
                yield from map(self._finer, part, found)

    def _finer(self, step: CoveredStep, tubes: list[Tube], halvings: int = _FINER) -> list[Tube]:
        """Return the tubes of a step, with more closed poses on it where these do not do."""
        unproved = [Tube(step.start.t, step.end.t, 0.0, np.inf, 0.0)]
        narrow = step.width <= _NARROWEST * max(1.0, abs(step.start.t))
        if tubes or narrow or not halvings:
            return tubes or unproved
        try:
            middle = step.at(0.5 * (step.start.t + step.end.t))
        except ClosureError:
            return unproved
        halves = [
            CoveredStep(step.course, step.piece, step.start, middle),
            CoveredStep(step.course, step.piece, middle, step.end),
        ]
        both = self._between(step.piece, [step.start, middle, step.end])
        found: list[Tube] = []
        for half, own in zip(halves, both, strict=True):
            found += self._finer(half, own, halvings - 1)
            if not found[-1].radius:
                return found[-1:]
        return found

    def _between(self, path: PathPiece, poses: Sequence[PathPose]) -> list[list[Tube]]:
        """Return the tubes between closed poses, none where nothing is proven."""
        sheet = self._equations.sheet(poses)
        found: list[dict[float, Tube]] = [{} for _ in poses[1:]]
        failed: set[int] = set()
        pieces = Pieces.whole([len(poses) - 1])
        for split in range(_SPLITS + 1):
            along, count = self._equations.along(sheet, path, pieces), pieces.at.shape[1]
            proven = self._krawczyk.of(along, count, self.rows, self.columns)
            gaps = self._krawczyk.gap(along, proven, self.rows, self.columns)
            for k in range(count):
                cell, at, half = int(pieces.cells[0, k]), pieces.at[0, k], pieces.half[0, k]
                if proven.good[k]:
                    start, end = poses[cell].t, poses[cell + 1].t
                    middle, width = 0.5 * (start + end), 0.5 * (end - start)
                    ends = (middle + (at + side * half) * width for side in (-1.0, 1.0))
                    numbers = proven.radius[k], proven.reach[k].max(), gaps[k]
                    found[cell][float(at)] = Tube(*map(float, (*ends, *numbers)))
                elif split == _SPLITS:
                    failed.add(cell)
            if proven.good.all():
                break
            pieces = pieces[~proven.good].split()
        return [
            [] if cell in failed else [own[at] for at in sorted(own)]
            for cell, own in enumerate(found)
        ]


def _first_gap(steps: Sequence[CoveredStep]) -> int:
    """Return the number of the last step up to which each begins at the pose where one ends."""
    for k, (before, after) in enumerate(pairwise(steps)):
        if before.end.t != after.start.t or not np.array_equal(before.end.q, after.start.q):
            return k
    return len(steps) - 1


def _hang_together(one: Tube, other: Tube) -> bool:
    """Tell whether the pose of one tube, where they meet, is in the other one."""
    return min(one.radius, other.radius) > 0.0 and (
        one.reach <= other.radius or other.reach <= one.radius
    )
