"""Cusps: where the image of a curve of gain turns back in motor space."""

from __future__ import annotations

from collections.abc import Iterator

from pmjac_pin.studies.singularities.curve_equations import SingularPoint
from pmjac_pin.studies.singularities.curve_tracing import OnCurve, Traced, Tracer
from pmjac_pin.studies.singularities.singular_equations import SingularEquations
from pmjac_pin.values.arrays import Array

_FALSE_POSITIONS = 60


def cusps(tracer: Tracer, equations: SingularEquations, curve: Traced) -> Iterator[SingularPoint]:
    """Yield the poses of a curve of gain at which its image in motor space has a cusp."""
    curvatures, left = [], None
    for one in curve.points:
        curvature, left = _curvature(equations, one.point, left)
        curvatures.append(curvature)
    pairs = zip(curve.points, curve.points[1:], strict=False)
    for k, (first, second) in enumerate(pairs):
        if curvatures[k] * curvatures[k + 1] < 0.0:
            found = _cusp_between(tracer, equations, first, second)
            if found is not None:
                yield found


def _curvature(
    equations: SingularEquations, point: SingularPoint, left: Array | None
) -> tuple[float, Array]:
    """Return the fold's curvature, its w on the side of another's, and that w."""
    fold = equations.fold(point)
    turned = 1.0 if left is None or fold.left @ left >= 0.0 else -1.0
    return turned * fold.curvature, turned * fold.left


def _cusp_between(
    tracer: Tracer, equations: SingularEquations, first: OnCurve, second: OnCurve
) -> SingularPoint | None:
    """Return where the curvature passes zero, by the rule of false position (Illinois)."""
    start, left = _curvature(equations, first.point, None)
    low, high = (0.0, start), (1.0, _curvature(equations, second.point, left)[0])
    found, kept = None, 0
    for _ in range(_FALSE_POSITIONS):
        share = (low[0] * high[1] - high[0] * low[1]) / (high[1] - low[1])
        found = tracer.between(first, second, share)
        if found is None:
            return None
        value, _ = _curvature(equations, found, left)
        if abs(value) <= 1e-14 or high[0] - low[0] <= 1e-14:
            return found
        if value * low[1] < 0.0:
            high, kept, low = (share, value), 1, (low[0], low[1] * (0.5 if kept == 1 else 1.0))
        else:
            low, kept, high = (share, value), -1, (high[0], high[1] * (0.5 if kept == -1 else 1.0))
    return found
