"""Machines whose loci and workspaces are known in closed form."""

from functools import cache

import numpy as np
from mechanisms import build

Z = (0.0, 0.0, 1.0)
BASE = np.array([[0.0, 0.0], [15.91, 0.0], [0.0, 10.0]])
SIDES = {"d12": 17.04, "d23": 16.54, "d31": 20.84}


def platform_corners():
    """The platform's corners in its own plane, the first at the origin, the second on x."""
    a, b, c = SIDES["d12"], SIDES["d31"], SIDES["d23"]
    x = (a * a + b * b - c * c) / (2.0 * a)
    return np.array([[0.0, 0.0], [a, 0.0], [x, np.sqrt(b * b - x * x)]])


@cache
def cuspidal_3rpr():
    """The 3-RPR of Innocenti and Parenti-Castelli: six modes, cusps, all legs from 1 to 60."""
    joints, corners = [], platform_corners()
    for k, foot in enumerate(BASE, start=1):
        joints.append((f"turn{k}", "revolute", "ground", f"leg{k}", (*foot.tolist(), 0.0), Z))
        joints.append((f"rho{k}", "prismatic", f"leg{k}", f"rod{k}", (0, 0, 0), (1, 0, 0)))
    joints.append(("angle", "revolute", "rod1", "plate", (0, 0, 0), Z))
    for k in (2, 3):
        joints.append((f"c{k}", "fixed", "plate", f"corner{k}", (*corners[k - 1].tolist(), 0.0)))
    home = {"rho1": 14.98, "rho2": 15.38, "rho3": 12.0, "turn1": 0.5, "angle": 0.3}
    loops = [("corner2", "rod2"), ("corner3", "rod3")]
    return build(joints, loops, ["rho1", "rho2", "rho3"], "plate", home)
