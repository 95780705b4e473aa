"""What has ranks at one closed pose, each of its matrices factorised once: loops and tool."""

from __future__ import annotations

from dataclasses import dataclass

from pmjac_pin.rates.factorisation import Factorisation
from pmjac_pin.rates.tool_motion import CommandedMotion
from pmjac_pin.values.arrays import Array, Index
from pmjac_pin.values.found_once import found_once


@dataclass(frozen=True, eq=False)
class PoseRanks:
    """[K K*], K* and the tool's motion at one pose, as a partition judges them.

    Attributes
    ----------
    scaled : ndarray, shape (p, nv)
        [K K*] without dimension.
    passive : Factorisation
        Of K*.
    motion : CommandedMotion
        What motors do to the tool, with [K K*] factorised.
    """

    scaled: Array
    passive: Factorisation
    motion: CommandedMotion

    @found_once
    def ranks(self) -> tuple[int, int, int]:
        """The ranks of [K K*], of K* and of the tool's motion."""
        return self.motion.whole.rank, self.passive.rank, self.motion.seen_rank()

    def unfelt(self, columns: Index) -> int:
        """Return how many motions of these passive columns move no motor and no judged row."""
        free = self.passive.null_space
        return int(free.shape[1]) - self.motion.tool.felt_rank(free, columns)
