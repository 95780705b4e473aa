"""Motion: all that follows from motor rates and accelerations at one pose."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pmjac_pin.rates.jacobian import EquivalentJacobian
from pmjac_pin.rates.second_order import following_rates
from pmjac_pin.values.arrays import Array, ReadOnlyArrays, read_only
from pmjac_pin.values.found_once import found_once


@dataclass(frozen=True, eq=False, repr=False)
class Motion(ReadOnlyArrays):
    """Rates and accelerations of motors, passive joints and tool, the loops staying closed.

    Made by `Configuration.motion`. All arrays are read-only.

    Attributes
    ----------
    jacobian : EquivalentJacobian
        At the pose; its `frame` is that of twist and acceleration.
    rates, accelerations : ndarray, shape (n,)
        θ̇ and θ̈ of the motors, m/s or rad/s, and m/s² or rad/s².

    Examples
    --------
    >>> import pmjac_pin as pj
    >>> motion = pj.load("four_bar").close([1.0]).motion([2.0], [0.5])
    >>> motion.twist.shape, motion.passive_accelerations.shape
    ((6,), (2,))
    """

    jacobian: EquivalentJacobian
    rates: Array
    accelerations: Array

    def known(self, motion_map: Array, bias: Array, drift: Array) -> Motion:
        """Return the same, knowing what was found elsewhere, read-only, where nothing idles."""
        nothing = np.empty((len(motion_map), 0))
        self.__dict__.update(ways=(motion_map, nothing), bias=bias, drift=drift)
        return self

    @found_once
    def ways(self) -> tuple[Array, Array]:
        """G (nv, n) and N (nv, i): what the motors drive, and what idles."""
        return self.jacobian.motion_map, self.jacobian.idle_map

    @found_once
    def v(self) -> Array:
        """Pinocchio's velocity G θ̇, shape (nv,)."""
        return read_only(self.ways[0] @ self.rates)

    @found_once
    def a(self) -> Array:
        """Pinocchio's acceleration G θ̈ + Ġ θ̇, shape (nv,)."""
        return read_only(self.ways[0] @ self.accelerations + self.bias)

    @found_once
    def bias(self) -> Array:
        """Ġ θ̇, shape (nv,): what the rates alone accelerate. −K*⁺ γ, and 0 of motors.

        Of what idles any acceleration keeps the loops closed: this is the smallest.
        """
        partition, (constraint, _) = self.jacobian.partition, self._slopes
        loops = self.jacobian._loops
        bias = np.zeros(self.v.shape)
        opening = (constraint @ self.v)[:, None]  # γ = K̇ θ̇ + K̇* φ̇
        bias[partition.passive] = following_rates(opening, loops, partition)[:, 0]
        return read_only(bias)

    @property
    def passive_rates(self) -> Array:
        """φ̇ = −K*⁻¹ K θ̇, shape (m_p,)."""
        return read_only(self.v[self.jacobian.partition.passive])

    @property
    def passive_accelerations(self) -> Array:
        """φ̈ = −K*⁻¹ (K θ̈ + γ), shape (m_p,), with γ = K̇ θ̇ + K̇* φ̇."""
        return read_only(self.a[self.jacobian.partition.passive])

    @property
    def twist(self) -> Array:
        """J_eq θ̇, shape (6,): the tool's velocity and angular velocity in `jacobian.frame`."""
        return read_only(self.jacobian.J_eq @ self.rates)

    @found_once
    def acceleration(self) -> Array:
        """J_eq θ̈ + J̇_eq θ̇, shape (6,): how the components of `twist` change.

        In LOCAL_WORLD_ALIGNED the acceleration of the tool's origin and its angular acceleration.
        """
        return read_only(self.jacobian.J_eq @ self.accelerations + self.drift)

    @found_once
    def drift(self) -> Array:
        """J̇_eq θ̇, shape (6,): what the rates alone do to `twist`."""
        _, tool = self._slopes
        return read_only(self.jacobian.tool_jacobian @ self.bias + tool @ self.v)

    @found_once
    def _slopes(self) -> tuple[Array, Array]:
        constraint, tool = self.jacobian.slopes(self.v[:, None])
        return constraint[0], tool[0]

    def __repr__(self) -> str:
        return f"Motion({self.rates.size} motors, {self.jacobian.partition.passive.size} passive)"
