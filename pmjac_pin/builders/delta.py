"""Delta robots made of their lengths."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike

from pmjac_pin.builders.points import as_length, as_radii
from pmjac_pin.errors import ArgumentError, quoted
from pmjac_pin.mechanism import Mechanism
from pmjac_pin.model.loop_spec import DistanceLoop
from pmjac_pin.values.arrays import Array
from pmjac_pin.values.checks import as_number, as_numbers

_DELTA_LEGS = 3
_RODS = {"a": 0.5, "b": -0.5}  # of a leg, and where they are, as a share of their spacing


def delta(
    base: float,
    arm: float | ArrayLike,
    rod: float | ArrayLike,
    plate: float,
    *,
    spacing: float | None = None,
    tool: float = 0.0,
    directions: ArrayLike = (0.0, 120.0, 240.0),
    home: float = 0.3,
    name: str = "delta",
) -> Mechanism:
    """Make a Delta robot of its lengths.

    Arm i turns about the horizontal through its motor, downwards for positive θ_i, and two
    parallel rods hang the plate on its end. The plate never turns where its three pairs of rods
    are parallel, and hangs below the base at home.

    Parameters
    ----------
    base, plate : float
        From the middle to the motors, and from the plate's middle to its axles, m.
    arm, rod : float or array_like, shape (3,)
        The lengths of the upper arms, and of the rods, m.
    spacing : float, optional
        Between the two rods of a leg, m; half the radius of the plate by default.
    tool : float
        How far the tool is below the plate's middle, m.
    directions : array_like, shape (3,)
        Where the legs are, seen from above, degrees from x to y.
    home : float
        θ of all three arms at home, rad. Arms or rods of unlike lengths turn the plate's home
        aside; its loops are closed then.
    name : str

    Raises
    ------
    ArgumentError
        Lengths that are none; rods that do not reach the plate at home; two legs in one place.
    ClosureError
        No home is found where arms or rods are unlike.

    Examples
    --------
    >>> import pmjac_pin as pj
    >>> machine = pj.delta(base=0.2, arm=0.3, rod=0.7, plate=0.06)
    >>> machine
    Mechanism(delta, actuated=(theta1, theta2, theta3), 6 passive, 6 loops, mobility 3)
    >>> machine.home.tool_pose().translation.round(4).tolist()
    [0.0, 0.0, -0.6436]
    """
    lengths = [as_length(base, "base"), as_length(plate, "plate")]
    arms, rods = (_three(given, what) for given, what in ((arm, "arm"), (rod, "rod")))
    apart = 0.5 * lengths[1] if spacing is None else as_length(spacing, "spacing")
    ways = list(_ways(directions))
    angle = as_number(home, "home")
    height = _depth(lengths[0] - lengths[1], float(np.mean(arms)), float(np.mean(rods)), angle)
    model = pin.Model()
    top = model.addJoint(0, pin.JointModelFreeFlyer(), pin.SE3.Identity(), "platform")
    _add_point_frame(model, "tool", top, np.array([0.0, 0.0, -as_number(tool, "tool")]))
    loops: list[DistanceLoop] = []
    motors = [f"theta{number}" for number in range(1, _DELTA_LEGS + 1)]
    for motor, rotation, of_arm, of_rod in zip(motors, ways, arms, rods, strict=True):
        foot = pin.SE3(rotation, rotation[:, 0] * lengths[0])
        shoulder = model.addJoint(0, pin.JointModelRY(), foot, motor)
        elbow = shoulder, pin.SE3(np.eye(3), np.array([of_arm, 0.0, 0.0]))
        wrist = top, pin.SE3(rotation, rotation[:, 0] * lengths[1])
        loops += _rods_of_leg(model, motor, (elbow, wrist), apart, of_rod)
    pose = (0.0, 0.0, -height, 0.0, 0.0, 0.0, 1.0)
    return Mechanism.from_pinocchio(
        model,
        loops,
        motors,
        "tool",
        home={"platform": pose, **dict.fromkeys(motors, angle)},
        name=name,
        tool_rows=("vx", "vy", "vz"),
    )


def _rods_of_leg(
    model: pin.Model,
    motor: str,
    axles: tuple[tuple[int, pin.SE3], tuple[int, pin.SE3]],
    apart: float,
    length: float,
) -> Iterator[DistanceLoop]:
    """Add the ends of a leg's two rods, on both sides along y of its axles, and yield the rods."""
    number = motor.removeprefix("theta")
    for letter, side in _RODS.items():
        ends = (f"elbow{number}{letter}", f"wrist{number}{letter}")
        for name, (body, axle) in zip(ends, axles, strict=True):
            _add_point_frame(model, name, body, axle.act(np.array([0.0, side * apart, 0.0])))
        yield DistanceLoop(frames=ends, length=length)


def _add_point_frame(model: pin.Model, name: str, joint: int, place: Array) -> None:
    placement = pin.SE3(np.eye(3), place)
    model.addFrame(pin.Frame(name, joint, placement, pin.FrameType.OP_FRAME))


def _three(given: float | ArrayLike, what: str) -> list[float]:
    found = as_numbers(given, what)
    return as_radii(np.full(_DELTA_LEGS, found) if found.ndim == 0 else found, what, _DELTA_LEGS)


def _ways(given: ArrayLike) -> Iterator[Array]:
    """Yield the frames of the legs: x outwards, y about which the motor turns, z upwards."""
    angles = as_numbers(given, "directions")
    if angles.shape != (_DELTA_LEGS,):
        raise ArgumentError(f"directions are {_DELTA_LEGS} angles in degrees, got {quoted(given)}")
    turns = np.exp(1j * np.deg2rad(angles))
    if min(abs(turns[k] - turns[k - 1]) for k in range(_DELTA_LEGS)) < 1e-6:
        raise ArgumentError(f"two legs point the same way: {quoted(given)} degrees")
    for turn in turns:
        cosine, sine = turn.real, turn.imag
        yield np.array([[cosine, -sine, 0.0], [sine, cosine, 0.0], [0.0, 0.0, 1.0]])


def _depth(offset: float, arm: float, rod: float, angle: float) -> float:
    """Return how deep the plate hangs: the elbow is aside of its axle by less than a rod."""
    aside = offset + arm * math.cos(angle)
    if abs(aside) >= rod:
        raise ArgumentError(
            f"the rods are {rod:.6g} m long and do not reach the plate at home: the elbows are "
            f"{abs(aside):.6g} m aside of its axles"
        )
    return arm * math.sin(angle) + math.sqrt(rod**2 - aside**2)
