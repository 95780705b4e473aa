"""slice_map: what following reaches in a plane of two motors, and where that mode is singular."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from itertools import takewhile

import numpy as np

from pmjac_pin.configuration import Configuration
from pmjac_pin.errors import ArgumentError, ClosureError, LimitError
from pmjac_pin.studies.singularities.charts import Chart, chart
from pmjac_pin.studies.singularities.joint_limits import within_joint_limits
from pmjac_pin.studies.singularities.locus_finding import LocusFinding
from pmjac_pin.studies.singularities.sheets import Sheets, SliceSheet
from pmjac_pin.values.arrays import Array
from pmjac_pin.viewer.messages import Slider
from pmjac_pin.viewer.slice_message import SliceCurve

CELLS = 41  # of the grid, along each axis
_SAME_HELD = 1e-9  # m or rad: motors that have not moved
_TURN = 2.0 * np.pi
_CELLS_OFF_FOLD = (3.0, 2.0, 1.0, 0.5)
_WAYS_OFF_FOLD = 16  # directions


@dataclass(frozen=True, slots=True, eq=False)
class SliceMap:
    """A map of the assembly mode of one pose.

    Attributes
    ----------
    drawn : Chart
    sheets : Sheets
        Of which the only one is that of the pose.
    cells : tuple of str
        A string for each value of the first motor: "0" not reached, "1" reached, "2" reached with
        joints beyond their limits.
    curves : tuple of SliceCurve
        Of gain and of loss.
    """

    drawn: Chart
    sheets: Sheets
    cells: tuple[str, ...]
    curves: tuple[SliceCurve, ...]

    def why_stale(self, pose: Configuration) -> str:
        """Return why this is not a map of where a pose is, "" where it is."""
        if pose.mechanism != self.drawn.at.mechanism:
            return "The mechanism is another one since this was drawn."
        values = dict(zip(pose.mechanism.actuated, pose.actuated.tolist(), strict=True))
        held = self.drawn.held.items()
        moved = [name for name, value in held if abs(values[name] - value) > _SAME_HELD]
        if moved:
            return f"Since this was drawn {', '.join(moved)} moved."
        if self.sheets.is_off(pose):
            return "The pose is of another mode than was drawn, or where the grid missed a part."
        return ""


def draw_slice(
    pose: Configuration,
    start: Configuration,
    motors: tuple[Slider, Slider],
    wanted: Callable[[], bool],
) -> SliceMap:
    """Draw the slice through a pose, or as much of it as is wanted.

    Parameters
    ----------
    pose : Configuration
    start : Configuration
        From where motors go on: the pose itself, or one right before it where it is singular.
    motors : (Slider, Slider)
        That vary.
    wanted : callable
        Asked between one curve and the next.

    Raises
    ------
    ArgumentError
        No cell is reached from there, or nothing says on which of the modes that meet there.
    """
    if start.singularity().is_singular:
        raise ArgumentError("assembly modes meet at this pose: move off it, onto one of them")
    values = dict(zip(pose.mechanism.actuated, pose.actuated.tolist(), strict=True))
    window = {motor.name: _slider_window(motor, values[motor.name]) for motor in motors}
    drawn = chart([motor.name for motor in motors], pose, window)
    sheets = Sheets(drawn.area, (CELLS, CELLS), limits=False)
    if all(sheets.add(one) is None for one in _beginnings(pose, start, drawn)):
        raise ArgumentError("no place of the map is reached from this pose: move off it")
    curves = tuple(_curves(drawn, sheets, wanted))
    return SliceMap(drawn, sheets, _cells(sheets.known[0], pose), curves)


def _beginnings(pose: Configuration, start: Configuration, drawn: Chart) -> Iterator[Configuration]:
    """Yield poses of the slice on the mode: beside a fold none but some cells away leads on."""
    if start is pose:
        yield pose
    motors = [pose.mechanism.actuated.index(name) for name in drawn.area.names]
    for cells in _CELLS_OFF_FOLD:
        for angle in np.linspace(0.0, _TURN, _WAYS_OFF_FOLD, endpoint=False):
            values = pose.actuated.copy()
            way = np.array([np.cos(angle), np.sin(angle)]) / (CELLS - 1)
            values[motors] += cells * way * drawn.area.size
            with contextlib.suppress(ClosureError, LimitError):
                yield pose.mechanism.close(values, guess=start)


def _slider_window(motor: Slider, value: float) -> tuple[float, float]:
    """Return a motor's range, of an angle one turn, in the middle or around where it is."""
    if motor.unit != "rad" or motor.upper - motor.lower <= _TURN:
        return motor.lower, motor.upper
    middle = 0.0 if abs(value) <= np.pi else value
    middle = min(max(middle, motor.lower + np.pi), motor.upper - np.pi)
    return middle - np.pi, middle + np.pi


def _curves(drawn: Chart, sheets: Sheets, wanted: Callable[[], bool]) -> Iterator[SliceCurve]:
    def while_wanted(seeds: Iterable[Array]) -> Iterator[Array]:
        return takewhile(lambda _: wanted(), seeds)

    sheet = sheets.known[0]
    findings = []
    if drawn.folds is not None:
        findings.append(LocusFinding(drawn.area, drawn.folds, sheets, drawn.fold_kind))
        findings[-1].seek(while_wanted(sheets.border_seeds(sheet, drawn.folds)))
    if drawn.inner is not None:
        findings.append(LocusFinding(drawn.area, drawn.inner, sheets, drawn.inner_kind))
        findings[-1].seek(while_wanted(sheets.inner_seeds(sheet, drawn.inner)))
    for finding in findings:
        for curve in finding.curves:
            if not finding.stays(curve):
                places = drawn.area.places(curve.q).tolist()
                complete = not {"lost", "long"} & set(curve.ends)
                yield SliceCurve(finding.kind, complete, tuple((x, y) for x, y in places))


def _cells(sheet: SliceSheet, pose: Configuration) -> tuple[str, ...]:
    told = np.zeros(sheet.closed.shape, dtype=int)
    within = within_joint_limits(pose.mechanism.coordinates, sheet.cells.q[sheet.closed])
    told[sheet.closed] = np.where(within, 1, 2)
    return tuple("".join(map(str, row)) for row in told.tolist())
