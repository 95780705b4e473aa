"""Joints by their kind, motors in their own colour, and the tool's frame."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from pmjac_pin.files.shapes import Box, Colour, Cone, Cylinder, Shape, Sphere, scaled
from pmjac_pin.pictures.anatomy import Anatomy
from pmjac_pin.pictures.bodies import Point, PointsOfBodies
from pmjac_pin.values.arrays import Array
from pmjac_pin.viewer.items import Part, stretched_between
from pmjac_pin.viewer.layers import (
    SPECK,
    Attached,
    Lines,
    MidwayLabels,
    distinct_parts,
    part_of_path,
    words,
)
from pmjac_pin.viewer.palette import AXIS_COLOURS, JOINT, MOTOR, WORDS

# Shares of the mechanism's size.
PIN_RADIUS, PIN_LENGTH = 0.025, 0.09
SLIDER = 0.05
BALL_RADIUS = 0.03
RAIL_RADIUS = 0.008
FRAME_LENGTH = 0.15
MOTOR_LETTERS = 0.055


def joint_layer(anatomy: Anatomy) -> Attached:
    """Return a cylinder along the axis of what turns, a box on what slides, a ball where both.

    Joints that leave a body loose (floating, planar) have no glyph.
    """
    return Attached.of(_glyphs(anatomy))


def rail_layer(anatomy: Anatomy) -> Lines:
    """Return what joints slide on along an axis: a bar from where they are fixed to where they are.

    A slide on the ground whose body has visuals is seen without. Those of a leg have one length at
    every stroke: the bar is what joins them.
    """
    drawn, parents = anatomy.drawn_by_visuals, anatomy.model.parents
    sliding = [
        joint
        for joint in anatomy.joints
        if anatomy.slides(joint) and (joint not in drawn or parents[joint])
    ]
    parts = [
        Part(f"{_joint_path(anatomy, j)}/rail", Cylinder(), _joint_colour(anatomy, j))
        for j in sliding
    ]
    return Lines(
        parts=distinct_parts(parts),
        starts=PointsOfBodies.of([anatomy.root(joint) for joint in sliding]),
        ends=PointsOfBodies.of([Point(joint, np.zeros(3)) for joint in sliding]),
        radii=np.full(len(sliding), RAIL_RADIUS * anatomy.size),
        smallest=SPECK * anatomy.size,
    )


def motor_names(anatomy: Anatomy) -> MidwayLabels:
    """Return the motors' names, at them; of a slide midway along its rail."""
    motors = sorted(anatomy.motors)
    names = [str(anatomy.model.names[motor]) for motor in motors]
    return MidwayLabels(
        parts=distinct_parts([words(f"names/{part_of_path(name)}", name, WORDS) for name in names]),
        starts=PointsOfBodies.of([anatomy.root(motor) for motor in motors]),
        ends=PointsOfBodies.of([Point(motor, np.zeros(3)) for motor in motors]),
        height=MOTOR_LETTERS * anatomy.size,
    )


def tool_layer(anatomy: Anatomy) -> Attached:
    """Return the tool's frame: three arrows, x red, y green and z blue, that nothing hides."""
    length = FRAME_LENGTH * anatomy.size
    ends, necks = length * np.eye(3), 0.75 * length * np.eye(3)
    starts, radii = np.vstack([np.zeros((3, 3)), necks]), length * np.repeat([0.05, 0.12], 3)
    places, _ = stretched_between(starts, np.vstack([necks, ends]), radii, 0.0)
    parts = [
        Part(f"tool/{axis}/{name}", shape, colour, on_top=True)
        for name, shape in (("shaft", Cylinder()), ("head", Cone()))
        for axis, colour in zip("xyz", AXIS_COLOURS, strict=True)
    ]
    return Attached(parts, np.full(6, -1), places)


def _glyphs(anatomy: Anatomy) -> Iterator[tuple[Part, int, Array]]:
    for joint in anatomy.joints:
        path, colour = _joint_path(anatomy, joint), _joint_colour(anatomy, joint)
        if joint in anatomy.bodies.axes:
            name, shape, place = _along_axis(anatomy, joint)
            yield Part(f"{path}/{name}", shape, colour), joint, place
        elif anatomy.ball(joint):
            yield Part(f"{path}/ball", Sphere(), colour), joint, scaled(BALL_RADIUS * anatomy.size)


def _along_axis(anatomy: Anatomy, joint: int) -> tuple[str, Shape, Array]:
    axis, turns, _ = anatomy.bodies.axes[joint]
    size = anatomy.size
    length = (PIN_LENGTH if turns else SLIDER) * size
    radius = (PIN_RADIUS if turns else SLIDER) * size
    end = 0.5 * length * axis[None]
    (place,), _ = stretched_between(-end, end, np.array([radius]), 0.0)
    return ("pin", Cylinder(), place) if turns else ("slider", Box(), place)


def _joint_path(anatomy: Anatomy, joint: int) -> str:
    kind = "motors" if joint in anatomy.motors else "joints"
    return f"{kind}/{part_of_path(str(anatomy.model.names[joint]))}"


def _joint_colour(anatomy: Anatomy, joint: int) -> Colour:
    return MOTOR if joint in anatomy.motors else JOINT
