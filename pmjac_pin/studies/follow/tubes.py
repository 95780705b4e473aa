"""Tubes: a proof that a path's steps follow one branch of closed poses.

About each step there is a tube in which Krawczyk's test (`SeriesProof`) finds exactly one closed
pose for every t, and K* regular there. Where two tubes meet, both are about the same pose, and what
is in the one is so near that it is in the other, too: it is the same. So one closed pose for each t
hangs together from the first to the last.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np

from pmjac_pin.algebra.balls import precise
from pmjac_pin.errors import ArgumentError, ClosureError
from pmjac_pin.rates.partition import independent_rows
from pmjac_pin.studies.evidence import Evidence
from pmjac_pin.studies.follow.course import Course
from pmjac_pin.studies.follow.step import CoveredStep
from pmjac_pin.studies.follow.stretch import PathPose
from pmjac_pin.studies.follow.tube_equations import TubeEquations
from pmjac_pin.studies.series_proof import SeriesProof
from pmjac_pin.studies.transmissions.sheet_equations import Pieces
from pmjac_pin.values.arrays import Index

_SPLITS = 3  # of a step's tube, before more closed poses on the step are asked for
_FINER = 6  # how often a step is halved so
_NARROWEST = 1e-7  # of t: steps that are narrower are not, as rounding is what fails there


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


class PathProof:
    """A proof of a course's steps, which are taken one after another, as they are walked.

    Parameters
    ----------
    course : Course
    start : PathPose
        Where the first step begins.

    Attributes
    ----------
    radii : list of float
        Of the steps that are proven.
    end : PathPose
        Where they end.
    failed : str
        Why a step is not proven, after which none is; empty as long as all are.
    """

    def __init__(self, course: Course, start: PathPose) -> None:
        self._course, self.end = course, start
        self.radii: list[float] = []
        self._last: Tube | None = None
        self._gap, self.failed = 0.0, ""

    def takes(self, step: CoveredStep) -> bool:
        """Prove the next step; tell whether all that were taken are proven."""
        if not self.failed:
            try:
                with precise():
                    self.failed = self._take(step)
            except ArgumentError as error:
                self.failed = str(error)
        return not self.failed

    def _take(self, step: CoveredStep) -> str:
        if step.start.t != self.end.t or not np.array_equal(step.start.q, self.end.q):
            return f"steps do not meet at t = {step.start.t:.9g}"
        if not self._course.problem.partition.passive_rank:  # motors alone say where all is
            self._add(step, np.inf)
            return ""
        tubes = self._prover.tubes(step)
        chain = tubes if self._last is None else [self._last, *tubes]
        broken = next((b for a, b in pairwise(chain) if not _hang_together(a, b)), None)
        if not tubes[0].radius or broken is not None:
            where = tubes[0] if broken is None else broken
            return f"nothing proves where the path goes on from t = {where.start:.9g}"
        radius = min(tube.radius for tube in tubes) / self._course.problem.partition.length
        self._gap, self._last = max(self._gap, *(tube.gap for tube in tubes)), tubes[-1]
        self._add(step, radius)
        return ""

    def _add(self, step: CoveredStep, radius: float) -> None:
        self.radii.append(radius)
        self.end = step.end

    def evidence(self) -> Evidence:
        """Say what is proven of the path, and up to where."""
        if not self.radii:
            return Evidence("nothing", self.failed or "there is no step to be proven")
        if self._last is None:
            return Evidence("proof", "nothing is passive: motors alone say where all is")
        wide = f"{min(self.radii):.2g} to {max(self.radii):.2g} rad or lengths"
        parts = [
            f"up to t = {self.end.t:.9g} each t has exactly one closed pose in a tube of {wide}, "
            "and they hang together"
        ]
        left_out, held = self._prover.names()
        if held:
            parts.append(f"with {', '.join(held)} held")
        if left_out:
            rows = f"{len(left_out)} dependent row" + "s" * (len(left_out) > 1)
            parts.append(f"of all rows but {rows}, which it solves to {self._gap:.2g}")
        return Evidence("proof", "; ".join(parts))

    @cached_property
    def _prover(self) -> _Prover:
        return _Prover(self._course, self.end)


class _Prover:
    """Krawczyk's test on rows and columns of K* that are independent where the course begins."""

    def __init__(self, course: Course, start: PathPose) -> None:
        partition = course.problem.partition
        scaled = start.point.scaled[:, partition.passive]
        self.rows: Index = independent_rows(scaled, partition.passive_rank)
        chosen = independent_rows(scaled[self.rows].T, partition.passive_rank)
        self.columns: Index = partition.passive[chosen]
        self._partition, self._equations = partition, TubeEquations(course)
        self._krawczyk = SeriesProof(self._equations, partition, 0.0)

    def names(self) -> tuple[tuple[str, ...], tuple[str, ...]]:
        """Return those of the rows that are left out, and of the freedoms that are held."""
        partition = self._partition
        others = np.setdiff1d(np.arange(self._equations.rows), self.rows)
        free = np.setdiff1d(partition.passive, self.columns)
        names = {column: name for name, column in partition.columns.items()}
        return tuple(partition.row_names[k] for k in others), tuple(names[k] for k in free)

    def tubes(self, step: CoveredStep) -> list[Tube]:
        """Return the tubes of a step; of the last of them, radius 0 says that it is not proven."""
        return self._finer(step, _FINER)

    def _finer(self, step: CoveredStep, halvings: int) -> list[Tube]:
        """Return the tubes of a step, with more closed poses on it where these do not do."""
        unproved = [Tube(step.start.t, step.end.t, 0.0, np.inf, 0.0)]
        tubes = self._between(step)
        narrow = step.width <= _NARROWEST * max(1.0, abs(step.start.t))
        if tubes or narrow or not halvings:
            return tubes or unproved
        try:
            middle = step.at(0.5 * (step.start.t + step.end.t))
        except ClosureError:
            return unproved
        found: list[Tube] = []
        for start, end in pairwise((step.start, middle, step.end)):
            half = CoveredStep(step.course, step.piece, start, end)
            found += self._finer(half, halvings - 1)
            if not found[-1].radius:
                return found[-1:]
        return found

    def _between(self, step: CoveredStep) -> list[Tube]:
        """Return the tubes between the ends of a step, none where nothing is proven."""
        sheet = self._equations.sheet([step.start, step.end])
        found: dict[float, Tube] = {}
        pieces = Pieces.whole([1])
        for _ in range(_SPLITS + 1):
            along, count = self._equations.along(sheet, step.piece, pieces), pieces.at.shape[1]
            proven = self._krawczyk.of(along, count, self.rows, self.columns)
            gaps = self._krawczyk.gap(along, proven, self.rows, self.columns)
            for k in np.flatnonzero(proven.good).tolist():
                at, half = float(pieces.at[0, k]), float(pieces.half[0, k])
                middle, width = 0.5 * (step.start.t + step.end.t), 0.5 * step.width
                ends = (middle + (at + side * half) * width for side in (-1.0, 1.0))
                numbers = proven.radius[k], proven.reach[k].max(), gaps[k]
                found[at] = Tube(*map(float, (*ends, *numbers)))
            if proven.good.all():
                return [found[at] for at in sorted(found)]
            pieces = pieces[~proven.good].split()
        return []


def _hang_together(one: Tube, other: Tube) -> bool:
    """Tell whether the pose of one tube, where they meet, is in the other one."""
    return min(one.radius, other.radius) > 0.0 and (
        one.reach <= other.radius or other.reach <= one.radius
    )
