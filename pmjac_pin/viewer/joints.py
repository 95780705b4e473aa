"""Joints by their kind, motors in their own colour, loop closures and the tool's frame."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from pmjac_pin.viewer.anatomy import BALL_JOINTS, Anatomy
from pmjac_pin.viewer.bodies import Point, Points
from pmjac_pin.viewer.layers import SPECK, Attached, Labels, Lines, distinct, part_of_path, words
from pmjac_pin.viewer.palette import (
    AXES,
    FIRST_ANCHOR,
    GAP,
    JOINT,
    MOTOR,
    ROD,
    SECOND_ANCHOR,
    WORDS,
)
from pmjac_pin.viewer.shapes import (
    Array,
    Box,
    Colour,
    Cone,
    Cylinder,
    Part,
    Shape,
    Sphere,
    between,
    scaled,
    translation,
)

# Shares of the mechanism's size.
PIN_RADIUS, PIN_LENGTH = 0.025, 0.09
SLIDER = 0.05
BALL_RADIUS = 0.03
RAIL_RADIUS = 0.008
FIRST_RADIUS, SECOND_RADIUS = 0.03, 0.045
ROD_RADIUS, GAP_RADIUS = 0.015, 0.008
FRAME_LENGTH = 0.15
LETTERS = 0.055


def joint_layer(anatomy: Anatomy) -> Attached:
    """Return a cylinder along the axis of what turns, a box on what slides, a ball where both.

    Joints that leave a body loose (floating, planar) have no glyph.
    """
    return Attached.of(_glyphs(anatomy))


def rail_layer(anatomy: Anatomy) -> Lines:
    """Return what prismatic joints slide on: a bar from where they are fixed to where they are."""
    sliding = [joint for joint in anatomy.joints if anatomy.slides(joint)]
    parts = [Part(f"{_path(anatomy, j)}/rail", Cylinder(), _colour(anatomy, j)) for j in sliding]
    return Lines(
        parts=distinct(parts),
        starts=Points.of([anatomy.root(joint) for joint in sliding]),
        ends=Points.of([Point(joint, np.zeros(3)) for joint in sliding]),
        radii=np.full(len(sliding), RAIL_RADIUS * anatomy.size),
        skipped=np.zeros(len(sliding)),
        smallest=SPECK * anatomy.size,
    )


def motor_names(anatomy: Anatomy) -> Labels:
    """Return the motors' names, at them."""
    motors = sorted(anatomy.motors)
    names = [str(anatomy.model.names[motor]) for motor in motors]
    return Labels(
        parts=distinct([words(f"names/{part_of_path(name)}", name, WORDS) for name in names]),
        points=Points.of([anatomy.root(motor) for motor in motors]),
        height=LETTERS * anatomy.size,
    )


def anchor_layer(anatomy: Anatomy) -> Attached:
    """Return a ball at each anchor; the second one's is larger and lets the first one shine."""
    return Attached.of(_balls(anatomy))


def _balls(anatomy: Anatomy) -> Iterator[tuple[Part, int, Array]]:
    for number, anchors in enumerate(anatomy.anchors, start=1):
        for name, point, radius, colour in (
            ("first", anchors.first, FIRST_RADIUS, FIRST_ANCHOR),
            ("second", anchors.second, SECOND_RADIUS, SECOND_ANCHOR),
        ):
            place = translation(point.place) @ scaled(radius * anatomy.size)
            yield Part(f"loops/{number}/{name}", Sphere(), colour), point.body, place


def closure_layer(anatomy: Anatomy) -> Lines:
    """Return the rods of distance loops, and what is open between the anchors of every loop.

    A rod starts at the first anchor; the gap is from its end, or from the first anchor where
    there is none, to the second anchor.
    """
    anchors = anatomy.anchors
    rods = [(n, a) for n, a in enumerate(anchors, start=1) if a.length > 0.0]
    parts = [Part(f"loops/{n}/gap", Cylinder(), GAP) for n in range(1, len(anchors) + 1)]
    parts += [Part(f"loops/{number}/rod", Cylinder(), ROD) for number, _ in rods]
    drawn = [*anchors, *(anchor for _, anchor in rods)]
    radii = [GAP_RADIUS] * len(anchors) + [ROD_RADIUS] * len(rods)
    return Lines(
        parts=parts,
        starts=Points.of([anchor.first for anchor in drawn]),
        ends=Points.of([anchor.second for anchor in drawn]),
        radii=anatomy.size * np.array(radii),
        skipped=np.array([anchor.length for anchor in anchors] + [0.0] * len(rods)),
        smallest=SPECK * anatomy.size,
    )


def tool_layer(anatomy: Anatomy) -> Attached:
    """Return the tool's frame: three arrows, x red, y green and z blue."""
    length = FRAME_LENGTH * anatomy.size
    shafts = between(np.zeros((3, 3)), 0.75 * length * np.eye(3), np.full(3, 0.05 * length), 0.0)
    heads = between(0.75 * length * np.eye(3), length * np.eye(3), np.full(3, 0.12 * length), 0.0)
    parts = [
        Part(f"tool/{axis}/{name}", shape, colour)
        for name, shape in (("shaft", Cylinder()), ("head", Cone()))
        for axis, colour in zip("xyz", AXES, strict=True)
    ]
    places = np.concatenate([shafts[0], heads[0]])
    return Attached(parts, np.full(6, -1), places)


def _glyphs(anatomy: Anatomy) -> Iterator[tuple[Part, int, Array]]:
    for joint in anatomy.joints:
        path, colour = _path(anatomy, joint), _colour(anatomy, joint)
        if joint in anatomy.bodies.axes:
            name, shape, place = _along_axis(anatomy, joint)
            yield Part(f"{path}/{name}", shape, colour), joint, place
        elif anatomy.model.joints[joint].shortname() in BALL_JOINTS:
            yield Part(f"{path}/ball", Sphere(), colour), joint, scaled(BALL_RADIUS * anatomy.size)


def _along_axis(anatomy: Anatomy, joint: int) -> tuple[str, Shape, Array]:
    axis, turns = anatomy.bodies.axes[joint]
    size = anatomy.size
    length = (PIN_LENGTH if turns else SLIDER) * size
    radius = (PIN_RADIUS if turns else SLIDER) * size
    end = 0.5 * length * axis[None]
    (place,), _ = between(-end, end, np.array([radius]), 0.0)
    return ("pin", Cylinder(), place) if turns else ("slider", Box(), place)


def _path(anatomy: Anatomy, joint: int) -> str:
    kind = "motors" if joint in anatomy.motors else "joints"
    return f"{kind}/{part_of_path(str(anatomy.model.names[joint]))}"


def _colour(anatomy: Anatomy, joint: int) -> Colour:
    return MOTOR if joint in anatomy.motors else JOINT
