"""Charts: a slice of motor space or of the tool's, with the machine whose motors span it.

In motor space the machine itself folds along what it gains, and loses within. In the tool's plane
the machine is driven by its tool, which two slides lead: that one folds along what the machine
loses, where its motors turn back, and within lies what it gains. K* of the machine is then a block
of [K K*].
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
import pinocchio as pin

from pmjac_pin.configuration import Configuration
from pmjac_pin.errors import ArgumentError, ClosureError, quoted
from pmjac_pin.mechanism import Mechanism
from pmjac_pin.model.coordinates import JointCoordinates
from pmjac_pin.model.loop_spec import FrameLoop, PointLoop
from pmjac_pin.studies.led_machine import LedMachine
from pmjac_pin.studies.singularities.joint_limits import limits_between, within_joint_limits
from pmjac_pin.studies.singularities.plane_names import TOOL_AXES, is_of_the_tool, plane_names
from pmjac_pin.studies.singularities.plane_slice import PlaneSlice
from pmjac_pin.studies.singularities.sheets import Sheets
from pmjac_pin.studies.singularities.singular_equations import Freed, RateBlock, SingularEquations
from pmjac_pin.values.arrays import Array, Mask

_GROWN, _COARSE = 4, 33  # times, and cells along each axis of a grid that finds the window
_CELLS_AROUND = 2.0  # of its cells: around what is reached


@dataclass(frozen=True, slots=True, eq=False)
class Chart:
    """A slice, and what may be singular on it.

    Attributes
    ----------
    at : Configuration
        Of the machine itself.
    area : PlaneSlice
        Of the machine that the plane drives.
    folds, inner : SingularEquations or None
        Of the borders of sheets, and of what lies within them; None where there is no such thing:
        chains without loops gain nothing, and without a tool nothing is lost.
    fold_kind, inner_kind : {"gain", "loss"}
        What these are of the machine itself.
    origin : ndarray, shape (2,)
        From where places of the area are counted: where a machine far from the world's origin is
        computed beside itself, so that its tool's slides are as exact as its own joints.
    """

    at: Configuration
    area: PlaneSlice
    folds: SingularEquations | None
    fold_kind: Freed
    inner: SingularEquations | None
    inner_kind: Freed
    origin: Array

    def in_world(self, places: Array) -> Array:
        """Return places (..., 2) of the area in the world."""
        return np.asarray(places + self.origin)

    def original(self, q: Array) -> Array:
        """Return q (..., nq) of the machine itself."""
        return q[..., : self.at.mechanism.nq]

    @property
    def equations(self) -> dict[Freed, SingularEquations]:
        """What may be singular, by the kinds that there are."""
        both = ((self.fold_kind, self.folds), (self.inner_kind, self.inner))
        return {kind: equations for kind, equations in both if equations is not None}

    @property
    def in_tool_space(self) -> bool:
        """Whether the tool spans the plane."""
        return self.fold_kind == "loss"

    @property
    def held(self) -> dict[str, float]:
        """What stays, by name: motors, or the tool's other coordinate."""
        if not self.in_tool_space:
            return self.area.held_values
        place = self.at.tool_pose().translation
        return {
            name: float(value)
            for name, value in zip(TOOL_AXES, place, strict=True)
            if name not in self.area.names
        }

    def lifted(self, pose: Configuration) -> Configuration:
        """Return a pose of the machine in the slice as one of the machine that the plane drives."""
        if not self.in_tool_space:
            return pose
        values = _along(self.area.names, pose.tool_pose().translation) - self.origin
        return self.area.mechanism.configuration(np.concatenate([pose.q, values]))


def slice_pose(mechanism: Mechanism, given: str | Configuration, what: str) -> Configuration:
    """Return the pose through which a slice is to go, or say what is wrong with it."""
    pose = mechanism.pose(given) if isinstance(given, str) else given
    if not isinstance(pose, Configuration) or pose.mechanism != mechanism:
        raise ArgumentError(f"`{what}` is a pose of the mechanism or its name, got {quoted(given)}")
    return pose


def chart(
    plane: Sequence[str], at: Configuration, window: Mapping[str, tuple[float, float]] | None
) -> Chart:
    """Return the slice through a pose that two names span.

    Parameters
    ----------
    plane : two str
        Motors, or two of "x", "y" and "z" where no motor is named so: the tool's, in the world.
    at : Configuration
    window : mapping of str to (float, float), optional

    Raises
    ------
    ArgumentError, UnknownNameError, NoToolError
    """
    mechanism = at.mechanism
    names = plane_names(plane, mechanism)
    if is_of_the_tool(names[0], mechanism):
        return _tool_chart(names, at, window)
    area = PlaneSlice.of(names, at, window)
    partition = mechanism.problem.partition
    loops = partition.passive_rank or partition.isolated
    folds = SingularEquations(mechanism, "gain") if loops else None
    inner = None if mechanism.spec.tool.is_none else SingularEquations(mechanism, "loss")
    return Chart(at, area, folds, "gain", inner, "loss", np.zeros(2))


def _tool_chart(
    names: tuple[str, str],
    at: Configuration,
    window: Mapping[str, tuple[float, float]] | None,
) -> Chart:
    mechanism, driven = at.mechanism, _driven(names, at)
    place, origin = _along(names, at.tool_pose().translation), _along(names, mechanism.place)
    start = driven.configuration(np.concatenate([at.q, place - origin]))
    area = _fitted_slice(names, start, window or {}, place, at)
    partition = mechanism.problem.partition
    block = RateBlock(partition.row_scale.size, partition.passive, partition.passive_rank)
    inner = SingularEquations(driven, "gain", block=block) if block.rank else None
    return Chart(at, area, SingularEquations(driven, "gain"), "loss", inner, "gain", origin)


def _along(names: tuple[str, str], place: Array) -> Array:
    """Return two coordinates of a place, by their names."""
    return np.array([place[TOOL_AXES.index(name)] for name in names])


def _beside(area: PlaneSlice, origin: Array) -> PlaneSlice:
    """Return a slice whose window is counted from elsewhere."""
    return replace(area, lower=area.lower - origin, upper=area.upper - origin)


def _fitted_slice(
    names: tuple[str, str],
    start: Configuration,
    window: Mapping[str, tuple[float, float]],
    place: Array,
    at: Configuration,
) -> PlaneSlice:
    """Return the slice with a window around all that is reached within the joints' limits.

    As a coarse grid sees it, which grows until its border is not reached, or eight times.
    """
    reach, origin = at.mechanism.characteristic_length, _along(names, at.mechanism.place)
    for _ in range(_GROWN):
        reach *= 2.0
        ranges = dict(zip(names, zip(place - reach, place + reach, strict=True), strict=True))
        area = _beside(PlaneSlice.of(names, start, {**ranges, **window}), origin)
        if all(name in window for name in names):
            return area
        sheets = Sheets(area, (_COARSE, _COARSE), limits=False)
        if sheets.add(start) is None:
            continue
        cells, closed = sheets.known[0].cells, sheets.known[0].closed
        reached = _beside_limits(at.mechanism.coordinates, cells.q[..., : at.mechanism.nq], closed)
        edge = reached.copy()
        edge[1:-1, 1:-1] = False
        if reached.any() and not edge.any():
            break
    else:
        return area
    found = area.places(cells.q[reached]) + origin
    margin = _CELLS_AROUND * area.size / (_COARSE - 1)
    ends = zip(found.min(axis=0) - margin, found.max(axis=0) + margin, strict=True)
    fitted = PlaneSlice.of(names, start, {**dict(zip(names, ends, strict=True)), **window})
    return _beside(fitted, origin)


def _beside_limits(coordinates: JointCoordinates, q: Array, closed: Mask) -> Mask:
    """Tell which closed cells (a, b) are within limits, or have a place that is before the next.

    What limits leave may be narrower than a cell.
    """
    found = closed.copy()
    found[closed] = within_joint_limits(coordinates, q[closed])
    for axis in (0, 1):
        poses, marks = np.moveaxis(q, axis, 0), np.moveaxis(found, axis, 0)
        both = np.moveaxis(closed, axis, 0)
        pairs: Mask = both[:-1] & both[1:]
        between = np.zeros(pairs.shape, dtype=bool)
        between[pairs] = limits_between(coordinates, poses[:-1][pairs], poses[1:][pairs])
        marks[:-1] |= between
        marks[1:] |= between
    return found


def _driven(names: tuple[str, str], at: Configuration) -> Mechanism:
    """Return the machine whose tool two slides lead from where it is, turning as `at` has it."""
    mechanism, pose = at.mechanism, at.tool_pose()
    last: dict[bytes, Mechanism] = mechanism.made_once(("tool plane", names), dict)
    known = last.get(whose := at.q.tobytes())
    if known is None:
        known = _led(names, at, pose)
        last.clear()
        last[whose] = known
    return known


def _led(names: tuple[str, str], at: Configuration, pose: pin.SE3) -> Mechanism:
    mechanism = at.mechanism
    frame = mechanism.spec.tool.frame
    if not frame:
        raise ArgumentError("the tool's plane is of a tool that is one frame, not three points")
    place, values = mechanism.place, _along(names, pose.translation - mechanism.place)
    home, led, carrier = pose.translation - place, LedMachine(mechanism), 0
    slides = {"x": pin.JointModelPX, "y": pin.JointModelPY, "z": pin.JointModelPZ}
    for name in names:
        home[TOOL_AXES.index(name)] = 0.0
        begins = pin.SE3.Identity() if carrier else pin.SE3(np.eye(3), np.array(place))
        carrier = led.joint(carrier, slides[name](), begins, name)
    target = led.frame(f"{frame} target", carrier, pin.SE3(pose.rotation, home))
    held = FrameLoop if mechanism.problem.partition.tool_rows.angular else PointLoop
    try:
        found = led.closed(np.concatenate([at.q, values]), after=[held(frames=(frame, target))])
    except ClosureError as error:
        raise ArgumentError(f"the tool cannot be led from there: {error}") from None
    if found.problem.partition.isolated or found.mobility != len(names):
        turns = "as it is turned" if held is FrameLoop else "turning as it likes"
        raise ArgumentError(
            f"the tool of {mechanism.name} cannot be led along {names[0]} and {names[1]} {turns}: "
            "name the rows of its twist that count, as with_tool(..., rows=...) takes them"
        )
    return found
