"""workspace: the region of a slice that one mode reaches, its border and a map of it."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator, Mapping, Sequence

import numpy as np

from pmjac_pin.algebra.one_thread import on_one_thread
from pmjac_pin.batches.batch import Batch
from pmjac_pin.batches.results import Status
from pmjac_pin.configuration import Configuration
from pmjac_pin.errors import ArgumentError
from pmjac_pin.mechanism import Mechanism
from pmjac_pin.studies.assembled_poses import assembled_poses
from pmjac_pin.studies.evidence import Evidence
from pmjac_pin.studies.singularities.charts import Chart, chart, slice_pose
from pmjac_pin.studies.singularities.joint_limits import limited, within_joint_limits
from pmjac_pin.studies.singularities.locus_finding import LocusFinding
from pmjac_pin.studies.singularities.plane_curve import PlaneCurve
from pmjac_pin.studies.singularities.plane_names import TOOL_AXES
from pmjac_pin.studies.singularities.sheets import Sheets, SliceSheet, as_grid, next_to
from pmjac_pin.studies.workspaces.border_checks import what_is_open
from pmjac_pin.studies.workspaces.border_pieces import SmoothPiece, border, pieces
from pmjac_pin.studies.workspaces.limit_equations import LimitEquations
from pmjac_pin.studies.workspaces.map_measures import MAP_MEASURES, checked_measure
from pmjac_pin.studies.workspaces.workspace import BorderPiece, Workspace
from pmjac_pin.values.arrays import Array, Mask
from pmjac_pin.values.checks import as_flag, check_kind

_CELLS_TRIED = 9  # cells near a place, from which it is walked to
_STEPS_TO_BORDER = 300  # to a place right beside the border
_HELD = 1e-9  # m, rad, or of a rotation: poses of one slice
_MEETING = 1e-6  # of the window: ends of pieces that meet


@on_one_thread
def workspace(
    mechanism: Mechanism,
    plane: Sequence[str],
    *,
    mode: str | Configuration = "home",
    measure: str | None = None,
    window: Mapping[str, tuple[float, float]] | None = None,
    cells: int = 101,
    limits: bool = True,
    trace: bool = True,
) -> Workspace:
    """Find what one mode of a mechanism reaches in a slice of motor or tool space.

    A grid is walked from cell to cell, so that the region is what is reached without leaving the
    mode; its border is traced along the poses at which the machine turns back, and those at which
    a joint is at its limit.

    Parameters
    ----------
    mechanism : Mechanism
    plane : two str
        Motors, or two of "x", "y" and "z" of the tool, as of `singularity_locus`.
    mode : str or Configuration
        The pose that is begun from: it has the assembly mode, the working mode, and what does not
        vary.
    measure : str, optional
        What colours the map: "smallest singular value" or "conditioning" of K*, "dexterity" (least
        by largest speed of the tool's point for unit motor rates), "gear ratio" (the least),
        "speed" (the largest), "force" (that unit motor efforts bear in each direction).
    window : mapping of str to (float, float), optional
        As of `singularity_locus`.
    cells : int
        Of the grid, along each axis.
    limits : bool
        Whether the joints keep within their limits, motors and others.
    trace : bool
        Whether the border is traced, and the area found.

    Returns
    -------
    Workspace

    Raises
    ------
    ArgumentError, UnknownNameError, NoToolError

    Examples
    --------
    Links of 1 and pivots 1 apart: two discs of radius 2, what they share.

    >>> import pmjac_pin as pj
    >>> bar = pj.load("five_bar", dict.fromkeys(("l0", "l1", "l2", "l3", "l4"), 1.0))
    >>> window = {"x": (-2.5, 3.5), "y": (-2.5, 2.5)}
    >>> round(pj.workspace(bar, ("x", "y"), window=window, cells=31).area, 5)
    8.60844
    """
    check_kind(mechanism, Mechanism)
    start = slice_pose(mechanism, mode, "mode")
    grid, whose = as_grid(cells), as_flag(limits, "limits")
    name = "" if measure is None else checked_measure(measure)
    drawn = chart(plane, start, window)
    sheets = Sheets(drawn.area, grid, limits=False)
    number = sheets.add(drawn.lifted(start))
    if number is None:
        raise ArgumentError("no cell of the grid is reached: name a window around the pose")
    region = _Region(drawn, sheets, sheets.known[number], limits=whose)
    found = _traced_border(drawn, sheets, region) if as_flag(trace, "trace") else ()
    wrong = _what_is_wrong(found, region)
    first, second = drawn.area.axes(grid).values()
    return Workspace(
        at=start,
        plane=drawn.area.names,
        units=drawn.area.units,
        held=drawn.held,
        mode=_mode_name(drawn, sheets, number),
        first=first + drawn.origin[0],
        second=second + drawn.origin[1],
        reached=region.reached,
        q=np.where(region.reached[..., None], drawn.original(region.sheet.cells.q), np.nan),
        measure=name,
        values=_values(drawn, region, name),
        border=tuple(BorderPiece(drawn.in_world(one.places), one.what) for one in found),
        area=float("nan") if wrong else sum(one.area() for one in found),
        evidence=_workspace_evidence(found, wrong, cells),
    )


class _Region:
    """The cells of a sheet that are within limits and hang together with its start."""

    def __init__(self, drawn: Chart, sheets: Sheets, sheet: SliceSheet, *, limits: bool) -> None:
        self.drawn, self.sheet, self.sheets, self._limits = drawn, sheet, sheets, limits
        self.reached = self._connected()
        cells = np.flatnonzero(self.reached.ravel())
        self._q = sheet.cells.q.reshape(-1, sheet.cells.q.shape[-1])[cells]
        self._places = drawn.area.places(self._q)

    def within(self, q: Array) -> Mask:
        """Tell which poses (N, nq) have all joints within their limits."""
        original = self.drawn.original(q)
        coordinates = self.drawn.at.mechanism.coordinates
        if not self._limits:
            return np.ones(len(original), dtype=bool)
        return within_joint_limits(coordinates, original)

    def __call__(self, place: Array) -> bool:
        """Tell whether a place is reached from the cells beside it."""
        area = self.drawn.area
        if not bool(area.inside(place)):
            return False
        start = self._q[area.nearest(self._places, place, _CELLS_TRIED)]
        found = self.sheets.walked(start, place, limits="none", steps=_STEPS_TO_BORDER)
        closed = found.q[found.status == Status.CLOSED]
        return bool(self.within(closed).any())

    def beside(self) -> Array:
        """Return the places (k, 2) of cells beside one that is not reached."""
        return self.drawn.area.places(self.sheet.cells.q[self.reached & next_to(~self.reached)])

    def _connected(self) -> Mask:
        from scipy.ndimage import label  # noqa: PLC0415 - with the first workspace

        sheet, area = self.sheet, self.drawn.area
        fine = sheet.closed.copy()
        fine[fine] = self.within(sheet.cells.q[sheet.closed])
        if not fine.any():
            return fine
        parts, _ = label(fine)
        places = np.where(fine[..., None], area.places(sheet.cells.q), np.inf)
        away = np.abs((places - area.places(sheet.start.q)) / area.size).max(axis=-1)
        return np.asarray(parts == parts.ravel()[int(np.argmin(away))])


def _what_is_wrong(found: Sequence[SmoothPiece], region: _Region) -> str:
    """Return what is wrong with a region's border; empty where nothing is."""
    cells, in_world = float(region.reached.sum()), region.drawn.in_world
    return what_is_open(found, region.beside(), cells, region.sheets.cell, in_world)


def _traced_border(drawn: Chart, sheets: Sheets, region: _Region) -> tuple[SmoothPiece, ...]:
    """Return the border of a region, in pieces."""
    named: list[tuple[str, PlaneCurve]] = []
    if drawn.folds is not None:
        folds = LocusFinding(drawn.area, drawn.folds, sheets, drawn.fold_kind)
        folds.seek(sheets.border_seeds(region.sheet, drawn.folds))
        named += [(str(drawn.fold_kind), curve) for curve in folds.moving]
    if region._limits:
        named += _limit_curves(drawn, sheets, region)
    names, curves = [name for name, _ in named], [curve for _, curve in named]
    found = [*pieces(curves, names), *_window_pieces(drawn, curves)]
    return border(found, drawn.area.size, region)


def _limit_curves(
    drawn: Chart, sheets: Sheets, region: _Region
) -> Iterator[tuple[str, PlaneCurve]]:
    """Yield the curves at which a joint is at its limit, where the sheet has both sides of it."""
    mechanism, sheet = drawn.at.mechanism, region.sheet
    coordinates, driven = mechanism.coordinates, drawn.area.mechanism
    bounded = set(limited(coordinates).tolist())
    for name, column in mechanism.problem.partition.columns.items():
        if name in drawn.area.names or column not in bounded:
            continue
        for side, limit in (("lower", coordinates.lower), ("upper", coordinates.upper)):
            if not np.isfinite(limit[column]):
                continue
            equations = LimitEquations(driven, name, float(limit[column]))
            away = np.full(sheet.closed.shape, np.nan)
            away[sheet.closed] = equations.missing(sheet.cells.q[sheet.closed])[:, 0]
            finding = LocusFinding(drawn.area, equations, sheets, drawn.fold_kind)
            finding.seek(sheet.changes(away))
            for curve in finding.curves:
                yield f"{name} at its {side} limit", PlaneCurve.of(finding.tracer, curve)


def _window_pieces(drawn: Chart, curves: Sequence[PlaneCurve]) -> Iterator[SmoothPiece]:
    """Yield the sides of the window, cut where curves end on them."""
    area = drawn.area
    low, high = area.lower, area.upper
    traced = [curve.traced for curve in curves if not curve.traced.is_closed]
    ends = [area.places(one.q[[0, -1]]) for one in traced]
    stops = np.vstack([np.zeros((0, 2)), *ends])
    corners = np.array([low, [high[0], low[1]], high, [low[0], high[1]]])
    for first, last in zip(corners, np.roll(corners, -1, axis=0), strict=True):
        chord = last - first
        share = (stops - first) @ chord / (chord @ chord)
        off = np.abs(stops - first - share[:, None] * chord).max(axis=1, initial=0.0)
        cuts = share[(off <= _MEETING * area.size.max()) & (share > 0.0) & (share < 1.0)]
        row = [0.0, *sorted(cuts.tolist()), 1.0]
        row = [row[0], *(b for a, b in itertools.pairwise(row) if b - a > _MEETING)]
        way = chord / np.linalg.norm(chord)
        for begin, end in itertools.pairwise(row):
            places = first + np.array([[begin], [0.5 * (begin + end)], [end]]) * chord
            yield SmoothPiece(places, np.tile(way, (3, 1)), "window")


def _values(drawn: Chart, region: _Region, measure: str) -> Array:
    values = np.full(region.reached.shape, np.nan)
    if not measure:
        return values
    mechanism = drawn.at.mechanism
    rows = mechanism.problem.partition.tool_rows.linear
    q = drawn.original(region.sheet.cells.q[region.reached])
    of: Callable[..., Array] = MAP_MEASURES[measure]
    values[region.reached] = of(Batch(mechanism).measures(q), min(len(rows) or 3, 3))
    return values


def _mode_name(drawn: Chart, sheets: Sheets, number: int) -> str:
    """Say which mode this is: by the named poses on it, and the sign of det K* where it has one."""
    sheet = sheets.known[number]
    names = [
        name
        for name, pose in assembled_poses(drawn.at.mechanism).items()
        if _same_slice(drawn, pose) and sheets.index(drawn.lifted(pose)) == number
    ]
    of = "working mode" if drawn.in_tool_space else "assembly mode"
    called = f"{of} of {' and '.join(map(repr, names))}" if names else f"{of} without a name"
    original = drawn.at.mechanism.configuration(drawn.original(sheet.start.q))
    K_star = original.split_jacobian().K_star
    if K_star.shape[0] != K_star.shape[1] or not K_star.size:
        return called
    sign = "> 0" if np.linalg.det(K_star) > 0.0 else "< 0"
    return f"{called}, det K* {sign} at its start"


def _same_slice(drawn: Chart, pose: Configuration) -> bool:
    """Tell whether a pose is in the slice."""
    if not drawn.in_tool_space:
        values = dict(zip(pose.mechanism.actuated, pose.actuated.tolist(), strict=True))
        return all(abs(values[name] - value) <= _HELD for name, value in drawn.held.items())
    here, there = drawn.at.tool_pose(), pose.tool_pose()
    stays = [k for k, name in enumerate(TOOL_AXES) if name in drawn.held]
    away = np.abs(here.translation - there.translation)[stays]
    turned = np.abs(here.rotation - there.rotation).max()
    angular = drawn.at.mechanism.problem.partition.tool_rows.angular
    return bool(away.max(initial=0.0) <= _HELD and (turned <= _HELD or not angular))


def _workspace_evidence(found: Sequence[SmoothPiece], wrong: str, cells: int) -> Evidence:
    closes = f"does not close: {wrong}" if wrong else "closes"
    return Evidence(
        "tolerance",
        f"poses that are closed, reached in a grid of {cells} x {cells} cells without leaving the "
        f"mode, and a border of {len(found)} pieces, which {closes}; what is smaller than a cell, "
        "a hole or an island, may be missed",
    )
