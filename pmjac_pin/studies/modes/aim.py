"""Aim: when a search for assembly modes may end."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

from pmjac_pin.errors import ArgumentError, quoted
from pmjac_pin.values.checks import as_number

if TYPE_CHECKING:
    from pmjac_pin.studies.homotopy.parameter_homotopy import ParameterHomotopy


def _always() -> bool:
    return True


@dataclass(frozen=True)
class Aim:
    """When a search may end.

    Attributes
    ----------
    unseen : float
        The share of the start space that may lead to modes not found.
    confidence : float
        Of this bound.
    most_starts : int
        Where the search gives up on the bound.
    proof : bool
        Try to prove that what was found is all.
    homotopy : ParameterHomotopy or None
        Count all complex solutions, where there is no proof.
    wanted : callable
        Asked now and then; the search ends as soon as it returns False.
    """

    unseen: float
    confidence: float
    most_starts: int
    proof: bool = True
    homotopy: ParameterHomotopy | None = None
    wanted: Callable[[], bool] = _always

    def __post_init__(self) -> None:
        for name, value in (("unseen", self.unseen), ("confidence", self.confidence)):
            if not 0.0 < as_number(value, name) < 1.0:
                raise ArgumentError(f"{name} is a share between 0 and 1, got {quoted(value)}")
        if as_number(self.most_starts, "most_starts", math.inf) < 1:
            raise ArgumentError(f"most_starts must be positive, got {quoted(self.most_starts)}")
