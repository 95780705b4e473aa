"""Rank bounds: what norms say for certain of K*, where no singular value is known.

1/‖K*⁻¹‖ is no more than the smallest singular value. Where that is above the rank tolerance of the
size of [K K*], K* has its rank; where it is not, nothing is said.
"""

from __future__ import annotations

import sys
from dataclasses import dataclass
from typing import Any

from pmjac_pin.rates.partition import Partition

_NOT_ZERO = sys.float_info.min  # times an infinite ‖K*⁻¹‖ it is infinite, too


@dataclass(frozen=True, slots=True)
class RankBounds:
    """The same for one pose, of floats, and for many, of arrays.

    Attributes
    ----------
    tolerance, least_size : float
        What counts as zero, of the size of [K K*], and the least that this counts as.
    share : float
        Of each bound: what is nearer to it is not certain.
    weakest : float
        Of the size: what singular value K* has to have, if more than what counts as zero.
    """

    tolerance: float
    least_size: float
    share: float = 1.0
    weakest: float = 0.0

    @classmethod
    def of(cls, partition: Partition, share: float = 1.0, weakest: float = 0.0) -> RankBounds:
        """Return those of a mechanism."""
        tolerance = partition.rank_tolerance
        return cls(tolerance, partition.least_size, share, max(weakest, tolerance))

    def regular(self, inverse: Any, size: Any) -> Any:
        """Tell where K* has its rank, by ‖K*⁻¹‖ and ‖[K K*]‖, dimensionless."""
        above = (self.weakest * size + _NOT_ZERO) * inverse < self.share
        return above & (self.tolerance * self.least_size * inverse < self.share)

    def follows(self, forbidden: Any, size: Any) -> Any:
        """Tell where K* can follow K, but for `forbidden`, dimensionless."""
        zero = self.share * self.tolerance
        return (forbidden <= zero * size) | (forbidden <= zero * self.least_size)
