"""singularity_locus: the curves of singular poses in a slice, traced from seeds of a grid."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence

import numpy as np

from pmjac_pin.algebra.one_thread import on_one_thread
from pmjac_pin.configuration import Configuration
from pmjac_pin.errors import ArgumentError, did_you_mean, quoted
from pmjac_pin.mechanism import Mechanism
from pmjac_pin.studies.evidence import Evidence
from pmjac_pin.studies.modes.find import assembly_modes
from pmjac_pin.studies.singularities.charts import Chart, chart, slice_pose
from pmjac_pin.studies.singularities.curve_crossings import curve_crossings, curve_touchings
from pmjac_pin.studies.singularities.curve_tracing import OnCurve, Traced
from pmjac_pin.studies.singularities.cusps import cusps
from pmjac_pin.studies.singularities.locus import (
    LocusCurve,
    LocusMark,
    LocusPoint,
    SingularityLocus,
)
from pmjac_pin.studies.singularities.locus_finding import LocusFinding
from pmjac_pin.studies.singularities.plane_curve import PlaneCurve, place_rate
from pmjac_pin.studies.singularities.sheets import Sheets, as_grid
from pmjac_pin.studies.singularities.singular_equations import Freed, SingularEquations
from pmjac_pin.values.arrays import Array, norm
from pmjac_pin.values.checks import check_kind

_BOTH_KINDS: tuple[Freed, ...] = ("gain", "loss")
_MOST_SHEETS = 64
_MEET = 1e-4  # the smallest singular value at an end: there it falls to 0 with the way left


@on_one_thread
def singularity_locus(
    mechanism: Mechanism,
    plane: Sequence[str],
    *,
    at: str | Configuration = "home",
    window: Mapping[str, tuple[float, float]] | None = None,
    kinds: Iterable[Freed] | None = None,
    cells: int = 81,
    modes: Iterable[Configuration] | None = None,
) -> SingularityLocus:
    """Trace the curves of singular poses in a two-dimensional slice of motor or tool space.

    The closed poses at which η(q) = 0, M(q) u = 0 and uᵀ u = 1 are a curve in the slice, M being K*
    for what is gained and [K K*] above the tool's rows for what is lost. It is followed along its
    tangent, Newton leading back to it after each step: each point is closed and singular to 1e-12.
    Seeds are cells of a grid on the border of what an assembly mode reaches, or in a valley of what
    vanishes; from each curve of gain lead the two modes that meet there, whose grids give further
    seeds, until there is no new one.

    Parameters
    ----------
    mechanism : Mechanism
    plane : two str
        The motors that vary; or two of "x", "y" and "z", the tool's place in the world, the third
        staying where it is and the tool turned as it is, where the rows of its twist that count
        have angular ones.
    at : str or Configuration
        Where the others stay.
    window : mapping of str to (float, float), optional
        The range of each, m or rad; by default their limits, of an angle [−π, π] at most, and of
        the tool what is reached within the joints' limits.
    kinds : iterable of {"gain", "loss"}, optional
        Which singularities: type II, type I; by default those that the mechanism may have. A chain
        without loops gains nothing, one without a tool loses nothing.
    cells : int
        Of the grid, along each axis.
    modes : iterable of Configuration, optional
        Where to begin, in the slice; by default all assembly modes at `at`, and for the tool's
        plane, `at` alone, from which other working modes are met.

    Returns
    -------
    SingularityLocus

    Raises
    ------
    ArgumentError, UnknownNameError, NoToolError
        No such motors or range; a loss without a tool, a gain without loops.

    References
    ----------
    C. Gosselin and J. Angeles, *Singularity analysis of closed-loop kinematic chains*, IEEE
    Transactions on Robotics and Automation 6 (1990), equations (2) to (4).

    Examples
    --------
    >>> import pmjac_pin as pj
    >>> bar = pj.load("five_bar")
    >>> locus = pj.singularity_locus(bar, ("theta1", "theta2"), kinds=["gain"], cells=41)
    >>> locus.residual < 1e-10, len(locus.modes)
    (True, 2)
    """
    check_kind(mechanism, Mechanism)
    start = slice_pose(mechanism, at, "at")
    given = None if kinds is None else _checked_kinds(kinds)
    grid = as_grid(cells)
    drawn = chart(plane, start, window)
    asked = _asked(drawn, given)
    sheets = Sheets(drawn.area, grid)
    for mode in _first_modes(drawn) if modes is None else modes:
        sheets.add(drawn.lifted(mode))
    if not sheets.known:
        raise ArgumentError("no cell of the grid is reached: name a window around the pose")
    found = []
    if drawn.folds is not None:
        folds = LocusFinding(drawn.area, drawn.folds, sheets, drawn.fold_kind)
        _over_the_folds(folds, drawn.folds)
        found += [folds] if drawn.fold_kind in asked else []
    if drawn.inner is not None and drawn.inner_kind in asked:
        within = LocusFinding(drawn.area, drawn.inner, sheets, drawn.inner_kind)
        for sheet in sheets.known:
            within.seek(sheets.inner_seeds(sheet, drawn.inner))
        found.append(within)
    return _locus(drawn, sheets, found, cells)


def _first_modes(drawn: Chart) -> Iterable[Configuration]:
    """Return all assembly modes at the slice's pose; of the tool's plane, that pose alone."""
    if drawn.in_tool_space:
        return [drawn.at]
    return assembly_modes(drawn.at.mechanism, drawn.at.actuated, rng=0, limits=False)


def _checked_kinds(kinds: Iterable[Freed]) -> tuple[Freed, ...]:
    wanted = "`kinds` are some of 'gain' and 'loss', in a list"
    if isinstance(kinds, str) or not isinstance(kinds, Iterable):
        hint = f": [{kinds!r}]" if kinds in _BOTH_KINDS else ""
        raise ArgumentError(f"{wanted}{hint}; got {quoted(kinds)}")
    given = tuple(kinds)
    for kind in given:
        if kind not in _BOTH_KINDS:
            raise ArgumentError(f"{wanted}; got {quoted(kind)}{did_you_mean(kind, _BOTH_KINDS)}")
    if not given:
        raise ArgumentError(f"{wanted}; got none")
    return given


def _asked(drawn: Chart, given: Sequence[Freed] | None) -> tuple[Freed, ...]:
    """Return the kinds that are asked for, by default those that there are."""
    mechanism, there = drawn.at.mechanism, drawn.equations
    asked = tuple(there) if given is None else tuple(given)
    if not asked or ("loss" in asked and "loss" not in there):
        mechanism.need_tool()
    if "gain" in asked and "gain" not in there:
        raise ArgumentError(f"{mechanism.name} has no loops, and gains nothing: ask for 'loss'")
    return asked


def _over_the_folds(folds: LocusFinding, equations: SingularEquations) -> None:
    """Seek curves of gain on all sheets, those too that are met over a fold."""
    done = 0
    while done < min(len(folds.sheets.known), _MOST_SHEETS):
        sheet = folds.sheets.known[done]
        for curve in folds.seek(folds.sheets.border_seeds(sheet, equations)):
            for mode in folds.beside(curve):
                folds.sheets.add(mode)
        done += 1


def _locus(
    drawn: Chart, sheets: Sheets, found: Sequence[LocusFinding], cells: int
) -> SingularityLocus:
    moving = [(finding, curve) for finding in found for curve in finding.moving]
    told = [_told_curve(drawn, finding, curve.traced) for finding, curve in moving]
    alone = [
        _special("isolated point", drawn, one.q, (), finding.kind)
        for finding in found
        for one in finding.isolated
    ]
    area = drawn.area
    return SingularityLocus(
        at=drawn.at,
        plane=area.names,
        units=area.units,
        held=drawn.held,
        lower=drawn.in_world(area.lower),
        upper=drawn.in_world(area.upper),
        curves=tuple(told),
        points=(*_on_curves(drawn, moving), *alone, *_where_curves_meet(drawn, moving)),
        modes=tuple(
            drawn.at.mechanism.configuration(drawn.original(sheet.start.q))
            for sheet in sheets.known
        ),
        evidence=_locus_evidence(told, sheets, cells, drawn.in_tool_space),
    )


def _on_curves(
    drawn: Chart, moving: Sequence[tuple[LocusFinding, PlaneCurve]]
) -> Iterator[LocusPoint]:
    """Yield the special points that each curve has by itself."""
    for number, (finding, curve) in enumerate(moving):
        for end in _ends_in_branch_points(curve.traced):
            yield _special("branch point", drawn, end.point.q, (number,), finding.kind)
        if finding.equations is drawn.folds:
            for one in cusps(finding.tracer, finding.equations, curve.traced):
                yield _special("cusp", drawn, one.q, (number,), finding.kind)


def _where_curves_meet(
    drawn: Chart, moving: Sequence[tuple[LocusFinding, PlaneCurve]]
) -> Iterator[LocusPoint]:
    """Yield where curves cross, and then where they touch."""
    curves = [curve for _, curve in moving]
    marks: tuple[LocusMark, LocusMark] = ("crossing", "touching")
    for mark, met in zip(marks, (curve_crossings(curves), curve_touchings(curves)), strict=True):
        for one in met:
            kind = moving[one.curves[0]][0].kind
            told: LocusMark = "branch point" if one.meets else mark
            yield _special(told, drawn, one.first.q, one.curves, kind)


def _ends_in_branch_points(curve: Traced) -> Iterator[OnCurve]:
    """Yield the ends beyond which no step led, but where more than one way leads on."""
    for end, name in zip((curve.points[0], curve.points[-1]), curve.ends, strict=True):
        if name == "lost" and end.regular <= _MEET:
            yield end


def _special(
    mark: LocusMark, drawn: Chart, q: Array, curves: tuple[int, ...], kind: Freed
) -> LocusPoint:
    return LocusPoint(mark, drawn.in_world(drawn.area.places(q)), drawn.original(q), curves, kind)


def _told_curve(drawn: Chart, finding: LocusFinding, curve: Traced) -> LocusCurve:
    return LocusCurve(
        kind=finding.kind,
        places=drawn.in_world(drawn.area.places(curve.q)),
        q=drawn.original(curve.q),
        directions=np.array([place_rate(finding.tracer, one) for one in curve.points]),
        is_closed=curve.is_closed,
        modes=finding.modes_of(curve),
        residual=max(norm(finding.equations.residual(one.point)) for one in curve.points),
        complete=not {"lost", "long"} & set(curve.ends),
        branches=len(list(_ends_in_branch_points(curve))),
    )


def _locus_evidence(
    curves: Sequence[LocusCurve], sheets: Sheets, cells: int, in_tool_space: bool
) -> Evidence:
    worst = max((curve.residual for curve in curves), default=0.0)
    cut = sum(not curve.complete for curve in curves)
    branches = sum(curve.branches for curve in curves)
    unfinished = f"; {cut} could not be followed to their ends" if cut else ""
    if branches:
        unfinished += f": {branches} of these are branch points, from which several ways lead on"
    modes = "working" if in_tool_space else "assembly"
    return Evidence(
        "tolerance",
        f"each point of {len(curves)} curves is closed and singular to {worst:.1g}{unfinished}; "
        f"their seeds are from a grid of {cells} x {cells} cells on {len(sheets.known)} "
        f"{modes} modes: a curve smaller than a cell may be missed, and what is on other modes",
    )
