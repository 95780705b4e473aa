"""Stick figures drawn in parallel projection, with matplotlib's flat axes.

What is nearer covers what is behind it: a bar has a dark edge, so that where two pass each other
it shows which is in front, and neither is interrupted. A mechanism that moves in a plane is drawn
in that plane.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from pmjac_pin.pictures.stick_figure import StickFigure, Stroke
from pmjac_pin.values.arrays import Array
from pmjac_pin.values.ties import first_largest

_ELEVATION = 25.0  # degrees, of the eye above the x-y plane
_AZIMUTHS = range(-45, 315, 15)  # degrees, where the eye may be: the first is the usual one
_IN_A_PLANE = 1e-6  # of the picture's width
_PICTURE_MARGIN = 0.06  # of the picture's width, about the drawing

# Okabe and Ito's palette, which colour-blind readers can tell apart.
_GROUND, _LINK, _MOTOR, _ANCHOR, DARK = "#8C8C8C", "#0072B2", "#D55E00", "#F0E442", "#262626"
_EDGES = {_LINK: "#003A5C", _MOTOR: "#6E3000"}  # the same, darker
_BAR_EDGE = 0.45  # points, at either side of a bar
_TOOL_COLOURS = ("#C81919", "#199919", "#1933E0")
_BARS = {  # colour and width in points
    "ground": (_GROUND, 2.0),
    "link": (_LINK, 2.2),
    "rod": (_LINK, 1.4),
    "rail": (DARK, 1.3),
    "motor rail": (_MOTOR, 2.0),
}
_MARKS = {  # marker, size in points, face and edge
    "joint": ("o", 4.5, "white", DARK),
    "motor": ("o", 5.5, _MOTOR, _MOTOR),
    "slider": ("s", 3.0, DARK, DARK),
    "ball": ("o", 4.0, DARK, DARK),
    "anchor": ("o", 4.5, _ANCHOR, DARK),
}
_LAYERS = {"link": 0, "rod": 0, "rail": 0, "motor rail": 0, "slider": 1, "anchor": 3}


def view_of(figures: Sequence[StickFigure]) -> Array:
    """Return the axes of the picture, as rows: to the right, upwards, towards the eye."""
    eye = _plane_normal(figures)
    if eye is None:
        eye = _round_about(figures)
    up = np.array([0.0, 0.0, 1.0]) if abs(eye[2]) < 0.9 else np.array([0.0, 1.0, 0.0])
    right = np.cross(up, eye)
    right /= np.linalg.norm(right)
    return np.array([right, np.cross(eye, right), eye])


def frame_of(figures: Sequence[StickFigure], view: Array) -> tuple[Array, Array]:
    """Return the lowest and the highest corner of a picture that holds them all, shapes (2,)."""
    seen = np.concatenate([figure.points for figure in figures]) @ view[:2].T
    low, high = seen.min(axis=0), seen.max(axis=0)
    margin = _PICTURE_MARGIN * float((high - low).max())
    return low - margin, high + margin


def _plane_normal(figures: Sequence[StickFigure]) -> Array | None:
    """Return the normal of the plane in which all is: with z or x positive, or y negative.

    None where there is no one plane: of less than three points, too.
    """
    points = np.concatenate([stroke.points for figure in figures for stroke in figure.strokes])
    sizes, axes = np.linalg.svd(points - points.mean(axis=0), full_matrices=False)[1:]
    if sizes.size < len(axes[0]) or sizes[2] > _IN_A_PLANE * sizes[0]:
        return None
    largest = int(first_largest(axes[2]))
    normal: Array = axes[2] * np.sign(axes[2][largest]) * (-1.0 if largest == 1 else 1.0)
    return normal


def _round_about(figures: Sequence[StickFigure]) -> Array:
    """Return the direction from which no plate is seen edge-on, as far as there is one."""
    turn, rise = np.deg2rad(_AZIMUTHS), math.radians(_ELEVATION)
    level = math.cos(rise)
    eyes = np.array(
        [level * np.cos(turn), level * np.sin(turn), np.full(turn.size, math.sin(rise))]
    )
    normals = [stroke.normal for figure in figures for stroke in figure.strokes if stroke.is_plate]
    if not normals:
        return np.asarray(eyes[:, 0])
    clarity = np.abs(np.array(normals) @ eyes).min(axis=0)
    return np.asarray(eyes[:, int(np.argmax(clarity.round(6)))])


def draw_figure(axes: Any, figure: StickFigure, view: Array) -> None:
    """Draw from far to near, marks after bodies; what is behind the ground's plate before it."""
    behind = _behind_the_ground(figure, view[2])

    def order(stroke: Stroke) -> tuple[int, int, float]:
        middle = stroke.points.mean(axis=0)
        if stroke.kind == "ground":
            return 1, 0, 0.0
        return 0 if behind(middle) else 2, _LAYERS.get(stroke.kind, 2), float(middle @ view[2])

    for rank, stroke in enumerate(sorted(figure.strokes, key=order)):
        outline = (stroke.points @ view[:2].T).T
        if outline.shape[1] == 1:
            marker, size, face, edge = _MARKS[stroke.kind]
            axes.plot(*outline, marker, zorder=rank, ms=size, mfc=face, mec=edge, mew=1.0)
        else:
            _draw_body(axes, stroke, outline, rank)
    origin, *ends = figure.tool @ view[:2].T
    for end, colour in zip(ends, _TOOL_COLOURS, strict=True):
        line = np.column_stack([origin, end])
        axes.plot(*line, color=colour, lw=1.3, zorder=len(figure.strokes))


def _behind_the_ground(figure: StickFigure, eye: Array) -> Callable[[Array], bool]:
    plates = [stroke for stroke in figure.strokes if stroke.kind == "ground" and stroke.is_plate]
    if len(plates) != 1:
        return lambda point: False
    middle, normal = plates[0].points.mean(axis=0), plates[0].normal
    normal = normal * np.sign(normal @ eye)
    depth = _IN_A_PLANE * float(np.ptp(plates[0].points, axis=0).max())
    return lambda point: bool((point - middle) @ normal < -depth)


def _draw_body(axes: Any, stroke: Stroke, outline: Array, order: int) -> None:
    colour, width = _BARS[stroke.kind]
    round_off = {"solid_capstyle": "round", "solid_joinstyle": "round"}
    closed = outline if outline.shape[1] == 2 else np.column_stack([outline, outline[:, :1]])
    if edge := _EDGES.get(colour):
        axes.plot(*closed, color=edge, lw=width + 2 * _BAR_EDGE, zorder=order, **round_off)
    if stroke.is_plate:
        axes.fill(*outline, facecolor=colour, alpha=0.18, linewidth=0, zorder=order)
    axes.plot(*closed, color=colour, lw=width, zorder=order, **round_off)
