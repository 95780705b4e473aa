"""The size of a machine, and where it stands: neither depends on the world's origin.

Metres and radians meet in ranks and steps, so a length has to say what a radian is worth. It is a
size of the loops: how far from its joints' axes a loop's two frames are, whatever else the model
names, and wherever it stands. So has each loop one, where it is much smaller than the machine.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from pmjac_pin.closing.scales import smallest_loops
from pmjac_pin.kinematics.loop_system import LoopEnd, LoopSystem
from pmjac_pin.kinematics.pinocchio import Kinematics
from pmjac_pin.kinematics.tool import frame_jacobian
from pmjac_pin.model.spec import MechanismSpec
from pmjac_pin.values.arrays import Array

#: Shorter than this, m, a lever arm is rounding: of a spherical linkage's joints, for one.
NO_LENGTH = 1e-9
#: Of the largest coordinate that loops and tool rest on: what their rounding may open a loop by.
ROUNDING_OF_PLACES = 16.0 * float(np.finfo(float).eps)

#: Of the machine's length: loops with shorter arms have none, as those of a spherical linkage.
SPHERICAL = 1e-6
#: Of the machine's length: smaller loops are measured by their own size.
SMALL = 1e-2

_TOLERANCES = 3.0  # a length that the tolerance covers is rounding, too
BESIDE_ITSELF = 8.0  # lengths: from here on it is computed beside itself, not from the origin


class Size:
    """A machine's length and place at one pose.

    Parameters
    ----------
    kinematics : Kinematics
    spec : MechanismSpec
    turns : ndarray of bool, shape (nv,)
        Which rates are in rad/s.
    q : ndarray, shape (nq,)

    Attributes
    ----------
    length : float
        The characteristic length, m: the mean lever arm of the loops, weighted by itself,
        Σa²/Σa. An arm is the distance of one of a loop's two frames from the axis of a joint
        that turns it against the other; the length of a rod counts as one. A spherical linkage
        has no such arms: then it is the tool's, and 1 m where that has none either.
    arms : tuple of float
        Of each loop in the same way, m; 0 where rounding is all there is.
    loop_sizes : tuple of float
        What each loop is measured by, m: its arms where they are less than a hundredth of the
        machine's, but not so short that it is spherical; `length` elsewhere.
    strokes : ndarray, shape (nv,)
        How far a rod lets slides go that nothing turns with it, a share of `length`; 1 elsewhere.
    rounding : float
        What rounding of coordinates may open a loop by, m, each loop as large as the machine.
    place : ndarray, shape (3,)
        Where the machine stands, m: 0 for coordinates that are no larger than the machine.
    """

    def __init__(
        self, kinematics: Kinematics, spec: MechanismSpec, turns: NDArray[np.bool_], q: Array
    ) -> None:
        model, loops, tool = kinematics.model, kinematics.loops, kinematics.tool
        data = kinematics.placed(q)
        jacobian, pose = tool.at(model, data)
        places = data.oMf
        points = [places[end.frame].translation for ends in loops.ends for end in ends]
        if not spec.tool.is_none:
            points.append(pose.translation)
        elif not points:
            places = data.oMf if model.nframes > 1 else data.oMi
            points = [place.translation for place in places.tolist()[1:]]
        opened = ROUNDING_OF_PLACES * float(np.abs(points).max())
        rods = _rods(loops)
        turned = (_arms(model, data, turns, ends) for ends in loops.ends)
        # Where nothing turns, how long a rod is does not matter to any rate.
        arms = [[*rod, *own] if own else [] for rod, own in zip(rods, turned, strict=True)]
        turning = jacobian[:, turns]
        rounding = max(NO_LENGTH, _TOLERANCES * max(spec.tolerance or 0.0, opened))
        means = [_mean(np.array(own)) for own in arms]
        every = _mean(np.array([arm for own in arms for arm in own]))
        if not any(arms):  # slides alone
            every = _mean(np.array([one for rod in rods for one in rod]))
        self.length = invertible(_length(every, _mean(_distances(turning)), rounding))
        held = [
            self.length if own else min(rod, default=self.length)
            for rod, own in zip(rods, arms, strict=True)
        ]
        self.strokes = smallest_loops(loops, held, model.nv, self.length) / self.length
        self.arms = tuple(mean if mean > rounding else 0.0 for mean in means)
        self.loop_sizes = tuple(
            mean if SPHERICAL * self.length < mean < SMALL * self.length else self.length
            for mean in self.arms
        )
        self.rounding = opened * self.length / min(self.loop_sizes, default=self.length)
        middle = np.mean(points, axis=0)
        self.place: Array = np.where(np.abs(middle) > BESIDE_ITSELF * self.length, middle, 0.0)


def shifted_model(model: pin.Model, by: Array) -> pin.Model:
    """Return the model moved in the world; q stays what it is.

    Examples
    --------
    >>> arm = pin.buildSampleModelManipulator()
    >>> moved = shifted_model(arm, np.array([0.0, 0.0, 5e6]))
    >>> float(moved.jointPlacements[1].translation[2] - arm.jointPlacements[1].translation[2])
    5000000.0
    """
    moved = model.copy()
    for joint in range(1, model.njoints):
        if model.parents[joint] == 0:
            moved.jointPlacements[joint].translation += by
    for frame in list(moved.frames)[1:]:
        if frame.parentJoint == 0:
            frame.placement = pin.SE3(frame.placement.rotation, frame.placement.translation + by)
    return moved


def _arms(
    model: pin.Model, data: pin.Data, turns: NDArray[np.bool_], ends: Sequence[LoopEnd]
) -> list[float]:
    arms: list[float] = []
    for frame, columns in ends:
        motions = frame_jacobian(model, data, frame)[:, columns[turns[columns]]]
        arms += _distances(motions).tolist()
    return arms


def _rods(loops: LoopSystem) -> list[list[float]]:
    """Return the lengths of the rods of each loop, m."""
    return [
        [loops.rods[row] for row in loops.rods if rows.start <= row < rows.stop]
        for rows in loops.slices
    ]


def _length(loops: float, tool: float, rounding: float) -> float:
    if loops > max(rounding, SPHERICAL * tool):
        return loops
    return tool if tool > rounding else 1.0


def invertible(length: float) -> float:
    """Return the next length x with x · (1/x) = 1 and 1/(1/x) = x.

    So a rad counts as one length wherever it is turned into that and back, and what programs say
    of a machine does not depend on how such products are rounded.

    Examples
    --------
    >>> x = 49.0
    >>> x * (1.0 / x), invertible(x) * (1.0 / invertible(x))
    (0.9999999999999999, 1.0)
    """
    while length * (1.0 / length) != 1.0 or 1.0 / (1.0 / length) != length:
        length = math.nextafter(length, math.inf)
    return length


def _distances(motions: Array) -> Array:
    """Return how far a point is from the axes that turn it, of its motions (6, k) by 1 rad each.

    What a screw slides along its axis is no distance from it. Points of several bodies have no
    axis: the frame that they span turns faster or slower than their joints.
    """
    linear, angular = motions[:3], motions[3:]
    about_an_axis = np.abs((angular * angular).sum(axis=0) - 1.0) < 1e-9
    along = np.where(about_an_axis, (linear * angular).sum(axis=0), 0.0)
    distances: Array = np.linalg.norm(linear - angular * along, axis=0)
    return distances


def _mean(arms: Array) -> float:
    """Return Σa²/Σa: joints whose axes pass through a frame do not count."""
    total = float(arms.sum())
    return float(arms @ arms) / total if total > 0.0 else 0.0
