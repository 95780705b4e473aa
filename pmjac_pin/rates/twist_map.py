"""TwistMap: the tool's twist by rates that the loops allow, J_eq, whichever rates lead."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pmjac_pin.rates.split import SplitJacobian
from pmjac_pin.values.arrays import Array
from pmjac_pin.values.found_once import found_once


@dataclass(frozen=True, eq=False, repr=False)
class TwistMap(SplitJacobian):
    """The map from the rates u of the motors that lead to the tool twist.

    Attributes
    ----------
    passive_rates : ndarray, shape (m_p, k)
        Φ with φ̇ = Φ u.
    J_eq : ndarray, shape (6, k)
        The tool twist for each unit rate, linear rows first, in `frame`.
    """

    passive_rates: Array
    J_eq: Array

    @property
    def Jv_eq(self) -> Array:
        """Linear rows of J_eq, shape (3, k): m/s per unit rate of a motor that leads."""
        return self.J_eq[:3]

    @property
    def Jw_eq(self) -> Array:
        """Angular rows of J_eq, shape (3, k): rad/s per unit rate of a motor that leads."""
        return self.J_eq[3:]

    @found_once
    def motion_map(self) -> Array:
        """G with q̇ = G u, shape (nv, k): J_eq = J G and the constraint Jacobian times G is 0."""
        return self._motions(self._of_all_motors(), self.passive_rates)

    @found_once
    def sizes(self) -> Array:
        """What the entries of J_eq are compared with, linear and angular, shape (2,).

        ‖J‖ ‖G‖ for J_eq = J G: of that, rounding leaves some 1e-16 where J_eq should be zero.
        """
        return self._sizes_of_motions(self.motion_map)

    def _of_all_motors(self) -> Array:
        """Return the rates of all motors, shape (n, k), by u: here each of them leads."""
        return np.eye(self.partition.actuated.size)
