"""How far a tool is from moving freely: what work each motor's wrench does on its twist."""

from __future__ import annotations

import math

import numpy as np

from pmjac_pin.rates.factorisation import factorise
from pmjac_pin.rates.margins import ToolMargin
from pmjac_pin.rates.partition import Partition
from pmjac_pin.rates.screw import Screw
from pmjac_pin.rates.tool_motion import ToolMotion
from pmjac_pin.values.arrays import Array, norm

_NO_AXIS = 1e-9  # of the other part, over the length: a turn, or a force, that is none


def tool_margins(
    allowed: Array, tool: ToolMotion, partition: Partition, pose: tuple[Array, Array]
) -> dict[str, ToolMargin]:
    """Return each motor's, by its name; none of a motor that does not move the tool alone.

    Parameters
    ----------
    allowed : ndarray, shape (nv, a)
        Orthonormal columns, on scaled rates: what loops allow.
    tool : ToolMotion
    partition : Partition
    pose : tuple of ndarray, shapes (3, 3) and (3,)
        Axes of the tool's rows in the world, and its origin.
    """
    if not partition.row_scale.size or partition.tool_rank < len(tool.rows.names):
        return {}
    motors = allowed[partition.actuated]
    found = {}
    for k, name in enumerate(partition.actuated_names):
        others = np.delete(motors, k, axis=0)
        commanded = _judged_span(tool, allowed @ _resting(others))
        against = _judged_span(tool, allowed @ _resting(motors[k : k + 1]))
        borne = factorise(against, 1.0).left_null_space
        if commanded.shape[1] == borne.shape[1] == 1:
            twist, wrench = _on_six_rows(tool, commanded[:, 0]), _on_six_rows(tool, borne[:, 0])
            found[name] = _margin(twist, wrench, tool.length, pose)
    return found


def _resting(motors: Array) -> Array:
    return factorise(motors, 1.0).null_space


def _judged_span(tool: ToolMotion, motions: Array) -> Array:
    """Return orthonormal columns that span what motions do to the judged rows, dimensionless."""
    if not motions.shape[1]:
        return np.zeros((len(tool.rows.names), 0))
    judged = tool.judged(motions)
    found = factorise(judged, tool.size, tool.tolerance)
    return found.left[:, : found.rank]


def _on_six_rows(tool: ToolMotion, judged: Array) -> Array:
    rows = np.zeros(6)
    rows[tool.rows.linear + tool.rows.angular] = judged
    return rows


def _margin(twist: Array, wrench: Array, length: float, pose: tuple[Array, Array]) -> ToolMargin:
    """Return the margin of a twist and a wrench, angular rows times the length, moments over it."""
    axes, origin = pose
    (velocity, omega), (force, moment) = (
        (axes @ half for half in np.split(one, 2)) for one in (twist, wrench)
    )
    work, turn, push = abs(float(twist @ wrench)), norm(omega), norm(force)
    turns, pushes = (norm(a) > _NO_AXIS * norm(b) for a, b in ((omega, velocity), (force, moment)))
    screws = (
        Screw.of(omega / length, velocity, origin, length),
        Screw.of(force, moment * length, origin, length),
    )
    if turns and pushes:
        return ToolMargin(length * work / (turn * push), "m", *screws)
    if pushes:  # on a translation
        angle = math.atan2(abs(float(force @ velocity)), norm(np.cross(force, velocity)))
    else:  # a moment: no work on a translation
        angle = math.atan2(abs(float(moment @ omega)), norm(np.cross(moment, omega)))
    return ToolMargin(angle, "rad", *screws)
