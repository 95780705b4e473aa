"""Velocity and force ellipsoids: what a 3 × n Jacobian block makes of a unit ball.

Plain linear algebra on plain arrays. With the singular value decomposition J = U Σ Vᵀ the
tool velocities J θ̇, |θ̇| ≤ 1, fill the ellipsoid with axes U and radii σ, and
the forces f with |Jᵀf| ≤ 1 fill its polar, with the same axes and radii 1/σ. The squared
radii of the first are the eigenvalues of g = JᵀJ of equation (33) in Ghosal, *Parallel
Manipulator Jacobian Matrix*; they are never computed from g, which would lose half the digits.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from pmjac_pin.errors import ArgumentError, quoted
from pmjac_pin.rates.ellipse import (
    FLATNESS_TOLERANCE,
    Ellipse,
    brief_radii,
    check_drawable,
    flattened,
    image_of_ball,
    polar,
    real_array,
    scalar_product,
    settled_axes,
    vector_product,
)
from pmjac_pin.values.arrays import Array, ReadOnlyArrays, sealed
from pmjac_pin.values.checks import LARGEST
from pmjac_pin.values.shown import Shown
from pmjac_pin.values.ties import first_largest

_ORTHONORMAL = 1e-6  # of lengths and scalar products


@dataclass(frozen=True, eq=False, repr=False)
class Ellipsoid(ReadOnlyArrays, Shown):
    """An ellipsoid about the origin: {axes @ (radii * u) : |u| ≤ 1}; in a notebook, a table.

    It may be flat (a zero radius), a needle (two) or a point (three), or unbounded (infinite
    radii: a cylinder, a slab or all of space), but not flat and unbounded at once.

    Attributes
    ----------
    radii : ndarray, shape (3,)
        Semi-axes in `unit`, descending.
    axes : ndarray, shape (3, 3)
        Column i is the unit direction of ``radii[i]``; orthonormal, determinant +1. From
        `velocity_ellipsoid` and `force_ellipsoid` the component of largest magnitude (the
        first of equal ones) of the first two columns is positive, and the third follows by
        the right-hand rule. Axes of equal radii (differing by up to 1e-9, relatively) are any
        orthonormal ones of their span; from those functions the world's axes x, y, z where all
        three are equal, and where two are, two of the world's axes, in their order, turned the
        shortest way into the plane of the two.
    unit : str
        Unit of the radii, such as "m/s", "rad/s" or "N".
    motor_unit : str
        In which the motor rates or efforts of length 1 are counted that it is of: "rad/s", "m/s and
        rad/s" where motors are mixed, or "shares of their limits". "" where that is not known.

    Raises
    ------
    ArgumentError
        If the arrays have other shapes or break one of the rules above.

    Examples
    --------
    >>> ellipsoid = velocity_ellipsoid([[0.0, 2.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 0.5]])
    >>> ellipsoid
    Ellipsoid(radii=[2 1 0.5] m/s, rank=3)
    >>> ellipsoid.section("yz").radii
    array([1. , 0.5])
    """

    radii: Array
    axes: Array
    unit: str
    motor_unit: str = ""

    def __post_init__(self) -> None:
        radii, axes = real_array(self.radii, "radii", (3,)), real_array(self.axes, "axes", (3, 3))
        largest, middle, smallest = radii.tolist()
        if not largest >= middle >= smallest >= 0:
            raise ArgumentError(f"radii must be descending and not negative; got {radii}")
        if largest == math.inf and smallest == 0:
            raise ArgumentError(f"radii must not be both infinite and zero; got {radii}")
        if not _right_handed(axes):
            raise ArgumentError(
                f"axes must be orthonormal columns with determinant +1; got {axes.tolist()}"
            )
        _check_unit_names(self.unit, self.motor_unit)
        self.__dict__.update(radii=radii, axes=axes)

    @classmethod
    def _of_image(cls, radii: Array, axes: Array, unit: str, motor_unit: str) -> Ellipsoid:
        """Return that with radii and axes as they are made here, which need no looking at."""
        _check_unit_names(unit, motor_unit)
        known = {"radii": sealed(radii), "axes": sealed(axes)}
        return cls.of_sealed({**known, "unit": unit, "motor_unit": motor_unit})

    def __repr__(self) -> str:
        counted = f", motors in {self.motor_unit}" if self.motor_unit else ""
        return f"Ellipsoid(radii={brief_radii(self.radii, self.unit)}, rank={self.rank}{counted})"

    @property
    def rank(self) -> int:
        """Dimension of the ellipsoid's span: how many radii are not zero."""
        return int(np.count_nonzero(self.radii))

    @property
    def volume(self) -> float:
        """Volume, 4/3 π r₁ r₂ r₃, in `unit` cubed."""
        return float(4 / 3 * math.pi * math.prod(self.radii.tolist()))

    def section(self, plane: str | ArrayLike) -> Ellipse:
        """Intersect the solid ellipsoid with a plane through its centre.

        The ellipsoid is the image A u, |u| ≤ 1, of a ball of `rank` dimensions. The plane
        with normal n keeps the u in the null space W of nᵀA, so that the section is the
        image of a ball under BᵀA W, B being the plane's basis. The section of an unbounded
        ellipsoid is the polar of the projection of its polar.

        Parameters
        ----------
        plane : str or array_like, shape (3,)
            Two of the letters x, y, z, or a normal of any length. With "zy" the coordinates of
            the result are (z, y). Those of a normal are given by the result's ``basis``,
            right-handed with it; for the x, y and z axes they are (y, z), (z, x) and (x, y).

        Returns
        -------
        Ellipse
            With a zero radius where the plane meets the ellipsoid in a line or a point.

        Raises
        ------
        ArgumentError
            If `plane` is none of these.

        Examples
        --------
        >>> disc = velocity_ellipsoid([[3.0, 0.0], [0.0, 2.0], [0.0, 0.0]])
        >>> disc.section("zy"), disc.projection([1, 0, 1])
        (Ellipse(radii=[2 0] m/s), Ellipse(radii=[2.121 2] m/s))
        """
        basis, normal = _basis_and_normal(plane)
        if self.radii[0] == math.inf:
            shadow = Ellipsoid(*polar(self.radii, self.axes), self.unit).projection(plane)
            return Ellipse(*polar(shadow.radii, shadow.axes), basis, self.unit)
        axes = self.axes[:, : self.rank]
        image = axes * self.radii[: self.rank]
        # Judged on directions alone: a plane that holds all of a flat ellipsoid cuts nothing.
        if np.any(np.abs(normal @ axes) > FLATNESS_TOLERANCE):
            image = image @ np.linalg.svd((normal @ image)[np.newaxis])[2][1:].T
        return self._flat_image(basis, image)

    def projection(self, plane: str | ArrayLike) -> Ellipse:
        """Project the ellipsoid orthogonally on a plane: its shadow, the image under BᵀA.

        The projection of an unbounded ellipsoid is the polar of the section of its polar.
        The plane, the returned `Ellipse` and the errors are those of `section`.
        """
        basis, _ = _basis_and_normal(plane)
        if self.radii[0] == math.inf:
            cut = Ellipsoid(*polar(self.radii, self.axes), self.unit).section(plane)
            return Ellipse(*polar(cut.radii, cut.axes), basis, self.unit)
        return self._flat_image(basis, self.axes * self.radii)

    def _flat_image(self, basis: Array, image: Array) -> Ellipse:
        radii, axes = image_of_ball(basis.T @ image)
        radii = flattened(radii, float(self.radii[0]))
        return Ellipse(radii, settled_axes(radii, axes), basis, self.unit)

    def points(self, n_u: int = 61, n_v: int = 31) -> Array:
        """Return surface points on a grid, as matplotlib's ``plot_surface`` takes them.

        Parameters
        ----------
        n_u : int
            Points around the third axis, at least 4; the last row equals the first.
        n_v : int
            Points from one end of the third axis to the other, at least 4.

        Returns
        -------
        ndarray, shape (n_u, n_v, 3)
            In `unit`; ``x, y, z = np.moveaxis(ellipsoid.points(), -1, 0)``.

        Raises
        ------
        ArgumentError
            If the ellipsoid is unbounded or a count is not such a number.
        """
        check_drawable(self.radii, n_u=n_u, n_v=n_v)
        u = np.linspace(0.0, 2 * math.pi, n_u)[:, np.newaxis]
        v = np.linspace(0.0, math.pi, n_v)
        ball = np.stack(
            np.broadcast_arrays(np.cos(u) * np.sin(v), np.sin(u) * np.sin(v), np.cos(v)), axis=-1
        )
        grid: Array = ball @ (self.axes * self.radii).T
        grid[-1] = grid[0]
        return grid


def velocity_ellipsoid(
    jacobian: ArrayLike, unit: str = "m/s", rounding: float = 0.0, motor_unit: str = ""
) -> Ellipsoid:
    """Return the tool velocities {J θ̇ : |θ̇| ≤ 1} of all motor rates within one.

    The radii are the singular values of J, the square roots of the eigenvalues of g = JᵀJ:
    equation (33) of Ghosal, *Parallel Manipulator Jacobian Matrix*.

    Parameters
    ----------
    jacobian : array_like, shape (3, n)
        ``Jv_eq``, ``Jw_eq`` or any other 3 × n block, n = 0 included. Linear and angular rows
        have different units and make no ellipsoid together.
    unit : str
        Unit of the radii: "m/s" for linear rows, "rad/s" for angular ones.
    rounding : float
        Radii up to this are zero, as are those up to 1e-9 (`FLATNESS_TOLERANCE`) of the largest:
        a Jacobian that is a difference of large numbers may be rounding throughout.
    motor_unit : str
        That of `Ellipsoid`.

    Returns
    -------
    Ellipsoid
        With fewer than three motors the missing radii are zero.

    Raises
    ------
    ArgumentError
        If `jacobian` is not a real, finite 3 × n array, or its radii are beyond all doubles, or
        `rounding` no number ≥ 0.

    Examples
    --------
    >>> velocity_ellipsoid([[0.3], [0.4], [0.0]])
    Ellipsoid(radii=[0.5 0 0] m/s, rank=1)
    >>> velocity_ellipsoid([[1e-17], [0.0], [0.0]], rounding=1e-12)
    Ellipsoid(radii=[0 0 0] m/s, rank=0)
    """
    return Ellipsoid._of_image(*_principal(jacobian, rounding), unit, motor_unit)


def force_ellipsoid(
    jacobian: ArrayLike, unit: str = "N", rounding: float = 0.0, motor_unit: str = ""
) -> Ellipsoid:
    """Return the tool forces {f : |Jᵀf| ≤ 1} that motor efforts within one can hold.

    By the power balance f · v = (Jᵀf) · θ̇ this is the polar of the velocity
    ellipsoid of equation (33): the same axes, reciprocal radii. A radius is infinite where the
    tool cannot move: the structure bears that force without any motor effort.

    Parameters
    ----------
    jacobian : array_like, shape (3, n)
        As for `velocity_ellipsoid`.
    unit : str
        Unit of the radii: "N" for linear rows, "N m" for angular ones.
    rounding : float
        Of `jacobian`, as for `velocity_ellipsoid`: what is zero there is infinite here.
    motor_unit : str
        That of `Ellipsoid`.

    Raises
    ------
    ArgumentError
        If `jacobian` is not a real, finite 3 × n array, or its radii are beyond all doubles, or
        `rounding` no number ≥ 0.

    Examples
    --------
    >>> force_ellipsoid([[4.0, 0.0], [0.0, 0.5], [0.0, 0.0]])
    Ellipsoid(radii=[inf 2 0.25] N, rank=3)
    """
    return Ellipsoid._of_image(*polar(*_principal(jacobian, rounding)), unit, motor_unit)


def _check_unit_names(unit: str, motor_unit: str) -> None:
    if not isinstance(unit, str):
        raise ArgumentError(f'unit must be a string, such as "m/s"; got {quoted(unit)}')
    if not isinstance(motor_unit, str):
        raise ArgumentError(f"motor_unit must be a string; got {quoted(motor_unit)}")


def _principal(jacobian: ArrayLike, rounding: float) -> tuple[Array, Array]:
    """Return the radii of the velocities, zero where they are rounding, and the axes."""
    block = _checked_block(jacobian)
    if not (isinstance(rounding, (int, float)) and 0.0 <= rounding <= LARGEST):
        raise ArgumentError(f"rounding must be a number ≥ 0, got {quoted(rounding)}")
    radii, axes = image_of_ball(block)
    values: list[float] = radii.tolist()
    if not values[0] < math.inf:
        largest = float(np.abs(block).max())
        raise ArgumentError(
            f"the Jacobian block's radii must be finite; its largest entry is {largest:.3g}"
        )
    nothing = max(FLATNESS_TOLERANCE * values[0], rounding)
    flat = np.array([radius if radius > nothing else 0.0 for radius in values])
    return flat, settled_axes(flat, axes)


def _right_handed(axes: Array) -> bool:
    """On Python floats: on so few numbers they are several times faster than NumPy."""
    a, b, c = axes.T.tolist()
    lengths = [scalar_product(one, one) - 1.0 for one in (a, b, c)]
    angles = [scalar_product(a, b), scalar_product(b, c), scalar_product(c, a)]
    # One by one, so that NaN is refused, too: what overflows is infinite or NaN.
    orthonormal = all(-_ORTHONORMAL <= x <= _ORTHONORMAL for x in lengths + angles)
    return orthonormal and scalar_product(vector_product(a, b), c) > 0.0


def _basis_and_normal(plane: str | ArrayLike) -> tuple[Array, Array]:
    """Return the basis (3, 2) of a plane and its unit normal, right-handed together."""
    if isinstance(plane, str):
        letters = plane.lower()
        if len(letters) != 2 or letters[0] == letters[1] or not set(letters) <= set("xyz"):
            raise ArgumentError(
                f'plane must be two different letters of "xyz", such as "xy", or a normal; '
                f"got {quoted(plane)}"
            )
        basis = np.eye(3)[:, ["xyz".index(letter) for letter in letters]]
        return basis, np.cross(basis[:, 0], basis[:, 1])
    normal = real_array(plane, "the plane's normal", (3,))
    largest = float(np.abs(normal).max())
    if not 0 < largest < math.inf:
        raise ArgumentError(f"the plane's normal must be finite and not zero; got {normal}")
    normal = normal / largest  # first, so that the norm neither overflows nor underflows
    normal = normal / np.linalg.norm(normal)
    # The axis after the one nearest to the normal is at least 45 degrees away from it.
    first = np.eye(3)[(int(first_largest(normal)) + 1) % 3]
    first = first - (first @ normal) * normal
    first = first / np.linalg.norm(first)
    return np.column_stack([first, np.cross(normal, first)]), normal


def _checked_block(jacobian: ArrayLike) -> Array:
    J = real_array(jacobian, "the Jacobian block")
    finite = all(map(math.isfinite, J.ravel().tolist()))
    if J.ndim != 2 or J.shape[0] != 3 or not finite:
        raise ArgumentError(
            f"the Jacobian block must be a finite 3 × n array, linear or angular rows alone; "
            f"got shape {J.shape}{'' if finite else ' with NaN or infinite entries'}"
        )
    return J
