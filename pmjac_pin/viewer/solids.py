"""The polytopes at the tool: what it can do within the limits of each motor."""

from __future__ import annotations

import functools
from collections.abc import Iterable, Sequence

import numpy as np

from pmjac_pin.configuration import Configuration
from pmjac_pin.errors import ArgumentError, enumerated
from pmjac_pin.files.shapes import Text
from pmjac_pin.mechanism import Mechanism
from pmjac_pin.pictures.anatomy import Anatomy
from pmjac_pin.pictures.within_limits import ToolQuantity, solid_within
from pmjac_pin.rates.motor_limits import stated_effort_limits, stated_rate_limits
from pmjac_pin.rates.solid import Solid
from pmjac_pin.values.arrays import Array
from pmjac_pin.viewer.ellipsoids import LETTERS, LIMIT, radius_label
from pmjac_pin.viewer.equivalent import equivalent
from pmjac_pin.viewer.facets import NO_FACETS, Facets, fans, rods
from pmjac_pin.viewer.items import Part
from pmjac_pin.viewer.layers import SPECK, Drawing, DrawnPose, SolidKind, lettering, specks, words
from pmjac_pin.viewer.palette import SOLID, SOLID_EDGE

QUANTITY_OF: dict[SolidKind, ToolQuantity] = {"velocity": "linear", "force": "force"}
_EDGE_RADIUS = 0.004  # of the mechanism's size, the radius of an edge
_NO_JACOBIAN = "No polytope: there is no equivalent Jacobian at this pose."


class SolidLayer:
    """One polytope about the tool: its faces, its edges, and how far its farthest corner is.

    Parameters
    ----------
    anatomy : Anatomy
    kind : {"velocity", "force"}
    automatic : float
        Of the ellipsoid of like quantity, metres in the picture per unit for motors at 1: where all
        limits are alike, that ellipsoid is inscribed in the polytope.
    """

    def __init__(self, anatomy: Anatomy, kind: SolidKind, automatic: float) -> None:
        self._kind: SolidKind = kind
        self._size = anatomy.size
        self._scale = automatic / _largest_limit(anatomy.mechanism, kind)
        path = f"polytopes/{kind}"
        self.parts: Sequence[Part] = (
            Part(f"{path}/faces", NO_FACETS, SOLID[kind]),
            Part(f"{path}/edges", NO_FACETS, SOLID_EDGE[kind]),
            words(f"{path}/label", "", SOLID_EDGE[kind]),
        )

    def draw(self, pose: DrawnPose) -> Drawing:
        """Return faces, edges and label."""
        solid = pose.solids.get(self._kind)
        transforms, visible = np.zeros((3, 4, 4)), np.zeros(3, dtype=bool)
        shapes: dict[int, Facets | Text] = {}
        if solid is not None:
            wanted = solid.reach * self._scale * pose.scale
            drawn = min(wanted, LIMIT * self._size)
            corners = solid.corners / solid.reach
            farthest = corners[np.linalg.norm(corners, axis=1).argmax()]
            transforms[:2] = lettering(np.tile(pose.tool, (2, 1)), drawn)
            beside = pose.tool + (drawn + LETTERS * self._size) * farthest
            transforms[2:] = lettering(beside[None], LETTERS * self._size)
            visible[:] = [bool(solid.faces), True, True]
            shapes = self._shapes(solid, corners, drawn)
            reduced = ", drawn smaller" * (wanted > drawn)
            shapes[2] = Text(f"{radius_label(solid.reach, solid.unit)}{reduced}")
        specks(transforms, visible, pose.tool, SPECK * self._size)
        return Drawing(transforms, visible, shapes)

    def _shapes(self, solid: Solid, corners: Array, drawn: float) -> dict[int, Facets | Text]:
        starts, ends = (corners[list(each)] for each in zip(*solid.edges, strict=True))
        edges = Facets.of(rods(starts, ends, _EDGE_RADIUS * self._size / drawn))
        if not solid.faces:
            return {1: edges}
        return {0: Facets.of(fans(corners, solid.faces)), 1: edges}


def find_solids(configuration: Configuration, kinds: Iterable[SolidKind]) -> dict[SolidKind, Solid]:
    """Return the polytopes of these kinds that exist here."""
    found = {kind: solid_or_refusal(configuration, kind)[0] for kind in kinds}
    return {kind: solid for kind, solid in found.items() if solid is not None}


@functools.lru_cache(maxsize=2)
def solid_or_refusal(configuration: Configuration, kind: SolidKind) -> tuple[Solid | None, str]:
    """Return a polytope within the limits that the model states, or why there is none.

    Those of the last configuration are kept.
    """
    jacobian, _ = equivalent(configuration)
    if jacobian is None:
        return None, _NO_JACOBIAN
    if missing := _unlimited(configuration.mechanism, kind):
        what = "rate" if kind == "velocity" else "effort"
        return None, f"No polytope: the model states no {what} limit of {enumerated(missing)}."
    try:
        return solid_within(jacobian, QUANTITY_OF[kind], "model"), ""
    except ArgumentError as error:
        return None, f"No polytope: {error}."


def _unlimited(mechanism: Mechanism, kind: SolidKind) -> list[str]:
    missing = np.flatnonzero(np.isinf(_limits(mechanism, kind)))
    return [mechanism.actuated[k] for k in missing]


def _largest_limit(mechanism: Mechanism, kind: SolidKind) -> float:
    """Return what rate, or effort, is drawn as 1."""
    limits = _limits(mechanism, kind)
    finite = limits[np.isfinite(limits)]
    return float(finite.max()) if finite.size else 1.0


def _limits(mechanism: Mechanism, kind: SolidKind) -> Array:
    stated = stated_rate_limits if kind == "velocity" else stated_effort_limits
    return stated(mechanism.problem.partition)
