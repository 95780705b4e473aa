"""For Crocoddyl: the motors of parallel joints as the actuation of a tree without their rods."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pmjac_pin.adapters import importing
from pmjac_pin.adapters.crocoddyl_build import warn_of_other_builds
from pmjac_pin.errors import ArgumentError, unknown_name
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
        joints = [name for names in transmissions for name in names]
        self._at = {name: _entries_of(state.pinocchio, name) for name in [*joints, *direct]}
        if len(self._at) < len(joints) + len(direct):
            raise ArgumentError("a joint is driven twice")
        for names, geared in transmissions.items():
            if len(names) != len(geared.joints):
                raise ArgumentError(f"{geared} has {len(geared.joints)} joints, got {names}")
        driven = [f"{names[0]}/{m}" for names, t in transmissions.items() for m in t.motors]
        self.motors = (*driven, *direct)
        super().__init__(state, len(self.motors))
        warn_of_other_builds()
        self._transmissions, self._direct = dict(transmissions), tuple(direct)

    def calc(self, data: Any, x: Array, u: Array) -> None:
        """Find τ."""
        data.tau = self._map(x) @ u

    def calcDiff(self, data: Any, x: Array, u: Array) -> None:
        """Find ∂τ/∂u and ∂τ/∂x."""
        data.dtau_du, by_x = self._map(x), np.zeros((self.state.nv, self.state.ndx))
        for geared, rows, columns in self._geared(x):
            by_x[np.ix_(rows, rows)] = np.einsum("i,ijk->jk", u[columns], geared.curvature)
        data.dtau_dx = by_x

    def commands(self, data: Any, x: Array, tau: Array) -> None:
        """Find u of τ."""
        data.u = self._inverse(x) @ tau

    def torqueTransform(self, data: Any, x: Array, u: Array) -> None:
        """Find ∂u/∂τ."""
        data.Mtau = self._inverse(x)

    def _inverse(self, x: Array) -> NDArray[np.floating]:
        rows = self._map(x)
        return np.linalg.solve(rows.T @ rows, rows.T)

    def _map(self, x: Array) -> Array:
        found = np.zeros((self.state.nv, self.nu))
        for geared, rows, columns in self._geared(x):
            found[np.ix_(rows, columns)] = geared.ratio.T
        for column, name in enumerate(self._direct, self.nu - len(self._direct)):
            found[self._at[name][1], column] = 1.0
        return found

    def _geared(self, x: Array) -> Iterator[tuple[Geared, list[int], list[int]]]:
        start = 0
        for names, transmission in self._transmissions.items():
            in_q, in_v = zip(*(self._at[name] for name in names), strict=True)
            columns = list(range(start, start := start + len(names)))
            yield transmission.at_joints(x[list(in_q)]), list(in_v), columns


def _entries_of(model: Any, name: str) -> tuple[int, int]:
    """Return where a joint of one degree of freedom is in q and in v."""
    if not model.existJointName(name):
        raise unknown_name("joint", name, list(model.names)[1:])
    joint = model.joints[model.getJointId(name)]
    if (joint.nq, joint.nv) != (1, 1):
        raise ArgumentError(f"joint {name!r} has no single value")
    return joint.idx_q, joint.idx_v
