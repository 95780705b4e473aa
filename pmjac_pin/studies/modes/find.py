"""Finding the assembly modes: random starts, until what is found is known to be all."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from itertools import chain
from typing import TYPE_CHECKING

import numpy as np

from pmjac_pin.closing.closed import closed_point
from pmjac_pin.closing.motor_values import MotorValues, motor_values
from pmjac_pin.configuration import Configuration
from pmjac_pin.direct_kinematics import check_limits
from pmjac_pin.errors import ArgumentError
from pmjac_pin.mechanism import Mechanism
from pmjac_pin.rates.elimination import refuse_felt_idle_motion
from pmjac_pin.studies.evidence import Evidence
from pmjac_pin.studies.modes.aim import Aim
from pmjac_pin.studies.modes.assembly_modes import AssemblyModes
from pmjac_pin.studies.modes.closed_pose import closed_pose, generator, open_by, order
from pmjac_pin.studies.modes.mirror import mirror_images
from pmjac_pin.studies.modes.nearly_closed import rounded_gaps, with_rounded
from pmjac_pin.studies.modes.proof import prove
from pmjac_pin.studies.modes.random_search import RandomSearch
from pmjac_pin.studies.modes.recognition import Recognition
from pmjac_pin.studies.modes.same_machine import same_machines
from pmjac_pin.studies.modes.search_problem import home_with, search_problem
from pmjac_pin.studies.modes.settling import Census, HomotopyCensus, ProofCensus, missing, settled
from pmjac_pin.studies.modes.starts import StartSpace
from pmjac_pin.values.arrays import Array
from pmjac_pin.values.checks import as_flag, check_kind

if TYPE_CHECKING:
    from pmjac_pin.studies.homotopy.parameter_homotopy import ParameterHomotopy


_FIRST_STARTS = 512  # before a proof is tried; most modes are met among them

_Found = tuple[Configuration, float]
_Judged = tuple[list[_Found], Evidence | None, list[Array]]  # with what is known and not closed


def assembly_modes(
    mechanism: Mechanism,
    actuated: MotorValues,
    *,
    rng: np.random.Generator | int | None = None,
    limits: bool = True,
    unseen: float = 2e-3,
    confidence: float = 0.99,
    most_starts: int = 200_000,
    proof: bool = True,
    homotopy: ParameterHomotopy | None = None,
) -> AssemblyModes:
    """Find all closed poses at these motor values: the solutions of direct kinematics.

    Damped Newton from random starts, hundreds at once; then, where that is affordable, a proof
    by interval arithmetic that none is missing; where it is not, more starts, until the share
    of the start space that leads to poses not seen yet is bounded as asked for. Poses that
    differ by full turns, by the sign of a quaternion, by idle motions or by half a turn of a
    leg's universal joint are one; so are those in which only bodies that look the same are
    turned over, which `ways` counts.

    Parameters
    ----------
    mechanism : Mechanism
    actuated : array_like, shape (n,), or mapping of str to float
        Motor values, m or rad: in the order of `actuated`, or by name where they have names,
        as those of a pandas Series do.
    rng : numpy.random.Generator or int, optional
        For the starts; a seed makes a generator, and none takes one that differs every time. The
        modes do not depend on it, nor does their order, as long as all are found.
    limits : bool
        Keep within the joints' limits, passive ones too.
    unseen : float
        The share of the start space that may lead to modes not found.
    confidence : float
        Of this bound.
    most_starts : int
        Where the search gives up on the bound.
    proof : bool
        Try to prove by interval arithmetic that these are all: possible for up to about six
        unknown joints, in a fraction of a second.
    homotopy : ParameterHomotopy, optional
        Of this mechanism: where there is no proof, count all complex solutions, too.

    Returns
    -------
    AssemblyModes
        A sequence of Configurations; `evidence` says what it rests on that these are all.

    Raises
    ------
    ArgumentError, LimitError
    IdleMotionError
        The tool moves with all motors locked: there are no separate modes.

    Examples
    --------
    >>> import pmjac_pin as pj
    >>> modes = pj.assembly_modes(pj.load("four_bar"), [0.9], rng=0)
    >>> [round(float(mode.passive[0]), 4) for mode in modes]
    [-2.4793, 2.0236]
    >>> modes.evidence.kind
    'proof'
    """
    check_kind(mechanism, Mechanism)
    aim = Aim(unseen, confidence, most_starts, as_flag(proof, "proof"), homotopy)
    return find_modes(mechanism, actuated, generator(rng), as_flag(limits, "limits"), aim)


def find_modes(
    mechanism: Mechanism, actuated: MotorValues, rng: np.random.Generator, limits: bool, aim: Aim
) -> AssemblyModes:
    """Find the assembly modes; see `assembly_modes`."""
    values = motor_values(mechanism.spec, mechanism.coordinates, actuated)
    if limits:
        check_limits(mechanism, values)
    problem = search_problem(mechanism, home_with(mechanism, values))
    search = RandomSearch(problem, StartSpace.of(problem, limits), rng)
    search.run(_FIRST_STARTS)
    if not search.raised:
        _refuse_felt_idle_motion(mechanism)
    censuses = [one for one in _censuses(mechanism, values, limits, aim) if one.whole]

    def judged() -> tuple[list[Array], _Judged]:
        modes = search.modes()
        rows = [problem.with_legs(q) for q, _ in modes]
        closed = _closed_rows(mechanism, rows, [share for _, share in modes], limits)
        return rows, _with_census(mechanism, closed, censuses, limits)

    rows, (found, evidence, lost) = judged() if censuses else ([], ([], None, []))
    if evidence is None:
        search.until(aim)
        rows, (found, evidence, lost) = judged()
    near = (problem.with_legs(q) for q in search.near.q)
    told = evidence is not None and lost
    gaps = [] if told else rounded_gaps(mechanism, chain(rows, lost, near))
    if evidence is None:
        evidence = search.evidence(aim)
        evidence = evidence if gaps else _without_open(mechanism, [*rows, *lost], evidence)
    if gaps:
        evidence = with_rounded(mechanism, gaps, evidence)
    return _distinct_modes(mechanism, found, search.starts, evidence)


def _without_open(
    mechanism: Mechanism, rows: list[Array], evidence: Evidence, which: str = "more"
) -> Evidence:
    """Say which poses are known, do not close to the tolerance and are left out."""
    gaps = list(filter(None, (open_by(mechanism, q) for q in rows)))
    if not gaps:
        return evidence
    least = f"the tolerance of {mechanism.tolerance:.2g} m"
    miss = f"misses {least} and is" if len(gaps) == 1 else f"miss {least} and are"
    left_out = f"{len(gaps)} {which}, open by {max(gaps):.2g} m at most, {miss} left out"
    return replace(evidence, statement=f"{evidence.statement}; {left_out}")


def _distinct_modes(
    mechanism: Mechanism, found: list[_Found], starts: int, evidence: Evidence
) -> AssemblyModes:
    """Return the poses found as modes, those that are the same machine as one."""
    groups = same_machines(mechanism, [configuration for configuration, _ in found])
    ways = [[found[index] for index in group] for group in groups]
    ways.sort(key=lambda group: order(group[0][0], mechanism.problem.partition.length))
    poses = tuple(tuple(configuration for configuration, _ in group) for group in ways)
    modes = tuple(group[0] for group in poses)
    if len(modes) < len(found):
        statement = f"{evidence.statement}; {len(found)} poses are {len(modes)} modes"
        evidence = replace(evidence, statement=f"{statement}, with bodies turned over unseen")
    return AssemblyModes(
        configurations=modes,
        shares=tuple(sum(share for _, share in group) for group in ways),
        starts=starts,
        evidence=evidence,
        mirror_images=mirror_images(mechanism, modes),
        poses=poses,
    )


def _censuses(mechanism: Mechanism, values: Array, limits: bool, aim: Aim) -> Iterator[Census]:
    """Yield what tells all modes, as far as it was asked for; the proof first."""
    if aim.proof:
        yield ProofCensus(mechanism, prove(mechanism, values, limits=limits))
    if aim.homotopy is not None:
        if getattr(aim.homotopy, "mechanism", None) != mechanism:
            raise ArgumentError("homotopy is that of another mechanism, or none at all")
        yield HomotopyCensus(mechanism, aim.homotopy.at(values), limits)


def _with_census(
    mechanism: Mechanism, found: list[_Found], censuses: list[Census], limits: bool
) -> _Judged:
    """Return the modes found with those that a census adds, and whether one says these are all.

    At last what a census has and cannot be closed: then it does not tell all, but how many.
    """
    lost: list[Array] = []
    for census in censuses:
        met = missing(census, [one for one, _ in found])
        more = found + _closed_rows(mechanism, met, [0.0] * len(met), limits)
        modes = [one for one, _ in more]
        if (evidence := settled(census, modes)) is not None:
            return more, evidence, []
        lost = [q for q in missing(census, modes) if open_by(mechanism, q)]
        if (evidence := settled(census, modes, but=len(lost))) is not None:
            told = Evidence("nothing", evidence.statement)
            return more, _without_open(mechanism, lost, told, "of them"), lost
    return found, None, lost


def _closed_rows(
    mechanism: Mechanism, rows: list[Array], shares: list[float], limits: bool
) -> list[_Found]:
    """Return the rows that Pinocchio closes within limits, each with its share of the starts."""
    pairs = [
        (closed_pose(mechanism, q, limits), share) for q, share in zip(rows, shares, strict=True)
    ]
    found = [(configuration, share) for configuration, share in pairs if configuration is not None]
    # Beside a singularity, Pinocchio's Newton may lead two of the search's poses to one.
    recognition = Recognition([configuration for configuration, _ in found])
    shared: dict[int, float] = {}
    for configuration, share in found:
        first = recognition.index(configuration)
        if first is not None:
            shared[first] = shared.get(first, 0.0) + share
    return [(found[index][0], share) for index, share in shared.items()]


def _refuse_felt_idle_motion(mechanism: Mechanism) -> None:
    """Raise IdleMotionError where the tool moves with all motors locked, as at home."""
    partition = mechanism.problem.partition
    factors = closed_point(mechanism.problem, mechanism.home.q).factors
    if partition.isolated:  # to first order alone the tool moves, and perhaps no farther
        return
    if factors.rank == partition.passive_rank < partition.passive.size:
        tool_jacobian = mechanism.kinematics.snapshot(mechanism.home.q).tool_jacobian
        refuse_felt_idle_motion(factors, tool_jacobian, partition)
