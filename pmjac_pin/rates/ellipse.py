"""Ellipse: a section or a projection of an ellipsoid; and what ellipses and ellipsoids share.

Both are images of a unit ball under a matrix. Their axes and radii are its left singular
vectors and singular values; polarity turns radii into their reciprocals.
"""

from __future__ import annotations

import itertools
import math
import operator
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from pmjac_pin.errors import ArgumentError, quoted
from pmjac_pin.values.arrays import Array, ReadOnlyArrays
from pmjac_pin.values.lapack import lapack
from pmjac_pin.values.ties import LIKE

MOST_POINTS = 5000  # of an outline, and each way of a surface: 25 million in all

FLATNESS_TOLERANCE = 1e-9
"""A radius or singular value at or below this times the largest is rounding: it becomes 0."""

TIE = 1e-9
"""Radii that differ by up to this, relatively, are equal: their axes are any of their span."""

_WORLD = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]


@dataclass(frozen=True, eq=False, repr=False)
class Ellipse(ReadOnlyArrays):
    """A section or a projection of an `Ellipsoid`, in the coordinates of its plane.

    Attributes
    ----------
    radii : ndarray, shape (2,)
        Semi-axes in `unit`, descending; zero where flat, infinite where unbounded.
    axes : ndarray, shape (2, 2)
        Column i is the direction of ``radii[i]`` in the plane's coordinates; determinant +1,
        the component of largest magnitude of the first column positive. Those of a circle
        (radii that differ by up to 1e-9, relatively) are the plane's own.
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
            self.__dict__[name] = real_array(getattr(self, name), name, shape)

    def __repr__(self) -> str:
        return f"Ellipse(radii={brief_radii(self.radii, self.unit)})"

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
    """Return radii (d,) and axes (d, d) of the image of the unit ball under a d x k matrix.

    The axes as the decomposition gives them: see `settled_axes`.
    """
    d, k = A.shape
    if not k:
        return np.zeros(d), np.eye(d)
    axes, sigma, _, failed = lapack().dgesdd(A, full_matrices=k < d)
    if failed:
        raise np.linalg.LinAlgError("the singular values did not converge")
    return (sigma if k >= d else np.concatenate([sigma, np.zeros(d - k)])), axes


def flattened(radii: Array, size: float | Array) -> Array:
    """Return the radii, with zeros for those that are flat beside `size`."""
    return np.where(radii > FLATNESS_TOLERANCE * size, radii, 0.0)


def polar(radii: Array, axes: Array) -> tuple[Array, Array]:
    """Return radii and axes of the polar set {y : x · y ≤ 1 for all x of the ellipsoid}."""
    reciprocal = np.array([1 / r if r else math.inf for r in radii.tolist()][::-1])
    return reciprocal, settled_axes(reciprocal, axes[:, ::-1])


def settled_axes(radii: Array, axes: Array) -> Array:
    """Choose among all 2 or 3 orthonormal axes of these radii, so that rounding does not.

    Axes of radii that are equal (`ties`) are those of the world, turned the shortest way into
    their plane: of all in it the nearest to two of the world's. The signs are such that the largest
    component is positive, but for the last axis, which makes the determinant +1.

    On Python floats: on so few numbers they are several times faster than NumPy.
    """
    tied = ties(radii)
    if all(tied):
        return np.eye(len(axes))
    a, b, *rest = axes.T.tolist()
    if not rest:
        a = _positive(a)
        return np.array([[a[0], -a[1]], [a[1], a[0]]])
    if tied[0]:
        a, b = turned_into_plane(rest[0], _WORLD)
    else:
        a = _positive(a)
        b = turned_into_plane(a, _WORLD)[0] if tied[1] else _positive(b)
    return np.array([a, b, vector_product(a, b)]).T


def scalar_product(a: list[float], b: list[float]) -> float:
    """Return a · b of three numbers each."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def vector_product(a: list[float], b: list[float]) -> list[float]:
    """Return a × b."""
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def ties(radii: Array) -> list[bool]:
    """Tell of each radius and the next whether they are equal, to `TIE`; zeros are, infinite too.

    Examples
    --------
    >>> ties(np.array([2.0, 2.0 - 1e-12, 0.0])), ties(np.array([np.inf, np.inf, 1.0]))
    ([True, False], [True, False])
    """
    values = radii.tolist()
    return [next_ >= (1.0 - TIE) * r for r, next_ in itertools.pairwise(values)]


def turned_into_plane(normal: list[float], axes: list[list[float]]) -> list[list[float]]:
    """Return two of three orthonormal axes, turned the shortest way into a plane.

    It takes the axis i that is most like the unit normal n, to either side (g = ±1), into it. The
    others become d − (d·n)(n + g dᵢ)/(1 + |n·dᵢ|). As the matrix between those two and what they
    become is symmetric and positive, none of the plane's axes are nearer to them.
    """
    likeness = [scalar_product(normal, axis) for axis in axes]
    peak = LIKE * max(map(abs, likeness))
    nearest = max(k for k in range(3) if abs(likeness[k]) >= peak)
    side = math.copysign(1.0, likeness[nearest])
    share = 1.0 / (1.0 + abs(likeness[nearest]))
    between = [share * (n + side * x) for n, x in zip(normal, axes[nearest], strict=True)]
    return [
        [x - likeness[k] * y for x, y in zip(axes[k], between, strict=True)]
        for k in range(3)
        if k != nearest
    ]


def _positive(direction: list[float]) -> list[float]:
    # Symmetric mechanisms make components that are equal up to rounding: the first decides.
    peak = LIKE * max(map(abs, direction))
    leading = next(x for x in direction if abs(x) >= peak)
    return direction if leading > 0 else [-x for x in direction]


def real_array(value: ArrayLike, name: str, shape: tuple[int, ...] | None = None) -> Array:
    """Return a read-only float copy, refusing what NumPy would convert with loss."""
    try:
        given = np.asarray(value)
    except ValueError:
        raise ArgumentError(f"{name} must be an array of numbers; got {quoted(value)}") from None
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
            f"an unbounded figure has no outline; its radii {brief_radii(radii)} must all be finite"
        )
    for name, count in counts.items():
        try:
            drawable = 4 <= operator.index(count) <= MOST_POINTS
        except TypeError:
            drawable = False
        if not drawable:
            wanted = f"a whole number of at least 4 and at most {MOST_POINTS}"
            raise ArgumentError(f"{name} must be {wanted}; got {quoted(count)}")


def brief_radii(radii: Array, unit: str = "") -> str:
    """Return radii as a ``repr`` shows them."""
    return f"[{' '.join(f'{r:.4g}' for r in radii.tolist())}] {unit}".rstrip()
