"""Sound rows: of many poses that are given, those that a single call would take.

One bad pose among a million must not cost the others: rows of no finite numbers, or with turns that
are not of unit length, are said to be INVALID, and another pose stands in for them.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property
from typing import Any

import numpy as np

from pmjac_pin.batches.pieces import Piece
from pmjac_pin.batches.results import Status, Statuses, say_nothing
from pmjac_pin.errors import ArgumentError
from pmjac_pin.mechanism import Mechanism
from pmjac_pin.model.unit_turns import UnitRows
from pmjac_pin.values.arrays import Array, Mask
from pmjac_pin.values.checks import LARGEST, are_doubles, real_numbers, within


def rows_of_q(given: Any, nq: int) -> Array:
    """Return q as rows (N, nq); what numbers they hold is looked at piece by piece.

    Raises
    ------
    ArgumentError
        Another shape, or no real numbers.
    """
    rows = given if are_doubles(given) else real_numbers(given, "q")
    if rows.ndim != 2 or rows.shape[1] != nq:
        raise ArgumentError(f"q of shape (N, {nq}) expected, got {rows.shape}")
    return rows


class SoundRows:
    """Looks at rows that are given for one mechanism.

    Parameters
    ----------
    mechanism : Mechanism
    """

    def __init__(self, mechanism: Mechanism) -> None:
        self._mechanism = mechanism

    def of_poses(self, q: Array) -> tuple[Array, Mask | None]:
        """Return rows of q (N, nq), their turns of unit length, and which are none; None: all are.

        Home stands in for them.
        """
        bad = _no_numbers(q)
        if bad is not None:
            q = np.where(bad[:, None], self._mechanism.home.q, q)
        q, no_turns = self._unit_rows.sound(q)
        if no_turns is not None:
            q[no_turns] = self._mechanism.home.q
            bad = no_turns if bad is None else bad | no_turns
        return q, bad

    def fill(self, work: Callable[..., object], piece: Piece, q: Array, *found: Any) -> None:
        """Do work at poses, ``work(piece, q, *found)``, of which some may be no q; say of which."""
        rows, bad = self.of_poses(q)
        work(piece, rows, *found)
        if bad is not None:
            say_nothing(found, bad, Status.INVALID)

    def of_paths(
        self, start: Array, values: Array, is_open: Callable[[Array], Mask]
    ) -> tuple[Array, Array, Statuses | None]:
        """Return rows of q (N, nq) and motor values (N, n), and why paths are none: as a status.

        Where one is none, it goes nowhere, from home if its start is none.

        Parameters
        ----------
        start, values : ndarray, shapes (N, nq) and (N, n)
        is_open : callable
            Tells where loops are open.
        """
        start, bad = self.of_poses(start)
        opened = is_open(start)
        if bad is None and not opened.any():
            return self.of_targets(start, values)
        start = np.where(opened[:, None], self._mechanism.home.q, start)
        why = np.where(opened, Status.OPEN, Status.CLOSED).astype(np.int8)
        why[[] if bad is None else bad] = Status.INVALID
        return self.of_targets(start, values, why)

    def of_targets(
        self, start: Array, values: Array, why: Statuses | None = None
    ) -> tuple[Array, Array, Statuses | None]:
        """Return the same of closed q.

        Parameters
        ----------
        start, values : ndarray, shapes (N, nq) and (N, n)
        why : ndarray of int, shape (N,), optional
            Why some are none; more are written into it.
        """
        if (bad := _no_numbers(values)) is not None:
            why = np.zeros(len(values), dtype=np.int8) if why is None else why
            why[bad] = Status.INVALID
        if why is None:
            return start, values, None
        motors = self._mechanism.problem.partition.actuated
        at_rest = self._mechanism.coordinates.values_of(start, motors)
        return start, np.where(why[:, None] != Status.CLOSED, at_rest, values), why

    @cached_property
    def _unit_rows(self) -> UnitRows:
        return UnitRows(self._mechanism.kinematics.model)


def _no_numbers(rows: Array) -> Mask | None:
    """Tell which rows hold what is no number, or beyond those that are computed with."""
    if within(rows, (-LARGEST, LARGEST)):
        return None
    return np.asarray(~(np.abs(rows) <= LARGEST).all(axis=1))
