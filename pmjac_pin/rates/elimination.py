"""Elimination of the passive rates: J_eq, or why there is none.

Linear algebra on plain arrays: it imports no Pinocchio and works on matrices from elsewhere.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np

from pmjac_pin.errors import ArgumentError, ForbiddenRatesError, IdleMotionError, SingularError
from pmjac_pin.rates.factorisation import REFINED, Factorisation
from pmjac_pin.rates.jacobian import EquivalentJacobian
from pmjac_pin.rates.partition import LoopRates, Partition
from pmjac_pin.rates.singularity import Singularity, analyse_singularity, forbidden_rates
from pmjac_pin.rates.split import SplitJacobian
from pmjac_pin.values.arrays import Array, norm, read_only
from pmjac_pin.values.brief import brief
from pmjac_pin.values.checks import check_callable, check_kind
from pmjac_pin.values.ties import first_largest

_STILL_JOINT = 1e-6  # of the largest rate of a motion


def equivalent_jacobian(
    split: SplitJacobian,
    singularity: Callable[[], Singularity] | None = None,
    *,
    loops: LoopRates | None = None,
) -> EquivalentJacobian:
    """Eliminate the passive rates: J_eq = J − J* K*⁻¹ K on all rows, by singular values.

    Parameters
    ----------
    split : SplitJacobian
        At a closed pose.
    singularity : callable, optional
        Returns the singularity there, for the error that says so: one that knows more than these
        matrices tell.
    loops : LoopRates, optional
        Of the constraint Jacobian, where these are known.

    Raises
    ------
    SingularError
        K* is below its generic rank, or no pose near home closes.
    ForbiddenRatesError
        The loops do not allow all motor rates.
    IdleMotionError
        A passive motion that no motor commands moves the tool.
    """
    check_kind(split, SplitJacobian)
    partition, constraint, J = split.partition, split.constraint_jacobian, split.tool_jacobian
    if np.isnan(J).any():
        raise ArgumentError("a tool Jacobian of numbers is needed: this one is of no tool")
    check_callable(singularity, "singularity")
    if loops is not None:
        check_kind(loops, LoopRates)
    here = singularity or partial(analyse_singularity, constraint, J, partition)
    rates, J_eq = eliminated(J, partition, loops or partition.loop_rates(constraint), here)
    return EquivalentJacobian(constraint, J, split.frame, partition, rates, J_eq, pose=split.pose)


def eliminated(
    J: Array, partition: Partition, loops: LoopRates, singularity: Callable[[], Singularity]
) -> tuple[Array, Array]:
    """Return Φ and J_eq of a tool Jacobian (6, nv), or raise as `equivalent_jacobian`."""
    actuated, passive = partition.actuated, partition.passive
    scaled, size, factors = loops.scaled, loops.size, loops.passive
    rank = factors.rank
    refuse_singular(loops, partition, singularity)
    if rank < len(scaled) and loops.not_followed > partition.rank_tolerance * size:
        _refuse_forbidden(factors, scaled, partition)
    if rank < passive.size:
        refuse_felt_idle_motion(factors, J, partition)
    rates = loops.following
    if not factors.surely_exceeds(REFINED * size):
        # Once again for what is left over: rounding of a weak row then stays in its own loop.
        # Where it is not needed it does no harm, and takes less than singular values.
        rates = rates + factors.solve(loops.driving - scaled.take(passive, axis=1) @ rates)
    rates = rates * partition.rate_scale
    return rates, J.take(actuated, axis=1) + J.take(passive, axis=1).dot(rates)


def refuse_singular(
    loops: LoopRates, partition: Partition, singularity: Callable[[], Singularity]
) -> None:
    """Raise SingularError where K* is below its generic rank, or no pose near home closes."""
    if loops.passive.rank < partition.passive_rank or partition.isolated:
        raise _singular(singularity())


def _singular(singularity: Singularity) -> SingularError:
    if singularity.isolated:
        return SingularError(
            "no pose near home closes: a structure, or a singular home, in whole or in part; rates "
            "that the loops seem to allow lead nowhere, and no J_eq exists",
            singular_value=singularity.smallest,
            tolerance=singularity.tolerance,
            free_motion={},
        )
    free = singularity.free_motion()
    moving = ", ".join(f"{name} {rate:+.3g}" for name, rate in free.items() if abs(rate) > 1e-3)
    message = (
        f"K* has rank {singularity.rank} here and {singularity.generic_rank} in general "
        f"(relative singular value {singularity.smallest:.3g}, tolerance "
        f"{singularity.tolerance:g}): with all motors locked, the passive motion "
        f"({moving}) is free and no J_eq exists"
    )
    return SingularError(
        message,
        singular_value=singularity.smallest,
        tolerance=singularity.tolerance,
        free_motion=free,
    )


def _moving_joints(names: tuple[str, ...], rates: Array) -> list[tuple[str, float]]:
    """Return the joints that take part in a motion: the others' rates are rounding."""
    floor = _STILL_JOINT * np.abs(rates).max()
    return [
        (name, rate) for name, rate in zip(names, rates.tolist(), strict=True) if abs(rate) > floor
    ]


def _refuse_forbidden(factors: Factorisation, scaled: Array, partition: Partition) -> None:
    forbidden = forbidden_rates(factors.left_null_space, scaled, partition)
    if not forbidden.shape[1]:
        return
    names = partition.actuated_names
    directions = "; ".join(
        ", ".join(f"{name} {rate:+.3g}" for name, rate in _moving_joints(names, column))
        for column in forbidden.T
    )
    motors = f"{len(names)} motor{'s are' if len(names) > 1 else ' is'}"
    tied = forbidden.shape[1] < len(names)
    raise ForbiddenRatesError(
        f"the loops forbid the motor rates ({directions}): {motors} too many for these loops; "
        f"make {forbidden.shape[1]} of them passive"
        + ", or ask allowed_jacobian() for the rates that fit each other"
        * tied,
        forbidden_rates=read_only(forbidden),
    )


def refuse_felt_idle_motion(
    factors: Factorisation, tool_jacobian: Array, partition: Partition
) -> None:
    """Raise IdleMotionError where the tool moves with the null space of K*."""
    scaled_tool = partition.scaled_tool(tool_jacobian)
    felt = scaled_tool[:, partition.passive] @ factors.null_space
    motions = partition.factorise(felt, norm(scaled_tool))
    if motions.rank == 0:
        return
    idle = partition.column_scale[partition.passive] * (factors.null_space @ motions.right[0])
    fastest = first_largest(idle)
    idle /= idle[fastest]
    twist = tool_jacobian[:, partition.passive] @ idle
    by = f"{brief(norm(twist[:3]))} m and {brief(norm(twist[3:]))} rad"
    joints = [name for name, _ in _moving_joints(partition.passive_names, idle)]
    moves = "moves" if len(joints) == 1 else "move"
    raise IdleMotionError(
        f"the tool is moved by a passive motion that no motor commands: {', '.join(joints)} "
        f"{moves} freely with all motors locked, which moves the tool by {by} for each unit of "
        f"{partition.passive_names[fastest]}; make one of them actuated, or put the tool on a body "
        f"that stays at rest",
        idle_motion=dict(zip(partition.passive_names, map(float, idle), strict=True)),
    )
