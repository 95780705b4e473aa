"""What a tool can do within the limits of each motor: the polytope, and the ellipsoid in it.

In units of its limit every motor's rate or effort is within ±1, a box; together of length 1 they
fill a ball in that box. So the ellipsoid is inscribed in the polytope, whatever units motors have.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Literal, TypeAlias, assert_never

import numpy as np

from pmjac_pin.rates.ellipsoid import Ellipsoid
from pmjac_pin.rates.jacobian import EquivalentJacobian
from pmjac_pin.rates.motor_limits import Limits, effort_limits, rate_limits
from pmjac_pin.rates.solid import Solid, force_solid, velocity_solid

ToolQuantity: TypeAlias = Literal["linear", "angular", "force"]


def ellipsoid_of(
    jacobian: EquivalentJacobian, quantity: ToolQuantity, limits: Limits | None = None
) -> Ellipsoid:
    """Return the ellipsoid of a quantity, in shares of limits where these are given."""
    match quantity:
        case "linear":
            return jacobian.velocity_ellipsoid(limits)
        case "angular":
            return jacobian.angular_ellipsoid(limits)
        case "force":
            return jacobian.force_ellipsoid(limits)
        case _:
            assert_never(quantity)


def within_limits(
    jacobian: EquivalentJacobian, quantity: ToolQuantity, limits: Limits
) -> tuple[Solid, Ellipsoid]:
    """Return what the tool does within limits, in the frame of `jacobian`, and the ellipsoid in it.

    Parameters
    ----------
    jacobian : EquivalentJacobian
    quantity : {"linear", "angular", "force"}
        Of a force those components along which the tool moves: the structure bears the others.
    limits : array_like, shape (n,), or "model"
        Of motor rates, m/s or rad/s, or of efforts, N or N m; or those that the model states.

    Raises
    ------
    ArgumentError
        Limits that are none, or that the model does not state; a tool that does not move so.
    """
    solid = solid_within(jacobian, quantity, limits)
    return solid, where_it_moves(ellipsoid_of(jacobian, quantity, limits))


def solid_within(jacobian: EquivalentJacobian, quantity: ToolQuantity, limits: Limits) -> Solid:
    """Return the polytope alone; parameters and errors as of `within_limits`."""
    linear = jacobian.Jv_eq, jacobian.velocity_ellipsoid()
    match quantity:
        case "linear":
            return velocity_solid(*linear, rate_limits(limits, jacobian.partition))
        case "angular":
            angular = jacobian.Jw_eq, jacobian.angular_ellipsoid()
            return velocity_solid(*angular, rate_limits(limits, jacobian.partition))
        case "force":
            return force_solid(*linear, effort_limits(limits, jacobian.partition))


def where_it_moves(ellipsoid: Ellipsoid) -> Ellipsoid:
    """Return an ellipsoid without the directions in which it has no bound: flat across them."""
    unbounded = int(np.isinf(ellipsoid.radii).sum())
    radii = np.append(ellipsoid.radii[unbounded:], np.zeros(unbounded))
    return replace(ellipsoid, radii=radii, axes=np.roll(ellipsoid.axes, -unbounded, axis=1))
