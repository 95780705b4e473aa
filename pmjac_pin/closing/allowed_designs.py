"""Which designs a file allows: parameters in their ranges, shapes and rods that have a size.

Of others, their own mechanism says what is wrong with them.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from pmjac_pin.closing.blueprint import Blueprint
from pmjac_pin.files.urdf.placed_numbers import sizes_of
from pmjac_pin.files.urdf.robot import size_coefficients
from pmjac_pin.model.loop_spec import JointLoop
from pmjac_pin.model.rows import Distance
from pmjac_pin.values.arrays import Array, Mask
from pmjac_pin.values.checks import LARGEST, SMALLEST


def allowed_designs(blueprint: Blueprint, names: Sequence[str], values: Array) -> Mask:
    """Tell which values (d, k) of parameters are allowed, others at their defaults."""
    spec = blueprint.spec
    allowed = np.ones(len(values), dtype=bool)
    for name, column in zip(names, values.T, strict=True):
        lower, upper = spec.parameters[name].range
        allowed &= (lower <= column) & (column <= upper) & (np.abs(column) < LARGEST)
    columns: dict[str, Any] = {**spec.parameter_values(), **dict(zip(names, values.T, strict=True))}
    sizes: dict[tuple[str, str], Array] = {
        key: np.array(size)[:, None] for key, size in sizes_of(blueprint.urdf).items()
    }
    for move, delta in spec.moves(columns):
        for attribute, coefficients in size_coefficients(move).items():
            key = move.visual or "", attribute
            sizes[key] = sizes[key] + np.outer(coefficients, delta)
    for size in sizes.values():
        allowed &= (size > 0.0).all(axis=0)
    for rod in _rod_lengths(blueprint, columns):
        allowed &= (rod >= SMALLEST) & (rod <= LARGEST)
    return allowed


def _rod_lengths(blueprint: Blueprint, values: Mapping[str, Any]) -> list[Array]:
    """Return the lengths of rods."""
    return [
        np.asarray(rows.length)
        for loop in blueprint.spec.loops
        if not isinstance(loop, JointLoop)
        for rows in loop.rows(values)
        if isinstance(rows, Distance)
    ]
