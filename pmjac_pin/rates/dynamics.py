"""Dynamics: the equations of motion in motor coordinates, M θ̈ + h = τ + J_eqᵀ w.

With v = G θ̇ and the tree's own M_t v̇ + h_t = τ_t + Jᵀ w + Cᵀ λ, the loops' forces λ do no work on
what the loops allow, C G = 0: M = Gᵀ M_t G and h = Gᵀ (M_t Ġ θ̇ + h_t). What idles, v = G θ̇ + N ψ̇,
is driven by nobody: it is at the smallest rates that J_eq takes, ψ̇ = 0, and accelerates as the
forces will have it, which M and h then allow for. Springs in joints are part of h_t where they are
given; friction and damping are not. Linear algebra on arrays.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from pmjac_pin.errors import NoInertiaError
from pmjac_pin.rates.factorisation import factorise
from pmjac_pin.rates.motion import Motion
from pmjac_pin.rates.partition import Partition
from pmjac_pin.values.arrays import Array, ReadOnlyArrays, read_only
from pmjac_pin.values.checks import as_vector

_NO_INERTIA = 1e-12  # of the largest, on motions of like size: rounding
_ROUNDED_IDLE_RATES = 1e-9  # of rates: what rounding may leave of those that an idle motion has not
_ROUNDED_FORCES = 1e-9  # of the forces that add up to one on an idle motion


@dataclass(frozen=True, eq=False, repr=False)
class Dynamics(ReadOnlyArrays):
    """The equations of motion at one pose and velocity, in the motors' coordinates.

    Made by `Configuration.dynamics`. All arrays are read-only; efforts are in N or N m.

    Attributes
    ----------
    motion : Motion
        At these rates, the motors not accelerated, in LOCAL_WORLD_ALIGNED: so a wrench is a force
        in N and a moment in N m about the tool's origin, in world axes.
    mass_matrix : ndarray, shape (n, n)
        M = Gᵀ M_t G where nothing idles, symmetric and positive definite.
    gravity : ndarray, shape (n,)
        Gᵀ g: the efforts that hold the machine's own weight, where nothing idles.
    bias : ndarray, shape (n,)
        h = Gᵀ (M_t Ġ θ̇ + h_t): gravity, given springs, and what the rates alone ask for.
    kinetic_energy : float
        ½ vᵀ M_t v of v = G θ̇, J.

    Examples
    --------
    >>> import pmjac_pin as pj
    >>> dynamics = pj.load("ur5").home.dynamics()
    >>> dynamics.mass_matrix.shape
    (6, 6)
    >>> accelerations = dynamics.accelerations(dynamics.gravity)  # held against its weight
    >>> bool(abs(accelerations).max() < 1e-12)
    True
    """

    motion: Motion
    mass_matrix: Array
    gravity: Array
    bias: Array
    kinetic_energy: float

    @property
    def rates(self) -> Array:
        """θ̇, shape (n,), m/s or rad/s."""
        return self.motion.rates

    def efforts(self, accelerations: ArrayLike, wrench: ArrayLike | None = None) -> Array:
        """Return the motor efforts that accelerate so: τ = M θ̈ + h − J_eqᵀ w (inverse dynamics).

        Parameters
        ----------
        accelerations : array_like, shape (n,)
            m/s² or rad/s².
        wrench : array_like, shape (6,), optional
            That acts on the tool.
        """
        given = as_vector(accelerations, self.rates.size, "motor accelerations")
        return read_only(self.mass_matrix @ given + self.bias - self._of_wrench(wrench))

    def accelerations(self, efforts: ArrayLike, wrench: ArrayLike | None = None) -> Array:
        """Return θ̈ = M⁻¹ (τ − h + J_eqᵀ w) under motor efforts (forward dynamics).

        Parameters
        ----------
        efforts : array_like, shape (n,)
            N or N m.
        wrench : array_like, shape (6,), optional
            That acts on the tool.
        """
        given = as_vector(efforts, self.rates.size, "motor efforts")
        driving = given - self.bias + self._of_wrench(wrench)
        return read_only(np.asarray(np.linalg.solve(self.mass_matrix, driving), dtype=np.float64))

    def _of_wrench(self, wrench: ArrayLike | None) -> Array:
        if wrench is None:
            return np.zeros(self.rates.size)
        return np.asarray(self.motion.jacobian.J_eq.T @ as_vector(wrench, 6, "a wrench"))

    def __repr__(self) -> str:
        return f"Dynamics({self.rates.size} motors)"


def without_idle(
    mass: Array, forces: Array, driven: Array, idle: Array, partition: Partition
) -> tuple[Array, Array]:
    """Return mass matrix (n, n) and forces (n, k) of what is driven, idle motions eliminated.

    Idle ones accelerate so that nothing drives them: with G and N the driven and the idle motions,
    M₁₁ = Gᵀ M_t G, M₁₂ = Gᵀ M_t N, and so on, M = M₁₁ − M₁₂ M₂₂⁻¹ M₂₁ and h = h₁ − M₁₂ M₂₂⁻¹ h₂.

    Parameters
    ----------
    mass : ndarray, shape (nv, nv)
        Of the cut tree.
    forces : ndarray, shape (nv, k)
        On the joints of the cut tree.
    driven : ndarray, shape (nv, n)
        G.
    idle : ndarray, shape (nv, i)
        N, orthonormal on dimensionless rates.
    partition : Partition

    Raises
    ------
    NoInertiaError
        A force on an idle motion that moves no mass.
    """
    n, ways = driven.shape[1], np.hstack([driven, idle])
    scale = np.concatenate([partition.motor_scale, np.ones(idle.shape[1])])
    unit = ways.T @ mass @ ways * np.outer(scale, scale)
    pushed = ways.T @ forces * scale[:, None]
    values, vectors = np.linalg.eigh(unit[n:, n:])
    heavy = values > least_inertia(mass, idle, partition.column_scale)
    inverse = (vectors[:, heavy] / values[heavy]) @ vectors[:, heavy].T
    held = np.abs(pushed[n:] - unit[n:, n:] @ inverse @ pushed[n:])
    sizes = np.abs(ways).T @ np.abs(forces) * scale[:, None]  # of what the forces are sums of
    if (held > _ROUNDED_FORCES * sizes.max(axis=0)).any():
        raise NoInertiaError("forces act on idle motions that move no mass: add inertia")
    across = unit[:n, n:] @ inverse
    eliminated = (unit[:n, :n] - across @ unit[n:, :n]) / np.outer(scale[:n], scale[:n])
    return eliminated, (pushed[:n] - across @ pushed[n:]) / scale[:n, None]


def least_inertia(mass: Array, idle: Array, scale: Array) -> float:
    """Return the inertia of idle motions that is none, but rounding of masses and of motions.

    Rates that an idle motion does not have are left at some ε by rounding, and ε² of the machine's
    inertia with them: taken for an inertia, it would be as mighty as any, since M₁₂ M₂₂⁻¹ M₂₁ is
    of the size of ε m ⋅ ε m / ε² m.

    Parameters
    ----------
    mass : ndarray, shape (nv, nv)
        Of the cut tree.
    idle : ndarray, shape (nv, i)
        Idle motions, orthonormal on dimensionless rates.
    scale : ndarray, shape (nv,)
        Natural rates.
    """
    sizes, rates = np.abs(mass) * np.outer(scale, scale), np.abs(idle / scale[:, None])
    own = float((rates.T @ sizes @ rates).max(initial=0.0))
    return max(_NO_INERTIA * own, _ROUNDED_IDLE_RATES**2 * float(np.linalg.norm(sizes)))


def check_inertia(mass_matrix: Array, scale: Array, massless: Callable[[], Sequence[str]]) -> None:
    """Raise where some motion moves no mass.

    Parameters
    ----------
    mass_matrix : ndarray, shape (n, n)
        Of motions that the loops allow: of the motors, or of all.
    scale : ndarray, shape (n,)
        Their natural rates.
    massless : callable
        () ↦ the bodies that have no mass, for the message.
    """
    values = np.linalg.eigvalsh(mass_matrix * scale * scale[:, None])
    if values.size and not values[0] > _NO_INERTIA * max(values[-1], 0.0):
        names = massless()
        listed = ", ".join(names[:6]) + ", ..." * (len(names) > 6)
        without = f": bodies without one are {listed}" if names else ""
        raise NoInertiaError(
            f"some motion that loops allow moves no mass{without}; add inertia, or use statics"
        )


def check_inertia_of_tree(
    mass: Array, equations: Array, scale: Array, massless: Callable[[], Sequence[str]]
) -> None:
    """Raise where some motion moves no mass, idle ones included.

    Parameters
    ----------
    mass : ndarray, shape (nv, nv)
        Of the cut tree.
    equations : ndarray, shape (r, nv)
        Independent ones of the loops: what they let pass is allowed.
    scale : ndarray, shape (nv,)
        Natural rates.
    massless : callable
        As for `check_inertia`.
    """
    allowed = scale[:, None] * factorise(equations * scale, 0.0).null_space
    check_inertia(allowed.T @ mass @ allowed, np.ones(allowed.shape[1]), massless)
