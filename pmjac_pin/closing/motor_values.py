"""Motor values as a caller gives them: by name, or in the motors' order; and their limits."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from pmjac_pin.errors import ArgumentError, unknown_name
from pmjac_pin.model.coordinates import LIMIT_SLACK, JointCoordinates
from pmjac_pin.model.spec import MechanismSpec
from pmjac_pin.values.arrays import Array, Mask
from pmjac_pin.values.checks import LARGEST, are_doubles, as_numbers, real_numbers, within
from pmjac_pin.values.columns import check_stated_unit, columns_of, without_labels
from pmjac_pin.values.named_values import named_values

MotorValues: TypeAlias = ArrayLike | Mapping[str, float]


class Motors:
    """The motors of a mechanism: their limits, and where q holds their values.

    Parameters
    ----------
    spec, coordinates
        Which joints are motors, and all that there are.

    Attributes
    ----------
    are_entries : bool
        Whether their values are entries of q, and their ways differences of these.
    narrowest : (float, float)
        The limits within which all of them are within their own.
    """

    __slots__ = (
        "_columns",
        "_coordinates",
        "_entries",
        "_limits",
        "_names",
        "are_entries",
        "narrowest",
    )

    def __init__(self, spec: MechanismSpec, coordinates: JointCoordinates) -> None:
        self._coordinates = coordinates
        self._names = coordinates.dof_names(spec.actuated)
        columns = self._columns = coordinates.columns(spec.actuated)
        ends = (coordinates.lower - LIMIT_SLACK, coordinates.upper + LIMIT_SLACK)
        lower, upper = (np.clip(end[columns], -LARGEST, LARGEST).tolist() for end in ends)
        self._limits = list(zip(lower, upper, strict=True))
        self.narrowest = max(lower, default=0.0), min(upper, default=0.0)
        # Elsewhere the coordinates know how these turn.
        self.are_entries = not (coordinates.wraps | coordinates.curved)[columns].any()
        entries = [coordinates.entry(column) for column in columns.tolist()]
        self._entries = np.array(entries, dtype=np.intp) if self.are_entries else None

    def within_limits(self, given: Any) -> Array | None:
        """Return a copy of an array of floats that are all within limits; None of all else."""
        if type(given) is not np.ndarray or given.dtype != float or given.ndim != 1:
            return None
        values = given.tolist()
        if len(values) != len(self._limits):
            return None
        for value, (lower, upper) in zip(values, self._limits, strict=True):
            if not lower <= value <= upper:
                return None
        copied: Array = given.copy()
        return copied

    def table(self, given: Any) -> Array:
        """Return values of many poses as an array (N, n), or say what was expected.

        An array of doubles is returned as it is. NaN and infinities may be among them.

        Parameters
        ----------
        given : array_like, shape (N, n), or columns by their names
            Columns of a mapping, a pandas DataFrame, an xarray Dataset or NumPy's records are
            taken by the names of the motors.

        Raises
        ------
        UnknownNameError, ArgumentError
            As `motor_values`; columns of unlike lengths, or that state another unit than m or rad.
        """
        values = given if are_doubles(given) else self._looked_at(given)
        if values.ndim != 2 or values.shape[1] != len(self._names):
            wanted = f"(N, {len(self._names)}) for {', '.join(self._names)}"
            raise ArgumentError(f"motor values of shape {wanted} expected, got {values.shape}")
        return values

    def _looked_at(self, given: Any) -> Array:
        """Return values of what is no array of doubles, their columns in the motors' order."""
        if (columns := columns_of(given)) is not None:
            _check_motor_names(self._names, self._coordinates, columns)
            _check_units(self._names, self._coordinates.rotational[self._columns], columns, given)
            return self._by_columns(columns)
        if type(given) in (list, tuple):
            _refuse_named_rows(given)
        return real_numbers(given, "motor values")

    def _by_columns(self, columns: dict[Any, Any]) -> Array:
        ordered = [
            real_numbers(without_labels(columns[name]), f"values of motor {name!r}")
            for name in self._names
        ]
        shapes = {column.shape for column in ordered}
        if len(shapes) > 1 or ordered[0].ndim != 1:
            got = ", ".join(str(column.shape) for column in ordered)
            raise ArgumentError(f"one value a pose expected of each motor, got shapes {got}")
        return np.column_stack(ordered)

    def beyond(self, values: Array) -> Mask | None:
        """Tell of which of many values (N, n) one is beyond limits; None where none is."""
        if self.are_inside(values):
            return None
        beyond = np.asarray(self._coordinates.beyond(values, self._columns).any(axis=1))
        return beyond if beyond.any() else None

    def are_inside(self, values: Array) -> bool:
        """Tell whether many values (N, n) are numbers within the limits of each motor.

        False also where limits are unlike, and some are beyond the narrowest of them.
        """
        return within(values, self.narrowest)

    def ways(self, start: Array, values: Array) -> Array:
        """Return how far the motors go from many q, or from one, to values (N, n)."""
        if self._entries is None:
            at_rest = self._coordinates.values_of(start, self._columns)
            return self._coordinates.shorter_way(at_rest, values, self._columns)
        ways: Array = values - start.take(self._entries, axis=-1)
        return ways

    def way(self, q: Array, values: Array) -> Array:
        """Return the motion (n,) of the motors in one unit of time from q to these values."""
        if self._entries is None:
            return self._coordinates.motion_to(q, self._columns, values)
        motion: Array = values - q.take(self._entries)
        return motion

    def at(self, q: Array, values: Array) -> Array:
        """Return q with the motors at these values."""
        if self._entries is None:
            return self._coordinates.with_values(q, self._columns, values)
        there = q.copy()
        there[self._entries] = values
        return there


def motor_values(spec: MechanismSpec, coordinates: JointCoordinates, actuated: Any) -> Array:
    """Return the motor values as an array (n,), or say what was expected.

    Parameters
    ----------
    spec, coordinates
        Which joints are motors, and all that there are.
    actuated : array_like, shape (n,), or mapping of str to float
        m or rad. What has names, as a mapping or a pandas Series, is taken by them; the rest in
        the motors' order. A joint of several degrees of freedom has a value for each, as in
        `Configuration.joint_values`; by its own name, it takes all of them, or its entries of q.

    Raises
    ------
    UnknownNameError
        A name that is no motor's.
    ArgumentError
        Another number of values, a motor without a value, or values that are no finite numbers.
    """
    names = coordinates.dof_names(spec.actuated)
    if (by_name := named_values(actuated, "motor values")) is not None:
        _check_units(
            names, coordinates.rotational[coordinates.columns(spec.actuated)], by_name, actuated
        )
        return _in_order(names, coordinates, _by_freedom(spec, coordinates, by_name))
    return _listed(names, actuated, "motor value")


def motor_rates(spec: MechanismSpec, coordinates: JointCoordinates, given: Any) -> Array:
    """Return rates or accelerations of the motors as an array (n,), or say what was expected.

    Parameters
    ----------
    spec, coordinates
        As for `motor_values`.
    given : array_like, shape (n,), or mapping of str to float
        By name, of each degree of freedom.

    Raises
    ------
    UnknownNameError, ArgumentError
        As `motor_values`.
    """
    names = coordinates.dof_names(spec.actuated)
    if (by_name := named_values(given, "motor rates")) is not None:
        return _in_order(names, coordinates, by_name)
    return _listed(names, given, "motor rate")


def _listed(names: tuple[str, ...], given: Any, what: str) -> Array:
    """Return one number for each name."""
    values = np.atleast_1d(as_numbers(given, f"{what}s"))
    if values.shape != (len(names),):
        got = str(values.size) if values.ndim == 1 else f"shape {values.shape}"
        plural = "s" * (len(names) != 1)
        wanted = f"{len(names)} {what}{plural} ({', '.join(names)})"
        raise ArgumentError(f"{wanted} expected, got {got}")
    return values


def _check_units(
    names: Sequence[str], turning: Mask, by_name: Mapping[Any, Any], given: Any
) -> None:
    """Raise ArgumentError where values, or all of them, state another unit than m or rad."""
    for name, turns in zip(names, turning, strict=True):
        unit = "rad" if turns else "m"
        check_stated_unit(by_name.get(name), f"motor values: {name!r}", unit)
        if not isinstance(given, Mapping):
            check_stated_unit(given, "motor values", unit)


def _refuse_named_rows(rows: Sequence[Any]) -> None:
    """Raise ArgumentError where rows have names, which must not be taken by their order."""
    for row in {type(row): row for row in rows}.values():
        if named_values(row, "motor values") is not None:
            right = "give all rows as one table, or plain rows in the motors' order"
            raise ArgumentError(f"motor values in rows with names of their own: {right}")


def _check_motor_names(
    names: tuple[str, ...], coordinates: JointCoordinates, given: Collection[Any]
) -> None:
    for name in given:
        if name not in names:
            if name in coordinates.names:
                message = f"joint {name!r} is passive; motors are: {', '.join(names)}"
                raise ArgumentError(message)
            raise unknown_name("motor", name, names)
    if missing := [name for name in names if name not in given]:
        plural = "s" * (len(missing) > 1)
        raise ArgumentError(f"no value is given for motor{plural} {', '.join(map(repr, missing))}")


def by_joint(
    spec: MechanismSpec, coordinates: JointCoordinates, values: Array
) -> dict[str, float | tuple[float, ...]]:
    """Return motor values (n,) by the motors' names, of each its value or its tuple of values."""
    found, rest = {}, values.tolist()
    for name in spec.actuated:
        count = coordinates.degrees_of_freedom(name)
        found[name] = rest[0] if count == 1 else tuple(rest[:count])
        del rest[:count]
    return found


def _by_freedom(
    spec: MechanismSpec, coordinates: JointCoordinates, by_name: dict[Any, Any]
) -> dict[Any, Any]:
    """Return values by the names of degrees of freedom, those of a whole joint taken apart."""
    found: dict[Any, Any] = {}
    for name, given in by_name.items():
        if name in spec.actuated and coordinates.degrees_of_freedom(name) > 1:
            values = coordinates.values(coordinates.q({name: given}))
            own = values[coordinates.columns([name])].tolist()
            found.update(zip(coordinates.dof_names([name]), own, strict=True))
        else:
            found[name] = given
    return found


def _in_order(
    names: tuple[str, ...], coordinates: JointCoordinates, by_name: dict[Any, Any]
) -> Array:
    _check_motor_names(names, coordinates, by_name)
    return np.array([_motor_value(name, by_name[name]) for name in names], dtype=float)


def _motor_value(name: str, given: Any) -> float:
    value = as_numbers(given, f"the value of motor {name!r}")
    if value.size != 1:
        raise ArgumentError(f"motor {name!r} takes 1 value, got {value.size}")
    return float(value.reshape(()))
