"""Links: their visuals, and bars between their joints, anchors and tool where these show none."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from pmjac_pin.files.shapes import Cylinder
from pmjac_pin.model.frames import find_frame
from pmjac_pin.pictures.anatomy import COINCIDENT, Anatomy
from pmjac_pin.values.arrays import Array
from pmjac_pin.viewer.items import Carried, Part, stretched_between
from pmjac_pin.viewer.layers import Attached, part_of_path
from pmjac_pin.viewer.palette import GROUND, LINK

# Shares of the mechanism's size.
BAR_RADIUS = 0.015
FAR = 0.1  # from a visual: what is nearer is seen to belong to it


def link_layer(anatomy: Anatomy) -> Attached:
    """Return everything that is fixed to the bodies as their shape.

    A body whose visuals are all boxes, cylinders, capsules and spheres is drawn by these; where a
    joint or a loop's end is elsewhere, a bar goes from the nearest of them there. A body with a
    mesh, or without any visual, gets bars: between two points one, from more of them one each to
    their mean.
    """
    return Attached.of([*_visuals(anatomy), *_bars(anatomy)])


def _visuals(anatomy: Anatomy) -> Iterator[Carried]:
    for visual in anatomy.visuals:
        frame = find_frame(anatomy.model, visual.link)
        name = f"links/{part_of_path(visual.link)}/{part_of_path(visual.name)}"
        for shape, transform in visual.pieces:
            part = Part(name, shape, visual.colour or LINK)
            yield part, frame.joint, frame.placement.homogeneous @ transform


def _bars(anatomy: Anatomy) -> Iterator[Carried]:
    complete = anatomy.drawn_by_visuals
    for body in range(anatomy.model.njoints):
        if body in complete:
            starts, ends = _from_visuals(anatomy, body)
        else:
            starts, ends = _bar_ends(anatomy.link_points(body))
        radii = np.full(len(starts), BAR_RADIUS * anatomy.size)
        transforms, visible = stretched_between(starts, ends, radii, COINCIDENT * anatomy.size)
        colour = LINK if body else GROUND
        name = part_of_path(anatomy.body_name(body))
        for number, transform in enumerate(transforms[visible], start=1):
            yield Part(f"links/{name}/bar{number}", Cylinder(), colour), body, transform


def _from_visuals(anatomy: Anatomy, body: int) -> tuple[Array, Array]:
    """Return what lies far from a body's visuals, (k, 3) in its frame, and from where to go there.

    Beside them is not far: mechanisms in a plane are drawn in layers.
    """
    points = anatomy.held_points(body)
    nearest, distances = points.copy(), np.full(len(points), np.inf)
    for part, carrier, place in _visuals(anatomy):
        if carrier == body:
            found = _nearest(part, place, points)
            away = np.linalg.norm(points - found, axis=1)
            nearest[away < distances] = found[away < distances]
            distances = np.minimum(distances, away)
    far = distances > FAR * anatomy.size
    return nearest[far], points[far]


def _nearest(part: Part, place: Array, points: Array) -> Array:
    """Return the points of a shape's box that are nearest to these, shape (k, 3)."""
    half = np.array(part.shape.half_extents)
    turned = (points - place[:3, 3]) @ np.linalg.inv(place[:3, :3]).T
    found: Array = np.clip(turned, -half, half) @ place[:3, :3].T + place[:3, 3]
    return found


def _bar_ends(points: Array) -> tuple[Array, Array]:
    if len(points) < 2:
        return np.zeros((0, 3)), np.zeros((0, 3))
    if len(points) == 2:
        return points[:1], points[1:]
    return np.broadcast_to(points.mean(axis=0), points.shape), points
