"""Courses in tool space: the machine driven by its tool, along a path of its coordinates."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from pmjac_pin.configuration import Configuration
from pmjac_pin.errors import ArgumentError, ClosureError, did_you_mean, quoted
from pmjac_pin.mechanism import Mechanism
from pmjac_pin.model.limits import limit_error
from pmjac_pin.studies.follow.course import Course
from pmjac_pin.studies.follow.given_path import path_of
from pmjac_pin.studies.follow.motor_path import MotorPath, PathPiece
from pmjac_pin.studies.reach.driven import Driven, driven_by
from pmjac_pin.studies.reach.goal import Goal
from pmjac_pin.studies.reach.targets import read_goals
from pmjac_pin.values.arrays import Array
from pmjac_pin.values.checks import as_names, as_numbers
from pmjac_pin.values.named_values import named_values

TOOL_COORDINATES = ("x", "y", "z", "angle")
_OFFSET = 0.125  # m or rad: exact in binary


def tool_path(path: Any, times: Any, coordinates: Sequence[str]) -> MotorPath:
    """Return the polynomials of a path of the tool's coordinates."""
    names = as_names(coordinates, "coordinates are names of the tool's")
    for name in names:
        if name not in TOOL_COORDINATES:
            known = did_you_mean(name, TOOL_COORDINATES)
            raise ArgumentError(f"no coordinate of the tool is called {quoted(name)}{known}")
    if not names or len(set(names)) < len(names):
        raise ArgumentError(f"coordinates name each once, got {quoted(names)}")

    def table(given: Any) -> Array:
        if (columns := named_values(given, "tool coordinates")) is not None:
            if set(columns) != set(names):
                raise ArgumentError(f"columns {', '.join(names)} are wanted, got {quoted(columns)}")
            given = np.column_stack([as_numbers(columns[name], name) for name in names])
        values = as_numbers(given, "tool coordinates")
        if values.ndim != 2 or values.shape[1] != len(names):
            wanted = f"tool coordinates of shape (N, {len(names)}) for {', '.join(names)}"
            raise ArgumentError(f"{wanted} are wanted, got {values.shape}")
        return values

    return path_of(path, times, names, table)


@dataclass(frozen=True, slots=True, eq=False)
class _ToolTargets:
    """Coordinates of a tool as targets of a machine."""

    mechanism: Mechanism
    coordinates: Sequence[str]
    tool: str | Sequence[str] | None
    start: Configuration

    def driven(self, values: Array) -> Driven:
        """Return the machine driven by its tool in these coordinates."""
        name, told = self.mechanism.name, ", ".join(self.coordinates)
        driven = driven_by(self.mechanism, self._goals(values))
        if driven is None:
            raise ArgumentError(f"{name}: {told} of the tool do not tell where the machine is")
        columns = driven.mechanism.problem.partition.actuated
        if driven.mechanism.coordinates.curved[columns].any():
            raise ArgumentError(f"{name}: a path of orientations is no path of numbers")
        return driven

    def in_motors(self, driven: Driven, values: Array) -> Array:
        """Return the motor values of the driven machine at these coordinates."""
        return driven.values(self._goals(values), self.start)

    def slopes(self, driven: Driven, values: Array) -> Array:
        """Return what those change by with each coordinate: constants, (k, n)."""
        wraps = driven.mechanism.coordinates.wraps[driven.mechanism.problem.partition.actuated]
        here, found = self.in_motors(driven, values), []
        for offset in _OFFSET * np.eye(len(values)):
            change = self.in_motors(driven, values + offset) - here
            change[wraps] = np.remainder(change[wraps] + np.pi, 2.0 * np.pi) - np.pi
            found.append(change / _OFFSET)
        return np.array(found)

    def _goals(self, values: Array) -> tuple[Goal, ...]:
        target = dict(zip(self.coordinates, values.tolist(), strict=True))
        return read_goals(self.mechanism, target, self.tool, None)


def tool_course(
    mechanism: Mechanism,
    path: MotorPath,
    coordinates: Sequence[str],
    tool: str | Sequence[str] | None,
    start: Configuration,
) -> tuple[Course, Configuration]:
    """Return the course of a tool, and the pose of the driven machine where it begins.

    Raises
    ------
    ArgumentError
        No rows of the coordinates tell the tool's pose.
    ClosureError
        The path's first point is not reached on a straight way of the tool from `start`.
    """
    first = path.pieces[0].values(path.start)
    targets = _ToolTargets(mechanism, coordinates, tool, start)
    driven = targets.driven(first)
    values = targets.in_motors(driven, first)
    ways = _in_motors(path, targets.slopes(driven, first), values)
    begin = begun(driven, values, start)
    return Course.beginning_at(begin, ways, mechanism), begin


def begun(driven: Driven, values: Array, start: Configuration) -> Configuration:
    """Return the driven machine's pose at these values, reached straight from one of the machine.

    Raises
    ------
    ClosureError
        It is not reached.
    """
    try:
        return driven.mechanism.close(values, driven.lifted(start), enforce_limits=False)
    except ClosureError as error:
        message = f"{driven.whole.name}: the tool does not go straight to where its path begins"
        raise ClosureError(
            f"{message}; begin at another pose", residual_norm=error.residual_norm, q=start.q
        ) from None


def check_start_within(pose: Configuration, whose: str) -> None:
    """Raise LimitError where a path begins beyond the limits that are enforced."""
    motors = set(pose.mechanism.actuated)
    beyond = {
        name: one
        for name, one in pose.limits_violated.items()
        if whose == "all" or (whose == "motors" and name in motors)
    }
    if beyond:
        raise limit_error(f"{pose.mechanism.name}: where the path begins, ", beyond)


def _in_motors(path: MotorPath, slopes: Array, values: Array) -> MotorPath:
    """Return a path of motor values, which are linear in the coordinates; `values` at its start."""
    here = path.pieces[0].values(path.start)
    shift = values - here @ slopes
    pieces: list[PathPiece] = []
    for piece in path.pieces:
        powers = piece.coefficients @ slopes
        powers[-1] += shift
        pieces.append(replace(piece, coefficients=powers))
    return MotorPath(tuple(pieces))
