"""Whether Crocoddyl was built for the Pinocchio that is installed: else its dynamics are wrong."""

from __future__ import annotations

import warnings

import numpy as np
import pinocchio as pin

from pmjac_pin.adapters import importing

with importing("crocoddyl"):
    import crocoddyl


def warn_of_other_builds() -> None:
    """Warn where Crocoddyl and Pinocchio do not agree on how a pendulum falls."""
    arm = pin.buildSampleModelManipulator()
    state, still = crocoddyl.StateMultibody(arm), np.zeros(arm.nv)
    actuation = crocoddyl.ActuationModelFull(state)
    costs = crocoddyl.CostModelSum(state, arm.nv)
    falling = crocoddyl.DifferentialActionModelFreeFwdDynamics(state, actuation, costs)
    found, q = falling.createData(), np.full(arm.nq, 0.5)
    falling.calc(found, np.concatenate([q, still]), still)
    if not np.allclose(found.xout, pin.aba(arm, arm.createData(), q, still, still), rtol=1e-6):
        wrong = f"Crocoddyl {crocoddyl.__version__} was built for another Pinocchio than"
        todo = "its dynamics are wrong, gravity is missing; install builds of each other's version"
        warnings.warn(f"{wrong} {pin.__version__}: {todo}", RuntimeWarning, stacklevel=4)
