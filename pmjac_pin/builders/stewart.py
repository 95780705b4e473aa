"""Stewart-Gough platforms made of their points."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike

from pmjac_pin.builders.points import as_pose, as_radii, points, upright
from pmjac_pin.errors import ArgumentError
from pmjac_pin.mechanism import Mechanism
from pmjac_pin.model.loop_spec import SphericalLoop
from pmjac_pin.values.arrays import Array

_STEWART_LEGS = 6


def stewart(
    base_points: ArrayLike,
    platform_points: ArrayLike,
    platform: float | pin.SE3,
    *,
    stroke: ArrayLike | None = None,
    name: str = "stewart",
) -> Mechanism:
    """Make a Stewart-Gough platform (6-UPS) of its joints' places.

    Leg i stands on a universal joint at base point i, slides by its motor li, and holds the
    platform by a ball at platform point i: |b_i − (p + R p_i)| = l_i. Its passive angles are zero
    at home.

    Parameters
    ----------
    base_points : array_like, shape (6, 3)
        In the world, m.
    platform_points : array_like, shape (6, 3)
        In the platform's frame, which is the tool's, m.
    platform : float or pin.SE3
        Where the platform is at home: how high above the world's origin, m, or its pose.
    stroke : (float, float), optional
        The shortest and the longest leg, m; a tenth to ten times the home lengths by default.
    name : str

    Raises
    ------
    ArgumentError
        Other shapes; a leg without length at home, or beyond its stroke.

    Examples
    --------
    The rows of the inverse Jacobian are the lines of the legs, (n_i, R p_i × n_i):

    >>> import numpy as np, pmjac_pin as pj
    >>> turn = np.deg2rad([0.0, 60.0, 120.0, 180.0, 240.0, 300.0])
    >>> ring = np.stack([np.cos(turn), np.sin(turn), 0.0 * turn], axis=1)
    >>> machine = pj.stewart(ring[[0, 0, 2, 2, 4, 4]], 0.5 * ring[[5, 1, 1, 3, 3, 5]], 1.0)
    >>> machine
    Mechanism(stewart, actuated=(l1, l2, l3, ...), 18 passive, 6 loops, mobility 6)
    >>> legs = 0.5 * ring[[5, 1, 1, 3, 3, 5]] + [0.0, 0.0, 1.0] - ring[[0, 0, 2, 2, 4, 4]]
    >>> n = legs / np.linalg.norm(legs, axis=1)[:, None]
    >>> lines = np.hstack([n, np.cross(0.5 * ring[[5, 1, 1, 3, 3, 5]], n)])
    >>> bool(np.allclose(lines @ machine.home.jacobian().J_eq, np.eye(6)))
    True
    """
    base = points(base_points, "base_points", _STEWART_LEGS)
    held = points(platform_points, "platform_points", _STEWART_LEGS)
    home = as_pose(platform)
    legs = held @ home.rotation.T + home.translation - base
    lengths = np.linalg.norm(legs, axis=1)
    model, q = pin.Model(), {"platform": pin.SE3ToXYZQUAT(home).tolist()}
    top = model.addJoint(0, pin.JointModelFreeFlyer(), pin.SE3.Identity(), "platform")
    model.addFrame(pin.Frame("tool", top, pin.SE3.Identity(), pin.FrameType.OP_FRAME))
    limits = np.outer([0.1, 10.0], lengths) if stroke is None else _stroke(stroke, lengths)
    for number, (foot, leg, point) in enumerate(zip(base, legs, held, strict=True), start=1):
        if not lengths[number - 1] > 0.0:
            raise ArgumentError(f"leg {number} has no length at home: its points agree")
        _add_leg(model, number, pin.SE3(upright(leg), foot), limits[:, number - 1])
        place = pin.SE3(np.eye(3), point)
        model.addFrame(pin.Frame(f"P{number}", top, place, pin.FrameType.OP_FRAME))
        q[f"l{number}"] = float(lengths[number - 1])
    numbers = range(1, _STEWART_LEGS + 1)
    loops = [SphericalLoop(frames=(f"P{number}", f"rod{number}")) for number in numbers]
    return Mechanism.from_pinocchio(
        model, loops, [f"l{number}" for number in numbers], "tool", home=q, name=name
    )


def _stroke(given: ArrayLike, lengths: Array) -> Array:
    shortest, longest = as_radii(given, "stroke", 2)
    for number, length in enumerate(lengths.tolist(), start=1):
        if not shortest <= length <= longest:
            raise ArgumentError(
                f"leg {number} is {length:.6g} m long at home, beyond its stroke of "
                f"{shortest:.6g} to {longest:.6g} m"
            )
    return np.outer([shortest, longest], np.ones(_STEWART_LEGS))


def _add_leg(model: pin.Model, number: int, foot: pin.SE3, stroke: Array) -> None:
    still = pin.SE3.Identity()
    cross = model.addJoint(0, pin.JointModelRX(), foot, f"alpha{number}")
    tube = model.addJoint(cross, pin.JointModelRY(), still, f"beta{number}")
    slide, sliding = pin.JointModelPZ(), np.ones(1)
    low, high = stroke[:1], stroke[1:]
    rod = model.addJoint(
        tube, slide, still, f"l{number}", np.inf * sliding, np.inf * sliding, low, high
    )
    model.addFrame(pin.Frame(f"rod{number}", rod, still, pin.FrameType.OP_FRAME))
