"""Rounded numbers: loops that stay open by a little because a model's numbers have few digits."""

from __future__ import annotations

import math


def wider_tolerance(gap: float, largest: float = math.inf) -> str:
    """Return which tolerance would let a gap count as closed: the next power of ten.

    Parameters
    ----------
    gap, largest : float
        What stays open, and the largest tolerance that the model may have, m.

    Examples
    --------
    >>> wider_tolerance(2.6e-8)
    'a `tolerance` of 1e-07 where numbers are rounded'
    """
    enough = min(float(10.0 ** math.ceil(math.log10(gap))), largest)
    return f"a `tolerance` of {enough:.3g} where numbers are rounded"
