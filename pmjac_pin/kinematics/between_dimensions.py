"""Loops of machines between such that differ in dimensions alone, without a file.

A placement slides straight and turns about one axis on its way. So it does by parameters, where
these slide a joint's origin, or turn it by one angle: what such an origin carries goes with it.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence
from typing import TypeAlias

import numpy as np
import pinocchio as pin

from pmjac_pin.kinematics.loop_system import LoopSystem
from pmjac_pin.kinematics.pinocchio import Kinematics
from pmjac_pin.kinematics.tool import tool_kinematics
from pmjac_pin.model.rows import Rows
from pmjac_pin.model.tool_spec import NO_TOOL

#: Share of the way ↦ the rows of each loop between frames there.
RowsOnTheWay: TypeAlias = Callable[[float], Sequence[Sequence[Rows]]]

#: Share of a leg ↦ where a placement is.
_Track: TypeAlias = Callable[[float], pin.SE3]


class BetweenDimensions:
    """Machines on a way from stop to stop.

    Parameters
    ----------
    stops : sequence of Kinematics
        At equal shares of the way, the first and the last at its ends: the same joints and loops,
        placed otherwise. Placements that turn go the shortest way to the next.
    rows : callable
        Share of the way ↦ the rows of each loop between frames there.
    """

    def __init__(self, stops: Sequence[Kinematics], rows: RowsOnTheWay) -> None:
        self._legs = [
            _Leg(one.model, other.model, one.loops) for one, other in itertools.pairwise(stops)
        ]
        last = stops[-1].model
        self._rows, self._data, self._tool = rows, last.createData(), tool_kinematics(last, NO_TOOL)

    def at(self, share: float) -> Kinematics:
        """Return the loops alone at a share of the way; it serves until the next is asked for."""
        along = share * len(self._legs)
        number = min(int(along), len(self._legs) - 1)
        model, loops = self._legs[number].at(along - number, self._rows(share))
        return Kinematics(model, loops, self._tool, self._data)


class _Leg:
    """The way from one stop to the next."""

    def __init__(self, one: pin.Model, other: pin.Model, loops: LoopSystem) -> None:
        self._model, self._loops = one, loops
        ends = enumerate(zip(one.jointPlacements, other.jointPlacements, strict=True))
        moved = [joint for joint, (first, last) in ends if first != last]
        self._joints = [(joint, _joint_track(one, other, joint)) for joint in moved]
        self._frames = [
            (index, _frame_track(one, other, index))
            for index in {end.frame for ends in loops.ends for end in ends}
            if one.frames[index].placement != other.frames[index].placement
        ]

    def at(self, share: float, rows: Sequence[Sequence[Rows]]) -> tuple[pin.Model, LoopSystem]:
        """Return a machine's joints and its loops; no other frame is where it should be."""
        model = self._model.copy()
        for joint, track in self._joints:
            model.jointPlacements[joint] = track(share)
        places = {index: track(share) for index, track in self._frames}
        return model, self._loops.placed(model, places, rows)


def _joint_track(one: pin.Model, other: pin.Model, joint: int) -> _Track:
    name, kind = one.names[joint], pin.FrameType.JOINT
    # What was hung up anew has no such frames.
    carrier = (
        one.frames[one.getFrameId(name, kind)].parentFrame if one.existFrame(name, kind) else 0
    )
    ends = one.jointPlacements[joint], other.jointPlacements[joint]
    return _track(one, other, carrier, one.parents[joint], ends)


def _frame_track(one: pin.Model, other: pin.Model, index: int) -> _Track:
    own = one.frames[index]
    ends = own.placement, other.frames[index].placement
    return _track(one, other, own.parentFrame, own.parentJoint, ends)


def _track(
    one: pin.Model, other: pin.Model, carrier: int, joint: int, ends: tuple[pin.SE3, pin.SE3]
) -> _Track:
    """Return the track of what a frame on a joint carries, or else the joint alone."""
    first, last = ends
    if np.array_equal(first.rotation, last.rotation):
        return lambda share: pin.SE3.Interpolate(first, last, share)
    if one.frames[carrier].parentJoint != joint or not carrier:
        return _turning_track(first, last)
    carrying = _frame_track(one, other, carrier)
    carriers = (model.frames[carrier].placement for model in (one, other))
    own = _turning_track(*(place.actInv(end) for place, end in zip(carriers, ends, strict=True)))
    return lambda share: carrying(share) * own(share)


def _turning_track(first: pin.SE3, last: pin.SE3) -> _Track:
    rotation, begin = first.rotation.copy(), first.translation.copy()
    turn, slide = pin.log3(rotation.T @ last.rotation), last.translation - begin
    return lambda share: pin.SE3(rotation @ pin.exp3(share * turn), begin + share * slide)
