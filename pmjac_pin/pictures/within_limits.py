"""What a tool can do within the limits of each motor: the polytope, and the ellipsoid in it.

In units of its limit every motor's rate or effort is within ±1, a box; together of length 1 they
fill a ball in that box. So the ellipsoid is inscribed in the polytope, whatever units motors have.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from pmjac_pin.configuration import Configuration
from pmjac_pin.errors import ArgumentError, enumerated, quoted
from pmjac_pin.rates.ellipsoid import Ellipsoid, velocity_ellipsoid
from pmjac_pin.rates.jacobian import EquivalentJacobian
from pmjac_pin.rates.solid import Solid, directions_of, force_solid, velocity_solid
from pmjac_pin.values.arrays import Array
from pmjac_pin.values.checks import as_limits
from pmjac_pin.words.motor_limits import motor_effort_limits, motor_rate_limits

GivenLimits: TypeAlias = ArrayLike | Literal["model"]
Quantity: TypeAlias = Literal["linear", "angular", "force"]


@dataclass(frozen=True, eq=False)
class WithinLimits:
    """A polytope and the ellipsoid that is inscribed in it."""

    solid: Solid
    ellipsoid: Ellipsoid


def solid_within(
    configuration: Configuration,
    jacobian: EquivalentJacobian,
    quantity: Quantity,
    limits: GivenLimits,
) -> Solid:
    """Return the polytope alone; parameters and errors as of `within_limits`."""
    bounds = _checked_limits(configuration, quantity, limits)
    block, moves = _block(jacobian, quantity)
    make = force_solid if quantity == "force" else velocity_solid
    return make(block, moves, bounds)


def within_limits(
    configuration: Configuration,
    jacobian: EquivalentJacobian,
    quantity: Quantity,
    limits: GivenLimits,
) -> WithinLimits:
    """Return what the tool does within limits, in the frame of `jacobian`.

    Parameters
    ----------
    configuration : Configuration
    jacobian : EquivalentJacobian
        There.
    quantity : {"linear", "angular", "force"}
        Of a force those components along which the tool moves: the structure bears the others.
    limits : array_like, shape (n,), or "model"
        Of motor rates, m/s or rad/s, or of efforts, N or N m; or those that the model states.

    Raises
    ------
    ArgumentError
        Limits that are none, or that the model does not state; a tool that does not move so.
    """
    solid = solid_within(configuration, jacobian, quantity, limits)
    bounds = _checked_limits(configuration, quantity, limits)
    block, moves = _block(jacobian, quantity)
    if quantity == "force":
        return WithinLimits(solid, _held(block, moves, bounds))
    return WithinLimits(solid, velocity_ellipsoid(_flat(block, moves) * bounds, moves.unit))


def _block(jacobian: EquivalentJacobian, quantity: Quantity) -> tuple[Array, Ellipsoid]:
    """Return rows of J_eq and the ellipsoid of their motions."""
    if quantity == "angular":
        return jacobian.Jw_eq, jacobian.angular_ellipsoid()
    return jacobian.Jv_eq, jacobian.velocity_ellipsoid()


def _flat(block: Array, moves: Ellipsoid) -> Array:
    """Return the rows of J_eq less what is rounding across the directions of motion."""
    span = directions_of(moves)
    return np.asarray(span @ (span.T @ block))


def _held(block: Array, moves: Ellipsoid, bounds: Array) -> Ellipsoid:
    """Return the polar within the directions of motion: flat where the tool does not move."""
    found, rank = velocity_ellipsoid(_flat(block, moves) / bounds), moves.rank
    order = [*range(rank - 1, -1, -1), *range(rank, 3)]
    radii = np.append(1.0 / found.radii[:rank][::-1], np.zeros(3 - rank))
    axes = found.axes[:, order].copy()
    axes[:, 0] *= np.sign(np.linalg.det(axes))
    return Ellipsoid(radii, axes, "N")


def _checked_limits(configuration: Configuration, quantity: Quantity, given: GivenLimits) -> Array:
    mechanism = configuration.mechanism
    if not isinstance(given, str):
        return as_limits(given, len(mechanism.actuated))
    if given != "model":
        raise ArgumentError(f"motor limits are numbers or 'model', got {quoted(given)}")
    force = quantity == "force"
    found = motor_effort_limits(mechanism) if force else motor_rate_limits(mechanism)
    if missing := [mechanism.actuated[k] for k in np.flatnonzero(np.isinf(found))]:
        what = "effort" if force else "rate"
        raise ArgumentError(f"the model states no {what} limit of {enumerated(missing)}")
    return found
