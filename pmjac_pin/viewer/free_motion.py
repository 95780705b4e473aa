"""Which way the tool or the linkage comes free, at a singularity and near one."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from pmjac_pin.configuration import Configuration
from pmjac_pin.files.shapes import Cone, Cylinder
from pmjac_pin.pictures.anatomy import Anatomy
from pmjac_pin.pictures.bodies import Point, PointsOfBodies
from pmjac_pin.rates.factorisation import factorise
from pmjac_pin.values.arrays import Array
from pmjac_pin.viewer.items import Part, stretched_between
from pmjac_pin.viewer.layers import SPECK, Drawing, DrawnPose, distinct_parts, part_of_path, specks
from pmjac_pin.viewer.palette import FREE

#: `Singularity.smallest` below which a pose is near a singularity.
ALMOST_SINGULAR = 0.01
# Shares of the mechanism's size.
_LENGTH = 0.3  # of the longer arrows, to either side
_ARROW_HEAD = 0.08
_ARROW_RADIUS = 0.012
_SLOWEST = 0.02  # of the fastest point: slower ones get no arrow
_RESTS = 1e-9  # of the size in a second: nothing moves, but a body spins in its place


class FreeMotionLayer:
    """Arrows along the velocities that are easiest with the motors locked.

    They point both ways, for a free motion has no sign. They start at the tool, at the loops'
    anchors and at the joints; all are hidden at regular poses, and those at points that do not
    move always.

    Attributes
    ----------
    parts : sequence of Part
        All shafts, then all heads one way, then all heads the other way.
    """

    def __init__(self, anatomy: Anatomy) -> None:
        self._anatomy = anatomy
        found = list(_places(anatomy)) if anatomy.anchors else []
        self._points = PointsOfBodies.of([point for _, point in found])
        # Without loops nothing is locked by the motors that could come free.
        names = ["tool", *(name for name, _ in found)] if anatomy.anchors else []
        shapes = (("shaft", Cylinder()), ("forth", Cone()), ("back", Cone()))
        self.parts: Sequence[Part] = distinct_parts(
            [Part(f"free/{name}/{end}", shape, FREE) for end, shape in shapes for name in names]
        )

    def draw(self, pose: DrawnPose) -> Drawing:
        """Return the arrows, or nothing to see at a regular pose."""
        count, size = len(self.parts), self._anatomy.size
        candidates = easiest_motions(pose.configuration) if count else np.zeros((0, 0))
        if not candidates.size:
            transforms, visible = np.zeros((count, 4, 4)), np.zeros(count, dtype=bool)
        else:
            places = np.vstack([pose.tool, self._points.at(pose.placements)])
            transforms, visible = self._arrows(places, self._velocities(pose, candidates))
        specks(transforms, visible, pose.tool, SPECK * size)
        return Drawing(transforms, visible)

    def _velocities(self, pose: DrawnPose, candidates: Array) -> Array:
        """Return the velocities (k, 3) of tool and points in that free motion that moves most."""
        split = pose.configuration.split_jacobian()
        columns = split.partition.passive
        moved = []
        for rates in candidates.T:
            v = np.zeros(self._anatomy.model.nv)
            v[columns] = rates
            points = self._anatomy.bodies.velocities(pose.configuration.q, v, self._points)
            moved.append(np.vstack([split.Jv_star @ rates, points]))
        if len(moved) == 1:
            return moved[0]
        weights = factorise(np.array(moved).reshape(len(moved), -1).T, 1.0).right[0]
        easiest: Array = np.tensordot(weights, np.array(moved), 1)
        return easiest

    def _arrows(self, places: Array, velocities: Array) -> tuple[Array, NDArray[np.bool_]]:
        size = self._anatomy.size
        speeds = np.linalg.norm(velocities, axis=1)
        fastest = speeds.max()
        moving = speeds > max(_SLOWEST * fastest, _RESTS * size)
        vectors = np.zeros_like(velocities)
        vectors[moving] = velocities[moving] * (_LENGTH * size / (fastest or 1.0))
        lengths = np.linalg.norm(vectors, axis=1)
        heads = np.minimum(_ARROW_HEAD * size, 0.5 * lengths)
        necks = vectors * (1.0 - heads / np.where(moving, lengths, 1.0))[:, None]
        radii = np.minimum(_ARROW_RADIUS * size, 0.15 * lengths)
        stretched = [
            stretched_between(places - necks, places + necks, radii, 0.0),
            stretched_between(places + necks, places + vectors, 0.4 * heads, 0.0),
            stretched_between(places - necks, places - vectors, 0.4 * heads, 0.0),
        ]
        return np.concatenate([item for item, _ in stretched]), np.tile(moving, 3)


def easiest_motions(configuration: Configuration) -> Array:
    """Return passive rates that are free here with the motors locked, or nearly so.

    Returns
    -------
    ndarray, shape (m_p, k)
        What comes free at a singularity, or near one the right singular vector of the smallest
        singular value of K* without dimension that decides; turned back to
        m/s and rad/s. Nothing (k = 0) at a regular pose. Idle motions, which are free at every
        pose, are left out.
    """
    singularity = configuration.singularity()
    if singularity.gained:
        return singularity.free_motions
    partition = configuration.split_jacobian().partition
    passive = partition.passive
    if singularity.smallest >= ALMOST_SINGULAR:
        return np.zeros((passive.size, 0))
    loops = partition.loop_rates(configuration.split_jacobian().constraint_jacobian)
    weakest = loops.passive.right[singularity.generic_rank - 1]
    rates: Array = partition.column_scale[passive] * weakest
    return rates[:, None]


def _places(anatomy: Anatomy) -> Iterator[tuple[str, Point]]:
    """Yield the points that may move, each once."""
    seen = [anatomy.settled(point) for point in anatomy.tool] if len(anatomy.tool) == 1 else []
    for name, point in _candidates(anatomy):
        settled = anatomy.settled(point)
        if settled.body and not any(anatomy.coincide(settled, other) for other in seen):
            seen.append(settled)
            yield name, settled


def _candidates(anatomy: Anatomy) -> Iterator[tuple[str, Point]]:
    for number, anchors in enumerate(anatomy.anchors, start=1):
        yield f"loops/{number}/first", anchors.first
        # The anchors of a closed point loop are one point, and move as one.
        if anchors.length > 0.0:
            yield f"loops/{number}/second", anchors.second
    for joint in anatomy.joints:
        yield f"joints/{part_of_path(str(anatomy.model.names[joint]))}", Point(joint, np.zeros(3))
