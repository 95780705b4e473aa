"""Limits of each motor's rate or effort: as a caller gives them, or those of the model."""

from __future__ import annotations

from typing import Literal, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from pmjac_pin.errors import ArgumentError, enumerated, quoted
from pmjac_pin.rates.partition import Partition
from pmjac_pin.values.arrays import Array
from pmjac_pin.values.checks import as_limits

#: In which rates or efforts are counted that are given as such.
SHARES = "shares of their limits"

#: By the unit of a motor's or a joint's value.
EFFORT_UNITS = {"m": "N", "rad": "N m"}

Limits: TypeAlias = ArrayLike | Literal["model"]


def rate_limits(given: Limits, partition: Partition) -> Array:
    """Return limits of motor rates, shape (n,), m/s or rad/s: as given, or "model" for its own.

    Raises
    ------
    ArgumentError
        Other numbers than one above 0 for each motor; a motor for which the model states none.
    """
    return _limits_of(given, partition, stated_rate_limits(partition), "rate")


def effort_limits(given: Limits, partition: Partition) -> Array:
    """Return limits of motor efforts, shape (n,), N or N m, as `rate_limits`."""
    return _limits_of(given, partition, stated_effort_limits(partition), "effort")


def stated_rate_limits(partition: Partition) -> Array:
    """Return the model's own limits of motor rates, shape (n,), infinite where it states none."""
    return _of_motors(partition.rate_limits, partition)


def stated_effort_limits(partition: Partition) -> Array:
    """Return the model's own limits of motor efforts, as `stated_rate_limits`."""
    return _of_motors(partition.effort_limits, partition)


def rates_unit(partition: Partition) -> str:
    """Return in which motor rates are counted, such as "m/s and rad/s"; "" where not known."""
    return " and ".join(f"{unit}/s" for unit in _motor_units(partition))


def efforts_unit(partition: Partition) -> str:
    """Return in which motor efforts are counted, such as "N and N m"; "" where not known."""
    return " and ".join(EFFORT_UNITS[unit] for unit in _motor_units(partition))


def _motor_units(partition: Partition) -> list[str]:
    return sorted(set(partition.units_of(partition.actuated)))


def _of_motors(limits: Array, partition: Partition) -> Array:
    found = limits[partition.actuated] if limits.size else np.full(partition.actuated.size, np.inf)
    return np.array(found)


def _limits_of(given: Limits, partition: Partition, stated: Array, what: str) -> Array:
    if not isinstance(given, str):
        return as_limits(given, partition.actuated.size)
    if given != "model":
        raise ArgumentError(f"motor limits are numbers or 'model', got {quoted(given)}")
    names = partition.actuated_names
    if missing := [names[k] for k in np.flatnonzero(np.isinf(stated))]:
        raise ArgumentError(
            f"the model states no {what} limit of {enumerated(missing)}: give limits, one number "
            f"for each motor ({enumerated(names)})"
        )
    return stated
