"""Certificate: a proof that a pose which closes the loops exactly is near a computed one.

Krawczyk's test with an approximate inverse; `docs/certificates.md` has the proof.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from weakref import WeakKeyDictionary

import numpy as np

from pmjac_pin.algebra.balls import OUTWARDS, precise, uppers
from pmjac_pin.configuration import Configuration
from pmjac_pin.errors import ArgumentError
from pmjac_pin.mechanism import Mechanism
from pmjac_pin.rates.partition import Partition, independent_rows
from pmjac_pin.studies.certificates.equations import LoopEquations
from pmjac_pin.studies.evidence import Evidence
from pmjac_pin.studies.krawczyk import RADII, block_norms, radii
from pmjac_pin.values.arrays import Array, Index
from pmjac_pin.values.checks import check_kind

# Those of a mechanism are written once, for all its poses.
_EQUATIONS: WeakKeyDictionary[Mechanism, LoopEquations] = WeakKeyDictionary()


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
    left_out: tuple[str, ...] = ()
    left_out_gap: float = 0.0
    held: tuple[str, ...] = ()

    def __bool__(self) -> bool:
        return not self.failed

    @property
    def evidence(self) -> Evidence:
        """What is proven."""
        if self.failed:
            return Evidence("nothing", self.failed)
        parts = [
            f"an exact solution exists within {self.existence_radius:.2g} rad, "
            f"the only one within {self.uniqueness_radius:.2g} rad"
        ]
        if self.held:
            parts.append(f"with {', '.join(self.held)} held")
        if self.left_out:
            rows = f"{len(self.left_out)} dependent row" + "s" * (len(self.left_out) > 1)
            parts.append(f"of all rows but {rows}, which it solves to {self.left_out_gap:.2g} m")
        return Evidence("proof", "; ".join(parts))


def certify(configuration: Configuration) -> Certificate:
    """Return a proof that an exact solution of the loop equations is near this pose.

    By Krawczyk's test, the motors held at exactly these values: with Newton's step Y = |A η| by
    an approximate inverse A of K*, and M(r) a bound on ‖I − A K*‖ at poses up to r away, in the
    mean along every way there,

        Y + M(r) r < r.

    All of it by arithmetic of balls and boxes that rounds outwards, from q and the model's
    numbers; it covers every mechanism whose placements differ from the model's by a few units
    in the last place.

    Parameters
    ----------
    configuration : Configuration

    Returns
    -------
    Certificate
        False where nothing is proven; `failed` then names the inequality.

    References
    ----------
    Krawczyk, *Newton-Algorithmen zur Bestimmung von Nullstellen mit Fehlerschranken*, Computing
    4, 1969; Rump, *Verification methods*, Acta Numerica 19, 2010.

    Examples
    --------
    >>> import pmjac_pin as pj
    >>> certificate = pj.certify(pj.load("three_rps").pose("lecture_a"))
    >>> bool(certificate), certificate.existence_radius < 1e-11
    (True, True)
    >>> certificate.uniqueness_radius > 0.001
    True
    """
    check_kind(configuration, Configuration)
    mechanism = configuration.mechanism
    try:
        equations = _equations(mechanism)
    except ArgumentError as error:
        return _no_certificate(str(error))
    names, partition = mechanism.rows, configuration.problem.partition
    # Where A is beyond all bounds, so are Y and Z₁, and nothing is proven.
    with precise(), np.errstate(over="ignore", invalid="ignore"):
        return _certified(equations, configuration.q, partition, names)


def _equations(mechanism: Mechanism) -> LoopEquations:
    equations = _EQUATIONS.get(mechanism)
    if equations is None:
        passive = mechanism.problem.partition.passive.tolist()
        model, loops = mechanism.kinematics.model, mechanism.spec.loops
        with precise():  # or they would be as sharp as the process happens to be
            equations = LoopEquations(model, loops, mechanism.parameters, passive)
        _EQUATIONS[mechanism] = equations
    return equations


def _no_certificate(reason: str) -> Certificate:
    return Certificate(math.inf, 0.0, reason)


def _certified(
    equations: LoopEquations, q: Array, partition: Partition, row_names: Sequence[str]
) -> Certificate:
    at = equations.at(q)
    residual, around = equations.residual(at, q), equations.around(at, RADII, partition.length)
    scaled = around.jacobian.middle[0] * partition.row_scale[:, None]
    rows, columns = independent_square(scaled, partition.passive_rank)
    groups = equations.unknowns.groups
    found = radii(residual[rows], around.jacobian[:, rows], columns, groups)
    if found.failed:
        return _no_certificate(found.failed)
    if not around.cosine[found.ball] > 0.0:
        return _no_certificate(
            "axes of a loop must be less than a quarter turn apart, for its rows vanish at half "
            f"a turn, too: the cosine between them may be {around.cosine[found.ball]:.3g}"
        )
    others, free = others_of(len(residual), rows), others_of(len(partition.passive), columns)
    slopes = around.jacobian[found.ball, others][:, columns].magnitude
    steps = block_norms(slopes, np.eye(len(others)), groups[:, columns]).sum(axis=1)
    gaps = (uppers(residual[others]) + steps * found.existence) * partition.row_scale[others]
    return Certificate(
        found.existence,
        found.uniqueness,
        left_out=tuple(row_names[k] for k in others.tolist()),
        left_out_gap=float(OUTWARDS * gaps.max(initial=0.0)),
        held=tuple(partition.passive_names[k] for k in free.tolist()),
    )


def independent_square(scaled: Array, rank: int) -> tuple[Index, Index]:
    """Return rows and columns of a square system of this rank."""
    rows = independent_rows(scaled, rank)
    return rows, independent_rows(scaled[rows].T, rank)


def others_of(count: int, taken: Index) -> Index:
    """Return those of so many that are not taken."""
    return np.flatnonzero(np.bincount(taken, minlength=count) == 0)
