"""A Delta robot picks and places
==============================

25 mm up, 305 mm across, 25 mm down, and back: the cycle by which such robots are compared. How fast
can this one do it with the motors that it has, and what do these do meanwhile?
"""

# %%
import numpy as np
from scipy.interpolate import CubicSpline

import pmjac_pin as pj

BASE, ARM, ROD, PLATE = 0.164, 0.250, 0.600, 0.045  # m
FASTEST, HARDEST = 15.0, 350.0  # of each motor behind its gears: rad/s, rad/s²
delta = pj.delta(base=BASE, arm=ARM, rod=ROD, plate=PLATE)
print(delta)

# %%
# The path is the tool's: a gate with round corners, and on it a time law that starts and ends at
# rest, as a spline of x, y and z over a time that runs from 0 to 2, there and back.
corners = np.array(
    [[-1, 0], [-1, 0.4], [-0.94, 0.9], [-0.7, 1], [0, 1], [0.7, 1], [0.94, 0.9], [1, 0.4], [1, 0]]
)
gate = corners * [0.305 / 2, 0.025]
way = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(gate, axis=0), axis=1))])
curve = CubicSpline(way / way[-1], gate, bc_type="clamped")
times = np.linspace(0.0, 2.0, 81)
share = 1.0 - abs(1.0 - times)
across, lift = curve(share**3 * (10.0 - 15.0 * share + 6.0 * share**2)).T
path = CubicSpline(times, np.stack([across, 0.0 * across, lift - 0.62], axis=1), bc_type="clamped")

# %%
# `follow` drives the machine by its tool and stays on one working mode. The first point is reached
# straight from home.
cycle = pj.follow(delta, path, coordinates=("x", "y", "z"), samples=401)
assert cycle.reached, cycle.reason
print(cycle.homecoming)

# %%
# In half the time rates are twice as large and accelerations four times.
rate, acceleration = np.abs(cycle.rates).max(), np.abs(cycle.accelerations).max()
duration = 2.0 * max(rate / FASTEST, np.sqrt(acceleration / HARDEST))
faster = 2.0 / duration
print(f"the cycle takes {duration:.3f} s: {60.0 / duration:.0f} picks a minute")
print(f"motors turn at up to {faster * rate:.1f} rad/s and {faster**2 * acceleration:.0f} rad/s²")

# %%
# Is every part of the path far from poses in which the machine is soft or stuck? Radii of the
# velocity ellipsoid are m/s of the plate for 1 rad/s of all motors together.
radii = pj.batch(delta).ellipsoids(cycle.q).velocity_radii
assert np.isfinite(radii).all()
print(f"1 rad/s moves the plate by {radii.min():.3f} m/s at least, {radii.max():.3f} m/s at most")

# %%
# Held against closed formulas. In the plane of a leg, with the plate's axle at (x, z) and y beside
# it, elbow and axle are a rod's length apart where A cos θ + B sin θ = C.
for leg, turn in enumerate(np.deg2rad([0.0, 120.0, 240.0])):
    x0, y0, z = cycle.tool_poses[:, :3, 3].T
    x = np.cos(turn) * x0 + np.sin(turn) * y0 + PLATE - BASE
    y = np.cos(turn) * y0 - np.sin(turn) * x0
    a, b, c = 2 * ARM * x, -2 * ARM * z, x**2 + y**2 + z**2 + ARM**2 - ROD**2
    by_hand = np.arctan2(b, a) - np.arccos(c / np.hypot(a, b))
    assert np.abs(by_hand - cycle.actuated[:, leg]).max() < 1e-11
assert np.abs(cycle.tool_poses[:, :3, 3] - path(cycle.t)).max() < 1e-11
print("all motor angles agree with closed formulas to 1e-11 rad")
