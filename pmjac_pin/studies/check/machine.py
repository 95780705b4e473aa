"""Machine: what a check knows of a mechanism, whether its home pose assembles or not."""

from __future__ import annotations

from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from pmjac_pin.closing.closure_problem import ClosureProblem
from pmjac_pin.kinematics.pinocchio import Kinematics
from pmjac_pin.model.coordinates import JointCoordinates
from pmjac_pin.model.spec import MechanismSpec


class CheckedMachine(Protocol):
    """A Mechanism, or what `unassembled` makes of the same model and spec."""

    @property
    def spec(self) -> MechanismSpec:
        """What the model file says."""

    @property
    def coordinates(self) -> JointCoordinates:
        """The joints' values in q."""

    @property
    def kinematics(self) -> Kinematics:
        """The tree, its loops and its tool."""

    @property
    def problem(self) -> ClosureProblem:
        """The closure problem."""

    @property
    def place(self) -> NDArray[np.float64]:
        """Where it stands, shape (3,), m."""
