"""Evidence: what the answer of a study rests on, in the same words for all of them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal


@dataclass(frozen=True)
class Evidence:
    """What a statement rests on: `docs/evidence.md` has all of them.

    Attributes
    ----------
    kind : {"proof", "statistics", "tolerance", "nothing"}
        A proof: arithmetic of intervals or balls, rounded outwards. Statistics: right with a
        probability over random starts. A tolerance: floating-point numbers beside a threshold.
        Nothing: it may be so or not.
    statement : str
        What is known, or why nothing is, in one sentence.
    unseen : float or None
        Upper bound on the share of the start space that leads to modes not found, where random
        starts say so: of those that end, where the statement counts some that do not.
    confidence : float or None
        Probability that this bound holds.

    Examples
    --------
    >>> print(Evidence("tolerance", "all gaps are 1e-15 m at most"))
    tolerance: all gaps are 1e-15 m at most
    """

    kind: Literal["proof", "statistics", "tolerance", "nothing"]
    statement: str
    unseen: float | None = None
    confidence: float | None = None

    def __str__(self) -> str:
        return f"{self.kind}: {self.statement}"
