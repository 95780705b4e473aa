"""pmjac_pin itself."""

from __future__ import annotations

from collections.abc import Mapping

from compared.known import (
    BEYOND,
    CRANK,
    LENGTHS,
    SHORT,
    SHORT_ENDS,
    error,
    none,
    rocker,
    rocker_rate,
)

import pmjac_pin as pj


def answers() -> Mapping[str, str]:
    """Return what it says, by question."""
    bar, short = pj.load("four_bar", LENGTHS), pj.load("four_bar", SHORT)
    pose = bar.close([CRANK])
    try:
        short.close([BEYOND])
        beyond = "closes"
    except pj.ClosureError as refused:
        beyond = f"refused: the mode ends after {100 * refused.share:.0f} % of the way"
    end = pj.follow(short, [[0.9], [BEYOND]])
    modes = pj.assembly_modes(bar, [CRANK], rng=0)
    return {
        "close": error(float(pose.joint_values["phi1"]), rocker(CRANK)),
        "beyond": beyond,
        "rate": error(float(pose.jacobian().passive_rates[0, 0]), rocker_rate(CRANK)),
        "singular": f"{end.status}, {error(float(end.end.actuated[0]), SHORT_ENDS)}",
        "modes": f"{len(modes)}, by {modes.evidence.kind}",
        "mobility": str(pj.load("bennett").mobility),
        "simulate": none(pj, "simulate"),
    }
