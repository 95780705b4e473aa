"""A humanoid's legs: 12 motors, 6 loops. A four-bar drives each knee, two rods each ankle."""

from __future__ import annotations

import numpy as np
import pinocchio as pin

import pmjac_pin as pj

THIGH, SHANK, HALF_HIP, HALF_ANKLE = 0.4, 0.38, 0.09, 0.05  # m
AXES = {"x": pin.JointModelRX, "y": pin.JointModelRY, "z": pin.JointModelRZ}
#: Of one leg, rad.
BENT = {"hip_pitch": -0.4, "knee_motor": 0.8, "knee_rod": -0.8, "knee": 0.8}


def humanoid() -> pj.Mechanism:
    """The legs, slightly bent, on a base that is held; the tool is the left foot."""
    model, loops, motors, home = pin.Model(), [], [], {}
    model.name = "humanoid"
    for side, sign in (("left", 1.0), ("right", -1.0)):
        loops += _leg(model, side, sign)
        names = ("hip_yaw", "hip_roll", "hip_pitch", "knee_motor", "ankle1_motor", "ankle2_motor")
        motors += [f"{side}_{name}" for name in names]
        home |= {f"{side}_{name}": angle for name, angle in BENT.items()}
    return pj.Mechanism.from_pinocchio(model, loops, motors, "left_sole", home=home)


def _leg(model: pin.Model, side: str, sign: float) -> list[pj.RevoluteLoop | pj.SphericalLoop]:
    def joint(parent: int, name: str, axis: str, *place: float) -> int:
        at, wide = pin.SE3(np.eye(3), np.array(place or (0.0, 0.0, 0.0))), np.array([3.0])
        no = np.full(1, 1e9)
        return model.addJoint(parent, AXES[axis](), at, f"{side}_{name}", no, no, -wide, wide)

    def frame(body: int, name: str, *place: float) -> str:
        at = pin.SE3(np.eye(3), np.array(place))
        model.addFrame(pin.Frame(f"{side}_{name}", body, at, pin.FrameType.OP_FRAME), False)
        return f"{side}_{name}"

    thigh = joint(0, "hip_yaw", "z", 0.0, sign * HALF_HIP, 0.0)
    thigh = joint(joint(thigh, "hip_roll", "x"), "hip_pitch", "y")
    crank = joint(thigh, "knee_motor", "y", 0.0, 0.0, -0.1)
    rod = joint(crank, "knee_rod", "y", -0.05, 0.0, 0.0)
    shank = joint(thigh, "knee", "y", 0.0, 0.0, -THIGH)
    pinned = (
        frame(rod, "knee_rod_end", -0.01, 0.0, -0.29),
        frame(shank, "knee_lever", -0.06, 0.0, 0.01),
    )
    loops: list[pj.RevoluteLoop | pj.SphericalLoop]
    loops = [pj.RevoluteLoop(frames=pinned, axis=(0.0, 1.0, 0.0))]
    foot = joint(joint(shank, "ankle_pitch", "y", 0.0, 0.0, -SHANK), "ankle_roll", "x")
    for number, height, half in ((1, 0.24, HALF_ANKLE), (2, 0.16, -HALF_ANKLE)):
        motor = joint(shank, f"ankle{number}_motor", "y", 0.0, half, height - SHANK)
        swing = joint(motor, f"ankle{number}_swing", "y", -0.06, 0.0, 0.0)
        sway = joint(swing, f"ankle{number}_sway", "x")
        ball = (
            frame(sway, f"ankle{number}_rod_end", 0.0, 0.0, -height),
            frame(foot, f"ankle{number}_heel", -0.06, half, 0.0),
        )
        loops.append(pj.SphericalLoop(frames=ball))
    frame(foot, "sole", 0.05, 0.0, -0.06)
    return loops
