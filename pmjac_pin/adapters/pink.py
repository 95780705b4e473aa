"""For pink: loops as a constraint of its inverse kinematics, and J_eq as a task."""

from __future__ import annotations

from typing import Any

import numpy as np

from pmjac_pin.adapters import importing
from pmjac_pin.mechanism import Mechanism
from pmjac_pin.rates.independent_equations import independent_loops
from pmjac_pin.values.arrays import Array
from pmjac_pin.values.checks import check_kind

with importing("pink"):
    from pink.tasks import FrameTask, Task


class LoopClosure(Task):
    """Closed loops: e = η(q) with its derivative, in as many equations as are independent.

    One of the `constraints` of ``pink.solve_ik``, whose step leaves the loops open by the square of
    its length; at the next step they are closed again by as much. The equations are combinations of
    the rows of η, in m. Without a cost as one of `tasks`, each weighs 1.

    Raises
    ------
    SingularError
        From ``solve_ik``, where the loops' equations lose rank.

    Examples
    --------
    >>> import pink, pmjac_pin as pj
    >>> from pmjac_pin.adapters.pink import LoopClosure
    >>> bar = pj.load("four_bar")
    >>> model = bar.model
    >>> configuration = pink.Configuration(model, model.createData(), bar.home.q)
    >>> LoopClosure(bar).compute_jacobian(configuration).shape  # of three rows, two tell all
    (2, 3)
    """

    def __init__(self, mechanism: Mechanism, cost: Any = None, gain: float = 1.0) -> None:
        check_kind(mechanism, Mechanism)
        super().__init__(cost=cost, gain=gain)
        self.mechanism = mechanism

    def compute_error(self, configuration: Any) -> Array:
        """Return e, shape (r,), m."""
        return self._equations(configuration.q)[0]

    def compute_jacobian(self, configuration: Any) -> Array:
        """Return ∂e/∂v, shape (r, nv)."""
        return self._equations(configuration.q)[1]

    def _equations(self, q: Array) -> tuple[Array, Array]:
        eta, by_v = self.mechanism.loop_equations(q)
        leading = independent_loops(self.mechanism.problem.partition, by_v, self.mechanism.name)
        return leading @ eta, leading @ by_v

    def __repr__(self) -> str:
        return f"LoopClosure({self.mechanism.name}, cost={self.cost}, gain={self.gain})"


class MotorFrameTask(FrameTask):
    """A frame's pose by the motors alone: J_eq on their columns, 0 on those of passive joints.

    Costs and target are those of ``pink.FrameTask``. What it moves are the motors; the passive
    joints follow by `Mechanism.close`, since J_eq exists on closed loops only.

    Raises
    ------
    ClosureError, SingularError, ForbiddenRatesError, IdleMotionError
        From ``solve_ik``: the loops are open, or as of `Configuration.jacobian`.
    """

    def __init__(self, mechanism: Mechanism, frame: str, *costs: Any, **options: Any) -> None:
        check_kind(mechanism, Mechanism)
        super().__init__(frame, *costs, **options)
        self.mechanism = mechanism.with_tool(frame)

    def compute_jacobian(self, configuration: Any) -> Array:
        """Return −Jlog6 J_eq, shape (6, nv), in the frame's own axes."""
        jacobian = self.mechanism.configuration(configuration.q).jacobian()
        motions = np.zeros((configuration.model.nv,) * 2)
        motions[:, jacobian.partition.actuated] = jacobian.motion_map
        of_tree: Array = super().compute_jacobian(configuration)
        return of_tree @ motions
