"""The kinematics of a tree over boxes of joint values: poses and their derivatives, enclosed.

A pose is [R p], and a joint multiplies it from the right by what `linkage` writes: before, motion
about or along z, after. Its derivatives by the unknowns go through the same products, all but the
joint's own: there the motion is differentiated. So no derivative is a difference of two poses,
which would be much wider than itself.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from pmjac_pin.algebra.intervals import Intervals
from pmjac_pin.frames import Frame
from pmjac_pin.linkage import edges_of

Array = NDArray[np.float64]


class IntervalTree:
    """The joints of a tree that boxes speak of, and those whose values are given.

    Parameters
    ----------
    model : pin.Model
    unknowns : sequence of str
        Joints of one degree of freedom: the columns of a box.
    given : mapping of str to float
        The other joints' values, m or rad.
    """

    __slots__ = ("_edges", "_given", "_unknowns")

    def __init__(
        self, model: pin.Model, unknowns: Sequence[str], given: Mapping[str, float]
    ) -> None:
        self._edges = {edge.child: edge for edge in edges_of(model).values()}
        self._unknowns = {name: column for column, name in enumerate(unknowns)}
        self._given = {name: Intervals.exact([value]) for name, value in given.items()}

    def frames(self, frames: Iterable[Frame], box: Intervals, by: Sequence[int]) -> Poses:
        """Return where frames are.

        Parameters
        ----------
        frames : iterable of Frame
        box : Intervals, shape (b, k)
            The unknowns' values, m or rad.
        by : sequence of int
            The unknowns to differentiate by.

        Returns
        -------
        mapping of int to Intervals, shape (b or 1, 1 + len(by), 3, 4)
            By the frame's index: [R p], and its derivatives.
        """
        poses = {0: _standing(len(by))}
        return {
            frame.index: self._body(frame.joint, box, by, poses).before(_matrix(frame.placement))
            for frame in frames
        }

    def _body(
        self, body: int, box: Intervals, by: Sequence[int], poses: dict[int, Intervals]
    ) -> Intervals:
        if body not in poses:
            edge = self._edges[body]
            pose = self._body(edge.parent, box, by, poses).before(_matrix(edge.before))
            column = self._unknowns.get(edge.name)
            value = self._given[edge.name] if column is None else box[:, column]
            own = by.index(column) + 1 if column in by else None
            move = _slid if edge.kind == "prismatic" else _turned
            poses[body] = move(pose, value, own).before(_matrix(edge.after))
        return poses[body]


Poses = Mapping[int, Intervals]


def _standing(rates: int) -> Intervals:
    pose = np.zeros((1, 1 + rates, 3, 4))
    pose[:, 0, :, :3] = np.eye(3)
    return Intervals.exact(pose)


def _matrix(placement: pin.SE3) -> Array:
    matrix: Array = placement.homogeneous
    return matrix


def _turned(pose: Intervals, angle: Intervals, own: int | None) -> Intervals:
    cosine, sine = angle.cos()[:, None, None], angle.sin()[:, None, None]
    x, y = pose[..., 0], pose[..., 1]
    columns = [x * cosine + y * sine, y * cosine - x * sine]
    # d/dφ (x cos φ + y sin φ) is the new y, and the new y's derivative is minus the new x.
    rates = [columns[1][:, 0], -columns[0][:, 0]]
    return _with_columns(pose, dict(enumerate(columns)), own, dict(enumerate(rates)))


def _slid(pose: Intervals, value: Intervals, own: int | None) -> Intervals:
    z, origin = pose[..., 2], pose[..., 3]
    moved = origin + z * value[:, None, None]
    return _with_columns(pose, {3: moved}, own, {3: z[:, 0]})


def _with_columns(
    pose: Intervals,
    columns: Mapping[int, Intervals],
    own: int | None,
    rates: Mapping[int, Intervals],
) -> Intervals:
    """Return the pose with some new columns, and its derivative by the joint that made them."""
    shape = (next(iter(columns.values())).shape[0], *pose.shape[1:])
    ends = []
    for end in ("lower", "upper"):
        whole = np.broadcast_to(getattr(pose, end), shape).copy()
        for column, values in columns.items():
            whole[..., column] = getattr(values, end)
        if own is not None:
            whole[:, own] = 0.0
            for column, values in rates.items():
                whole[:, own, :, column] = getattr(values, end)
        ends.append(whole)
    return Intervals(ends[0], ends[1])
