"""A ladder: four-bars that follow one another, the rocker of each the crank of the next."""

from __future__ import annotations

import numpy as np
import pinocchio as pin

from pmjac_pin import Mechanism, PointLoop

CRANK, GROUND, SKEW, ANGLE = 0.8, 1.0, 0.02, 1.2  # m, and rad
NOTHING, WIDE = np.full(1, 1e9), np.full(1, 100.0)


def ladder(count: int) -> Mechanism:
    """Make one of so many loops, couplers longer and shorter than the ground in turn."""
    model, loops, home = pin.Model(), [], {"t0": ANGLE}

    def joint(parent: int, name: str, x: float) -> int:
        at = pin.SE3(np.eye(3), np.array([x, 0.0, 0.0]))
        return model.addJoint(parent, pin.JointModelRZ(), at, name, NOTHING, NOTHING, -WIDE, WIDE)

    def frame(body: int, name: str, x: float) -> str:
        at = pin.SE3(np.eye(3), np.array([x, 0.0, 0.0]))
        model.addFrame(pin.Frame(name, body, at, pin.FrameType.OP_FRAME), False)
        return name

    crank = joint(0, "t0", 0.0)
    for k in range(1, count + 1):
        coupler, rocker = joint(crank, f"c{k}", CRANK), joint(0, f"t{k}", k * GROUND)
        tips = (
            frame(coupler, f"coupler{k}", GROUND + SKEW * (-1) ** k),
            frame(rocker, f"rocker{k}", CRANK),
        )
        loops.append(PointLoop(frames=tips))
        home |= {f"t{k}": ANGLE, f"c{k}": -ANGLE}
        crank = rocker
    return Mechanism.from_pinocchio(
        model, loops, ["t0"], f"rocker{count}", home=home, name=f"ladder of {count}"
    )
