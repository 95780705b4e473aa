"""A locus as an xarray dataset."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from pmjac_pin.model.coordinates import entry_names
from pmjac_pin.studies.sweep.store import packages

if TYPE_CHECKING:
    from xarray import Dataset

    from pmjac_pin.studies.singularities.locus import SingularityLocus
else:
    Dataset = SingularityLocus = Any


def dataset(locus: SingularityLocus) -> Dataset:
    """Return curves and special points as a dataset; see `SingularityLocus.to_xarray`."""
    xarray, _ = packages()
    curves, points = locus.curves, locus.points
    nq = locus.at.mechanism.nq
    numbers = [np.full(len(curve.places), k) for k, curve in enumerate(curves)]
    variables: dict[str, Any] = {
        "place": (("vertex", "axis"), _stacked([c.places for c in curves], 2)),
        "q": (("vertex", "entry"), _stacked([c.q for c in curves], nq)),
        "curve": ("vertex", np.concatenate([np.zeros(0, dtype=int), *numbers])),
        "kind": ("curve_number", [curve.kind for curve in curves]),
        "closed": ("curve_number", [curve.is_closed for curve in curves]),
        "on_modes": ("curve_number", [" ".join(map(str, curve.modes)) for curve in curves]),
        "special_place": (("special", "axis"), _stacked([p.place[None] for p in points], 2)),
        "special_q": (("special", "entry"), _stacked([p.q[None] for p in points], nq)),
        "mark": ("special", [point.mark for point in points]),
    }
    coordinates = {
        "axis": list(locus.plane),
        "entry": list(entry_names(locus.at.mechanism.model)),
    }
    held = {f"held {name}": value for name, value in locus.held.items()}
    attributes = {"mechanism": locus.at.mechanism.name, "evidence": str(locus.evidence), **held}
    found: Dataset = xarray.Dataset(variables, coordinates, attributes)
    return found


def _stacked(parts: list[Any], width: int) -> Any:
    return np.concatenate([np.zeros((0, width)), *parts])
