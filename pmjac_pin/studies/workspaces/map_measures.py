"""What a map of a workspace may be coloured by, at each closed pose."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import MappingProxyType

import numpy as np

from pmjac_pin.batches.results import ManyMeasures
from pmjac_pin.errors import unknown_name
from pmjac_pin.values.arrays import Array


def _tool_radii(found: ManyMeasures, rows: int) -> tuple[Array, Array]:
    """Return the largest and the smallest singular value of J_eq's linear rows."""
    return found.velocity_radii[:, 0], found.velocity_radii[:, rows - 1]


def _share(least: Array, most: Array) -> Array:
    found = np.full(least.shape, np.nan)
    np.divide(least, most, out=found, where=most > 0.0)
    return found


def _dexterity(found: ManyMeasures, rows: int) -> Array:
    most, least = _tool_radii(found, rows)
    return _share(least, most)


def _force(found: ManyMeasures, rows: int) -> Array:
    most, _ = _tool_radii(found, rows)
    return _share(np.ones(most.shape), most)


def _closeness(found: ManyMeasures, _: int) -> Array:
    return _share(np.ones(found.condition.shape), found.condition)


#: (measures of N poses, in how many ways the tool's point moves) ↦ (N,), by name: K*'s smallest
#: singular value and 1/condition, dimensionless; min/max of the tool's speeds by unit motor rates,
#: 0 to 1; the slowest and the fastest of them, m per unit of the motors; the least force that unit
#: motor efforts bear in all directions, N per unit.
MAP_MEASURES: Mapping[str, Callable[[ManyMeasures, int], Array]] = MappingProxyType(
    {
        "smallest singular value": lambda found, _: found.smallest,
        "conditioning": _closeness,
        "dexterity": _dexterity,
        "gear ratio": lambda found, rows: _tool_radii(found, rows)[1],
        "speed": lambda found, rows: _tool_radii(found, rows)[0],
        "force": _force,
    }
)


def checked_measure(name: object) -> str:
    """Return the name of a measure.

    Raises
    ------
    UnknownNameError
    """
    if not isinstance(name, str) or name not in MAP_MEASURES:
        raise unknown_name("measure", str(name), tuple(MAP_MEASURES))
    return name
