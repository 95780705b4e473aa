"""Unknowns: the passive joints as coordinates around a pose, and the norm of a step of them.

One number for each passive degree of freedom: an angle, a slide along a fixed direction, or a
component of a rotation vector x, by which a ball turns to R exp[x]. A free body slides along
the axes that it has at the pose, which stand still, and turns so.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pmjac_pin.kinematics.joints import JOINT_KINDS
from pmjac_pin.model.linkage import Edge

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Group:
    """Unknowns that are measured together, by the Euclidean norm.

    Attributes
    ----------
    columns : tuple of int
        Among the unknowns.
    turns : bool
        They are an angle or a rotation vector, rad; otherwise slides, m.
    """

    columns: tuple[int, ...]
    turns: bool


@dataclass(frozen=True, slots=True)
class JointUnknowns:
    """The groups of one passive joint."""

    slide: int | None
    turn: int | None


class Unknowns:
    """The passive degrees of freedom, in the order of `Mechanism.passive`.

    Attributes
    ----------
    groups : tuple of Group
    of_joint : mapping of int to JointUnknowns
        By Pinocchio's index of the joint; joints that are held are not in it.
    """

    __slots__ = ("groups", "of_joint")

    def __init__(self, edges: Mapping[int, Edge], starts: Mapping[int, int]) -> None:
        groups: list[Group] = []
        self.of_joint: dict[int, JointUnknowns] = {}
        for joint, start in starts.items():
            kind = JOINT_KINDS[edges[joint].kind]
            slides, turns = kind.slides, kind.turns
            middle, end = start + slides, start + slides + turns
            slide = turn = None
            if slides:
                slide = len(groups)
                groups.append(Group(tuple(range(start, middle)), False))
            if turns:
                turn = len(groups)
                groups.append(Group(tuple(range(middle, end)), True))
            self.of_joint[joint] = JointUnknowns(slide, turn)
        self.groups = tuple(groups)

    @property
    def count(self) -> int:
        """The number of unknowns."""
        return sum(len(group.columns) for group in self.groups)

    def scale(self, length: float) -> Array:
        """Return what a step of norm 1 moves each group by: 1 rad, or the length in m."""
        return np.array([1.0 if group.turns else length for group in self.groups])
