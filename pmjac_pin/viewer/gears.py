"""Gears: a wheel at each turning joint of a pair, and a line between the two."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from pmjac_pin.files.shapes import Cylinder
from pmjac_pin.model.loop_spec import JointLoop
from pmjac_pin.pictures.anatomy import Anatomy
from pmjac_pin.pictures.bodies import Point, PointsOfBodies
from pmjac_pin.values.arrays import Array
from pmjac_pin.viewer.items import Carried, Part, stretched_between
from pmjac_pin.viewer.layers import SPECK, Attached, Lines
from pmjac_pin.viewer.palette import GEAR, WHEEL

# Shares of the mechanism's size.
_BOTH = 0.2  # the radii of two wheels that do not touch, together
_SMALLEST_WHEEL = 0.02  # radius, of a ratio that is far from 1
_THICKNESS, _SPOKE, _BELT = 0.012, 0.006, 0.005
_PARALLEL_WHEELS = 1e-6


@dataclass(frozen=True, eq=False)
class _Pair:
    """Two geared joints: Pinocchio's indices, and the radii in m of their wheels."""

    number: int
    joints: tuple[int, int]
    radii: tuple[float, float]


def wheel_layer(anatomy: Anatomy) -> Attached:
    """Return a wheel with a spoke about the axis of each geared joint that turns.

    The radii are as the ratio. Wheels on parallel axes that turn against each other touch at home.
    """
    return Attached.of(piece for pair in _geared_pairs(anatomy) for piece in _wheels(anatomy, pair))


def belt_layer(anatomy: Anatomy) -> Lines:
    """Return the lines that tell which joints are geared."""
    pairs = list(_geared_pairs(anatomy))
    starts, ends = ([Point(pair.joints[end], np.zeros(3)) for pair in pairs] for end in (0, 1))
    return Lines(
        parts=[Part(f"gears/{pair.number}/belt", Cylinder(), GEAR) for pair in pairs],
        starts=PointsOfBodies.of(starts),
        ends=PointsOfBodies.of(ends),
        radii=np.full(len(pairs), _BELT * anatomy.size),
        smallest=SPECK * anatomy.size,
    )


def _geared_pairs(anatomy: Anatomy) -> Iterator[_Pair]:
    gears = [loop for loop in anatomy.mechanism.spec.loops if isinstance(loop, JointLoop)]
    for number, loop in enumerate(gears, start=1):
        first, second = (anatomy.model.getJointId(name) for name in loop.joints)
        yield _Pair(number, (first, second), _wheel_radii(anatomy, first, second, loop.ratio))


def _wheel_radii(anatomy: Anatomy, first: int, second: int, ratio: float) -> tuple[float, float]:
    both = _BOTH * anatomy.size
    one, other = anatomy.home[first], anatomy.home[second]
    axes = anatomy.bodies.axes
    if first in axes and second in axes and axes[first].turns and axes[second].turns:
        a = one[:3, :3] @ axes[first].direction
        b = other[:3, :3] @ axes[second].direction
        way = other[:3, 3] - one[:3, 3]
        apart = float(np.linalg.norm(way - (way @ a) * a))
        against = ratio * float(a @ b) < 0.0
        if against and np.linalg.norm(np.cross(a, b)) < _PARALLEL_WHEELS and apart > 0.0:
            both = apart
    share = abs(ratio) / (1.0 + abs(ratio))  # r_first / r_second = |ratio|
    smallest = _SMALLEST_WHEEL * anatomy.size
    return max(share * both, smallest), max((1.0 - share) * both, smallest)


def _wheels(anatomy: Anatomy, pair: _Pair) -> Iterator[Carried]:
    for name, joint, radius in zip(("first", "second"), pair.joints, pair.radii, strict=True):
        axis = anatomy.bodies.axes.get(joint)
        if axis is None or not axis.turns:
            continue
        half = 0.5 * _THICKNESS * anatomy.size * axis.direction[None]
        (disc,), _ = stretched_between(-half, half, np.array([radius]), 0.0)
        yield Part(f"gears/{pair.number}/{name}", Cylinder(), WHEEL), joint, disc
        rim = radius * _unit_across(axis.direction)[None]
        (spoke,), _ = stretched_between(0.0 * rim, rim, np.array([_SPOKE * anatomy.size]), 0.0)
        yield Part(f"gears/{pair.number}/{name}_spoke", Cylinder(), GEAR), joint, spoke


def _unit_across(direction: Array) -> Array:
    """Return a unit vector across another."""
    across: Array = np.cross(direction, np.eye(3)[np.argmin(np.abs(direction))])
    return across / np.linalg.norm(across)
