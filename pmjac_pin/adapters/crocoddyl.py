"""For Crocoddyl: the motors of parallel joints as the actuation of a tree without their rods."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from scipy.linalg import block_diag

from pmjac_pin.adapters import importing
from pmjac_pin.adapters.crocoddyl_build import warn_of_other_builds
from pmjac_pin.errors import ArgumentError
from pmjac_pin.model.coordinates import JointCoordinates
from pmjac_pin.studies.transmissions.transmission import Geared, Transmission
from pmjac_pin.values.arrays import Array

with importing("crocoddyl"):
    import crocoddyl


class TransmissionActuation(crocoddyl.ActuationModelAbstract):
    """Motor efforts u as joint efforts, τ = Rᵀ u, with R = ∂θ/∂x at the joints' values.

    Its derivatives are ∂τ/∂u = Rᵀ and ∂τ/∂x = Σᵢ uᵢ ∂²θᵢ/∂x². The rods have no mass here.

    Parameters
    ----------
    state : crocoddyl.StateMultibody
        Of the tree whose joints the robot thinks in.
    transmissions : mapping of tuple of str to Transmission
        By the tree's names of each transmission's joints, which count from the same zeros.
    direct : sequence of str
        Joints with a motor of their own. All others have none.

    Attributes
    ----------
    motors : tuple of str
        The entries of u: each transmission's motors after its first joint's name, then `direct`.

    Raises
    ------
    UnknownNameError, ArgumentError
        No such joint, one of several degrees of freedom, one named twice, too few or too many.
    ClosureError, LimitError, SingularError
        Later, from a solver: as `Transmission.at_joints`, from home.

    Warns
    -----
    RuntimeWarning
        Crocoddyl was built for another Pinocchio: its own dynamics are wrong, as of one without
        gravity.
    """

    def __init__(
        self,
        state: Any,
        transmissions: Mapping[tuple[str, ...], Transmission],
        direct: Sequence[str] = (),
    ) -> None:
        joints = [*(name for names in transmissions for name in names), *direct]
        if len(set(joints)) < len(joints):
            raise ArgumentError("a joint is driven twice")
        for names, geared in transmissions.items():
            if len(names) != len(geared.joints):
                raise ArgumentError(f"{geared} has {len(geared.joints)} joints, got {names}")
        driven = [f"{names[0]}/{m}" for names, t in transmissions.items() for m in t.motors]
        self.motors = (*driven, *direct)
        super().__init__(state, len(self.motors))
        warn_of_other_builds()
        self._coordinates = JointCoordinates(state.pinocchio)
        self._columns = self._coordinates.columns(joints)
        if len(self._columns) > len(joints):
            many = [name for name in joints if self._coordinates.degrees_of_freedom(name) > 1]
            raise ArgumentError(f"joints have no single value: {', '.join(many)}")
        self._driven = np.eye(state.nv)[:, self._columns]  # a joint beside each entry of u
        self._transmissions, self._direct = tuple(transmissions.values()), np.eye(len(direct))
        self._ends = np.cumsum([len(names) for names in transmissions], dtype=np.intp)

    def calc(self, data: Any, x: Array, u: Array) -> None:
        """Find τ."""
        data.tau = self._driven @ self._ratio(x).T @ u

    def calcDiff(self, data: Any, x: Array, u: Array) -> None:
        """Find ∂τ/∂u and ∂τ/∂x."""
        data.dtau_du = self._driven @ self._ratio(x).T
        exerted = zip(np.split(u, self._ends), self._geared(x), strict=False)
        bent = [np.einsum("i,ijk->jk", efforts, each.curvature) for efforts, each in exerted]
        by_q = self._driven @ block_diag(*bent, np.zeros_like(self._direct)) @ self._driven.T
        data.dtau_dx = np.hstack([by_q, np.zeros_like(by_q)])

    def commands(self, data: Any, x: Array, tau: Array) -> None:
        """Find u of τ."""
        data.u = np.linalg.solve(self._ratio(x).T, self._driven.T @ tau)

    def torqueTransform(self, data: Any, x: Array, u: Array) -> None:
        """Find ∂u/∂τ."""
        data.Mtau = np.linalg.solve(self._ratio(x).T, self._driven.T)

    def _ratio(self, x: Array) -> Array:
        """Return R of all motors."""
        ratio: Array = block_diag(*(each.ratio for each in self._geared(x)), self._direct)
        return ratio

    def _geared(self, x: Array) -> list[Geared]:
        values = self._coordinates.values_of(x[: self.state.nq], self._columns)
        each = zip(self._transmissions, np.split(values, self._ends), strict=False)
        return [transmission.at_joints(own) for transmission, own in each]
