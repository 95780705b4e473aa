"""Geared and held joints of MJCF: <joint> of <equality>.

MuJoCo's equation is y − y₀ = a₀ + a₁ (x − x₀) + a₂ (x − x₀)² + ..., with y the value of the first
joint, x that of the second, and y₀, x₀ their `ref` (MuJoCo, XML reference, equality/joint).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from xml.etree.ElementTree import Element

from pmjac_pin.errors import ModelFileError
from pmjac_pin.formats.mjcf_equality import called
from pmjac_pin.formats.mjcf_joints import SCALAR, MjcfJoint
from pmjac_pin.formats.mjcf_names import find_name
from pmjac_pin.loop_spec import JointLoop
from pmjac_pin.urdf_xml import numbers, shown

_IDENTITY = (0.0, 1.0, 0.0, 0.0, 0.0)


def read_couplings(
    equalities: Sequence[Element], joints: Mapping[str, MjcfJoint]
) -> tuple[list[JointLoop], dict[str, float]]:
    """Return the loops that gear two joints, and the values at which single joints are held.

    Raises
    ------
    ModelFileError
        A joint that does not exist or has several degrees of freedom, or an equation that is
        not linear.
    """
    loops: list[JointLoop] = []
    held: dict[str, float] = {}
    for element in equalities:
        if element.tag != "joint":
            continue
        where, follower = called(element), _joint(element, "joint1", joints)
        polynomial = _polynomial(where, element)
        if element.get("joint2") is None or not any(polynomial[1:]):
            if follower.name in held:
                raise ModelFileError(f"{where}: the joint is held by another constraint already")
            held[follower.name] = follower.reference + polynomial[0]
            continue
        loops.append(_geared(where, (_joint(element, "joint2", joints), follower), polynomial))
    for loop in loops:
        for name in loop.joints:
            if name in held:
                todo = "remove one of the two constraints"
                raise ModelFileError(f"joint {shown(name)} is geared and held; {todo}")
    return loops, held


def _geared(
    where: str, joints: tuple[MjcfJoint, MjcfJoint], polynomial: Sequence[float]
) -> JointLoop:
    driver, follower = joints
    if driver.name == follower.name:
        raise ModelFileError(f"{where} joins joint {shown(driver.name)} to itself")
    offset, ratio, *higher = polynomial
    if any(higher):
        terms = " ".join(f"{value:g}" for value in polynomial)
        todo = "only a linear one is read (the last three 0)"
        raise ModelFileError(f"{where}: `polycoef` is '{terms}'; {todo}")
    constant = follower.reference + offset - ratio * driver.reference
    return JointLoop(joints=(driver.name, follower.name), ratio=ratio, offset=constant)


def _joint(element: Element, key: str, joints: Mapping[str, MjcfJoint]) -> MjcfJoint:
    where = called(element)
    if not (name := element.get(key)):
        raise ModelFileError(f"{where} has no `{key}`")
    joint = joints[find_name(f"{where}: the joint", name, {known: known for known in joints})]
    if joint.kind not in SCALAR:
        what = f"joint {shown(name)} is of type {joint.kind}"
        raise ModelFileError(f"{where}: {what}; hinges and slides can be geared")
    return joint


def _polynomial(where: str, element: Element) -> list[float]:
    """Return the five coefficients; those that are not given are 0 1 0 0 0."""
    given = len(element.get("polycoef", "").split())
    if not 0 < given <= len(_IDENTITY):
        if given == 0:
            return list(_IDENTITY)
        raise ModelFileError(f"{where}: `polycoef` has {given} numbers; at most 5 are read")
    return [*numbers(where, element, "polycoef", count=given), *_IDENTITY[given:]]
