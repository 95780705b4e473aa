"""Proof: that all assembly modes at given motor values are known, by interval arithmetic.

Branch and prune leaves small boxes that hold every pose which counts as closed. Boxes that touch
are taken together, and Krawczyk's test shows that there is one mode near each.
"""

from __future__ import annotations

import time
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pmjac_pin.algebra.intervals import Intervals
from pmjac_pin.closing.motor_values import MotorValues, motor_values
from pmjac_pin.errors import ArgumentError
from pmjac_pin.mechanism import Mechanism
from pmjac_pin.studies.evidence import Evidence
from pmjac_pin.studies.modes.box_domain import NoBoxesError
from pmjac_pin.studies.modes.box_problem import BoxProblem, box_problem, given_values, start
from pmjac_pin.studies.modes.branch_and_prune import Budget, branch_and_prune
from pmjac_pin.studies.modes.enclosed_modes import Enclosure, enclose
from pmjac_pin.studies.modes.search_problem import home_with
from pmjac_pin.studies.modes.touching import moved_near, together
from pmjac_pin.values.arrays import Array
from pmjac_pin.values.checks import as_flag, as_numbers, check_kind

_MOST_BOXES = 1000  # small ones: more are a motion or a singularity, not modes


@dataclass(frozen=True, slots=True, eq=False)
class Proof:
    """What interval arithmetic proves about the assembly modes at given motor values.

    True where it is settled: every pose that counts as closed is in the neighbourhood of an
    enclosure, each of which holds exactly one root of its kept rows, where the other rows count as
    closed.

    Attributes
    ----------
    names : tuple of str
        The k unknowns: passive joints of one degree of freedom.
    enclosures : tuple of Enclosure
        Proven even where the whole is not settled.
    unsettled : Intervals, shape (u, k)
        Boxes that may hold further modes, or none.
    failed : str
        Why it is not settled; empty if it is.
    boxes : int
        How many were looked at.
    seconds : float
    q : ndarray, shape (n, nq)
        The modes as Pinocchio's configuration vectors, to rounding.
    endless : ndarray of bool, shape (k,)
        Which unknowns are the same after a full turn.
    """

    names: tuple[str, ...]
    enclosures: tuple[Enclosure, ...]
    unsettled: Intervals
    failed: str
    boxes: int
    seconds: float
    q: Array
    endless: NDArray[np.bool_]

    def __bool__(self) -> bool:
        return not self.failed

    @property
    def evidence(self) -> Evidence:
        """What it rests on that the enclosures are all modes."""
        if self.failed:
            return Evidence("nothing", self.failed)
        rest = "interval arithmetic over all values of the passive joints"
        exactly = f"exactly {len(self.enclosures)}, by {rest} ({self.boxes} boxes)"
        return Evidence("proof", exactly)

    def match(self, values: ArrayLike) -> tuple[int | None, ...]:
        """Return for each row of joint values the one enclosure whose mode it stands for.

        Parameters
        ----------
        values : array_like, shape (n, k)
            Of the joints `names`, rad or m.

        Returns
        -------
        tuple of (int or None)
            None for a row in no enclosure's neighbourhood, or in several.

        Raises
        ------
        ArgumentError
        """
        found: list[int | None] = []
        rows = np.atleast_2d(as_numbers(values, "values"))
        if rows.ndim != 2 or rows.shape[1] != len(self.names):
            wanted = f"{len(self.names)} a row, of {', '.join(self.names)}"
            raise ArgumentError(f"values must be {wanted}; got shape {rows.shape}")
        for row in rows:
            point = Intervals.exact(row)
            near = [
                index
                for index, one in enumerate(self.enclosures)
                if moved_near(point, one.around, self.endless).inside(one.around).all()
            ]
            found.append(near[0] if len(near) == 1 else None)
        return tuple(found)


def prove(
    mechanism: Mechanism,
    actuated: MotorValues,
    *,
    limits: bool = True,
    budget: Budget | None = None,
) -> Proof:
    """Prove how many assembly modes there are at these motor values, or say what is not settled.

    Parameters
    ----------
    mechanism : Mechanism
    actuated : array_like, shape (n,), or mapping of str to float
        Motor values, m or rad.
    limits : bool
        Keep within the passive joints' limits.
    budget : Budget, optional
        How many boxes and seconds it may take.

    Raises
    ------
    ArgumentError

    Examples
    --------
    >>> import pmjac_pin as pj
    >>> proof = pj.prove(pj.load("four_bar"), [0.9])
    >>> print(proof.evidence)
    proof: exactly 2, by interval arithmetic over all values of the passive joints (... boxes)
    >>> [enclosure.mode.middle.round(4).tolist() for enclosure in proof.enclosures]
    [[-2.4793, -2.2632], [2.0236, 0.0075]]
    """
    check_kind(mechanism, Mechanism)
    limits = as_flag(limits, "limits")
    budget = Budget() if budget is None else budget
    check_kind(budget, Budget)
    began = time.monotonic()
    values = motor_values(mechanism.spec, mechanism.coordinates, actuated)
    if not (mechanism.problem.partition.passive.size or mechanism.spec.loops):
        return _open_chain(mechanism, values)
    try:
        problem = box_problem(mechanism, given_values(mechanism, values), limits)
    except NoBoxesError as error:
        return _no_proof(mechanism, str(error))
    with np.errstate(over="ignore", invalid="ignore"):  # what is not a number excludes nothing
        pruned = branch_and_prune(problem.loops, problem.domain[None], problem.scale, budget)
        enclosures, unsettled, failed = _enclosed(problem, pruned.small)
    if len(pruned.unfinished.lower):
        failed = f"{len(pruned.unfinished.lower)} boxes were not looked at within the budget"
    base = home_with(mechanism, values)
    rows = [start(mechanism, problem, base, one.mode.middle) for one in enclosures]
    return Proof(
        names=problem.names,
        enclosures=enclosures,
        unsettled=Intervals.join([unsettled, pruned.unfinished]),
        failed=failed,
        boxes=pruned.boxes,
        seconds=time.monotonic() - began,
        q=np.array(rows).reshape(-1, base.size),
        endless=problem.endless,
    )


def _open_chain(mechanism: Mechanism, values: Array) -> Proof:
    """Return the proof that motors alone leave one pose, their own."""
    none, no_joint = Intervals.exact(np.zeros((0, 0))), Intervals.exact(np.zeros(0))
    q = home_with(mechanism, values)
    only = Enclosure(no_joint, no_joint, (), 0.0)
    return Proof((), (only,), none, "", 0, 0.0, q[None], np.zeros(0, dtype=bool))


def _no_proof(mechanism: Mechanism, failed: str) -> Proof:
    """Return the proof of nothing, where intervals do not apply."""
    none = Intervals.exact(np.zeros((0, 0)))
    q, endless = np.zeros((0, mechanism.nq)), np.zeros(0, dtype=bool)
    return Proof((), (), none, failed, 0, 0.0, q, endless)


def _enclosed(
    problem: BoxProblem, small: Intervals
) -> tuple[tuple[Enclosure, ...], Intervals, str]:
    """Return the enclosures of the modes in small boxes, the boxes that stay unsettled, and why."""
    if len(small.lower) > _MOST_BOXES:
        return (), small, f"{len(small.lower)} small boxes are left, as at a singularity"
    hulls = together(small, problem.endless, problem.scale)
    found: list[Enclosure] = []
    unsettled = [hulls[:0]]
    for index, one in enumerate(enclose(problem.loops, hulls, problem.scale)):
        if one is None or one.left_out > 1.0:
            unsettled.append(hulls[index : index + 1])
            continue
        if not one.mode.inside(problem.domain)[~problem.endless].all():
            unsettled.append(hulls[index : index + 1])
        elif not _known(one, hulls[index], found, problem):
            found.append(one)
    if _overlap(found, problem):
        return (), small, "enclosures of modes overlap"
    left = Intervals.join(unsettled)
    count = len(left.lower)
    boxes = "one box" if count == 1 else f"{count} boxes"
    failed = f"{boxes} may hold modes or none, as near a singularity" if count else ""
    return tuple(found), left, failed


def _known(one: Enclosure, box: Intervals, found: list[Enclosure], problem: BoxProblem) -> bool:
    """Tell whether a box is near a mode already known, where the same rows have only one root."""
    near = [other.around for other in found if other.kept == one.kept]
    if not near:
        return False
    whole, around = Intervals.stack([one.mode, box], 0)[:, None], Intervals.stack(near, 0)
    inside = moved_near(whole, around, problem.endless).inside(around)
    return bool(inside.all(axis=(0, 2)).any())


def _overlap(found: list[Enclosure], problem: BoxProblem) -> bool:
    if not found:
        return False
    modes = Intervals.stack([one.mode for one in found], 0)
    meet = moved_near(modes[:, None], modes, problem.endless).meets(modes).all(axis=2)
    return bool(np.tril(meet, -1).any())
