"""Legs: chains that do no more than hold two points at a distance, with their motors locked.

A leg begins at a body with a ball, or with a universal joint: two hinges whose axes cross at
right angles. Then come motors only, and a point loop ends it. With the motors locked, the point
can be anywhere at its distance from the centre of the ball, if it lies square to the second
hinge; so for a search the leg is a rod. Six legs less of a Gough platform are twelve unknowns
less.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from pmjac_pin.mechanism import Mechanism
from pmjac_pin.model.frames import Frame, find_frame
from pmjac_pin.model.linkage import Edge, edges_of
from pmjac_pin.model.loop_spec import JointLoop, Loop, PointLoop
from pmjac_pin.values.arrays import Array

_SQUARE = 1e-9  # of the characteristic length, or the sine of an angle


@dataclass(frozen=True, slots=True, eq=False)
class Leg:
    """A chain that is a rod.

    Attributes
    ----------
    edges : tuple of Edge
        All of its joints, the last first.
    loop : Loop
        The point loop that ends it.
    frame : str
        The loop's other frame.
    body : int
        What the leg stands on.
    centre : ndarray, shape (3,)
        Of the ball, on that body.
    length : float
        From the centre to the end.
    """

    edges: tuple[Edge, ...]
    loop: Loop
    frame: str
    body: int
    centre: Array
    length: float


def find_legs(mechanism: Mechanism, q: Array) -> list[Leg]:
    """Return the mechanism's legs, with the motors as in q."""
    # First: where ranks are not known yet they are found then, with the same scratch data.
    length = mechanism.problem.partition.length
    model, data = mechanism.kinematics.model, mechanism.kinematics.placed(q)
    joints = {edge.child: edge for edge in edges_of(model).values()}
    lonely = _lonely_bodies(mechanism, joints)
    legs = []
    for loop in mechanism.spec.loops:
        if isinstance(loop, PointLoop):
            ends = [find_frame(model, name) for name in loop.frames]
            for end, other in ((ends[0], loop.frames[1]), (ends[1], loop.frames[0])):
                chain = _leg_chain(mechanism, joints, lonely, end.joint)
                if chain and (leg := _leg(mechanism, data, chain, end, length)):
                    legs.append(Leg(chain, loop, other, chain[-1].parent, *leg))
                    break
    return legs


def _lonely_bodies(mechanism: Mechanism, joints: dict[int, Edge]) -> set[int]:
    """Return the bodies that nothing but a chain of joints and one loop at its end holds."""
    model, spec = mechanism.kinematics.model, mechanism.spec
    tool = spec.tool.names
    uses = [find_frame(model, name).joint for name in tool]
    branches = [edge.parent for edge in joints.values()]
    ends: list[int] = []
    for loop in spec.loops:
        if isinstance(loop, JointLoop):
            uses += [model.getJointId(name) for name in loop.joints]
        else:
            ends += [find_frame(model, name).joint for name in loop.frames]
    return {
        body for body in joints if body not in uses and branches.count(body) + ends.count(body) <= 1
    }


def _leg_chain(
    mechanism: Mechanism, joints: dict[int, Edge], lonely: set[int], end: int
) -> tuple[Edge, ...] | None:
    """Return the joints from a leg's end up to its ball or universal joint, or None."""
    chain: list[Edge] = []
    hinges = 0
    body = end
    while body in lonely:
        edge = joints[body]
        chain.append(edge)
        if edge.name not in mechanism.spec.actuated:
            hinges += not edge.kind.ball
            if edge.kind.along or (edge.kind.ball and hinges):
                return None
            if edge.kind.ball or hinges == 2:
                return tuple(chain)
        elif hinges:
            return None
        body = edge.parent
    return None


def _leg(
    mechanism: Mechanism, data: pin.Data, chain: tuple[Edge, ...], end: Frame, length: float
) -> tuple[Array, float] | None:
    """Return the centre of a chain's ball or universal joint and its reach, if it is a leg."""
    tip = data.oMi[end.joint].act(end.placement.translation)
    places = [data.oMi[edge.child] * edge.after.inverse() for edge in chain]
    hinges = [
        (place.translation, place.rotation[:, 2])
        for place, edge in zip(places, chain, strict=True)
        if not edge.kind.ball and edge.name not in mechanism.spec.actuated
    ]
    if hinges:
        (second, b), (first, a) = hinges
        normal = np.cross(a, b)
        apart = first - second
        if abs(a @ b) > _SQUARE or abs(apart @ normal) > _SQUARE * length:
            return None
        centre = second + (apart @ b) * b
        if abs((tip - centre) @ b) > _SQUARE * length:
            return None
    else:
        centre = places[-1].translation
    reach = float(np.linalg.norm(tip - centre))
    stand = data.oMi[chain[-1].parent]
    return (stand.actInv(centre), reach) if reach > _SQUARE * length else None


def names_of(legs: Iterable[Leg]) -> list[str]:
    """Return the names of all joints in legs."""
    return [edge.name for leg in legs for edge in leg.edges]
