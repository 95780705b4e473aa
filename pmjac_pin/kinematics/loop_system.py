"""LoopSystem: all loop closures of a mechanism as one residual and one Jacobian.

Pinocchio's anchor constraints give the pose of one anchor seen from the other, and its rates;
the rows of each kind are functions of it. `LoopSystem.evaluate` stays in the anchors' own axes,
where no rotation is needed and Newton converges just as well; `LoopSystem.in_world` has the rows
as the lecture does: world axes, first minus second.
"""

from __future__ import annotations

import copy
import itertools
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from pmjac_pin.errors import ArgumentError, quoted
from pmjac_pin.kinematics.anchored_loop import AnchoredLoop, Relative, anchored, relative
from pmjac_pin.model.coupling import Coupling, couple
from pmjac_pin.model.frames import find_frame, moving_columns
from pmjac_pin.model.loop_between_frames import LoopBetweenFrames
from pmjac_pin.model.loop_spec import JointLoop, Loop
from pmjac_pin.model.rows import Distance, Rows
from pmjac_pin.values.arrays import Array


class LoopEnd(NamedTuple):
    """One of the two frames of a loop.

    Attributes
    ----------
    frame : int
        Pinocchio's index.
    columns : ndarray of int
        That move it, but not the loop's other frame with it.
    """

    frame: int
    columns: NDArray[np.intp]


class _LoopRows(NamedTuple):
    """What one loop's rows are called and counted in, its ends, and what moves these."""

    names: tuple[str, ...]
    units: tuple[str, ...]
    ends: tuple[LoopEnd, ...]
    moving: NDArray[np.intp]


class LoopData(NamedTuple):
    """Pinocchio's scratch data of the loops between frames, for one thread.

    Attributes
    ----------
    each : list
        Of each loop.
    together : pin.StdVec_ConstraintData or None
        Which hold them, where all loops are gaps that Pinocchio evaluates at once.
    """

    each: list[Any]
    together: Any


class LoopSystem:
    """All the loops of a mechanism, stacked: η(q) and ∂η/∂v.

    Parameters
    ----------
    model : pin.Model
    loops : sequence of PointLoop, RevoluteLoop, ...
    values : mapping of str to float
        The parameters' values, for lengths that depend on them.

    Attributes
    ----------
    row_names : tuple of str
        One for each of the p rows, e.g. ``"coupler_tip-rocker_tip x"``.
    row_units : tuple of str
        "m", "rad" or "m²" for each row.
    row_loops : tuple of str
        What each row's loop joins, e.g. ``"coupler_tip-rocker_tip"``.
    slices : tuple of slice
        The rows of each loop, in the order of the loops.
    couplings : dict of int to Coupling
        The geared joints, by their row.
    rods : dict of int to float
        The lengths of the rods by their row, m.
    ends : tuple of (LoopEnd, LoopEnd)
        Of each loop, the first frame's and the second's; none for gears.
    moving : tuple of ndarray of int
        The columns that move each loop's two frames against each other; none for gears.
    """

    __slots__ = (
        "_bases",
        "_closures",
        "_grounds",
        "_points",
        "_seconds",
        "_shape",
        "couplings",
        "ends",
        "moving",
        "rods",
        "row_loops",
        "row_names",
        "row_units",
        "slices",
    )

    def __init__(
        self, model: pin.Model, loops: Sequence[Loop], values: Mapping[str, float]
    ) -> None:
        self._closures: list[AnchoredLoop] = []
        self.couplings: dict[int, Coupling] = {}
        self.rods: dict[int, float] = {}
        found: list[_LoopRows] = []
        for loop in loops:
            start = sum(len(one.names) for one in found)
            if isinstance(loop, JointLoop):
                found.append(self._geared(model, loop, start))
            else:
                found.append(self._between_frames(model, loop, loop.rows(values), start))
        self.row_names = tuple(
            f"{'-'.join(loop.ends)} {name}"
            for loop, one in zip(loops, found, strict=True)
            for name in one.names
        )
        self._shape = len(self.row_names), model.nv
        self.row_units = tuple(unit for one in found for unit in one.units)
        self.row_loops = tuple(
            "-".join(loop.ends) for loop, one in zip(loops, found, strict=True) for _ in one.names
        )
        self.ends = tuple(one.ends for one in found)
        self.moving = tuple(one.moving for one in found)
        stops = itertools.accumulate((len(one.names) for one in found), initial=0)
        self.slices = tuple(itertools.starmap(slice, itertools.pairwise(stops)))
        # Of each loop, the joint from whose body its rows are seen: 0 for the world, None for the
        # body of the second anchor, in whose axes Pinocchio has them.
        self._seconds: tuple[int | None, ...] = (None,) * len(self._closures)
        self._grounds: tuple[int | None, ...] = (0,) * len(self._closures)
        self._bases = tuple(None if c.base == c.body else c.base for c in self._closures)
        self._points = self._together()

    def _together(self) -> Any:
        """Return Pinocchio's constraints as it evaluates them at once, None where it cannot."""
        if self.couplings or not all(closure.gap for closure in self._closures):
            return None
        points = pin.StdVec_ConstraintModel()
        points.extend(pin.ConstraintModel(closure.constraint) for closure in self._closures)
        return points

    def _geared(self, model: pin.Model, loop: JointLoop, start: int) -> _LoopRows:
        coupling = self.couplings[start] = couple(model, loop)
        return _LoopRows(("ratio",), (coupling.unit,), (), np.zeros(0, dtype=np.intp))

    def _between_frames(
        self, model: pin.Model, loop: LoopBetweenFrames, rows: Sequence[Rows], start: int
    ) -> _LoopRows:
        frames = [find_frame(model, name) for name in loop.frames]
        stops = itertools.accumulate((len(block.names) for block in rows), initial=start)
        slots = itertools.starmap(slice, itertools.pairwise(stops))
        blocks = tuple(zip(slots, rows, strict=True))
        for slot, block in blocks:
            if isinstance(block, Distance):
                self.rods[slot.start] = block.length
            else:
                _check_unit(block)
        self._closures.append(anchored(model, loop, frames, blocks))
        columns = moving_columns(model, frames)
        return _LoopRows(
            tuple(name for block in rows for name in block.names),
            tuple(block.unit for block in rows for _ in block.names),
            tuple(map(LoopEnd, [frame.index for frame in frames], columns)),
            np.concatenate(columns),
        )

    def placed(
        self, model: pin.Model, places: Mapping[int, pin.SE3], rows: Sequence[Sequence[Rows]]
    ) -> LoopSystem:
        """Return the loops of a machine of other dimensions, of the same joints and loops.

        Parameters
        ----------
        model : pin.Model
            That machine's.
        places : mapping of int to pin.SE3
            Where the joints carry frames that are elsewhere, by Pinocchio's indices.
        rows : sequence of sequences of Rows
            Of each loop between frames.
        """
        found = copy.copy(self)
        own = zip(self._closures, rows, strict=True)
        found._closures = [closure.placed(model, places, blocks) for closure, blocks in own]
        found._points = found._together()
        found.rods = {
            slots.start: block.length
            for closure in found._closures
            for slots, block in closure.blocks
            if isinstance(block, Distance)
        }
        return found

    def create_data(self) -> LoopData:
        """Return Pinocchio's scratch data."""
        each = [closure.constraint.createData() for closure in self._closures]
        if self._points is None:
            return LoopData(each, None)
        together = pin.StdVec_ConstraintData()
        together.extend(map(pin.ConstraintData, each))
        return LoopData([data.extract() for data in together], together)

    def evaluate(
        self, model: pin.Model, data: pin.Data, scratch: LoopData, q: Array
    ) -> tuple[Array, Array]:
        """Return η (p,) and ∂η/∂v (p, nv) in the anchors' axes.

        After ``pin.computeJointJacobians`` filled `data` at `q`; ``forwardKinematics`` would
        leave the joint Jacobians stale.
        """
        if self._points is None or not self._closures:
            return self._filled(model, data, scratch, q, self._seconds)
        for closure, own in zip(self._closures, scratch.each, strict=True):
            closure.constraint.calc(model, data, own)
        jacobian = pin.getConstraintsJacobian(model, data, self._points, scratch.together)
        residual = np.concatenate([own.constraint_position_error for own in scratch.each])
        return residual, jacobian.reshape(self._shape)

    def in_world(
        self, model: pin.Model, data: pin.Data, scratch: LoopData, q: Array
    ) -> tuple[Array, Array]:
        """Return what `evaluate` does in world axes.

        On closure the derivative is exact; off it, `add_turning` adds what is missing.
        """
        return self._filled(model, data, scratch, q, self._grounds)

    def from_base(
        self, model: pin.Model, data: pin.Data, scratch: LoopData, q: Array
    ) -> tuple[Array, Array]:
        """Return what `evaluate` does, seen from the body that carries both ends of a loop.

        What happens above a loop does not turn its rows, and neither do its own joints.
        """
        return self._filled(model, data, scratch, q, self._bases)

    def _filled(
        self,
        model: pin.Model,
        data: pin.Data,
        scratch: LoopData,
        q: Array,
        bodies: tuple[int | None, ...],
    ) -> tuple[Array, Array]:
        residual, jacobian = np.empty(self._shape[0]), np.empty(self._shape)
        for closure, own, body in zip(self._closures, scratch.each, bodies):  # noqa: B905 - as long
            rates = _anchor_rates(closure.constraint, model, data, own)
            turn = None if body is None else own.oMc1.rotation
            if body:
                turn = data.oMi[body].rotation.T.dot(turn)
            if closure.gap is not None and turn is not None:
                turn.dot(own.constraint_position_error, out=residual[closure.gap])
                turn.dot(rates, out=jacobian[closure.gap])
                continue
            pose = relative(own, rates)
            for rows, block in closure.blocks:
                gap, rates = block(pose)
                if turn is not None and block.vector:
                    gap, rates = turn.dot(gap), turn.dot(rates)
                residual[rows], jacobian[rows] = gap, rates
        for row, coupling in self.couplings.items():
            residual[row], jacobian[row] = coupling.residual(q), coupling.gradient
        return residual, jacobian

    def rows_by_twists(self, model: pin.Model, data: pin.Data, loop: int, twists: Array) -> Array:
        """Return how a loop's rows change with relative twists of its two frames, (rows, k).

        Parameters
        ----------
        model, data
            After ``pin.computeJointJacobians``.
        loop : int
            Its number among all; one between frames.
        twists : ndarray, shape (6, k)
            Of the first frame seen from the second, linear rows first, world axes, at the first
            frame's origin.
        """
        start = self.slices[loop].start
        closure = next(c for c in self._closures if c.blocks[0][0].start == start)
        loop_data = closure.constraint.createData()
        pose = relative(loop_data, _anchor_rates(closure.constraint, model, data, loop_data))
        to_second = loop_data.oMc1.rotation.T
        linear, turning = to_second @ twists[:3], to_second @ twists[3:]
        seen = Relative(pose.gap, linear, pose.rotation, turning)
        return np.vstack([block(seen)[1] for _, block in closure.blocks])

    def add_turning(
        self, model: pin.Model, data: pin.Data, residual: Array, jacobian: Array
    ) -> None:
        """Add ω × η of the second anchor to the world's ∂η/∂v, in place: zero on closure."""
        for closure in self._closures:
            turning = pin.getJointJacobian(model, data, closure.body, pin.LOCAL_WORLD_ALIGNED)
            turning = turning.reshape(6, -1)[3:]
            for rows in closure.vectors:
                jacobian[rows] -= pin.skew(residual[rows]) @ turning


def _anchor_rates(constraint: Any, model: pin.Model, data: pin.Data, scratch: Any) -> Array:
    """Return how one anchor moves seen from the other, (3, nv) or (6, nv), as `data` has it.

    `scratch` then has where it is: without `calc` the Jacobian is silently the one of another q.
    """
    constraint.calc(model, data, scratch)
    rates: Array = constraint.jacobian(model, data, scratch)
    return rates if rates.ndim > 1 else rates[:, None]  # of one degree of freedom


def _check_unit(block: Rows) -> None:
    if block.unit not in ("m", "rad"):
        raise ArgumentError(
            f"rows in {quoted(block.unit)} of a loop that is no rod: nothing says by how much "
            "they open with a gap; write them in m or rad"
        )
