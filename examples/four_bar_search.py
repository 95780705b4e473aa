"""Dimensions by search, where some machines do not exist
======================================================

A crank that turns is to swing a rocker of 120 mm by 60°, and the coupler is to push it as squarely
as it can all the way round. Which crank and which coupler? Some designs that a search tries cannot
be assembled, and with others the crank cannot turn: both are answers, and cost the search nothing.
"""

# %%
from collections import Counter

import numpy as np
from scipy.optimize import minimize

import pmjac_pin as pj

FRAME, ROCKER, SWING = 0.300, 0.120, np.deg2rad(60.0)  # m, m, rad
turn = np.linspace(0.0, 2.0 * np.pi, 61)[:, None]
linkage = pj.load("four_bar", {"l0": FRAME, "l1": 0.06, "l2": 0.28, "l3": ROCKER})
became = Counter()


def measured(crank, coupler):
    """Return the rocker's swing and the least angle between it and the coupler, or why not."""
    try:
        design = linkage.with_parameters(l1=crank, l2=coupler)
    except pj.ClosureError:
        return "cannot be assembled"
    poses = pj.batch(design).close(turn, enforce_limits=False)
    if (poses.status != pj.Status.CLOSED).any():
        return "the crank cannot turn"
    angle = poses.joint("phi1")
    across = np.sin(poses.joint("theta1") + poses.joint("phi2") - angle)
    return np.ptp(angle), np.arcsin(np.abs(across).min())


def badness(lengths):
    """Return what the search makes small: how far from square, and how far from the swing."""
    found = measured(*lengths)
    if isinstance(found, str):
        became[found] += 1
        return 10.0
    became["turns"] += 1
    return np.pi / 2 - found[1] + 30.0 * (found[0] - SWING) ** 2


# %%
# Some designs at random, and from the best of them downhill by SciPy.
rng = np.random.default_rng(0)
first = min(rng.uniform([0.02, 0.08], [0.12, 0.40], (16, 2)), key=badness)
print("designs at random:", ", ".join(f"{count} {what}" for what, count in became.items()))
search = minimize(badness, first, method="Nelder-Mead", options={"xatol": 1e-4, "fatol": 1e-4})
swing, across = measured(*search.x)
crank, coupler = 1e3 * search.x
print(f"after {search.nfev} more: crank {crank:.1f} mm, coupler {coupler:.1f} mm,")
print(f"  swing {np.rad2deg(swing):.2f}°, never less than {np.rad2deg(across):.2f}° across")

# %%
# Held against formulas: the rocker turns back where crank and coupler are in line, and stands least
# square where the crank is in line with the frame. The law of cosines says where. And of 40,000
# designs by these formulas none is better.


def by_hand(crank, coupler):
    """Return swing and least angle across of any number of designs; NaN where the crank sticks."""
    back = [FRAME**2 + ROCKER**2 - (coupler + s * crank) ** 2 for s in (1, -1)]
    line = [coupler**2 + ROCKER**2 - (FRAME + s * crank) ** 2 for s in (1, -1)]
    with np.errstate(invalid="ignore"):
        ends = np.arccos(np.divide(back, 2 * FRAME * ROCKER))
        angles = np.arccos(np.divide(line, 2 * coupler * ROCKER))
    return abs(ends[0] - ends[1]), np.minimum(angles, np.pi - angles).min(axis=0)


assert np.abs(np.subtract((swing, across), by_hand(*search.x))).max() < 1e-3
swings, acrosses = by_hand(*np.meshgrid(np.linspace(0.02, 0.12, 200), np.linspace(0.08, 0.40, 200)))
best = np.nanmin(np.pi / 2 - acrosses + 30.0 * (swings - SWING) ** 2)
print(f"badness {search.fun:.4f}; of 40,000 designs by formulas the best has {best:.4f}")
assert search.fun < best + 1e-3

# %%
# The four-bar that was found.
figure = pj.plot(linkage.with_parameters(l1=search.x[0], l2=search.x[1]).home)
