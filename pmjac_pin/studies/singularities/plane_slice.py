"""PlaneSlice: two motors that vary within a window, and all others where a pose has them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from pmjac_pin.configuration import Configuration
from pmjac_pin.errors import ArgumentError, quoted, unknown_name
from pmjac_pin.mechanism import Mechanism
from pmjac_pin.values.arrays import Array, Index, Mask, norm
from pmjac_pin.values.checks import as_numbers

_ONE_TURN = 2.0 * np.pi
_WINDOW_ROUNDING = 1e-12  # of a window: rounding on its border is no leaving


@dataclass(frozen=True, slots=True, eq=False)
class PlaneSlice:
    """A plane of motor values.

    Attributes
    ----------
    mechanism : Mechanism
        Whose motors these are.
    at : Configuration
        Has the values of the motors that stay.
    names : tuple of two str
    columns, held : ndarray of int, shapes (2,) and (n − 2,)
        Columns of the two motors, and of those that stay.
    lower, upper : ndarray, shape (2,)
        The window, m or rad.
    """

    mechanism: Mechanism
    at: Configuration
    names: tuple[str, str]
    columns: Index
    held: Index
    lower: Array
    upper: Array

    @classmethod
    def of(
        cls, names: tuple[str, str], at: Configuration, window: Mapping[str, object] | None
    ) -> PlaneSlice:
        """Return the slice through a pose.

        Parameters
        ----------
        names : tuple of two str
            Motors.
        at : Configuration
        window : mapping of str to (float, float), optional
            The range of each; by default its limits, of an angle one turn at most.

        Raises
        ------
        ArgumentError, UnknownNameError
        """
        mechanism = at.mechanism
        partition = mechanism.problem.partition
        columns = np.array([partition.columns[name] for name in names])
        if mechanism.coordinates.curved[columns].any():
            raise ArgumentError(f"{names[0]!r} or {names[1]!r} turns about more than one axis")
        held = np.array([c for c in partition.actuated.tolist() if c not in columns], dtype=np.intp)
        ranges = _window(names, mechanism, window)
        return cls(mechanism, at, names, columns, held, ranges[:, 0], ranges[:, 1])

    @property
    def size(self) -> Array:
        """Width and height of the window, m or rad."""
        return np.asarray(self.upper - self.lower)

    @property
    def units(self) -> tuple[str, str]:
        """Of the two motors, "m" or "rad"."""
        first, second = (self.mechanism.units[name] for name in self.names)
        return first, second

    @property
    def motors(self) -> list[int]:
        """Which of the machine's motors the two are."""
        return [self.mechanism.actuated.index(name) for name in self.names]

    @property
    def held_values(self) -> dict[str, float]:
        """The values of the motors that stay, by name."""
        values = dict(zip(self.mechanism.actuated, self.at.actuated.tolist(), strict=True))
        return {name: value for name, value in values.items() if name not in self.names}

    def axes(self, cells: tuple[int, int]) -> dict[str, Array]:
        """Return so many values of each motor, over the whole window."""
        ends = zip(self.names, self.lower, self.upper, cells, strict=True)
        return {name: np.linspace(low, high, count) for name, low, high, count in ends}

    def places(self, q: Array) -> Array:
        """Return where poses (..., nq) are in the plane, (..., 2)."""
        return self.mechanism.coordinates.values_of(q, self.columns)

    def nearest(self, places: Array, place: Array, count: int) -> Index:
        """Return so many of some places (..., 2), as if in one row, that are nearest to another."""
        away = np.linalg.norm((places - place) / self.size, axis=-1).ravel()
        return np.argsort(away, kind="stable")[:count]

    def inside(self, places: Array) -> Mask:
        """Tell which places (..., 2) are in the window."""
        slack = _WINDOW_ROUNDING * self.size
        within = (places >= self.lower - slack) & (places <= self.upper + slack)
        return np.asarray(within.all(axis=-1))

    def way(self, q: Array, other: Array) -> Array:
        """Return the motion (nv,) from one pose to another, lengths or rad, full turns aside."""
        problem, coordinates = self.mechanism.problem, self.mechanism.coordinates
        away = problem.difference(q, other)
        turning = coordinates.angles | coordinates.wraps
        away[turning] = np.remainder(away[turning] + np.pi, _ONE_TURN) - np.pi
        return np.asarray(away / (problem.partition.length * problem.partition.column_scale))

    def apart(self, q: Array, other: Array) -> float:
        """Return how far two poses are from each other, lengths or rad, full turns aside."""
        return norm(self.way(q, other))

    def turned_back(self, q: Array) -> list[Array]:
        """Return the same pose at the other side of the window, where that is a full turn."""
        found, coordinates = [], self.mechanism.coordinates
        place = self.places(q)
        for k, column in enumerate(self.columns.tolist()):
            if not coordinates.angles[column] or abs(self.size[k] - _ONE_TURN) > 1e-9:
                continue
            for side, way in ((self.lower[k], _ONE_TURN), (self.upper[k], -_ONE_TURN)):
                if abs(place[k] - side) <= 1e-9:
                    values = np.array([place[k] + way])
                    found.append(coordinates.with_values(q, self.columns[[k]], values))
        return found


def _window(
    names: tuple[str, str], mechanism: Mechanism, window: Mapping[str, object] | None
) -> Array:
    given = {} if window is None else window
    if not isinstance(given, Mapping):
        raise ArgumentError(f"`window` has a range for each motor by name, got {quoted(window)}")
    for name in given:
        if name not in names:
            raise unknown_name("motor of the plane", str(name), names)
    return np.array([_range(name, mechanism, given.get(name)) for name in names])


def _range(name: str, mechanism: Mechanism, given: object) -> Array:
    lower, upper = mechanism.limits(name)
    column = mechanism.problem.partition.columns[name]
    coordinates = mechanism.coordinates
    if given is None:
        if coordinates.angles[column] or coordinates.wraps[column]:
            lower, upper = max(lower, -np.pi), min(upper, np.pi)
        if not np.isfinite(upper - lower):
            raise ArgumentError(f"{name!r} has no limits: give its range in `window`")
        return np.array([lower, upper])
    ends = as_numbers(given, f"the range of {name!r}")
    if ends.shape != (2,) or not ends[0] < ends[1]:
        raise ArgumentError(f"the range of {name!r} is (lower, upper), got {quoted(given)}")
    return ends
