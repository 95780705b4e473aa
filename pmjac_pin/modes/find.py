"""Finding the assembly modes: random starts until the bound on what is missing is met."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pmjac_pin.closure import closed_point
from pmjac_pin.configuration import Configuration
from pmjac_pin.damped_closure import assemble
from pmjac_pin.direct_kinematics import check_limits, motor_values
from pmjac_pin.errors import ArgumentError
from pmjac_pin.jacobian import refuse_felt_idle_motion
from pmjac_pin.modes.assembly_modes import AssemblyModes, Completeness
from pmjac_pin.modes.distinct import Distinct, Signatures
from pmjac_pin.modes.mirror import mirror_images
from pmjac_pin.modes.proof import prove
from pmjac_pin.modes.search import ManyClosures, unseen_share
from pmjac_pin.modes.search_problem import SearchProblem, search_problem, with_legs
from pmjac_pin.modes.settling import missing, settled
from pmjac_pin.modes.starts import StartSpace
from pmjac_pin.parts import Parts
from pmjac_pin.pose_assembly import motor_weights

if TYPE_CHECKING:
    from pmjac_pin.mechanism import Mechanism

Array = NDArray[np.float64]

_BATCH = 2048
_MOST_MODES = 2000  # more is a motion, not a set of poses


def _always() -> bool:
    return True


@dataclass(frozen=True)
class Aim:
    """When a search may end.

    Attributes
    ----------
    unseen : float
        The share of the start space that may lead to modes not found.
    confidence : float
        Of this bound.
    most_starts : int
        Where the search gives up on the bound.
    proof : bool
        Try to prove that what was found is all.
    wanted : callable
        Asked now and then; the search ends as soon as it returns False.
    """

    unseen: float
    confidence: float
    most_starts: int
    proof: bool = True
    wanted: Callable[[], bool] = _always

    def __post_init__(self) -> None:
        for name, value in (("unseen", self.unseen), ("confidence", self.confidence)):
            if not 0.0 < value < 1.0:
                raise ArgumentError(f"{name} is a share between 0 and 1, got {value!r}")
        if self.most_starts < 1:
            raise ArgumentError(f"most_starts must be positive, got {self.most_starts!r}")


def find_modes(
    mechanism: Mechanism, actuated: ArrayLike, rng: np.random.Generator, limits: bool, aim: Aim
) -> AssemblyModes:
    """Find the assembly modes; see `Mechanism.assembly_modes`."""
    parts = mechanism._parts
    values = motor_values(parts, actuated)
    if limits:
        check_limits(parts, values)
    _refuse_felt_idle_motion(parts)
    base = parts.coordinates.with_values(parts.home_q, parts.problem.partition.actuated, values)
    problem, legs = search_problem(parts, base)
    met, starts, bound = _searched(problem, StartSpace.of(problem, limits), rng, aim)
    rows = [with_legs(parts, legs, problem, base, q) for q in met.q]
    found = _configurations(mechanism, rows, [hits / starts for hits in met.hits], limits)
    complete = _completeness(bound, aim, starts)
    if aim.proof:
        proof = prove(parts, values, limits)
        lost = proof.q[missing(parts, proof, [one for one, _ in found])] if proof.complete else ()
        if len(lost) and not legs:
            found += _configurations(mechanism, list(lost), [0.0] * len(lost), limits)
        complete = settled(parts, proof, [one for one, _ in found], complete)
    found.sort(key=lambda item: _order(item[0], parts.problem.partition.length))
    modes = tuple(configuration for configuration, _ in found)
    return AssemblyModes(
        configurations=modes,
        shares=tuple(share for _, share in found),
        starts=starts,
        complete=complete,
        mirror_images=mirror_images(parts, modes),
    )


def _configurations(
    mechanism: Mechanism, rows: list[Array], shares: list[float], limits: bool
) -> list[tuple[Configuration, float]]:
    """Return the rows that Pinocchio closes within limits, each with its share of the starts."""
    pairs = [
        (_configuration(mechanism, q, limits), share) for q, share in zip(rows, shares, strict=True)
    ]
    return [(configuration, share) for configuration, share in pairs if configuration is not None]


def _searched(
    problem: SearchProblem, space: StartSpace, rng: np.random.Generator, aim: Aim
) -> tuple[Distinct, int, float]:
    """Return the poses met, the number of starts, and the bound on the share not seen."""
    closures = ManyClosures(problem)
    first = closures.closed(space.draw(rng, _BATCH))
    met = Distinct(Signatures.of(problem, first))
    met.add(first)
    starts, in_a_row, question, bound = _BATCH, 0, 1, 1.0
    while starts < aim.most_starts and bound > aim.unseen and aim.wanted():
        starts += _BATCH
        if met.add(closures.closed(space.draw(rng, _BATCH))):
            in_a_row, question = 0, question + 1
        else:
            in_a_row += _BATCH
        if len(met.q) > _MOST_MODES:
            why = f"{_MOST_MODES} poses were met, as where the loops move with all motors locked"
            raise ArgumentError(f"there are no separate assembly modes here: {why}")
        bound = unseen_share(in_a_row, question, aim.confidence)
    return met, starts, bound


def _refuse_felt_idle_motion(parts: Parts) -> None:
    """Raise IdleMotionError where the tool moves with all motors locked, at every pose."""
    partition = parts.problem.partition
    factors = closed_point(parts.problem, parts.home_q).factors
    if factors.rank == partition.passive_rank < partition.passive.size:
        tool_jacobian = parts.kinematics.snapshot(parts.home_q).tool_jacobian
        refuse_felt_idle_motion(factors, tool_jacobian, partition)


def _configuration(mechanism: Mechanism, q: Array, limits: bool) -> Configuration | None:
    """Return the closed pose by Pinocchio's measure, None where it is none or beyond limits."""
    parts = mechanism._parts
    problem, coordinates = parts.problem, parts.coordinates
    closed = assemble(problem, q, motor_weights(problem, 0.0))
    if closed.gap > problem.tolerance:
        return None
    columns = problem.partition.passive
    q = coordinates.unwound(closed.q, columns, limits)
    if limits and coordinates.outside(coordinates.values(q)[columns], columns):
        return None
    return Configuration._of_q(mechanism, q)


def _order(configuration: Configuration, length: float) -> tuple[float, ...]:
    """Return what modes are sorted by: the tool's height first, highest first."""
    pose = configuration.tool_pose
    x, y, z = np.round(pose.translation / length, 6) + 0.0
    return (-z, x, y, *(np.round(pose.rotation.ravel(), 6) + 0.0))


def _completeness(bound: float, aim: Aim, starts: int) -> Completeness:
    if bound <= aim.unseen:
        statement = (
            f"statistics: with confidence {aim.confidence:g}, at most {bound:.2g} of the start "
            f"space leads to modes not found, after {starts} random starts"
        )
        return Completeness("statistics", statement, bound, aim.confidence)
    statement = (
        f"neither proof nor statistics: new modes were met among the last of {starts} random "
        f"starts; the share not seen is bounded by {bound:.2g} only"
    )
    return Completeness("neither", statement, bound, aim.confidence)


def generator(rng: np.random.Generator | int) -> np.random.Generator:
    """Return the generator, or the one that a seed makes."""
    try:
        return np.random.default_rng(rng)
    except (TypeError, ValueError):
        wanted = "a numpy Generator or a whole number ≥ 0"
        raise ArgumentError(f"rng is {wanted}, got {rng!r}") from None
