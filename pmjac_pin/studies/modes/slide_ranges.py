"""Slide ranges: how far passive slides, and bodies that float, can be where the loops are closed.

A loop that holds two points together, or at a distance, is a polygon: between two joints that turn
a side keeps its length, but for what slides along it. So no side is longer than all the others
together, and what slides within a side is bounded as soon as nothing else in the loop is without
bound. Lengths are measured at one pose, closed or not, with the slides there: neither the world's
origin nor where a slide counts from matters.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
import pinocchio as pin

from pmjac_pin.model.frames import Frame, find_frame
from pmjac_pin.model.linkage import Edge, edges_of
from pmjac_pin.model.loop_spec import JointLoop
from pmjac_pin.model.rows import Distance, Gap
from pmjac_pin.rates.factorisation import factorise
from pmjac_pin.studies.modes.search_problem import SearchProblem
from pmjac_pin.values.arrays import Array

Span: TypeAlias = tuple[Frame, Frame, float]

_ROUNDED_LENGTHS = 1.0 + 1e-9  # for lengths that are added up
_DIGITS = 1e-14  # of values that are added up
_ROUNDS_OF_BOUNDS = 10  # in which one loop's bounds help in others
_FAR = 5.0  # times the loop's own sides: how far is looked where nothing bounds a slide
_AS_GOOD_AS_NONE = 1000.0  # times them: limits so far from each other, as 1e9, are none
_PARALLEL_SLIDES = 1e-6  # axes whose directions differ by less do not tell how far each one slid


@dataclass(frozen=True, slots=True, eq=False)
class SlideRange:
    """The values of a joint's translation, along its own axes: shapes (k,).

    Attributes
    ----------
    lower, upper : ndarray
    unit : str
        "m"; of a screw, whose value is its angle, "rad".
    cut_off : float or None
        To either side of the pose it was measured at, where neither limits nor loops bound it.
    """

    lower: Array
    upper: Array
    unit: str
    cut_off: float | None = None


@dataclass(frozen=True, slots=True, eq=False)
class _Slide:
    """A passive joint's translation at the pose.

    Attributes
    ----------
    axes : ndarray, shape (3, k)
        What one unit of its values moves by, in the world.
    values : ndarray, shape (k,)
    reach : float
        How long each of the axes is: 1, or the pitch of a screw, m/rad.
    """

    axes: Array
    values: Array
    reach: float

    def room(self, lower: Array, upper: Array) -> float:
        """Return how far, m, it can be from these values."""
        units = np.linalg.norm(np.maximum(self.values - lower, upper - self.values))
        return self.reach * float(units)


@dataclass(frozen=True, slots=True, eq=False)
class _Side:
    """From one joint of a loop that turns to the next; the slides between, and their senses."""

    vector: Array
    slides: tuple[tuple[str, float], ...]

    @property
    def length(self) -> float:
        return float(np.linalg.norm(self.vector))


@dataclass(frozen=True, slots=True, eq=False)
class _Polygon:
    sides: tuple[_Side, ...]
    span: float

    @property
    def length(self) -> float:
        return self.span + sum(side.length for side in self.sides)


def slide_ranges(problem: SearchProblem, limits: bool) -> dict[str, SlideRange]:
    """Return the values of all passive joints that slide or float, by name.

    Parameters
    ----------
    problem : SearchProblem
    limits : bool
        Keep within the joints' limits.
    """
    edges = [edge for _, edge in problem.passive if edge.kind.along]
    polygons = Polygons(problem.model, problem.base, edges, _spans(problem))
    bounds = polygons.bounds({edge.name: _edge_limits(edge, limits) for edge in edges})
    units = {edge.name: "rad" if edge.kind.screw else "m" for edge in edges}
    return {
        name: _cut_off(
            *(slide, bounds[name], units[name]), max(problem.length, polygons.length_with(name))
        )
        for name, slide in polygons.slides.items()
    }


class Polygons:
    """The polygons that bound what slides, measured at one pose, closed or not.

    Parameters
    ----------
    model : pin.Model
    q : ndarray, shape (nq,)
        The pose. What is no slide and not turned by a joint of it is there at every pose.
    edges : sequence of Edge
        The joints that slide, their values unknown.
    spans : iterable of (Frame, Frame, float)
        How far apart, m, the origins of two frames are at most at all poses in question.

    Attributes
    ----------
    slides : dict of str to _Slide
    """

    def __init__(
        self, model: pin.Model, q: Array, edges: Sequence[Edge], spans: Iterable[Span]
    ) -> None:
        data = model.createData()
        pin.forwardKinematics(model, data, q)
        self.slides = {
            edge.name: _slide(data, edge, _slide_values(model, edge, q)) for edge in edges
        }
        joints = {edge.child: edge for edge in edges_of(model).values()}
        self._polygons = [
            _Polygon(tuple(_sides(joints, data, self.slides, (first, second))), span)
            for first, second, span in (spans if edges else ())
        ]

    def bounds(self, limits: Mapping[str, tuple[Array, Array]]) -> dict[str, tuple[Array, Array]]:
        """Return between which values joints can slide, shapes (k,); infinite where nothing tells.

        Rounded outwards: sums of lengths have 1e-9 of themselves to spare, ends their last digits.

        Parameters
        ----------
        limits : mapping of str to (lower, upper)
            Values that are allowed.
        """
        ranges = {name: (low.copy(), high.copy()) for name, (low, high) in limits.items()}
        for _ in range(_ROUNDS_OF_BOUNDS):
            before = dict(ranges)
            for polygon in self._polygons:
                _tighten(polygon, self.slides, ranges)
            if all(np.array_equal(ranges[name], before[name]) for name in ranges):
                break
        return ranges

    def length_with(self, name: str) -> float:
        """Return the length of the longest polygon that a joint slides in, 0 for none."""
        own = [
            polygon.length
            for polygon in self._polygons
            if any(name == other for side in polygon.sides for other, _ in side.slides)
        ]
        return max(own, default=0.0)


def _slide_values(model: pin.Model, edge: Edge, q: Array) -> Array:
    first = model.joints[edge.child].idx_q
    return q[first : first + len(edge.kind.along)]


def _slide(data: pin.Data, edge: Edge, values: Array) -> _Slide:
    parent: Array = (data.oMi[edge.parent] * edge.before).rotation
    reach = edge.kind.reach(edge.pitch)
    return _Slide(reach * parent[:, list(edge.kind.along)], values, abs(reach))


def _edge_limits(edge: Edge, limits: bool) -> tuple[Array, Array]:
    lower, upper = edge.bounds if limits else (-np.inf, np.inf)
    return np.full(len(edge.kind.along), lower), np.full(len(edge.kind.along), upper)


def _spans(problem: SearchProblem) -> Iterator[Span]:
    for loop in problem.closures:
        if isinstance(loop, JointLoop):
            continue
        first, second = (find_frame(problem.model, name) for name in loop.frames)
        for block in loop.rows(problem.mechanism.parameters):
            if isinstance(block, Gap | Distance):
                yield first, second, block.length if isinstance(block, Distance) else 0.0


def _sides(
    joints: Mapping[int, Edge], data: pin.Data, slides: Mapping[str, _Slide], ends: Sequence[Frame]
) -> Iterator[_Side]:
    """Yield the sides from the first frame inwards to where both hang, and out to the second."""
    inwards, outwards = (_path(joints, frame.joint) for frame in ends)
    while inwards and outwards and inwards[-1] is outwards[-1]:
        inwards.pop()
        outwards.pop()
    places = [data.oMi[frame.joint].act(frame.placement.translation) for frame in ends]
    between: list[tuple[str, float]] = []
    here = places[0]
    for edge, sense in [*((e, -1.0) for e in inwards), *((e, 1.0) for e in reversed(outwards))]:
        if sense > 0.0 and edge.name in slides:
            between.append((edge.name, sense))
        if edge.kind.turns:
            turning: Array = (data.oMi[edge.child] * edge.after.inverse()).translation
            yield _Side(turning - here, tuple(between))
            here, between = turning, []
        if sense < 0.0 and edge.name in slides:
            between.append((edge.name, sense))
    yield _Side(places[1] - here, tuple(between))


def _path(joints: Mapping[int, Edge], body: int) -> list[Edge]:
    path = []
    while body:
        path.append(joints[body])
        body = joints[body].parent
    return path


def _tighten(
    polygon: _Polygon, slides: Mapping[str, _Slide], ranges: dict[str, tuple[Array, Array]]
) -> None:
    """Bound what slides in a polygon by all the rest of it, in place."""
    for side in polygon.sides:
        together = _independent(side, slides)
        for group in [side.slides] if together else [(slide,) for slide in side.slides]:
            own = {name for name, _ in group}
            others = [name for one in polygon.sides for name, _ in one.slides if name not in own]
            rest = polygon.length - side.length
            rest += sum(slides[name].room(*ranges[name]) for name in others)
            if group and np.isfinite(rest):
                _bound(side, group, slides, _ROUNDED_LENGTHS * rest, ranges)


def _independent(side: _Side, slides: Mapping[str, _Slide]) -> bool:
    """Tell whether the place at the end of a side gives what slides in it."""
    own = [slides[name] for name, _ in side.slides]
    axes = np.column_stack([np.zeros((3, 0)), *(slide.axes / slide.reach for slide in own)])
    return bool(factorise(axes, 1.0, _PARALLEL_SLIDES).rank == axes.shape[1])


def _bound(
    side: _Side,
    group: Sequence[tuple[str, float]],
    slides: Mapping[str, _Slide],
    rest: float,
    ranges: dict[str, tuple[Array, Array]],
) -> None:
    """Bound some slides of a side by the length of what is left of the polygon, in place.

    With c the side at the pose and Z the slides' axes, |c + Z d| is at most that after sliding
    by d, and so |Z (d + Z⁺c)|² at most rest² − |c − Z Z⁺c|².
    """
    axes = np.column_stack([sense * slides[name].axes for name, sense in group])
    inverse = factorise(axes, 1.0).inverse(axes.shape[1])
    middle = -inverse @ side.vector
    aside = side.vector + axes @ middle
    left = math.sqrt(max(0.0, rest**2 - float(aside @ aside)))
    reach = left * np.linalg.norm(inverse, axis=1)
    first = 0
    for name, _ in group:
        slide, (lower, upper) = slides[name], ranges[name]
        own = slice(first, first + slide.values.size)
        centre, first = slide.values + middle[own], own.stop
        far = reach[own] + _DIGITS * (np.abs(slide.values) + np.abs(middle[own]))
        low, high = np.maximum(lower, centre - far), np.minimum(upper, centre + far)
        # Where limits and loops exclude each other nothing closes: what is between holds it all.
        ranges[name] = np.minimum(low, high), np.maximum(low, high)


def _cut_off(slide: _Slide, bounds: tuple[Array, Array], unit: str, length: float) -> SlideRange:
    """Return the range, cut off where it is beyond all measure."""
    lower, upper = bounds
    if (upper - lower <= _AS_GOOD_AS_NONE * length / slide.reach).all():
        return SlideRange(lower, upper, unit)
    far = _FAR * length / slide.reach
    nearest = np.clip(slide.values, lower, upper)
    return SlideRange(np.maximum(lower, nearest - far), np.minimum(upper, nearest + far), unit, far)
