"""TransmissionMap: a transmission at points of a rectangle of joint values.

Where it exists, where it is singular, and how gear ratios, gains and limits vary.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pmjac_pin.batches.results import Status, Statuses
from pmjac_pin.errors import ArgumentError
from pmjac_pin.studies.transmissions.rectangle import Rectangle, largest_block
from pmjac_pin.studies.transmissions.transmission import Transmission, motor_matrix
from pmjac_pin.values.arrays import Array, Index, Mask, ReadOnlyArrays
from pmjac_pin.values.brief import with_names
from pmjac_pin.values.checks import as_limits


@dataclass(frozen=True, eq=False, repr=False)
class TransmissionMap(ReadOnlyArrays):
    """A transmission at all points of a grid of joint values.

    Made by `pmjac_pin.transmission_map`. Arrays begin with the axes of the grid, one a joint;
    motors and ratios are NaN where `status` is not CLOSED.

    Attributes
    ----------
    transmission : Transmission
    rectangle : Rectangle
    axes : tuple of ndarray
        Values of each joint, m or rad.
    q : ndarray, shape (*grid, nq)
    status : ndarray of int, shape (*grid,)
        `Status`: CLOSED where the transmission exists; STOPPED where the loops do not close;
        LIMITS where a joint or motor is beyond its limits; SINGULAR where the joints do not
        determine the motors, or not the other way round; NO_JACOBIAN where the loops forbid
        some rates of the joints.
    motors : ndarray, shape (*grid, n)
        θ, m or rad.
    ratio : ndarray, shape (*grid, n, n)
        R = ∂θ/∂x.
    condition : ndarray, shape (*grid,)
        Largest by smallest singular value of R, a rad counted as the mechanism's length.
    loops_condition : ndarray, shape (*grid,)
        At least the condition of K* where the joints drive: infinite where they do not determine
        the motors.
    """

    transmission: Transmission
    rectangle: Rectangle
    axes: tuple[Array, ...]
    q: Array
    status: Statuses
    motors: Array
    ratio: Array
    condition: Array
    loops_condition: Array

    @property
    def joints(self) -> tuple[str, ...]:
        """Names of the n joints, the axes."""
        return self.transmission.joints

    @property
    def exists(self) -> Mask:
        """Where it exists and is regular, shape (*grid,)."""
        return np.asarray(self.status == Status.CLOSED)

    @cached_property
    def crossed(self) -> Mask:
        """Cells of the grid, shape (*(grid − 1),), that a singularity passes: det R changes sign.

        A cell without all of its corners is none.
        """
        turned = _corners(np.sign(np.linalg.det(np.nan_to_num(self.ratio))) > 0.0)
        whole = _corners(self.exists).all(axis=0)
        return np.asarray(whole & (turned.any(axis=0) != turned.all(axis=0)))

    def covered(self) -> dict[str, tuple[float, float]]:
        """Return the largest rectangle of the grid, about home, in which it exists everywhere.

        Raises
        ------
        ArgumentError
            There is none.
        """
        good, start = self._usable(), self._start()
        if start is None:
            raise ArgumentError(f"{self._named()} exists at no point of {self.rectangle}")
        lower, upper = largest_block(good, start)
        if (lower == upper).any():
            raise ArgumentError(
                f"{self._named()} exists at some points of {self.rectangle}, and not around them: "
                "give a smaller rectangle"
            )
        ends = zip(self.axes, lower.tolist(), upper.tolist(), strict=True)
        found = [(float(axis[a]), float(axis[b])) for axis, a, b in ends]
        return dict(zip(self.joints, found, strict=True))

    def reflected(self, of_motors: ArrayLike) -> Array:
        """Return Rᵀ D R, shape (*grid, n, n): damping, armature, or stiffness without load.

        Parameters
        ----------
        of_motors : array_like, shape (n,) or (n, n)
            D: of the motors.
        """
        matrix = motor_matrix(of_motors, len(self.joints), "what the motors have")
        return np.asarray(self.ratio.swapaxes(-1, -2) @ matrix @ self.ratio)

    def efforts_alone(self, motor_limits: ArrayLike) -> Array:
        """Return the largest effort of each joint, the others without, shape (*grid, n).

        Where motors give |τᵢ| ≤ limitᵢ: how far the rhombus reaches along each joint's own axis.
        """
        limits = as_limits(motor_limits, len(self.joints))
        return _reach(limits, self._inverse.swapaxes(-1, -2))

    def rates_alone(self, motor_limits: ArrayLike) -> Array:
        """Return the largest rate of each joint, the others at rest, shape (*grid, n)."""
        return _reach(as_limits(motor_limits, len(self.joints)), self.ratio)

    @cached_property
    def _inverse(self) -> Array:
        regular = np.where(self.exists[..., None, None], self.ratio, np.eye(len(self.joints)))
        return np.asarray(np.linalg.inv(regular) + 0.0 * self.ratio)

    def check_whole(self) -> None:
        """Raise ArgumentError, which says where, unless it exists everywhere in the rectangle."""
        wrong, crossed = np.argwhere(~self.exists), np.argwhere(self.crossed)
        if wrong.size:
            why = _WHY[Status(int(self.status[tuple(wrong[0])]))]
            count = f"at {len(wrong)} of {self.status.size} points of {self.rectangle} {why}"
            message = f"{count}, so at {self._place(wrong[0])}"
        elif crossed.size:
            between = f"between {self._place(crossed[0])} and {self._place(crossed[0] + 1)}"
            message = f"{_WHY[Status.SINGULAR]} inside {self.rectangle}, so {between}"
        else:
            return
        try:
            within = Rectangle.of(self.covered())
        except ArgumentError:
            raise ArgumentError(message) from None
        raise ArgumentError(f"{message}; it exists for {within}")

    def _place(self, index: Index) -> str:
        values = (float(axis[k]) for axis, k in zip(self.axes, index.tolist(), strict=True))
        return with_names(self.joints, values)

    def _named(self) -> str:
        return f"a transmission from {', '.join(self.transmission.motors)}"

    def _usable(self) -> Mask:
        """Points around home that exist, on home's side of singularities."""
        start = self._start()
        if start is None:
            return self.exists
        signs = np.sign(np.linalg.det(np.nan_to_num(self.ratio)))
        return np.asarray(self.exists & (signs == signs[start]))

    def _start(self) -> tuple[int, ...] | None:
        """Return the point nearest to home, as a share of the rectangle."""
        home = self.transmission.by_joints.home.actuated
        width = self.rectangle.upper - self.rectangle.lower
        mesh = np.stack(np.meshgrid(*self.axes, indexing="ij"), axis=-1)
        away = np.where(self.exists, np.linalg.norm((mesh - home) / width, axis=-1), np.inf)
        place = np.unravel_index(int(away.argmin()), away.shape)
        return tuple(int(k) for k in place) if np.isfinite(away[place]) else None

    def __repr__(self) -> str:
        share = f"{int(self.exists.sum())} of {self.status.size} points"
        return f"TransmissionMap({self.transmission!r} over {self.rectangle}: exists at {share})"


_WHY = {
    Status.STOPPED: "the loops do not close",
    Status.LIMITS: "a joint is beyond its limits",
    Status.SINGULAR: "the transmission is singular",
    Status.NO_JACOBIAN: "the loops forbid some rates of the joints",
}


def _corners(cells: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Return the corners of each cell between points, along a new first axis."""
    found = [cells]
    for axis in range(cells.ndim):
        ends = slice(None, -1), slice(1, None)
        found = [part[(slice(None),) * axis + (end,)] for part in found for end in ends]
    return np.array(found)


def _reach(limits: Array, matrices: Array) -> Array:
    """Return the largest |x| of each unit vector x eₖ with |M x eₖ| ≤ limits."""
    sizes = np.abs(matrices)
    with np.errstate(divide="ignore"):
        return np.asarray((limits[:, None] / sizes).min(axis=-2))
