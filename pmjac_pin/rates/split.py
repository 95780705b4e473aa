"""SplitJacobian: K, K*, J and J*, columns of motors apart from passive ones.

Linear algebra on plain arrays: it imports no Pinocchio and works on matrices from elsewhere.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from pmjac_pin.model.twist_frame import FrameName
from pmjac_pin.rates.error_estimate import JacobianPose
from pmjac_pin.rates.partition import Partition
from pmjac_pin.values.arrays import Array, ReadOnlyArrays, norm, read_only
from pmjac_pin.values.found_once import found_once
from pmjac_pin.values.shown import Tabled


@dataclass(frozen=True, eq=False, repr=False)
class SplitJacobian(ReadOnlyArrays, Tabled):
    """The matrices before the passive rates are eliminated: they exist at singular poses too.

    All arrays are read-only. n motors, m_p passive degrees of freedom, m independent rows of
    the loop equations. `table` has each with names and units; in a notebook they show themselves.

    Attributes
    ----------
    constraint_jacobian : ndarray, shape (p, nv)
        ∂η/∂v on all rows, world axes, Pinocchio's columns.
    tool_jacobian : ndarray, shape (6, nv)
        Of the cut tree, linear rows first, in `frame`, Pinocchio's columns.
    frame : str
        "LOCAL", "WORLD" or "LOCAL_WORLD_ALIGNED", as in Pinocchio.
    partition : Partition
        Which columns are actuated and which passive.
    pose : JacobianPose or None
        The pose that they belong to; None for matrices from elsewhere.
    """

    constraint_jacobian: Array
    tool_jacobian: Array
    frame: FrameName
    partition: Partition
    pose: JacobianPose | None = field(default=None, kw_only=True)

    @found_once
    def rows(self) -> NDArray[np.intp]:
        """Which rows of η are those of K and K*, shape (m,)."""
        scaled = self.partition.scaled(self.constraint_jacobian)
        return read_only(self.partition.shown_rows(scaled))

    @found_once
    def K(self) -> Array:
        """∂η/∂θ on the independent rows, shape (m, n)."""
        return read_only(self.constraint_jacobian[np.ix_(self.rows, self.partition.actuated)])

    @found_once
    def K_star(self) -> Array:
        """∂η/∂φ on the independent rows, shape (m, m_p)."""
        return read_only(self.constraint_jacobian[np.ix_(self.rows, self.partition.passive)])

    @found_once
    def Jv(self) -> Array:
        """Linear rows of J, shape (3, n)."""
        return read_only(self.tool_jacobian[:3, self.partition.actuated])

    @found_once
    def Jv_star(self) -> Array:
        """Linear rows of J*, shape (3, m_p)."""
        return read_only(self.tool_jacobian[:3, self.partition.passive])

    @found_once
    def Jw(self) -> Array:
        """Angular rows of J, shape (3, n)."""
        return read_only(self.tool_jacobian[3:, self.partition.actuated])

    @found_once
    def Jw_star(self) -> Array:
        """Angular rows of J*, shape (3, m_p)."""
        return read_only(self.tool_jacobian[3:, self.partition.passive])

    @property
    def tool_sizes(self) -> Array:
        """What the entries of J and J* are compared with, linear and angular, shape (2,)."""
        tool = self.partition.tool_motion(self.tool_jacobian)
        sizes = np.array([tool.size, tool.angular_size])
        return read_only(sizes / self.partition.column_scale.min(initial=1.0))

    @property
    def det_K_star(self) -> float | None:
        """Determinant of K*, None where K* is not square. It decides nothing."""
        rows, columns = self.K_star.shape
        return float(np.linalg.det(self.K_star)) if rows == columns else None

    def _motions(self, motor_rates: Array, passive_rates: Array) -> Array:
        """Return motions of all joints by columns, shape (nv, k), of motors' and passive ones'."""
        motions = np.zeros((self.tool_jacobian.shape[1], motor_rates.shape[1]))
        motions[self.partition.actuated] = motor_rates
        motions[self.partition.passive] = passive_rates
        return read_only(motions)

    def _sizes_of_motions(self, motion_map: Array) -> Array:
        """Return ‖J‖ ‖G‖, linear and angular, shape (2,), of the entries of J G."""
        tool = self.partition.tool_motion(self.tool_jacobian)
        motions = motion_map / self.partition.column_scale[:, None]
        return read_only(np.array([tool.size, tool.angular_size]) * norm(motions))

    def __repr__(self) -> str:
        return f"SplitJacobian({self._sizes()})"

    def _sizes(self) -> str:
        m, n, m_p = self.rows.size, self.partition.actuated.size, self.partition.passive.size
        return f"K={m}×{n}, K_star={m}×{m_p}, J=6×{n}, J_star=6×{m_p}, frame={self.frame!r}"
