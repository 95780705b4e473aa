"""For mink: a closed machine in MuJoCo, and its loops as a constraint of inverse kinematics."""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import Any

import numpy as np

from pmjac_pin.adapters import importing
from pmjac_pin.mechanism import Mechanism
from pmjac_pin.rates.factorisation import factorise
from pmjac_pin.rates.independent_equations import leading_rows
from pmjac_pin.studies.export.export import export
from pmjac_pin.values.arrays import Array

with importing("mink"):
    import mink
    import mujoco


def exported_model(mechanism: Mechanism) -> Any:
    """Return what MuJoCo makes of a mechanism's export to MJCF; its keyframe is `home`.

    Its equalities are named after the frames of the loops, as `pmjac_pin.export` does.

    Raises
    ------
    ArgumentError
        As `pmjac_pin.export`.
    """
    with tempfile.TemporaryDirectory() as folder:
        exported = export(mechanism, to="mjcf", file=Path(folder) / "machine.xml")
        return mujoco.MjModel.from_xml_path(str(exported.paths[0]))


class LoopClosure(mink.EqualityConstraintTask):
    """All equalities of an exported model, in as many equations as are independent.

    One of the `constraints` of ``mink.solve_ik``, as ``mink.EqualityConstraintTask`` is, which has
    all rows, and which does not know of tendons, by which rods are held at their lengths.

    Parameters
    ----------
    mechanism : Mechanism
    model : mujoco.MjModel
        Its `exported_model`.
    cost, gain : float
        As of ``mink.Task``.

    Raises
    ------
    SingularError
        From ``solve_ik``, where the loops' equations lose rank.
    """

    def __init__(self, mechanism: Mechanism, model: Any, cost: float = 1.0, gain: float = 1.0):
        super().__init__(model, cost=cost, gain=gain)
        partition = mechanism.problem.partition
        self._rank = model.nv - partition.column_scale.size + partition.constraint_rank
        self._weight = cost

    def compute_error(self, configuration: Any) -> Array:
        """Return e, shape (r,)."""
        leading = self._leading(configuration)
        error: Array = leading @ super().compute_error(configuration)
        self.cost = np.full(self._rank, self._weight)
        return error

    def compute_jacobian(self, configuration: Any) -> Array:
        """Return ∂e/∂v, shape (r, nv)."""
        leading = self._leading(configuration)
        jacobian: Array = leading @ super().compute_jacobian(configuration)
        self.cost = np.full(self._rank, self._weight)
        return jacobian

    def _leading(self, configuration: Any) -> Array:
        mujoco.mj_fwdPosition(configuration.model, configuration.data)
        rows: Array = super().compute_jacobian(configuration)
        factors = factorise(rows, float(np.linalg.norm(rows)))
        return leading_rows(factors, self._rank, "the equalities")
