"""The transmission of a parallel joint: between motors and the joints that a robot thinks in.

An ankle's rods lead two motors to its pitch and roll. With θ(x) the motors at joint values x and
R = ∂θ/∂x there,

    θ̇ = R ẋ,   τ_x = Rᵀ τ,   K_x = Rᵀ K R − Σᵢ τᵢ ∂²θᵢ/∂x²,   D_x = Rᵀ D R,   I_x = Rᵀ I R.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from pmjac_pin.configuration import Configuration
from pmjac_pin.direct_kinematics import Guess
from pmjac_pin.errors import ArgumentError
from pmjac_pin.mechanism import Mechanism
from pmjac_pin.rates.jacobian import EquivalentJacobian
from pmjac_pin.rates.polytope import Polytope, image_of_box
from pmjac_pin.values.arrays import Array, Index, read_only
from pmjac_pin.values.brief import with_names
from pmjac_pin.values.checks import as_limits, as_numbers, as_vector, check_kind

_PART_OF_IDLE = 1e-9  # of an idle motion: a motor that moves more takes part in it


@dataclass(frozen=True, eq=False, repr=False)
class Transmission:
    """The map between the motors of a mechanism and other joints of it, at any pose.

    Made by `pmjac_pin.transmission`.

    Attributes
    ----------
    by_motors, by_joints : Mechanism
        The machine as its motors drive it, and as these joints would.
    """

    by_motors: Mechanism
    by_joints: Mechanism

    @property
    def motors(self) -> tuple[str, ...]:
        """Names of the n motors."""
        return self.by_motors.actuated

    @property
    def joints(self) -> tuple[str, ...]:
        """Names of the n joints."""
        return self.by_joints.actuated

    def at_joints(self, values: ArrayLike | Mapping[str, float], guess: Guess = "home") -> Geared:
        """Return the transmission at joint values: inverse kinematics, as `Mechanism.close` walks.

        Raises
        ------
        ClosureError, LimitError, UnknownNameError, ArgumentError
            As `Mechanism.close`.
        SingularError, ArgumentError
            The joints do not determine the motors: there, or anywhere.
        """
        return Geared(self, self.by_joints.close(values, guess))

    def at_motors(self, values: ArrayLike | Mapping[str, float], guess: Guess = "home") -> Geared:
        """Return the transmission at motor values: direct kinematics, as `Mechanism.close` walks.

        Raises
        ------
        ClosureError, LimitError, UnknownNameError, ArgumentError, SingularError
            As `at_joints`.
        """
        return self.at(self.by_motors.close(values, guess))

    def at(self, configuration: Configuration) -> Geared:
        """Return the transmission at a pose of either mechanism."""
        check_kind(configuration, Configuration)
        return Geared(self, self.by_joints.configuration(configuration.q))

    def __repr__(self) -> str:
        return f"Transmission({', '.join(self.motors)} ↔ {', '.join(self.joints)})"


@dataclass(frozen=True, eq=False, repr=False)
class Geared:
    """A transmission at one pose. All arrays are read-only.

    Attributes
    ----------
    transmission : Transmission
    configuration : Configuration
        Of `transmission.by_joints`.
    """

    transmission: Transmission
    configuration: Configuration

    @property
    def joints(self) -> Array:
        """x, shape (n,), m or rad."""
        return self.configuration.actuated

    @property
    def motors(self) -> Array:
        """θ, shape (n,), m or rad."""
        whole = self.transmission.by_motors
        values = whole.coordinates.values(self.configuration.q)
        return read_only(values[whole.problem.partition.actuated])

    @cached_property
    def ratio(self) -> Array:
        """R = ∂θ/∂x, shape (n, n): motor rates by joint rates."""
        return read_only(self._jacobian.motion_map[self._columns])

    @cached_property
    def curvature(self) -> Array:
        """∂R/∂x = ∂²θ/∂x², shape (n, n, n), the last axis along which joint."""
        partition, found = self._jacobian.partition, self._jacobian.passive_hessian
        whole = np.zeros((self._jacobian.motion_map.shape[0], *found.shape[1:]))
        whole[partition.passive] = found
        return read_only(whole[self._columns])

    def motor_rates(self, joint_rates: ArrayLike) -> Array:
        """Return θ̇ = R ẋ."""
        return read_only(self.ratio @ self._vector(joint_rates, "joint rates"))

    def joint_rates(self, motor_rates: ArrayLike) -> Array:
        """Return ẋ = R⁻¹ θ̇; R has an inverse where the motors determine the joints."""
        return read_only(self._inverse @ self._vector(motor_rates, "motor rates"))

    def joint_efforts(self, motor_efforts: ArrayLike) -> Array:
        """Return τ_x = Rᵀ τ, N m or N."""
        return read_only(self.ratio.T @ self._vector(motor_efforts, "motor efforts"))

    def motor_efforts(self, joint_efforts: ArrayLike) -> Array:
        """Return τ = R⁻ᵀ τ_x."""
        return read_only(self._inverse.T @ self._vector(joint_efforts, "joint efforts"))

    def stiffness(
        self, motor_stiffness: ArrayLike, motor_efforts: ArrayLike | None = None
    ) -> Array:
        """Return K_x = −∂τ_x/∂x = Rᵀ K R − Σᵢ τᵢ ∂²θᵢ/∂x², shape (n, n).

        The position gains of motors as the joints feel them: motors that exert τ − K δθ.

        Parameters
        ----------
        motor_stiffness : array_like, shape (n,) or (n, n)
            K, N/m or N m/rad.
        motor_efforts : array_like, shape (n,), optional
            τ that the motors exert here; none when None.
        """
        own = self.ratio.T @ self._matrix(motor_stiffness, "motor stiffness") @ self.ratio
        if motor_efforts is None:
            return read_only(own)
        exerted = self._vector(motor_efforts, "motor efforts")
        return read_only(own - np.einsum("i,ijk->jk", exerted, self.curvature))

    def damping(self, motor_damping: ArrayLike) -> Array:
        """Return D_x = Rᵀ D R, shape (n, n)."""
        return read_only(self.ratio.T @ self._matrix(motor_damping, "motor damping") @ self.ratio)

    def armature(self, motor_armature: ArrayLike) -> Array:
        """Return I_x = Rᵀ I R, shape (n, n): no single number for each joint describes it."""
        return read_only(self.ratio.T @ self._matrix(motor_armature, "motor armature") @ self.ratio)

    def effort_limits(self, motor_limits: ArrayLike) -> Polytope:
        """Return the joint efforts that |τᵢ| ≤ limit reach: of two joints a rhombus, no box."""
        limits = self._limits(motor_limits)
        return image_of_box(self.ratio.T, limits, "joint effort")

    def rate_limits(self, motor_limits: ArrayLike) -> Polytope:
        """Return the joint rates that |θ̇ᵢ| ≤ limit reach."""
        limits = self._limits(motor_limits)
        return image_of_box(self._inverse, limits, "joint rate")

    @cached_property
    def _jacobian(self) -> EquivalentJacobian:
        found = self.configuration.jacobian()
        idling = found.idle_map / found.partition.column_scale[:, None]
        moving = (np.abs(idling[self._columns]) > _PART_OF_IDLE).any(axis=1)
        if idle := [self.transmission.motors[k] for k in np.flatnonzero(moving).tolist()]:
            raise ArgumentError(f"the joints do not determine what idles: {', '.join(idle)}")
        return found

    @property
    def _columns(self) -> Index:
        return self.transmission.by_motors.problem.partition.actuated

    @cached_property
    def _inverse(self) -> Array:
        # Says so where the motors do not determine the joints.
        by_motors = self.transmission.by_motors.configuration(self.configuration.q).jacobian()
        joints = self._jacobian.partition.actuated
        return np.asarray(by_motors.motion_map[joints])

    def _vector(self, given: ArrayLike, what: str) -> Array:
        return as_vector(given, len(self.transmission.motors), what)

    def _limits(self, given: ArrayLike) -> Array:
        return as_limits(given, len(self.transmission.motors))

    def _matrix(self, given: ArrayLike, what: str) -> Array:
        return motor_matrix(given, len(self.transmission.motors), what)

    def __repr__(self) -> str:
        return f"Geared({with_names(self.transmission.joints, self.joints)})"


def motor_matrix(given: ArrayLike, count: int, what: str) -> Array:
    """Return a matrix (n, n) over the motors, or one of what each motor has for itself (n,)."""
    values = as_numbers(given, what)
    return values if values.shape == (count, count) else np.diag(as_vector(given, count, what))


def transmission(mechanism: Mechanism, joints: Iterable[str]) -> Transmission:
    """Return the map between a mechanism's motors and other joints that determine its pose as well.

    Parameters
    ----------
    mechanism : Mechanism
    joints : iterable of str
        As many as there are motors, each of one degree of freedom.

    Raises
    ------
    UnknownNameError, ArgumentError
        No such joints, or another number of them.

    Examples
    --------
    >>> import pmjac_pin as pj
    >>> rocker = pj.transmission(pj.load("four_bar"), ["phi1"])
    >>> rocker
    Transmission(theta1 ↔ phi1)
    >>> geared = rocker.at_motors([1.0])
    >>> geared.motor_rates(geared.joint_rates([2.0])).round(9).tolist()
    [2.0]
    """
    check_kind(mechanism, Mechanism)
    driven = mechanism.driven_by(joints)
    if len(driven.actuated) != len(mechanism.actuated):
        wanted = f"as many joints as motors, {len(mechanism.actuated)}"
        raise ArgumentError(f"{wanted}, got {len(driven.actuated)}")
    return Transmission(mechanism, driven)
