"""pylinkage: planar linkages, taken apart into pairs of links."""

from __future__ import annotations

from collections.abc import Mapping
from importlib.metadata import metadata

import numpy as np
import pylinkage
from compared.known import (
    BEYOND,
    CRANK,
    LENGTHS,
    SHORT,
    SHORT_ENDS,
    SHORT_NEAR,
    error,
    own_lines,
    rocker,
    rocker_rate,
)


def stepped(
    lengths: Mapping[str, float], crank: float, near: complex = 2.4 + 3.1j
) -> tuple[complex, complex | None]:
    """Return the rocker as an arrow and the velocity of its end, where it has one, for 1 rad/s."""
    ends = [pylinkage.Ground(0.0, 0.0), pylinkage.Ground(lengths["l0"], 0.0)]
    motor = pylinkage.Crank(ends[0], lengths["l1"], angular_velocity=1e-9, initial_angle=crank)
    tip = pylinkage.RRRDyad(
        motor.output, ends[1], lengths["l2"], lengths["l3"], x=near.real, y=near.imag
    )
    linkage = pylinkage.Linkage([*ends, motor, tip], order=[motor, tip])
    linkage.set_input_velocity(motor, 1.0)
    ((places, speeds, _),) = linkage.step_with_derivatives(iterations=1)
    arm = complex(*places[-1]) - lengths["l0"]
    return arm, None if speeds[-1] is None else complex(*speeds[-1])


def builds(crank: float) -> bool:
    """Return whether the short linkage can be built at an angle of the crank."""
    try:
        stepped(SHORT, crank)
    except pylinkage.UnbuildableError:
        return False
    return True


def end_of_mode() -> float:
    """Return the largest angle at which it can be built, by halving."""
    low, high = SHORT_NEAR, BEYOND
    while low < (middle := (low + high) / 2) < high:
        low, high = (middle, high) if builds(middle) else (low, middle)
    return low


def ways() -> int:
    """Count what is found from guesses on both sides of the ground."""
    found = {np.round(stepped(LENGTHS, CRANK, side)[0], 6) for side in (2.4 + 3.1j, 2.4 - 3.1j)}
    return len(found)


def answers() -> Mapping[str, str]:
    """Return what it says, by question."""
    arm, speed = stepped(LENGTHS, CRANK)
    beyond = "a pose" if builds(BEYOND) else f"refused: {pylinkage.UnbuildableError.__name__}"
    return {
        "close": error(float(np.angle(arm)), rocker(CRANK)),
        "beyond": beyond,
        "rate": error(float((speed / arm).imag), rocker_rate(CRANK)),
        "singular": own_lines(pylinkage, "singular", error(end_of_mode(), SHORT_ENDS)),
        "modes": own_lines(pylinkage, "modes", f"{ways()} from two guesses"),
        "mobility": "planar only" if "planar" in metadata("pylinkage")["Summary"] else "?",
        "simulate": f"kinematics only: {pylinkage.Simulation.__name__}",
    }
