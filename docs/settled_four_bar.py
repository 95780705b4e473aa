"""A four-bar that programs draw differently, and how far its crank turns.

Run `python docs/settled_four_bar.py`.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

import pmjac_pin as pj

Place = tuple[float, float]

#: Crank on the ground, crank to coupler, coupler to rocker, rocker on the ground; E is the tracer.
JOINTS: dict[str, Place] = {
    "A": (4.1, 3.75),
    "B": (1.244, 0.196),
    "C": (-2.32, -2.293),
    "D": (0.165, 1.322),
    "E": (-2.591, 1.657),
}


class Lengths(NamedTuple):
    """Of the four links, in the units of the joints' places."""

    ground: float
    crank: float
    coupler: float
    rocker: float


def lengths_of(joints: Mapping[str, Place]) -> Lengths:
    """Return |AD|, |AB|, |BC| and |CD|."""
    A, B, C, D = (np.array(joints[name]) for name in "ABCD")
    return Lengths(*(float(np.linalg.norm(q - p)) for p, q in ((A, D), (A, B), (B, C), (C, D))))


def excess(lengths: Lengths) -> float:
    """Return Grashof's s + l − (p + q): positive where no link can turn fully."""
    shortest, *others, longest = sorted(lengths)
    return shortest + longest - sum(others)


def drawn(joints: Mapping[str, Place]) -> pj.Configuration:
    """Return the four-bar as it is drawn: the crank's angle is counted from A towards D."""
    sizes = zip(("l0", "l1", "l2", "l3"), lengths_of(joints), strict=True)
    mechanism = pj.load("four_bar", dict(sizes))
    A, B, C, D = (complex(*joints[name]) for name in "ABCD")
    along = (D - A) / abs(D - A)
    middle = ((B + C) / 2 - A) / along
    modes = pj.assembly_modes(mechanism, [np.angle((B - A) / along)])
    return min(modes, key=lambda mode: abs(complex(*mode.tool_pose().translation[:2]) - middle))


def travel(start: pj.Configuration) -> tuple[float, float]:
    """Return the crank's angles at which a way from here backwards and forwards ends, rad."""
    [angle] = start.actuated
    ways = (
        pj.follow(start.mechanism, [[angle], [angle + way * np.pi]], start=start)
        for way in (-1.0, 1.0)
    )
    low, high = (float(way.end.actuated[0]) for way in ways)
    return low, high


def swing(start: pj.Configuration, angle: float) -> float:
    """Return by how much the rocker turns while the crank goes from an angle to its negative."""
    rocker = [start.mechanism.close([way * angle], guess=start).passive[0] for way in (1.0, -1.0)]
    return float(rocker[1] - rocker[0])


def changes_of_side(joints: Mapping[str, Place], step: float) -> list[float]:
    """Return the crank's angles at which a program of steps changes over to another mode, rad.

    Such a program turns the crank by a step, here backwards, has the coupler's circle about B meet
    the rocker's about D, and keeps of the two points the one that is nearer to the last. A change
    of the point's side of the line from B to D is a change of the assembly mode.
    """
    coupler, rocker = lengths_of(joints)[2:]
    A, B, C, D = (complex(*joints[name]) for name in "ABCD")
    side, changes = np.sign(((C - B) / (D - B)).imag), []
    while True:
        B = A + (B - A) * np.exp(-1j * step)
        along = (abs(D - B) ** 2 + coupler**2 - rocker**2) / (2 * abs(D - B))
        if abs(along) > coupler:  # the circles do not meet: it stops
            return changes
        across = np.sqrt(coupler**2 - along**2)
        places = {way: B + (along + 1j * way * across) * (D - B) / abs(D - B) for way in (1, -1)}
        nearer = min(places, key=lambda way: abs(places[way] - C))
        if nearer != side:
            changes.append(float(np.angle((B - A) / (D - A))))
        side, C = nearer, places[nearer]


def main() -> None:
    """Print what is known of it."""
    rounded = {name: (round(x, 1), round(y, 1)) for name, (x, y) in JOINTS.items()}
    for words, joints in (("as given", JOINTS), ("rounded to 0.1", rounded)):
        lengths = lengths_of(joints)
        share = excess(lengths) / (sum(lengths) - min(lengths) - max(lengths))
        print(f"joints {words}:")
        print("  ", "  ".join(f"{name} {size:.6f}" for name, size in lengths._asdict().items()))
        print(f"   s + l - (p + q) = {excess(lengths):+.6f}, {share:+.2%} of p + q")
        start = drawn(joints)
        low, high = np.degrees(travel(start))
        print(f"   the crank stands at {np.degrees(start.actuated[0]):.3f} deg from AD")
        print(f"   it turns from {low:.6f} to {high:.6f} deg, {high - low:.4f} in all")
    swung = np.degrees(swing(drawn(JOINTS), np.radians(2.0)))
    print(f"as given, the rocker swings by {swung:.1f} deg as the crank goes from 2 to -2 deg")
    for step in (10.0, 5.0, 2.0, 1.0):
        found = np.degrees(changes_of_side(JOINTS, np.radians(step)))
        told = f"change of mode at {', '.join(f'{angle:.3f} deg' for angle in found)}"
        print(f"steps of {step:g} deg, the nearer intersection: {told if found.size else 'none'}")


if __name__ == "__main__":
    main()
