"""ToolRates: the judged rows of a tool's Jacobian over neighbourhoods of a pose, enclosed."""

from __future__ import annotations

import numpy as np

from pmjac_pin.algebra import Number
from pmjac_pin.algebra.intervals import Intervals
from pmjac_pin.errors import ArgumentError
from pmjac_pin.kinematics.frame_jets import Riding
from pmjac_pin.kinematics.tree import Tree
from pmjac_pin.mechanism import Mechanism
from pmjac_pin.model.frames import find_frame
from pmjac_pin.model.tool_rows import WORLD_AXES
from pmjac_pin.studies.certificates.chains import Chain
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
        frame = find_frame(model, spec.tool.frame)
        self._chain = Chain(Tree(model), 0, frame, unknowns)

    def around(self, poses: Neighbourhoods) -> Intervals:
        """Return the judged rows (b, rows, n): one unit of the unknowns is 1 rad, or 1 m.

        Linear ones in m, angular ones in rad.
        """
        shape = (len(poses.turns), len(self._rows.names), len(self._places))
        lower, upper = np.zeros(shape), np.zeros(shape)
        frame = self._chain.around(poses)
        rates = [*self._linear(frame), *self._angular(frame)]
        chosen = [rates[k] for k in self._rows.linear + self._rows.angular]
        columns = [self._places[column] for column in frame.origin().columns]
        for row, one in enumerate(chosen):
            if columns and one is not None:
                lower[:, row, columns] = np.moveaxis(one.lower, -1, 0)
                upper[:, row, columns] = np.moveaxis(one.upper, -1, 0)
        return Intervals(lower, upper)

    @property
    def _in_world(self) -> bool:
        return self._rows.axes == WORLD_AXES

    def _linear(self, frame: Riding) -> list[Number]:
        """Return the rates (columns, b) of the origin, along the axes of the rows."""
        velocity = frame.origin().rates
        if velocity is None:
            return [None] * 3
        if self._in_world:
            return [velocity[k] for k in range(3)]
        axes = frame.carried(np.eye(3)).value
        return [(axes[:, k] * velocity).sum(axis=0) for k in range(3)]

    def _angular(self, frame: Riding) -> list[Number]:
        """Return ωₓ = ẏ·z and so on about the tool's own axes, or about the world's."""
        carried = frame.carried(np.eye(3))
        axes, rates = carried.value, carried.rates
        if rates is None:
            return [None] * 3
        own = [(rates[:, (k + 1) % 3] * axes[:, (k + 2) % 3]).sum(axis=0) for k in range(3)]
        if not self._in_world:
            return own
        return [axes[k, 0] * own[0] + axes[k, 1] * own[1] + axes[k, 2] * own[2] for k in range(3)]
