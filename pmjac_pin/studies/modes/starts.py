"""Starts: random values of the passive joints, over all the space that they may be in."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from pmjac_pin.model.coordinates import JointCoordinates
from pmjac_pin.model.linkage import Edge
from pmjac_pin.studies.modes.gear_trains import GearTrain, gear_trains
from pmjac_pin.studies.modes.search_problem import SearchProblem
from pmjac_pin.studies.modes.slide_ranges import SlideRange, slide_ranges
from pmjac_pin.values.arrays import Array

_STRIDE = 0.1  # of what a slide can reach: in a few steps it has been everywhere
_ANYWHERE = (-np.inf, np.inf)


@dataclass(frozen=True, slots=True, eq=False)
class _Train:
    """A gear train, between which t it is drawn, and the entries in q of its passive joints."""

    train: GearTrain
    lower: float
    upper: float
    cut_off: bool
    joints: tuple[tuple[int, slice, Edge], ...]


@dataclass(frozen=True, slots=True, eq=False)
class StartSpace:
    """The space of passive joint values at given motor values.

    Angles are uniform over a full turn or between narrower limits, orientations uniform over all
    rotations. Slides and places of bodies that float are uniform over all that limits and loops
    let them reach (`slide_ranges`). Of joints geared together one is drawn and the others follow:
    over as many turns as make a difference, or between their limits (`gear_trains`).

    Attributes
    ----------
    base : ndarray, shape (nq,)
        The home pose, with the motors at their values.
    passive : tuple of (slice, Edge)
        Each passive joint's entries in q, geared joints left out.
    slides : mapping of str to SlideRange
    trains : tuple
    """

    base: Array
    passive: tuple[tuple[slice, Edge], ...]
    slides: Mapping[str, SlideRange]
    trains: tuple[_Train, ...]
    limits: bool

    @classmethod
    def of(cls, problem: SearchProblem, limits: bool) -> StartSpace:
        """Return the start space of a problem, within the joints' limits or not."""
        slides = slide_ranges(problem, limits)
        motors = {*problem.model.names} - {edge.name for _, edge in problem.passive}
        trains = gear_trains(problem.model, problem.closures, motors)
        geared = {name for train in trains for name in train.names}
        return cls(
            base=problem.base,
            passive=tuple(one for one in problem.passive if one[1].name not in geared),
            slides=slides,
            trains=tuple(_bounded(problem, train, slides, limits) for train in trains),
            limits=limits,
        )

    @property
    def cut_off(self) -> str:
        """What of all values is left out, as nothing bounds them; empty for none."""
        slides = [
            f"{name!r} within {one.cut_off:.3g} {one.unit} of home"
            for name, one in self.slides.items()
            if one.cut_off is not None
        ]
        turns = [
            f"{one.train.names[0]!r} between {one.lower:.4g} and {one.upper:.4g} rad"
            for one in self.trains
            if one.cut_off
        ]
        return ", ".join([*slides, *turns])

    def strides(self, problem: SearchProblem) -> Array:
        """Return how far one step of a search may move each passive degree of freedom, m.

        A length, or a rad, which counts as one; further where a slide has far to go.
        """
        found = np.full(problem.model.nv, problem.length)
        for joint in list(problem.model.joints)[1:]:
            reached = self.slides.get(problem.model.names[joint.id])
            if reached is not None:
                widest = float((reached.upper - reached.lower).max())
                columns = slice(joint.idx_v, joint.idx_v + reached.lower.size)
                # A rad of a screw is one length here, a metre of a slide a metre.
                unit = problem.length if reached.unit == "rad" else 1.0
                found[columns] = max(problem.length, _STRIDE * widest * unit)
        return np.asarray(found[problem.partition.passive])

    def draw(self, rng: np.random.Generator, count: int) -> Array:
        """Return `count` random rows of q."""
        q = np.tile(self.base, (count, 1))
        for entries, edge in self.passive:
            q[:, entries] = self._drawn(rng, edge, count)
        for one in self.trains:
            values = one.train.values(rng.uniform(one.lower, one.upper, count))
            for joint, entries, edge in one.joints:
                q[:, entries] = edge.kind.of_value(values[:, joint])
        return q

    def _drawn(self, rng: np.random.Generator, edge: Edge, count: int) -> Array:
        places = np.zeros((count, 0))
        if edge.kind.along:
            reached = self.slides[edge.name]
            places = rng.uniform(reached.lower, reached.upper, (count, reached.lower.size))
        return edge.kind.drawn(rng, places, _turn_range(edge, self.limits))


def _bounded(
    problem: SearchProblem, train: GearTrain, slides: Mapping[str, SlideRange], limits: bool
) -> _Train:
    """Return a train with the values that its first joint is drawn from."""
    joints = dict(_passive_edges(problem, train))
    home = JointCoordinates(problem.model).values(problem.base)[train.columns]
    if train.driver is not None:
        t = train.first(train.driver, float(home[train.driver]))
        return _Train(train, t, t, False, tuple((k, *one) for k, one in joints.items()))
    bounds = [
        _bounds(joints[index][1], slides, limits) if index in joints else _range_ends(*_ANYWHERE)
        for index in range(len(train.names))
    ]
    lower, upper = (np.concatenate(ends) for ends in zip(*bounds, strict=True))
    between = sorted(train.between(lower, upper))
    low, high, cut_off = train.window(between[0], between[1], float(home[0]))
    return _Train(train, low, high, cut_off, tuple((k, *one) for k, one in joints.items()))


def _passive_edges(
    problem: SearchProblem, train: GearTrain
) -> Iterator[tuple[int, tuple[slice, Edge]]]:
    passive = {edge.name: (entries, edge) for entries, edge in problem.passive}
    for index, name in enumerate(train.names):
        if name in passive:
            yield index, passive[name]


def _bounds(edge: Edge, slides: Mapping[str, SlideRange], limits: bool) -> tuple[Array, Array]:
    if edge.name in slides:
        return slides[edge.name].lower, slides[edge.name].upper
    return _range_ends(*(edge.bounds if limits else _ANYWHERE))


def _range_ends(lower: float, upper: float) -> tuple[Array, Array]:
    return np.array([lower]), np.array([upper])


def _turn_range(edge: Edge, limits: bool) -> tuple[float, float]:
    lower, upper = edge.bounds if limits else _ANYWHERE
    return (lower, upper) if upper / 2.0 - lower / 2.0 < np.pi else (-np.pi, np.pi)
