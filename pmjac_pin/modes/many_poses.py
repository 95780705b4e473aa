"""Many poses of one tree at once: forward kinematics and joint motions, vectorised in NumPy.

Pinocchio computes one pose at a time; a search over thousands of starts needs them together.
Its q is kept, one row a pose, and the tree's edges come from `linkage`, in which every joint of
one degree of freedom turns about or slides along z.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from pmjac_pin.linkage import Edge, edges_of

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class Poses:
    """Where all bodies are in b poses, and how each degree of freedom moves them.

    Attributes
    ----------
    rotations, positions : ndarray, shapes (bodies, b, 3, 3) and (bodies, b, 3)
        In the world.
    linear, angular : ndarray, shapes (b, 3, nv)
        The motion of each degree of freedom in world axes: angular velocity, and velocity of
        the point of the moved body that is at the world's origin.
    """

    rotations: Array
    positions: Array
    linear: Array
    angular: Array


class ManyPoses:
    """The kinematics of a tree over rows of q.

    Attributes
    ----------
    moved_by : ndarray of bool, shape (bodies, nv)
        Which degrees of freedom move which body.
    """

    __slots__ = ("_edges", "_joints", "_nv", "moved_by")

    def __init__(self, model: pin.Model) -> None:
        edges = edges_of(model)
        self._nv = model.nv
        self._joints = list(model.joints)[1:]
        self._edges: list[Edge] = [edges[name] for name in list(model.names)[1:]]
        self.moved_by = np.zeros((model.njoints, model.nv), dtype=bool)
        for joint, edge in zip(self._joints, self._edges, strict=True):
            self.moved_by[joint.id] = self.moved_by[edge.parent]
            self.moved_by[joint.id, joint.idx_v : joint.idx_v + joint.nv] = True

    def poses(self, q: Array) -> Poses:
        """Return where the bodies are at each row of q, shape (b, nq)."""
        count = len(q)
        rotations = np.empty((len(self._joints) + 1, count, 3, 3))
        positions = np.empty((len(self._joints) + 1, count, 3))
        rotations[0], positions[0] = np.eye(3), 0.0
        linear, angular = (np.zeros((count, 3, self._nv)) for _ in range(2))
        for joint, edge in zip(self._joints, self._edges, strict=True):
            base = rotations[edge.parent] @ edge.before.rotation
            origin = positions[edge.parent] + rotations[edge.parent] @ edge.before.translation
            turn, shift = _motion(edge, q[:, joint.idx_q : joint.idx_q + joint.nq])
            moved = base if turn is None else base @ turn
            if shift is not None:
                origin = origin + (base @ shift[:, :, None])[:, :, 0]
            columns = slice(joint.idx_v, joint.idx_v + joint.nv)
            angular[:, :, columns], linear[:, :, columns] = _rates(edge, moved, origin)
            rotations[joint.id] = moved @ edge.after.rotation
            positions[joint.id] = origin + moved @ edge.after.translation
        return Poses(rotations, positions, linear, angular)

    def moved(self, q: Array, v: Array) -> Array:
        """Return q ⊕ v for each row, shapes (b, nq) and (b, nv)."""
        result = q.copy()
        for joint, edge in zip(self._joints, self._edges, strict=True):
            entries = slice(joint.idx_q, joint.idx_q + joint.nq)
            rates = v[:, joint.idx_v : joint.idx_v + joint.nv]
            result[:, entries] = _integrated(edge, q[:, entries], rates)
        return result


def _motion(edge: Edge, entries: Array) -> tuple[Array | None, Array | None]:
    """Return a joint's rotation (b, 3, 3) and translation (b, 3), None where it has none."""
    match edge.kind:
        case "revolute":
            return _about_z(np.cos(entries[:, 0]), np.sin(entries[:, 0])), None
        case "continuous":
            return _about_z(entries[:, 0], entries[:, 1]), None
        case "prismatic":
            return None, entries * np.array([0.0, 0.0, 1.0])
        case "spherical":
            return _turned(entries), None
        case "planar":
            shift = np.column_stack([entries[:, :2], np.zeros(len(entries))])
            return _about_z(entries[:, 2], entries[:, 3]), shift
    return _turned(entries[:, 3:]), entries[:, :3]


def _rates(edge: Edge, moved: Array, origin: Array) -> tuple[Array, Array]:
    """Return angular and linear motion (b, 3, nv) of a joint, in world axes at the origin.

    As Pinocchio has them: a ball turns, and a free body moves, in its own axes.
    """
    z = moved[:, :, 2:]
    no = np.zeros((*z.shape[:2], 1))
    match edge.kind:
        case "revolute" | "continuous":
            return z, crossed(origin, z)
        case "prismatic":
            return no, z
        case "spherical":
            return moved, crossed(origin, moved)
        case "planar":
            slides = moved[:, :, :2]
            angular = np.concatenate([np.zeros_like(slides), z], axis=2)
            return angular, np.concatenate([slides, crossed(origin, z)], axis=2)
    angular = np.concatenate([np.zeros_like(moved), moved], axis=2)
    return angular, np.concatenate([moved, crossed(origin, moved)], axis=2)


def _integrated(edge: Edge, entries: Array, rates: Array) -> Array:
    match edge.kind:
        case "revolute" | "prismatic":
            return np.asarray(entries + rates)
        case "continuous":
            angle = np.arctan2(entries[:, 1], entries[:, 0]) + rates[:, 0]
            return np.column_stack([np.cos(angle), np.sin(angle)])
        case "spherical":
            return _times(entries, rates)
        case "planar":
            turn = _about_z(entries[:, 2], entries[:, 3])[:, :2, :2]
            shift = (turn @ rates[:, :2, None])[:, :, 0]
            angle = np.arctan2(entries[:, 3], entries[:, 2]) + rates[:, 2]
            return np.column_stack([entries[:, :2] + shift, np.cos(angle), np.sin(angle)])
    shift = (_turned(entries[:, 3:]) @ rates[:, :3, None])[:, :, 0]
    return np.column_stack([entries[:, :3] + shift, _times(entries[:, 3:], rates[:, 3:])])


def _times(quaternions: Array, vectors: Array) -> Array:
    turned: Array = (Rotation.from_quat(quaternions) * Rotation.from_rotvec(vectors)).as_quat()
    return turned


def _turned(quaternions: Array) -> Array:
    matrices: Array = Rotation.from_quat(quaternions).as_matrix()
    return matrices


def _about_z(cosine: Array, sine: Array) -> Array:
    turn = np.zeros((len(cosine), 3, 3))
    turn[:, 0, 0], turn[:, 0, 1], turn[:, 1, 0], turn[:, 1, 1] = cosine, -sine, sine, cosine
    turn[:, 2, 2] = 1.0
    return turn


def crossed(points: Array, vectors: Array) -> Array:
    """Return points (b, 3) × each column of vectors (b, 3, k)."""
    x, y, z = points.T
    skew = np.zeros((len(points), 3, 3))
    skew[:, 0, 1], skew[:, 0, 2], skew[:, 1, 2] = -z, y, -x
    skew[:, 1, 0], skew[:, 2, 0], skew[:, 2, 1] = z, -y, x
    return skew @ vectors
