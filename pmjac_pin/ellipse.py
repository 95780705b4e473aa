"""Ellipse: a section or a projection of an ellipsoid; and what ellipses and ellipsoids share.

Both are images of a unit ball under a matrix. Their axes and radii are its left singular
vectors and singular values; polarity turns radii into their reciprocals.
"""

from __future__ import annotations

import math
import operator
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pmjac_pin.errors import ArgumentError

Array = NDArray[np.float64]

FLATNESS_TOLERANCE = 1e-9
"""A radius or singular value at or below this times the largest is rounding: it becomes 0."""


@dataclass(frozen=True, eq=False, repr=False, slots=True)
class Ellipse:
    """A section or a projection of an `Ellipsoid`, in the coordinates of its plane.

    Attributes
    ----------
    radii : ndarray, shape (2,)
        Semi-axes in `unit`, descending; zero where flat, infinite where unbounded.
    axes : ndarray, shape (2, 2)
        Column i is the direction of ``radii[i]`` in the plane's coordinates; determinant +1,
        the component of largest magnitude of the first column positive.
    basis : ndarray, shape (3, 2)
        The plane's coordinate directions: ``basis @ y`` is the point of space at ``y``.
    unit : str
        Unit of the radii.
    """

    radii: Array
    axes: Array
    basis: Array
    unit: str

    def __post_init__(self) -> None:
        for name, shape in (("radii", (2,)), ("axes", (2, 2)), ("basis", (3, 2))):
            object.__setattr__(self, name, real_array(getattr(self, name), name, shape))

    def __reduce__(self) -> tuple[Callable[..., Ellipse], tuple[Any, ...]]:
        # NumPy forgets the read-only flag when it pickles; the constructor sets it again.
        return Ellipse, (self.radii, self.axes, self.basis, self.unit)

    def __repr__(self) -> str:
        return f"Ellipse(radii={brief(self.radii, self.unit)})"

    @property
    def area(self) -> float:
        """Area, π r₁ r₂, in `unit` squared."""
        return float(math.pi * math.prod(self.radii.tolist()))

    def points(self, count: int = 181) -> Array:
        """Return the closed outline, counter-clockwise from the end of the first axis.

        Parameters
        ----------
        count : int
            Number of points, at least 4; the last equals the first.

        Returns
        -------
        ndarray, shape (count, 2)
            In the plane's coordinates, in `unit`.

        Raises
        ------
        ArgumentError
            If the ellipse is unbounded or `count` is not such a number.
        """
        check_drawable(self.radii, count=count)
        angle = np.linspace(0.0, 2 * math.pi, count)
        circle = np.column_stack([np.cos(angle), np.sin(angle)])
        outline: Array = circle @ (self.axes * self.radii).T
        outline[-1] = outline[0]
        return outline


def image_of_ball(A: Array) -> tuple[Array, Array]:
    """Return radii (d,) and axes (d, d) of the image of the unit ball under a d x k matrix."""
    d, k = A.shape
    axes, sigma, _ = np.linalg.svd(A, full_matrices=k < d)
    radii = np.zeros(d)
    radii[: len(sigma)] = sigma
    return radii, oriented(axes)


def flattened(radii: Array, size: float) -> Array:
    """Return the radii, with zeros for those that are flat beside `size`."""
    return np.where(radii > FLATNESS_TOLERANCE * size, radii, 0.0)


def polar(radii: Array, axes: Array) -> tuple[Array, Array]:
    """Return radii and axes of the polar set {y : x · y ≤ 1 for all x of the ellipsoid}."""
    reciprocal = [1 / r if r else math.inf for r in radii.tolist()]
    return np.array(reciprocal[::-1]), oriented(axes[:, ::-1])


def oriented(axes: Array) -> Array:
    """Turn 2 or 3 orthonormal columns so that their signs are repeatable and det is +1.

    On Python floats: on so few numbers they are several times faster than NumPy.
    """
    a, b = axes.T[:2].tolist()
    a = _positive(a)
    if len(a) == 2:
        return np.array([[a[0], -a[1]], [a[1], a[0]]])
    b = _positive(b)
    c = [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
    return np.array([a, b, c]).T


def _positive(direction: list[float]) -> list[float]:
    # Symmetric mechanisms make components that are equal up to rounding: the first decides.
    peak = (1 - 1e-6) * max(map(abs, direction))
    leading = next(x for x in direction if abs(x) >= peak)
    return direction if leading > 0 else [-x for x in direction]


def real_array(value: ArrayLike, name: str, shape: tuple[int, ...] | None = None) -> Array:
    """Return a read-only float copy, refusing what NumPy would convert with loss."""
    try:
        given = np.asarray(value)
    except ValueError:
        raise ArgumentError(f"{name} must be an array of numbers; got {value!r}") from None
    if given.dtype.kind not in "fiu":
        raise ArgumentError(f"{name} must hold real numbers; got {given.dtype} values")
    if shape is not None and given.shape != shape:
        raise ArgumentError(f"{name} must have shape {shape}; got shape {given.shape}")
    array = np.array(given, dtype=np.float64)
    array.setflags(write=False)
    return array


def check_drawable(radii: Array, **counts: int) -> None:
    """Refuse the outline of an unbounded figure, and too few points for one."""
    if radii[0] == math.inf:
        raise ArgumentError(
            f"an unbounded figure has no outline; its radii {brief(radii)} must all be finite"
        )
    for name, count in counts.items():
        try:
            enough = operator.index(count) >= 4
        except TypeError:
            enough = False
        if not enough:
            raise ArgumentError(f"{name} must be a whole number of at least 4; got {count!r}")


def brief(radii: Array, unit: str = "") -> str:
    """Return radii as a ``repr`` shows them."""
    return f"[{' '.join(f'{r:.4g}' for r in radii.tolist())}] {unit}".rstrip()
