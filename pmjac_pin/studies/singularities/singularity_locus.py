"""singularity_locus: the curves of singular poses in a slice, traced from seeds of a grid."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

import numpy as np

from pmjac_pin.configuration import Configuration
from pmjac_pin.errors import ArgumentError, quoted
from pmjac_pin.mechanism import Mechanism
from pmjac_pin.studies.evidence import Evidence
from pmjac_pin.studies.modes.find import assembly_modes
from pmjac_pin.studies.singularities.curve_tracing import Traced, Tracer
from pmjac_pin.studies.singularities.locus import (
    LocusCurve,
    LocusMark,
    LocusPoint,
    SingularityLocus,
)
from pmjac_pin.studies.singularities.locus_finding import LocusFinding
from pmjac_pin.studies.singularities.locus_marks import crossings, cusps
from pmjac_pin.studies.singularities.plane_slice import PlaneSlice
from pmjac_pin.studies.singularities.sheets import Sheets
from pmjac_pin.studies.singularities.singular_equations import Freed, SingularEquations
from pmjac_pin.values.arrays import Array, norm
from pmjac_pin.values.checks import check_kind

_KINDS: tuple[Freed, ...] = ("gain", "loss")
_MOST_SHEETS = 64
_AT_REST = 1e-9  # of the window: a curve that stays at its place


def singularity_locus(
    mechanism: Mechanism,
    plane: Sequence[str],
    *,
    at: str | Configuration = "home",
    window: Mapping[str, tuple[float, float]] | None = None,
    kinds: Iterable[Freed] = _KINDS,
    cells: int = 81,
    modes: Iterable[Configuration] | None = None,
) -> SingularityLocus:
    """Trace the curves of singular poses in a two-dimensional slice of motor space.

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
        The motors that vary.
    at : str or Configuration
        Where the other motors stay.
    window : mapping of str to (float, float), optional
        The range of each, m or rad; by default their limits, of an angle [−π, π] at most.
    kinds : iterable of {"gain", "loss"}
        Which singularities: type II, type I.
    cells : int
        Of the grid, along each axis.
    modes : iterable of Configuration, optional
        Where to begin, in the slice; by default all assembly modes at `at`.

    Returns
    -------
    SingularityLocus

    Raises
    ------
    ArgumentError, UnknownNameError, NoToolError
        No such motors or range; a loss without a tool.

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
    start = mechanism.pose(at) if isinstance(at, str) else at
    if not isinstance(start, Configuration) or start.mechanism != mechanism:
        raise ArgumentError(f"`at` is a pose of the mechanism or its name, got {quoted(at)}")
    asked = _kinds(kinds)
    if not isinstance(cells, int) or isinstance(cells, bool) or cells < 2:
        raise ArgumentError(f"`cells` is a number, 2 or more, got {quoted(cells)}")
    area = PlaneSlice.of(plane, start, window)
    sheets = Sheets(area, (cells, cells))
    begin = (
        assembly_modes(mechanism, start.actuated, rng=0, limits=False) if modes is None else modes
    )
    for mode in begin:
        sheets.add(mode)
    gain = SingularEquations(mechanism, "gain")
    folds = LocusFinding(area, gain, sheets)
    _over_the_folds(folds)
    found = [folds] if "gain" in asked else []
    if "loss" in asked:
        losses = LocusFinding(area, SingularEquations(mechanism, "loss"), sheets)
        for sheet in sheets.known:
            losses.seek(sheets.loss_seeds(sheet))
        found.append(losses)
    return _locus(area, sheets, found, cells)


def _kinds(kinds: Iterable[Freed]) -> tuple[Freed, ...]:
    given = () if isinstance(kinds, str) else tuple(kinds)
    if not given or any(kind not in _KINDS for kind in given):
        raise ArgumentError(f"`kinds` are some of 'gain' and 'loss', got {quoted(kinds)}")
    return given


def _over_the_folds(folds: LocusFinding) -> None:
    """Seek curves of gain on all sheets, those too that are met over a fold."""
    done = 0
    while done < min(len(folds.sheets.known), _MOST_SHEETS):
        for curve in folds.seek(folds.sheets.gain_seeds(folds.sheets.known[done])):
            for mode in folds.beside(curve):
                folds.sheets.add(mode)
        done += 1


def _locus(
    area: PlaneSlice, sheets: Sheets, found: Sequence[LocusFinding], cells: int
) -> SingularityLocus:
    curves: list[Traced] = []
    tracers: list[Tracer] = []
    told: list[LocusCurve] = []
    points: list[LocusPoint] = []
    for finding in found:
        kind = finding.equations.freed
        for curve in finding.curves:
            if (np.ptp(area.places(curve.q), axis=0) <= _AT_REST * area.size).all():
                resting = curve.points[0].point.q
                points.append(_special("isolated point", area, resting, (), kind))
                continue
            number = len(curves)
            curves.append(curve)
            tracers.append(finding.tracer)
            told.append(_told(finding, curve))
            if kind == "gain":
                points += [
                    _special("cusp", area, point.q, (number,), kind)
                    for point in cusps(finding.tracer, curve)
                ]
        points += [
            _special("isolated point", area, point.q, (), kind) for point in finding.isolated
        ]
    for one in crossings(tracers, curves):
        mark: LocusMark = "branch point" if one.meets else "crossing"
        kind = told[one.curves[0]].kind
        points.append(_special(mark, area, one.first.q, one.curves, kind))
    return SingularityLocus(
        at=area.at,
        plane=area.names,
        units=area.units,
        held=area.held_values,
        lower=area.lower,
        upper=area.upper,
        curves=tuple(told),
        points=tuple(points),
        modes=tuple(sheet.start for sheet in sheets.known),
        evidence=_evidence(told, sheets, cells),
    )


def _special(
    mark: LocusMark, area: PlaneSlice, q: Array, curves: tuple[int, ...], kind: Freed
) -> LocusPoint:
    return LocusPoint(mark, area.places(q), q, curves, kind)


def _told(finding: LocusFinding, curve: Traced) -> LocusCurve:
    area, equations = finding.area, finding.equations
    partition = equations.partition
    stride = partition.length * partition.column_scale[area.columns]
    tangents = np.array([one.tangent[area.columns] for one in curve.points])
    return LocusCurve(
        kind=equations.freed,
        places=area.places(curve.q),
        q=curve.q,
        directions=tangents * stride,
        is_closed=curve.is_closed,
        modes=finding.modes_of(curve),
        residual=max(norm(equations.residual(one.point)) for one in curve.points),
        complete=not {"lost", "long"} & set(curve.ends),
    )


def _evidence(curves: Sequence[LocusCurve], sheets: Sheets, cells: int) -> Evidence:
    worst = max((curve.residual for curve in curves), default=0.0)
    cut = sum(not curve.complete for curve in curves)
    unfinished = f"; {cut} could not be followed to their ends" if cut else ""
    return Evidence(
        "tolerance",
        f"each point of {len(curves)} curves is closed and singular to {worst:.1g}{unfinished}; "
        f"their seeds are from a grid of {cells} x {cells} cells on {len(sheets.known)} assembly "
        "modes: a curve smaller than a cell may be missed, and what is on other modes",
    )
