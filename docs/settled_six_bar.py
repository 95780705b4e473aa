"""The accelerations of a Watt six-bar: where a published table leaves its own formula.

Run `python docs/settled_six_bar.py`.
"""

from __future__ import annotations

import numpy as np

import pmjac_pin as pj

#: PMKS+ (github.com/PMKS-Web), the six-bar of its tests: links AB, BCD, DE, EF and FCG.
POINTS = {
    "A": -3.74 - 2.41j,
    "B": -2.72 + 0.91j,
    "C": 1.58 + 0.43j,
    "D": -0.24 + 4.01j,
    "E": 5.08 + 5.31j,
    "F": 8.14 + 3.35j,
    "G": 7.32 - 3.51j,
}
CRANK = 10.0  # rad/s, and no acceleration

#: Its table of accelerations at this pose, m/s² and rad/s².
PUBLISHED = {
    "D": 1767.556952 - 3172.708646j,
    "F": -4214.706537 - 938.3213417j,
    "E": -1628.541536 - 2660.628166j,
}
PUBLISHED_TURNING = {"FCG": 571.7024918, "DE": 238.0335082, "EF": 15.24971074}


#: Frames of the model: at a point, and moving with a link.
FRAMES = {"D": "link_DE", "F": "link_EF", "E": "tip"}
LINKS = {"FCG": "rocker_arm", "DE": "link_DE", "EF": "link_EF"}


def six_bar() -> pj.Configuration:
    """Return the catalogue's Watt six-bar in these sizes, at this pose, its ground along x."""
    A, B, C, D, E, F, G = (POINTS[name] for name in "ABCDEFG")
    sizes = {
        "AG": abs(G - A),
        "AB": abs(B - A),
        "BC": abs(C - B),
        "CD": abs(D - C),
        "GC": abs(C - G),
        "CF": abs(F - C),
        "DE": abs(E - D),
        "EF": abs(E - F),
        "beta": np.angle((D - C) / (C - B)),
        "gamma": np.angle((F - C) / (C - G)),
    }
    angles = {
        "A": np.angle((B - A) / (G - A)),
        "B": np.angle((C - B) / (B - A)),
        "D": np.angle((E - D) / (D - C)),
        "G": np.angle((C - G) / (G - A)),
        "F": np.angle((E - F) / (F - C)),
    }
    mechanism = pj.load("watt_six_bar", sizes)
    return mechanism.close([angles.pop("A")], guess=angles)


def twist_and_rate(pose: pj.Configuration, frame: str) -> tuple[complex, float, complex, float]:
    """Return a frame's velocity and turning, its acceleration and angular acceleration.

    The model's x axis is along the ground link: what is returned is turned to the table's.
    """
    ground = POINTS["G"] - POINTS["A"]
    motion = pose.with_tool(frame).motion([CRANK])
    velocity, acceleration = (
        complex(*twist[:2]) * ground / abs(ground) for twist in (motion.twist, motion.acceleration)
    )
    return velocity, float(motion.twist[5]), acceleration, float(motion.acceleration[5])


def about_a_fixed_point(arm: complex, rate: float, acceleration: float) -> complex:
    """Return α z × r − ω² r: how a point accelerates whose link turns about the ground."""
    return (1j * acceleration - rate**2) * arm


def pair(value: complex) -> str:
    """Return x and y of a vector in the plane."""
    return f"{value.real:13.6f} {value.imag:13.6f}"


def main() -> None:
    """Print what is known of it."""
    pose = six_bar()
    print(f"{'acceleration [m/s2]':24}{'published':27} computed")
    for point, frame in FRAMES.items():
        print(f"  {point:16}{pair(PUBLISHED[point])} {pair(twist_and_rate(pose, frame)[2])}")
    print("angular acceleration [rad/s2]")
    for link, frame in LINKS.items():
        found = twist_and_rate(pose, frame)[3]
        print(f"  {link:16}{PUBLISHED_TURNING[link]:13.6f} {'':13} {found:13.6f}")
    _, rate, _, _ = twist_and_rate(pose, LINKS["FCG"])
    arm = POINTS["F"] - POINTS["G"]
    by_hand = about_a_fixed_point(arm, rate, PUBLISHED_TURNING["FCG"])
    crank = about_a_fixed_point(POINTS["B"] - POINTS["A"], CRANK, 0.0)
    print("F turns about G, so that its acceleration is that of its link's turning alone:")
    print(f"  alpha z x GF - omega^2 GF, alpha of the table  {pair(by_hand)}")
    print(f"  F of the table less this                       {pair(PUBLISHED['F'] - by_hand)}")
    print(f"  twice the acceleration of B, -omega^2 AB       {pair(2 * crank)}")


if __name__ == "__main__":
    main()
