"""Scales: what makes loop equations and joint rates comparable, wherever ranks are judged.

Rows are turned into metres of gap, columns into metres of motion. A joint that only gears tie to
the loops moves by its ratio as fast as the joint that it is geared to, and its natural rate is
that much larger: which of two geared joints is named first, and by N or 1/N, changes nothing.

A loop much smaller than the machine is measured by its own size, as if it were as large: else its
gap would count as closed, and its rows as rounding, beside those of the large ones.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from pmjac_pin.kinematics.loop_system import LoopSystem
from pmjac_pin.model.coupling import Coupling
from pmjac_pin.values.arrays import Array, Mask


def column_scale(
    loops: LoopSystem,
    rotational: Mask,
    length: float,
    sizes: Sequence[float],
    carrying: Mask | None = None,
) -> Array:
    """Return a natural rate of each column, shape (nv,): 1/length rad or 1 m, times its gears.

    A slide that is in a small loop moves by its size.

    Parameters
    ----------
    loops : LoopSystem
    rotational : ndarray of bool, shape (nv,)
        Which columns are rotations.
    length : float
        The mechanism's characteristic length, m.
    sizes : sequence of float
        Of each loop, m: `length`, or less where it is much smaller.
    carrying : ndarray of bool, shape (nv,), optional
        The columns that move the tool: the measure of gear trains that are in no loop.
    """
    scale = np.where(
        rotational, 1.0 / length, smallest_loops(loops, sizes, rotational.size, length) / length
    )
    known, waiting = np.zeros(rotational.size, dtype=bool), list(loops.couplings.values())
    for columns in loops.moving:
        known[columns] = True
    while waiting:
        number = next((k for k, item in enumerate(waiting) if known[item.columns].any()), None)
        if number is None:  # gear trains of their own
            columns = np.unique([item.columns for item in waiting])
            measures = columns[:0] if carrying is None else columns[carrying[columns]]
            known[measures if measures.size else columns[:1]] = True
        else:
            _pass_on(waiting.pop(number), scale, known)
    return scale


def smallest_loops(loops: LoopSystem, sizes: Sequence[float], count: int, length: float) -> Array:
    """Return the size, m, of the smallest loop that each column is in; `length` for one in none.

    That loop is what ends the slide: with a larger size, its rows would be all about the slide.
    """
    smallest = np.full(count, length)
    for columns, size in zip(loops.moving, sizes, strict=True):
        smallest[columns] = np.minimum(smallest[columns], size)
    return smallest


def _pass_on(coupling: Coupling, scale: Array, known: Mask) -> None:
    """Set the rate of the joint that is not known yet: q̇_second = ratio · q̇_first."""
    first, second = coupling.columns
    ratio = abs(coupling.ratio)
    if ratio > 0.0 and not known[second]:
        scale[second] = ratio * scale[first]
    elif ratio > 0.0 and not known[first]:
        scale[first] = scale[second] / ratio
    known[coupling.columns] = True


def row_scale(loops: LoopSystem, columns: Array, length: float, sizes: Sequence[float]) -> Array:
    """Return what turns each row into metres of gap, to first order, shape (p,).

    The gap of a small loop counts as that of one as large as the machine.

    Parameters
    ----------
    loops : LoopSystem
    columns : ndarray, shape (nv,)
        `column_scale`: the row of a coupling is measured by the motion that it allows.
    length : float
        The mechanism's characteristic length in m: a gap of one rad counts as that.
    sizes : sequence of float
        Of each loop, m: `length`, or less where it is much smaller.
    """
    scale = np.where(np.array(loops.row_units) == "rad", length, 1.0)
    for row, rod in loops.rods.items():
        scale[row] = 0.5 / rod  # d(distance²) = 2 distance d(distance)
    metric = np.array([unit != "rad" for unit in loops.row_units], dtype=bool)
    for rows, size in zip(loops.slices, sizes, strict=True):
        scale[rows][metric[rows]] *= length / size
    for row, coupling in loops.couplings.items():
        scale[row] = 1.0 / np.abs(coupling.gradient * columns).max()
    return scale
