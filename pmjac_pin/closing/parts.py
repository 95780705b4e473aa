"""Parts: what a Mechanism is made of."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import pinocchio as pin

from pmjac_pin.closing.closure_problem import ClosureProblem
from pmjac_pin.files.urdf.robot import Urdf
from pmjac_pin.kinematics.pinocchio import Kinematics
from pmjac_pin.model.coordinates import JointCoordinates
from pmjac_pin.model.spec import MechanismSpec
from pmjac_pin.values.arrays import Array


@dataclass(frozen=True, slots=True, eq=False)
class Parts:
    """What a Mechanism is made of; nothing of it ever changes.

    Attributes
    ----------
    model : pin.Model
        What everything is computed with: the machine beside the origin, less `place`.
    urdf : Urdf or None
        What the model was built of, the parameters' moves included, kept for its visuals; None
        where there was only a Pinocchio model.
    standing : pin.Model
        The model as it was given, where the machine stands in the world.
    place : ndarray, shape (3,)
        Where that is, m: 0 but for a machine far from the world's origin, whose coordinates
        would leave few digits for what moves.
    """

    model: pin.Model
    spec: MechanismSpec
    values: Mapping[str, float]
    coordinates: JointCoordinates
    kinematics: Kinematics
    problem: ClosureProblem
    home_q: Array
    urdf: Urdf | None
    standing: pin.Model
    place: Array
