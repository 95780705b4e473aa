"""Cusps: where the image of a curve of gain turns back in motor space."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

from pmjac_pin.studies.singularities.curve_equations import SingularPoint
from pmjac_pin.studies.singularities.curve_tracing import Traced, Tracer
from pmjac_pin.studies.singularities.singular_equations import SingularEquations
from pmjac_pin.values.arrays import Array


def cusps(tracer: Tracer, equations: SingularEquations, curve: Traced) -> Iterator[SingularPoint]:
    """Yield the poses of a curve of gain at which its image in motor space has a cusp."""
    curvatures, left = [], None
    for one in curve.points:
        curvature, left = _curvature(equations, one.point, left)
        curvatures.append(curvature)
    pairs = zip(curve.points, curve.points[1:], strict=False)
    for k, (first, second) in enumerate(pairs):
        if curvatures[k] * curvatures[k + 1] < 0.0:
            _, beside = _curvature(equations, first.point, None)
            at = partial(_signed_curvature, equations, beside)
            if (found := tracer.zero_between(first, second, at)) is not None:
                yield found[1]


def _curvature(
    equations: SingularEquations, point: SingularPoint, left: Array | None
) -> tuple[float, Array]:
    """Return the fold's curvature, its w on the side of another's, and that w."""
    fold = equations.fold(point)
    turned = 1.0 if left is None or fold.left @ left >= 0.0 else -1.0
    return turned * fold.curvature, turned * fold.left


def _signed_curvature(equations: SingularEquations, left: Array, point: SingularPoint) -> float:
    return _curvature(equations, point, left)[0]
