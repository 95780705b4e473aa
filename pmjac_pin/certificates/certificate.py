"""Certificate: a proof that a pose which closes the loops exactly is near a computed one.

The Newton–Kantorovich theorem with an approximate inverse; `docs/certificates.md` has the proof.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pmjac_pin.certificates.equations import LoopEquations
from pmjac_pin.certificates.intervals import OUTWARDS, middles, precise, uppers
from pmjac_pin.certificates.kantorovich import System, radii
from pmjac_pin.partition import Partition, independent_rows

Array = NDArray[np.float64]
Index = NDArray[np.intp]


_HALF_A_TURN = 2.0  # the chord between an axis and itself turned over


@dataclass(frozen=True, slots=True)
class Certificate:
    """Whether an exact solution of the loop equations is proven to be near a computed pose.

    The motors are held at exactly their values. Distances are the largest change of any passive
    joint: an angle, or the length of a ball's rotation vector, in rad; a slide, or the length of
    a free body's translation, divided by the mechanism's characteristic length. True where the
    proof succeeded.

    Attributes
    ----------
    existence_radius : float
        A solution is no farther than this, rad; infinite where none is proven.
    uniqueness_radius : float
        No second solution is nearer than this, rad; zero where nothing is proven.
    failed : str
        The inequality that failed, with its numbers; empty where none did.
    kantorovich : float
        h = 2 Y Z₂ / (1 − Z₁)², which must be below 1; NaN where it was not reached.
    left_out : tuple of str
        Rows of the loop equations that depend on the others here. The proven solution solves
        the others exactly, and these to `left_out_gap`.
    left_out_gap : float
        In m, proven.
    held : tuple of str
        Passive degrees of freedom that the loops leave free: held as the motors are.
    """

    existence_radius: float
    uniqueness_radius: float
    failed: str = ""
    kantorovich: float = math.nan
    left_out: tuple[str, ...] = ()
    left_out_gap: float = 0.0
    held: tuple[str, ...] = ()

    def __bool__(self) -> bool:
        return not self.failed

    @property
    def statement(self) -> str:
        """What is proven, in one sentence."""
        if self.failed:
            return f"nothing is proven: {self.failed}"
        parts = [
            f"an exact solution exists within {self.existence_radius:.2g} rad, "
            f"the only one within {self.uniqueness_radius:.2g} rad"
        ]
        if self.held:
            parts.append(f"with {', '.join(self.held)} held")
        if self.left_out:
            rows = f"{len(self.left_out)} dependent row" + "s" * (len(self.left_out) > 1)
            parts.append(f"of all rows but {rows}, which it solves to {self.left_out_gap:.2g} m")
        return "; ".join(parts)


def refused(reason: str) -> Certificate:
    """Return the certificate that proves nothing."""
    return Certificate(math.inf, 0.0, reason)


def certify(
    equations: LoopEquations, q: Array, partition: Partition, row_names: Sequence[str]
) -> Certificate:
    """Return what can be proven of the loop equations near q, the motors held.

    Parameters
    ----------
    equations : LoopEquations
    q : ndarray, shape (nq,)
    partition : Partition
        Its generic rank says how many rows and unknowns make the square system.
    row_names : sequence of str
        One for each row.
    """
    # Where A is beyond all bounds, so are Y and Z₁, and nothing is proven.
    with precise(), np.errstate(over="ignore", invalid="ignore"):
        return _certified(equations, q, partition, row_names)


def _certified(
    equations: LoopEquations, q: Array, partition: Partition, row_names: Sequence[str]
) -> Certificate:
    blocks = equations.enclosed(q)
    system = equations.system(blocks, partition.length)
    scaled = middles(system.jacobian) * partition.row_scale[:, None]
    rows, columns = _independent(scaled, partition.passive_rank)
    found = radii(system.part(rows, columns))
    if found.failed:
        return Certificate(math.inf, 0.0, found.failed, found.number)
    away = max((block.away_within(found.existence) for block in blocks), default=0.0)
    if not away < _HALF_A_TURN:
        return refused(
            f"axes of a loop differ by a chord of up to {away:.3g}, which may be half a turn (2)"
        )
    others = np.setdiff1d(np.arange(len(row_names)), rows)
    rest = system.part(others, columns)
    return Certificate(
        found.existence,
        found.uniqueness,
        kantorovich=found.number,
        left_out=tuple(row_names[row] for row in others),
        left_out_gap=_gap(rest, partition.row_scale[others], found.existence),
        held=tuple(
            name for k, name in enumerate(partition.passive_names) if k not in columns.tolist()
        ),
    )


def _independent(scaled: Array, rank: int) -> tuple[Index, Index]:
    """Return rows and columns of a square system of this rank."""
    rows = independent_rows(scaled, rank)
    return rows, independent_rows(scaled[rows].T, rank)


def _gap(rest: System, row_scale: Array, radius: float) -> float:
    """Return how large rows may be at most, in m, within a radius of the pose."""
    if not rest.residual.size:
        return 0.0
    slopes = uppers(rest.jacobian)
    steps = [np.linalg.norm(slopes[:, list(group)], axis=1) for group in rest.groups]
    bend = [0.5 * rest.bends[block](radius) * radius**2 for block in rest.blocks.tolist()]
    gaps = uppers(rest.residual) + sum(steps) * radius + bend
    return float(OUTWARDS * (gaps * row_scale).max())
