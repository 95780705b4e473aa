"""What a tool reaches by its motors: ellipsoids, and polytopes within limits."""

from __future__ import annotations

from collections.abc import Iterable

from pmjac_pin.errors import ArgumentError
from pmjac_pin.model.tool_rows import TWIST_ROWS, checked_rows
from pmjac_pin.rates.ellipsoid import Ellipsoid, force_ellipsoid, velocity_ellipsoid
from pmjac_pin.rates.motor_limits import (
    SHARES,
    Limits,
    effort_limits,
    efforts_unit,
    rate_limits,
    rates_unit,
)
from pmjac_pin.rates.polytope import Polytope, image_of_box, within_box
from pmjac_pin.rates.twist_map import TwistMap
from pmjac_pin.values.arrays import Array
from pmjac_pin.values.found_once import found_once

RADIUS_ROUNDING = 1e-12  # of ‖J‖ ‖G‖


class ToolReach(TwistMap):
    """J_eq between the motors and the tool: what an `EquivalentJacobian` knows of reach."""

    def velocity_ellipsoid(self, limits: Limits | None = None) -> Ellipsoid:
        """Return the tool velocities of all |θ̇| = 1: the principal velocities, in m/s.

        A radius that is only rounding, beside `sizes`, is 0.

        Parameters
        ----------
        limits : array_like, shape (n,), or "model", optional
            Of the motors, m/s or rad/s, or those that the model states: rates are then counted in
            shares of these, so that motors that slide and motors that turn are alike.

        Raises
        ------
        ArgumentError
            Limits that are none; a motor for which the model states none.

        Examples
        --------
        >>> import pmjac_pin as pj
        >>> jacobian = pj.load("serial_2r").close([0.0, 1.5]).jacobian()
        >>> jacobian.velocity_ellipsoid()
        Ellipsoid(radii=[...] m/s, rank=2, motors in rad/s)
        >>> jacobian.velocity_ellipsoid([2.0, 0.5])
        Ellipsoid(radii=[...] m/s, rank=2, motors in shares of their limits)
        """
        if limits is None:
            return self._linear_ellipsoid
        return self._in_shares(0, limits)

    @found_once
    def _linear_ellipsoid(self) -> Ellipsoid:
        return self._ellipsoid(0, self.J_eq, self.sizes, rates_unit(self.partition))

    def angular_ellipsoid(self, limits: Limits | None = None) -> Ellipsoid:
        """Return the tool's angular velocities of all |θ̇| = 1, in rad/s.

        `limits` and errors as of `velocity_ellipsoid`.
        """
        if limits is None:
            return self._angular_ellipsoid
        return self._in_shares(1, limits)

    @found_once
    def _angular_ellipsoid(self) -> Ellipsoid:
        return self._ellipsoid(1, self.J_eq, self.sizes, rates_unit(self.partition))

    def force_ellipsoid(self, limits: Limits | None = None) -> Ellipsoid:
        """Return the tool forces, without moment, that motor efforts |τ| = 1 balance, in N.

        Parameters
        ----------
        limits : array_like, shape (n,), or "model", optional
            Of the motors, N or N m: efforts are then counted in shares of these.

        Raises
        ------
        ArgumentError
            As `velocity_ellipsoid`.
        """
        if limits is None:
            J_eq, sizes, counted = self.J_eq, self.sizes, efforts_unit(self.partition)
        else:
            J_eq, sizes = self._weighted(1.0 / effort_limits(limits, self.partition))
            counted = SHARES
        return force_ellipsoid(J_eq[:3], "N", RADIUS_ROUNDING * float(sizes[0]), counted)

    def _in_shares(self, kind: int, limits: Limits) -> Ellipsoid:
        J_eq, sizes = self._weighted(rate_limits(limits, self.partition))
        return self._ellipsoid(kind, J_eq, sizes, SHARES)

    def _weighted(self, weights: Array) -> tuple[Array, Array]:
        """Return J_eq, and what its entries are compared with, of motors that count as weighted."""
        return self.J_eq * weights, self._sizes_of_motions(self.motion_map * weights)

    def _ellipsoid(self, kind: int, J_eq: Array, sizes: Array, counted: str) -> Ellipsoid:
        """Return that of the linear rows, 0, or of the angular ones, 1.

        What radii may be by rounding alone is far above it, and far below all that matters.
        """
        unit, block = ("m/s", "rad/s")[kind], J_eq[3 * kind : 3 * kind + 3]
        return velocity_ellipsoid(block, unit, RADIUS_ROUNDING * float(sizes[kind]), counted)

    def velocity_polytope(self, limits: Limits, rows: Iterable[str] = TWIST_ROWS[:3]) -> Polytope:
        """Return the tool velocities that motor rates |θ̇ᵢ| ≤ limit reach, a zonotope.

        Parameters
        ----------
        limits : array_like, shape (n,), or "model"
            Of the motors, m/s or rad/s, or those that the model states.
        rows : iterable of str, optional
            The rows of the twist, all linear or all angular ones; the linear ones by default.

        Raises
        ------
        ArgumentError
            Rows of both kinds, or a direction that is not reached; limits that are none.
        """
        block, unit = self._rows_of_one_kind(rows, "m/s", "rad/s")
        return image_of_box(block, rate_limits(limits, self.partition), unit)

    def force_polytope(self, limits: Limits, rows: Iterable[str] = TWIST_ROWS[:3]) -> Polytope:
        """Return the forces or moments alone that motor efforts |τᵢ| ≤ limit hold.

        Parameters
        ----------
        limits : array_like, shape (n,), or "model"
            Of the motors, N or N m, or those that the model states.
        rows : iterable of str, optional
            As of `velocity_polytope`: "vx" is for a force along x.

        Raises
        ------
        ArgumentError
            As `velocity_polytope`; a direction that is held at no effort.
        """
        block, unit = self._rows_of_one_kind(rows, "N", "N m")
        return within_box(block, effort_limits(limits, self.partition), unit)

    def _rows_of_one_kind(
        self, rows: Iterable[str], linear: str, angular: str
    ) -> tuple[Array, str]:
        """Return rows of J_eq and their unit."""
        which = [TWIST_ROWS.index(name) for name in checked_rows(rows)]
        if which[0] < 3 <= which[-1]:
            raise ArgumentError("a polytope is of linear or of angular rows, not of both")
        return self.J_eq[which], linear if which[0] < 3 else angular
