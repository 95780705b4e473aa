"""Finding the curves of singular poses in a slice: from sheet to sheet, over the folds between.

From each sheet curves are sought; from each curve of gain lead the two sheets that meet there, and
so on, until there is no new one.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator

import numpy as np

from pmjac_pin.closing.damped_closure import assemble, motor_weights
from pmjac_pin.configuration import Configuration
from pmjac_pin.studies.singularities.curve_equations import CurveEquations, SingularPoint
from pmjac_pin.studies.singularities.curve_tracing import OnCurve, Traced, Tracer
from pmjac_pin.studies.singularities.plane_curve import PlaneCurve
from pmjac_pin.studies.singularities.plane_slice import PlaneSlice
from pmjac_pin.studies.singularities.sheets import Sheets
from pmjac_pin.studies.singularities.singular_equations import Freed, SingularEquations
from pmjac_pin.values.arrays import Array

_TO_THE_LOCUS = 0.5  # lengths or rad, of each joint: Newton's way from a cell to the locus
_BESIDE_FOLD = 1e-2  # lengths or rad: from a fold to the two modes that meet there
_LOOKED, _LOOKED_EVERY = 6, 15  # points of a curve from where its sheets are looked for
_STAYING = 1e-9  # of the window
_NO_FOLD = 1e-9  # dimensionless: where branches meet the motors are not held back


class LocusFinding:
    """Finds curves and isolated points of one kind in a slice.

    Parameters
    ----------
    area : PlaneSlice
    equations : SingularEquations
    sheets : Sheets
        Known to all kinds.
    kind : {"gain", "loss"}
        What these are of the machine itself.

    Attributes
    ----------
    curves : list of Traced
    """

    def __init__(
        self, area: PlaneSlice, equations: CurveEquations, sheets: Sheets, kind: Freed
    ) -> None:
        self.area, self.equations, self.sheets, self.kind = area, equations, sheets, kind
        self.tracer = Tracer(equations, area)
        # Where many joints share the way, each goes as far as in a machine of few.
        self._most = _TO_THE_LOCUS * equations.partition.column_scale.size**0.5
        self._folds: SingularEquations | None = None
        if isinstance(equations, SingularEquations) and equations.folds:
            self._folds = equations
        self.curves: list[Traced] = []
        self._alone: list[SingularPoint] = []

    @property
    def isolated(self) -> list[SingularPoint]:
        """Singular points through which no curve leads that was found, or none in the plane."""
        staying = [curve.points[0].point for curve in self.curves if self.stays(curve)]
        return staying + [
            point
            for point in self._alone
            if not any(self.tracer.holds(curve, point) for curve in self.curves)
        ]

    def seek(self, seeds: Iterable[Array]) -> list[Traced]:
        """Trace the curves near some poses; return those that are new."""
        before = len(self.curves)
        for q in seeds:
            point = self.tracer.corrected(self.equations.begin(q), self._most)
            if point is not None:
                self._trace(self.equations.turned(point))
        return self.curves[before:]

    def _trace(self, point: SingularPoint) -> None:
        area = self.area
        if not area.inside(area.places(point.q)):
            return
        if any(self.tracer.holds(curve, point) for curve in self.curves):
            return
        if any(area.apart(one.q, point.q) <= 1e-6 for one in self._alone):
            return
        traced = self.tracer.trace(point)
        if traced is None:
            self._alone.append(point)
            return
        self.curves.append(traced)
        for end in (traced.points[0].point, traced.points[-1].point):
            for q in area.turned_back(end.q):
                again = self.tracer.corrected(SingularPoint(q, end.u, end.idle), self._most)
                if again is not None:
                    self._trace(again)

    def beside(self, curve: Traced) -> Iterator[Configuration]:
        """Yield poses on the sheets that meet at a curve of gain, some cells away from it."""
        if self.stays(curve):
            return
        count = len(curve.points)
        looked = max(_LOOKED, count // _LOOKED_EVERY)
        for index in sorted({int(k) for k in np.linspace(0, count - 1, looked + 2)[1:-1]}):
            yield from self.modes_at(curve.points[index])

    @property
    def moving(self) -> list[PlaneCurve]:
        """The curves that do not stay at one place, in the plane."""
        return [PlaneCurve.of(self.tracer, one) for one in self.curves if not self.stays(one)]

    def stays(self, curve: Traced) -> bool:
        """Tell whether a curve stays at its place, the machine moving with the plane at rest."""
        extent = np.ptp(self.area.places(curve.q), axis=0)
        return bool((extent <= _STAYING * self.area.size).all())

    def modes_of(self, curve: Traced) -> tuple[int, ...]:
        """Return on which of the known sheets a curve lies; of a gain, which meet there."""
        if self.stays(curve):
            return ()
        middle = curve.points[len(curve.points) // 2].point.q
        poses = (
            self.beside(curve)
            if self._folds is not None
            else [self.area.mechanism.configuration(middle)]
        )
        numbers = {self.sheets.index(pose) for pose in poses}
        return tuple(sorted(number for number in numbers if number is not None))

    def modes_at(self, here: OnCurve) -> Iterator[Configuration]:
        """Yield poses on the two sheets that meet at a fold."""
        equations, area, point = self._folds, self.area, here.point
        if equations is None:
            return
        fold, partition = equations.fold(point), equations.partition
        normal = np.where(np.isin(partition.actuated, area.columns), fold.normal, 0.0)
        size = float(np.linalg.norm(normal))
        if not min(size, abs(fold.curvature)) > _NO_FOLD:
            return
        inward = -np.sign(fold.curvature) * normal / size
        for side in (1.0, -1.0):
            # η_θ δθ + ½ η_uu aside² = 0 along w.
            step = np.zeros(here.tangent.size)
            step[partition.passive] = side * _BESIDE_FOLD * point.u
            step[partition.actuated] = 0.5 * abs(fold.curvature) * _BESIDE_FOLD**2 / size * inward
            q = equations.moved(point, step).q
            found = assemble(equations.problem, q, motor_weights(equations.problem, 0.0))
            if found.gap <= equations.problem.tolerance and area.apart(found.q, q) < _BESIDE_FOLD:
                away = self.sheets.away_from(found.q, inward)
                if away is not None:
                    yield away
