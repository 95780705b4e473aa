"""Motor values as a caller gives them: by name, or in the motors' order; and their limits."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from pmjac_pin.errors import ArgumentError, unknown_name
from pmjac_pin.model.coordinates import JointCoordinates
from pmjac_pin.model.spec import MechanismSpec
from pmjac_pin.values.arrays import Array
from pmjac_pin.values.checks import as_numbers
from pmjac_pin.values.named_values import named_values

MotorValues: TypeAlias = ArrayLike | Mapping[str, float]


def motor_values(spec: MechanismSpec, coordinates: JointCoordinates, actuated: Any) -> Array:
    """Return the motor values as an array (n,), or say what was expected.

    Parameters
    ----------
    spec, coordinates
        Which joints are motors, and all that there are.
    actuated : array_like, shape (n,), or mapping of str to float
        m or rad. What has names, as a mapping or a pandas Series, is taken by them; the rest in
        the motors' order.

    Raises
    ------
    UnknownNameError
        A name that is no motor's.
    ArgumentError
        Another number of values, a motor without a value, or values that are no finite numbers.
    """
    names = spec.actuated
    if (by_name := named_values(actuated, "motor values")) is not None:
        return _in_order(names, coordinates, by_name)
    values = np.atleast_1d(as_numbers(actuated, "motor values"))
    if values.shape != (len(names),):
        got = str(values.size) if values.ndim == 1 else f"shape {values.shape}"
        plural = "s" * (len(names) != 1)
        wanted = f"{len(names)} motor value{plural} ({', '.join(names)})"
        raise ArgumentError(f"{wanted} expected, got {got}")
    return values


def _in_order(
    names: tuple[str, ...], coordinates: JointCoordinates, by_name: dict[Any, Any]
) -> Array:
    for name in by_name:
        if name not in names:
            if name in coordinates.names:
                message = f"joint {name!r} is passive; motors are: {', '.join(names)}"
                raise ArgumentError(message)
            raise unknown_name("motor", name, names)
    if missing := [name for name in names if name not in by_name]:
        plural = "s" * (len(missing) > 1)
        raise ArgumentError(f"no value is given for motor{plural} {', '.join(map(repr, missing))}")
    return np.array([_one(name, by_name[name]) for name in names], dtype=float)


def _one(name: str, given: Any) -> float:
    value = as_numbers(given, f"the value of motor {name!r}")
    if value.size != 1:
        raise ArgumentError(f"motor {name!r} takes 1 value, got {value.size}")
    return float(value.reshape(()))
