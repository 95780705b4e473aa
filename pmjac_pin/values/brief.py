"""A number in words, whose size alone matters."""

from __future__ import annotations

import math


def brief(value: float) -> str:
    """Write a number whose size alone matters: a residual, a tolerance."""
    return "∞" if value == math.inf else f"{value:.3g}"
