"""Certificate: a proof that a pose which closes the loops exactly is near a computed one.

The Newton–Kantorovich theorem with an approximate inverse; `docs/certificates.md` has the proof.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from pmjac_pin.algebra.balls import OUTWARDS, middles, precise, uppers
from pmjac_pin.configuration import Configuration
from pmjac_pin.errors import ArgumentError
from pmjac_pin.mechanism import Mechanism
from pmjac_pin.rates.partition import Partition, independent_rows
from pmjac_pin.studies.certificates.equations import LoopEquations
from pmjac_pin.studies.certificates.kantorovich import System, radii

Array = NDArray[np.float64]
Index = NDArray[np.intp]


# Those of a mechanism are written once, for all its poses.
_EQUATIONS: WeakKeyDictionary[Mechanism, LoopEquations] = WeakKeyDictionary()
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


def certify(configuration: Configuration) -> Certificate:
    """Return a proof that an exact solution of the loop equations is near this pose.

    By the Newton–Kantorovich theorem, the motors held at exactly these values: with
    Newton's step Y = |A η|, the defect Z₁ = ‖I − A K*‖ of an approximate inverse A of K*,
    and a bound Z₂ on ‖A D²η‖ from the lengths of the links,

        h = 2 Y Z₂ / (1 − Z₁)² < 1.

    All of it by interval arithmetic rounded outwards, from q and the model's numbers; it
    covers every mechanism whose placements differ from the model's by a few units in the
    last place.

    Parameters
    ----------
    configuration : Configuration

    Returns
    -------
    Certificate
        False where nothing is proven; `failed` then names the inequality.

    References
    ----------
    Kantorovich, *Functional analysis and applied mathematics*, 1948; Rump, *Verification
    methods*, Acta Numerica 19, 2010.

    Examples
    --------
    >>> import pmjac_pin as pj
    >>> certificate = pj.certify(pj.load("three_rps").pose("lecture_a"))
    >>> bool(certificate), certificate.existence_radius < 1e-11
    (True, True)
    >>> certificate.uniqueness_radius > 0.001
    True
    """
    if not isinstance(configuration, Configuration):
        raise ArgumentError(f"a Configuration is wanted, got {type(configuration).__name__}")
    mechanism = configuration.mechanism
    try:
        equations = _equations(mechanism)
    except ArgumentError as error:
        return _nothing(str(error))
    names, partition = mechanism.rows, mechanism.problem.partition
    # Where A is beyond all bounds, so are Y and Z₁, and nothing is proven.
    with precise(), np.errstate(over="ignore", invalid="ignore"):
        return _certified(equations, configuration.q, partition, names)


def _equations(mechanism: Mechanism) -> LoopEquations:
    if mechanism not in _EQUATIONS:
        passive = mechanism.problem.partition.passive.tolist()
        model, loops = mechanism.kinematics.model, mechanism.spec.loops
        equations = LoopEquations(model, loops, mechanism.parameters, passive)
        _EQUATIONS[mechanism] = equations
    return _EQUATIONS[mechanism]


def _nothing(reason: str) -> Certificate:
    return Certificate(math.inf, 0.0, reason)


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
        return _nothing(
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
