"""A loop closure is a residual and a Jacobian; both come from a Pinocchio anchor constraint.

The anchor constraint gives the gap between two points as seen from the second one, and the
gap's derivative by the joint rates, both exact on and off closure. Every kind of loop is a
rule of a line or two on these. `LoopSystem.evaluate` stays in the anchors' own axes, where
no rotation is needed and Newton converges just as well; `LoopSystem.to_world` turns the rows
into the lecture's: world axes, first point minus second.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from pmjac_pin.errors import ArgumentError
from pmjac_pin.frames import find_frame
from pmjac_pin.spec import DistanceLoop, Loop, PointLoop

Array = NDArray[np.float64]


class Rule(Protocol):
    """How the residual follows from the gap between two anchors.

    Attributes
    ----------
    row_names : tuple of str
        What each row measures.
    row_unit : str
        "m" or "m²".
    row_scale : float
        Turns a row into metres of gap, to first order.
    vector : bool
        The rows are a vector's components and turn with the axes.
    """

    @property
    def row_names(self) -> tuple[str, ...]: ...  # noqa: D102
    @property
    def row_unit(self) -> str: ...  # noqa: D102
    @property
    def row_scale(self) -> float: ...  # noqa: D102
    @property
    def vector(self) -> bool: ...  # noqa: D102

    def __call__(self, gap: Array, rates: Array) -> tuple[Array | float, Array]:
        """Return the residual (rows,) and its Jacobian (rows, nv) from those of the gap."""
        ...


@dataclass(frozen=True, slots=True)
class PointRule:
    """η = p_first − p_second: the gap itself."""

    row_names = ("x", "y", "z")
    row_unit = "m"
    row_scale = 1.0
    vector = True

    def __call__(self, gap: Array, rates: Array) -> tuple[Array, Array]:
        """Return the gap and its rates."""
        return gap, rates


@dataclass(frozen=True, slots=True)
class DistanceRule:
    """η = |p_first − p_second|² − length²."""

    length: float
    row_names = ("distance²",)
    row_unit = "m²"
    vector = False

    @property
    def row_scale(self) -> float:
        """One over 2 length, for d(distance²) = 2 length d(distance)."""
        return 0.5 / self.length

    def __call__(self, gap: Array, rates: Array) -> tuple[float, Array]:
        """Return |gap|² − length² and 2 gapᵀ rates."""
        return float(gap @ gap) - self.length * self.length, (2.0 * gap) @ rates


@dataclass(frozen=True, slots=True)
class _Closure:
    rule: Rule
    constraint: Any  # pin.PointAnchorConstraintModel
    rows: slice


class LoopSystem:
    """All the loops of a mechanism, stacked: η(q) and ∂η/∂v.

    Parameters
    ----------
    model : pin.Model
    loops : sequence of PointLoop or DistanceLoop
    values : mapping of str to float
        The parameters' values, for lengths that depend on them.

    Attributes
    ----------
    row_names : tuple of str
        One for each of the p rows, e.g. ``"coupler_tip-rocker_tip x"``.
    row_units : tuple of str
        "m" or "m²" for each row.
    row_scale : ndarray, shape (p,)
        Turns each row into metres of gap.
    """

    __slots__ = ("_closures", "_nv", "row_names", "row_scale", "row_units")

    def __init__(
        self, model: pin.Model, loops: Sequence[Loop], values: Mapping[str, float]
    ) -> None:
        self._nv = model.nv
        self._closures: list[_Closure] = []
        names: list[str] = []
        scales: list[float] = []
        for loop in loops:
            rule = _rule(loop, values)
            rows = slice(len(names), len(names) + len(rule.row_names))
            self._closures.append(_Closure(rule, _anchors(model, loop), rows))
            names += [f"{loop.frames[0]}-{loop.frames[1]} {row}" for row in rule.row_names]
            scales += [rule.row_scale] * len(rule.row_names)
        self.row_names = tuple(names)
        self.row_units = tuple(
            closure.rule.row_unit for closure in self._closures for _ in closure.rule.row_names
        )
        self.row_scale = np.array(scales)

    def create_data(self) -> list[Any]:
        """Return Pinocchio's scratch data, one for each loop."""
        return [closure.constraint.createData() for closure in self._closures]

    def evaluate(self, model: pin.Model, data: pin.Data, scratch: list[Any]) -> tuple[Array, Array]:
        """Return η (p,) and ∂η/∂v (p, nv) in the anchors' axes.

        After ``pin.computeJointJacobians`` filled `data`; ``forwardKinematics`` would leave
        the joint Jacobians stale.
        """
        residual = np.empty(len(self.row_names))
        jacobian = np.empty((len(self.row_names), self._nv))
        for closure, loop_data in zip(self._closures, scratch, strict=True):
            # Without `calc` the constraint's Jacobian is silently the one of another q.
            closure.constraint.calc(model, data, loop_data)
            residual[closure.rows], jacobian[closure.rows] = closure.rule(
                loop_data.constraint_position_error,
                closure.constraint.jacobian(model, data, loop_data),
            )
        return residual, jacobian

    def to_world(self, scratch: list[Any], residual: Array, jacobian: Array) -> None:
        """Turn what `evaluate` just returned into world axes, in place.

        On closure this is exact; off it, the derivative of the turned residual has a further
        term, ω × η of the second anchor.
        """
        for closure, loop_data in zip(self._closures, scratch, strict=True):
            if closure.rule.vector:
                rotation, rows = loop_data.oMc1.rotation, closure.rows
                residual[rows] = rotation @ residual[rows]
                jacobian[rows] = rotation @ jacobian[rows]


def _rule(loop: Loop, values: Mapping[str, float]) -> Rule:
    match loop:
        case PointLoop():
            return PointRule()
        case DistanceLoop():
            return DistanceRule(loop.resolved_length(values))


def _anchors(model: pin.Model, loop: Loop) -> Any:
    """Build the anchor constraint. Pinocchio's gap is its second minus its first, ours opposite."""
    first, second = (find_frame(model, name) for name in loop.frames)
    if first.joint == second.joint:
        names = " and ".join(map(repr, loop.frames))
        raise ArgumentError(
            f"the frames {names} of a loop are on one body: nothing moves them apart"
        )
    return pin.PointAnchorConstraintModel(
        model, second.joint, second.placement, first.joint, first.placement
    )
