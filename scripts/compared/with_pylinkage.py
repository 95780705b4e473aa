"""pylinkage: planar linkages, taken apart into pairs of links."""

from __future__ import annotations

from collections.abc import Mapping
from importlib.metadata import metadata

import numpy as np
import pylinkage as pl
from compared.known import BEYOND, CRANK, LENGTHS, SHORT, error, none, rocker, rocker_rate


def stepped(lengths: Mapping[str, float], crank: float) -> tuple[complex, complex]:
    """Return the rocker as an arrow and the velocity of its end, for 1 rad/s."""
    ends = [pl.Ground(0.0, 0.0), pl.Ground(lengths["l0"], 0.0)]
    motor = pl.Crank(ends[0], lengths["l1"], angular_velocity=1e-9, initial_angle=crank)
    tip = pl.RRRDyad(motor.output, ends[1], lengths["l2"], lengths["l3"], x=2.4, y=3.1)
    linkage = pl.Linkage([*ends, motor, tip], order=[motor, tip])
    linkage.set_input_velocity(motor, 1.0)
    ((places, speeds, _),) = linkage.step_with_derivatives(iterations=1)
    return complex(*places[-1]) - lengths["l0"], complex(*speeds[-1])


def answers() -> Mapping[str, str]:
    """Return what it says, by question."""
    arm, speed = stepped(LENGTHS, CRANK)
    try:
        stepped(SHORT, BEYOND)
        beyond = "a pose"
    except pl.UnbuildableError:
        beyond = "refused: UnbuildableError"
    return {
        "close": error(float(np.angle(arm)), rocker(CRANK)),
        "beyond": beyond,
        "rate": error(float((speed / arm).imag), rocker_rate(CRANK)),
        "singular": none(pl, "singular"),
        "modes": none(pl, "modes"),
        "mobility": "planar only" if "planar" in metadata("pylinkage")["Summary"] else "?",
        "simulate": f"kinematics only: {pl.Simulation.__name__}",
    }
