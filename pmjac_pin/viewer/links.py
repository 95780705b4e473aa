"""Links: their visuals, or bars between their joints, anchors and tool where there are none."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from pmjac_pin.files.shapes import Cylinder
from pmjac_pin.model.frames import find_frame
from pmjac_pin.pictures.anatomy import COINCIDENT, Anatomy
from pmjac_pin.values.arrays import Array
from pmjac_pin.viewer.items import Carried, Part, between
from pmjac_pin.viewer.layers import Attached, part_of_path
from pmjac_pin.viewer.palette import GROUND, LINK

BAR_RADIUS = 0.015  # of the mechanism's size


def link_layer(anatomy: Anatomy) -> Attached:
    """Return everything that is fixed to the bodies as their shape.

    A body whose visuals are all boxes, cylinders, capsules and spheres is drawn by these. One
    with a mesh, or without any visual, gets bars: between two points one, from more of them one
    each to their mean.
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
            continue
        starts, ends = _bar_ends(anatomy.link_points(body))
        radii = np.full(len(starts), BAR_RADIUS * anatomy.size)
        transforms, visible = between(starts, ends, radii, COINCIDENT * anatomy.size)
        colour = LINK if body else GROUND
        name = part_of_path(anatomy.body_name(body))
        for number, transform in enumerate(transforms[visible], start=1):
            yield Part(f"links/{name}/bar{number}", Cylinder(), colour), body, transform


def _bar_ends(points: Array) -> tuple[Array, Array]:
    if len(points) < 2:
        return np.zeros((0, 3)), np.zeros((0, 3))
    if len(points) == 2:
        return points[:1], points[1:]
    return np.broadcast_to(points.mean(axis=0), points.shape), points
