"""ToolRates: the judged rows of a tool's Jacobian over neighbourhoods of a pose, enclosed."""

from __future__ import annotations

import numpy as np

from pmjac_pin.algebra import Algebra, Number
from pmjac_pin.algebra.intervals import Intervals
from pmjac_pin.algebra.jets import Columns
from pmjac_pin.errors import ArgumentError
from pmjac_pin.kinematics.frame_jets import Riding
from pmjac_pin.kinematics.tree import Poses, Tree
from pmjac_pin.mechanism import Mechanism
from pmjac_pin.model.frames import find_frame
from pmjac_pin.model.tool_rows import WORLD_AXES
from pmjac_pin.studies.certificates.chains import WIDE_BOXES, Chain
from pmjac_pin.studies.certificates.neighbourhoods import Neighbourhoods
from pmjac_pin.studies.certificates.unknowns import Unknowns


class ToolRates:
    """The rows of a mechanism's tool.

    Parameters
    ----------
    mechanism : Mechanism
    unknowns : Unknowns
        Of which all joints that move the tool are.

    Raises
    ------
    NoToolError
        No frame is named as the tool.
    ArgumentError
        A tool that three points span.
    """

    def __init__(self, mechanism: Mechanism, unknowns: Unknowns) -> None:
        mechanism.need_tool()
        spec, model = mechanism.spec, mechanism.kinematics.model
        if not spec.tool.frame:
            raise ArgumentError(
                f"{mechanism.name}: what a tool that three points span loses is not enclosed; "
                "name a frame as the tool"
            )
        self._rows, self._places = spec.tool.judged, unknowns.places
        self._frame = find_frame(model, spec.tool.frame)
        self._chain = Chain(Tree(model), 0, self._frame, unknowns)

    def around(self, poses: Neighbourhoods) -> Intervals:
        """Return the judged rows (b, rows, n): one unit of the unknowns is 1 rad, or 1 m.

        Linear ones in m, angular ones in rad.
        """
        shape = (len(poses.turns), len(self._rows.names), len(self._places))
        lower, upper = np.zeros(shape), np.zeros(shape)
        frame = self._chain.around(poses)
        columns = [self._places[column] for column in frame.origin().columns]
        for row, one in enumerate(self._rates(WIDE_BOXES, frame)):
            if one is not None:
                lower[:, row, columns] = np.moveaxis(one.lower, -1, 0)
                upper[:, row, columns] = np.moveaxis(one.upper, -1, 0)
        return Intervals(lower, upper)

    def rows_of(self, poses: Poses) -> tuple[Columns, list[Number]]:
        """Return by which columns each row has which rates, (columns, b).

        None for a row that nothing moves. Of poses on whose numbers derivatives ride.
        """
        frame = poses.riding(0, self._frame)
        return frame.origin().columns, self._rates(poses.algebra, frame)

    def _rates(self, algebra: Algebra, frame: Riding) -> list[Number]:
        rates = [*self._linear(algebra, frame), *self._angular(algebra, frame)]
        return [rates[k] for k in self._rows.linear + self._rows.angular]

    @property
    def _in_world(self) -> bool:
        return self._rows.axes == WORLD_AXES

    def _linear(self, algebra: Algebra, frame: Riding) -> list[Number]:
        """Return the rates of the origin along the axes of the rows."""
        velocity = frame.origin().rates
        if velocity is None:
            return [None] * 3
        if self._in_world:
            return [velocity[k] for k in range(3)]
        axes = frame.carried(np.eye(3)).value
        return [algebra.dot(axes[:, k], velocity) for k in range(3)]

    def _angular(self, algebra: Algebra, frame: Riding) -> list[Number]:
        """Return ωₓ = ẏ·z and so on about the tool's own axes, or about the world's."""
        carried = frame.carried(np.eye(3))
        axes, rates = carried.value, carried.rates
        if rates is None:
            return [None] * 3
        own = [algebra.dot(rates[:, (k + 1) % 3], axes[:, (k + 2) % 3]) for k in range(3)]
        if not self._in_world:
            return own
        return [axes[k, 0] * own[0] + axes[k, 1] * own[1] + axes[k, 2] * own[2] for k in range(3)]
