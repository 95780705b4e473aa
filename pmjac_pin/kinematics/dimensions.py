"""Dimensions: where a machine's joints and frames are placed, as numbers that need not be doubles.

A model has them as constants. Where programs take dimensions as inputs, those that parameters
change are recorded numbers instead.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Protocol

import pinocchio as pin

from pmjac_pin.algebra.arrays import Numbers
from pmjac_pin.model.frames import Frame


@dataclass(frozen=True, slots=True, eq=False)
class Placement:
    """A placement of any numbers, as `pin.SE3` is one of doubles.

    Attributes
    ----------
    rotation, translation : ndarray, shapes (3, 3) and (3,)

    Examples
    --------
    >>> import numpy as np
    >>> up = Placement(np.eye(3), np.array([0.0, 0.0, 1.0]))
    >>> (up * up).translation.tolist()
    [0.0, 0.0, 2.0]
    """

    rotation: Numbers
    translation: Numbers

    @classmethod
    def of(cls, placement: pin.SE3) -> Placement:
        """Return one of Pinocchio's."""
        return cls(placement.rotation.astype(object), placement.translation.astype(object))

    def __mul__(self, other: pin.SE3 | Placement) -> Placement:
        translation = self.rotation @ other.translation + self.translation
        return Placement(self.rotation @ other.rotation, translation)


class Placements(Protocol):
    """Where joints are in their parents, and frames in the joints that carry them."""

    def of_joint(self, joint: int) -> Any:
        """Return that of Pinocchio's joint of this index."""
        ...

    def of_frame(self, frame: Frame) -> Any:
        """Return a frame's."""
        ...


class OfModel:
    """The placements of a model."""

    __slots__ = ("_model",)

    def __init__(self, model: pin.Model) -> None:
        self._model = model

    def of_joint(self, joint: int) -> pin.SE3:
        """Return that of Pinocchio's joint of this index."""
        return self._model.jointPlacements[joint]

    def of_frame(self, frame: Frame) -> pin.SE3:
        """Return a frame's."""
        return frame.placement


@dataclass(frozen=True, slots=True, eq=False)
class Dimensions:
    """The dimensions of a machine as recorded numbers.

    Attributes
    ----------
    joints, frames : mapping of int to Placement
        By Pinocchio's indices: of all joints, and of the frames that loops and tool rest on.
    values : mapping of str to number
        Of the parameters.
    """

    joints: Mapping[int, Placement]
    frames: Mapping[int, Placement]
    values: Mapping[str, Any]

    def of_joint(self, joint: int) -> Placement:
        """Return that of Pinocchio's joint of this index."""
        return self.joints[joint]

    def of_frame(self, frame: Frame) -> Placement:
        """Return a frame's."""
        return self.frames[frame.index]
