"""Slide ranges: how far passive slides, and bodies that float, can be where the loops are closed.

A loop that holds two points together, or at a distance, is a polygon: between two joints that turn
a side keeps its length, but for what slides along it. So no side is longer than all the others
together, and what slides within a side is bounded as soon as nothing else in the loop is without
bound. Lengths are measured at one pose, closed or not, with the slides there: neither the world's
origin nor where a slide counts from matters.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from pmjac_pin.frames import Frame, find_frame
from pmjac_pin.linkage import Edge, edges_of
from pmjac_pin.loop_rows import Distance, Gap
from pmjac_pin.loop_spec import JointLoop
from pmjac_pin.loops import loop_blocks
from pmjac_pin.modes.search_problem import SearchProblem

Array = NDArray[np.float64]

_ROUNDING = 1.0 + 1e-9  # for lengths that are added up
_ROUNDS = 10  # in which one loop's bounds help in others
_FAR = 5.0  # times the loop's own sides: how far is looked where nothing bounds a slide
_PARALLEL = 1e-6  # axes whose directions differ by less do not tell how far each one slid
_AXES = {"prismatic": [2], "planar": [0, 1], "free": [0, 1, 2]}


@dataclass(frozen=True, slots=True, eq=False)
class SlideRange:
    """The values of a joint's translation, along its own axes: m, shapes (k,).

    Attributes
    ----------
    lower, upper : ndarray
    cut_off : float or None
        m to either side of the pose it was measured at, where neither limits nor loops bound it.
    """

    lower: Array
    upper: Array
    cut_off: float | None = None


@dataclass(frozen=True, slots=True, eq=False)
class _Slide:
    """A passive joint's translation at the pose: its axes (3, k) in the world, and values (k,)."""

    axes: Array
    values: Array

    def room(self, lower: Array, upper: Array) -> float:
        """Return how far it can be from these values."""
        return float(np.linalg.norm(np.maximum(self.values - lower, upper - self.values)))


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
    data = problem.model.createData()
    pin.forwardKinematics(problem.model, data, problem.base)
    slides = {edge.name: _slide(data, edge, problem.base[q]) for q, edge in _sliding(problem)}
    ranges = {edge.name: _limits(edge, limits) for _, edge in _sliding(problem)}
    polygons = list(_polygons(problem, data, slides)) if slides else []
    for _ in range(_ROUNDS):
        before = {name: (lower.copy(), upper.copy()) for name, (lower, upper) in ranges.items()}
        for polygon in polygons:
            _tighten(polygon, slides, ranges)
        if all(np.array_equal(ranges[name], before[name]) for name in ranges):
            break
    return {
        name: _cut_off(slides[name], ranges[name], _own_length(problem, polygons, name))
        for name in slides
    }


def _sliding(problem: SearchProblem) -> list[tuple[slice, Edge]]:
    return [(entries, edge) for entries, edge in problem.passive if edge.kind in _AXES]


def _slide(data: pin.Data, edge: Edge, entries: Array) -> _Slide:
    parent: Array = (data.oMi[edge.parent] * edge.before).rotation
    axes = _AXES[edge.kind]
    return _Slide(parent[:, axes], entries[: len(axes)])


def _limits(edge: Edge, limits: bool) -> tuple[Array, Array]:
    count = len(_AXES[edge.kind])
    if not limits or edge.limits is None or edge.kind != "prismatic":
        return np.full(count, -np.inf), np.full(count, np.inf)
    lower, upper = edge.limits
    return lower.copy(), upper.copy()


def _polygons(
    problem: SearchProblem, data: pin.Data, slides: Mapping[str, _Slide]
) -> Iterator[_Polygon]:
    joints = {edge.child: edge for edge in edges_of(problem.model).values()}
    for loop in problem.closures:
        if isinstance(loop, JointLoop):
            continue
        ends = [find_frame(problem.model, name) for name in loop.frames]
        for block in loop_blocks(loop, problem.values):
            if isinstance(block, Gap | Distance):
                span = block.length if isinstance(block, Distance) else 0.0
                yield _Polygon(tuple(_sides(joints, data, slides, ends)), span)


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
        if edge.kind != "prismatic":
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
                _bound(side, group, slides, _ROUNDING * rest, ranges)


def _independent(side: _Side, slides: Mapping[str, _Slide]) -> bool:
    """Tell whether the place at the end of a side gives what slides in it."""
    axes = np.column_stack([np.zeros((3, 0)), *(slides[name].axes for name, _ in side.slides)])
    values = np.linalg.svd(axes, compute_uv=False)
    return axes.shape[1] <= 3 and bool((values > _PARALLEL).all())


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
    inverse = np.linalg.pinv(axes)
    middle = -inverse @ side.vector
    aside = side.vector + axes @ middle
    left = math.sqrt(max(0.0, rest**2 - float(aside @ aside)))
    reach = left * np.linalg.norm(inverse, axis=1)
    first = 0
    for name, _ in group:
        slide, (lower, upper) = slides[name], ranges[name]
        own = slice(first, first + slide.values.size)
        centre, first = slide.values + middle[own], own.stop
        ranges[name] = (
            np.maximum(lower, centre - reach[own]),
            np.minimum(upper, centre + reach[own]),
        )


def _own_length(problem: SearchProblem, polygons: Sequence[_Polygon], name: str) -> float:
    """Return the length of the longest polygon that a joint slides in."""
    own = [
        polygon.length
        for polygon in polygons
        if any(name == other for side in polygon.sides for other, _ in side.slides)
    ]
    return max([problem.length, *own])


def _cut_off(slide: _Slide, bounds: tuple[Array, Array], length: float) -> SlideRange:
    """Return the range, cut off where it is beyond all measure."""
    lower, upper = bounds
    far = _FAR * length
    if (upper - lower <= 2.0 * far).all():
        return SlideRange(np.minimum(lower, upper), np.maximum(lower, upper))
    nearest = np.clip(slide.values, lower, upper)
    return SlideRange(np.maximum(lower, nearest - far), np.minimum(upper, nearest + far), far)
