"""Geared and held joints of MJCF: <joint> and <tendon> of <equality>.

MuJoCo's equation is y − y₀ = a₀ + a₁ (x − x₀) + a₂ (x − x₀)² + ..., with y the first joint's value
or the first tendon's length, x the second's, and y₀, x₀ those at qpos0. The length of a fixed
tendon is a weighted sum of joint values (MuJoCo, XML reference, equality/joint, equality/tendon
and tendon/fixed).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from pmjac_pin.errors import ModelFileError, quoted
from pmjac_pin.files.mjcf.joints import SCALAR, MjcfJoint
from pmjac_pin.files.mjcf.mujoco import Compiled
from pmjac_pin.model.loop_spec import JointLoop

_ON_A_JOINT = 1  # of mujoco.mjtWrap
_COEFFICIENTS = 5


@dataclass(frozen=True)
class Equation:
    """A weighted sum of how far joints are from their `ref`, and what it is held at.

    Attributes
    ----------
    where : str
    weights : mapping of str to float
        By the joints' names; none of them zero.
    value : float
    """

    where: str
    weights: Mapping[str, float]
    value: float


def equations(
    compiled: Compiled, active: Mapping[str, Sequence[int]], joints: Sequence[str]
) -> list[Equation]:
    """Return the equations of <joint> and <tendon> constraints.

    Parameters
    ----------
    compiled : Compiled
    active : mapping of str to sequence of int
        The numbers of those that hold, under "joint" and "tendon".
    joints : sequence of str
        The joints' names by MuJoCo's numbers.

    Raises
    ------
    ModelFileError
        One that is not linear, or of tendons along other things than joints.
    """

    def joint(_: str, number: int) -> dict[str, float]:
        return {joints[number]: 1.0}

    def tendon(where: str, number: int) -> dict[str, float]:
        return _weights(where, compiled.model, number, joints)

    return [
        _equation(compiled, number, side)
        for kind, side in (("joint", joint), ("tendon", tendon))
        for number in active[kind]
    ]


def _equation(
    compiled: Compiled, number: int, side: Callable[[str, int], dict[str, float]]
) -> Equation:
    model, where = compiled.model, compiled.equalities[number]
    constant, factor, *higher = polynomial = model.eq_data[number, :_COEFFICIENTS].tolist()
    first, second = int(model.eq_obj1id[number]), int(model.eq_obj2id[number])
    weights = side(where, first)
    if second >= 0 and any(polynomial[1:]):
        if any(higher):
            terms = " ".join(f"{value:g}" for value in polynomial)
            todo = "only a linear one is read (the last three 0)"
            raise ModelFileError(f"{where}: `polycoef` is '{terms}'; {todo}")
        if first == second:
            raise ModelFileError(f"{where} joins one thing to itself")
        for name, weight in side(where, second).items():
            weights[name] = weights.get(name, 0.0) - factor * weight
    return Equation(where, {name: weight for name, weight in weights.items() if weight}, constant)


def _weights(where: str, model: Any, tendon: int, joints: Sequence[str]) -> dict[str, float]:
    start, count = int(model.tendon_adr[tendon]), int(model.tendon_num[tendon])
    weights: dict[str, float] = {}
    for wrap in reversed(range(start, start + count)):  # the last joint follows the others
        if model.wrap_type[wrap] != _ON_A_JOINT:
            todo = 'set active="false" to leave it out'
            known = "a <fixed> one of joints, and one from a site straight to another, are read"
            raise ModelFileError(f"{where}: of tendons {known}; {todo}")
        name = joints[model.wrap_objid[wrap]]
        weights[name] = weights.get(name, 0.0) + float(model.wrap_prm[wrap])
    return weights


def read_couplings(
    equations: Sequence[Equation], joints: Mapping[str, MjcfJoint]
) -> tuple[list[JointLoop], dict[str, float]]:
    """Return the loops that gear two joints, and the values at which single joints are held.

    Raises
    ------
    ModelFileError
        An equation of no joint, of more than two, or of joints with several degrees of freedom;
        or a joint that is held and geared.
    """
    loops: list[JointLoop] = []
    held: dict[str, float] = {}
    for equation in equations:
        for name in equation.weights:
            if joints[name].kind not in SCALAR:
                what = f"joint {quoted(name)} is of type {joints[name].kind}"
                raise ModelFileError(f"{equation.where}: {what}; hinges and slides can be geared")
        match len(equation.weights):
            case 1:
                _hold(equation, joints, held)
            case 2:
                loops.append(_geared(equation, joints))
            case count:
                what = f"ties {count} joints; one or two can be tied"
                raise ModelFileError(f'{equation.where} {what}; set active="false" to leave it out')
    for loop in loops:
        for name in loop.joints:
            if name in held:
                todo = "remove one of the two constraints"
                raise ModelFileError(f"joint {quoted(name)} is geared and held; {todo}")
    return loops, held


def _hold(equation: Equation, joints: Mapping[str, MjcfJoint], held: dict[str, float]) -> None:
    ((name, weight),) = equation.weights.items()
    if name in held:
        what = "the joint is held by another constraint already"
        raise ModelFileError(f"{equation.where}: {what}")
    held[name] = joints[name].reference + equation.value / weight


def _geared(equation: Equation, joints: Mapping[str, MjcfJoint]) -> JointLoop:
    """Return the loop in which the joint that was named first follows the other."""
    (follower, weight), (driver, other) = equation.weights.items()
    ratio = -other / weight
    offset = equation.value / weight - ratio * joints[driver].reference
    return JointLoop(
        joints=(driver, follower), ratio=ratio, offset=joints[follower].reference + offset
    )
