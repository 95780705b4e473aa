"""Parts: what a Mechanism is made of."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Self

import pinocchio as pin

from pmjac_pin.algebra.one_thread import one_thread_from
from pmjac_pin.closing.closure_problem import ClosureProblem
from pmjac_pin.closing.generic_ranks import ranked
from pmjac_pin.files.urdf.robot import Urdf
from pmjac_pin.kinematics.pinocchio import Kinematics
from pmjac_pin.model.coordinates import JointCoordinates
from pmjac_pin.model.spec import MechanismSpec
from pmjac_pin.values.arrays import Array
from pmjac_pin.values.found_once import found_once


@dataclass(frozen=True, eq=False)
class Parts:
    """What a Mechanism is made of, its home pose as it is given; nothing of it ever changes.

    Attributes
    ----------
    model : pin.Model
        What everything is computed with: the machine beside the origin, less `place`.
    split : ClosureProblem
        The loop equations and how their columns are split, no ranks known.
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
    split: ClosureProblem
    home_q: Array
    urdf: Urdf | None
    standing: pin.Model
    place: Array

    @found_once
    def problem(self) -> ClosureProblem:
        """The closure problem, with what is known of its ranks: nothing where home is open."""
        return self.split


@dataclass(frozen=True, eq=False)
class PartsAtHome(Parts):
    """The same where the loops of the home pose are closed."""

    @found_once
    def problem(self) -> ClosureProblem:
        """The closure problem with its generic ranks, found when they are first asked for."""
        with one_thread_from(self.model.nv):
            return ranked(self.split, self.kinematics, self.home_q)

    def with_problem(self, problem: ClosureProblem) -> Self:
        """Return the parts with ranks that are known: of another branch, or found elsewhere."""
        parts = replace(self)
        parts.__dict__["problem"] = problem
        return parts
