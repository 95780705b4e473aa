"""A Stewart platform as a motion base
====================================

Six cylinders carry the cabin of a simulator. How far, how fast and with what load does it go within
the limits of its cylinders, and does a manoeuvre fit in?
"""

# %%
import numpy as np
import pinocchio as pin
from scipy.spatial.transform import Rotation

import pmjac_pin as pj

STROKE, FASTEST, STRONGEST = (1.45, 2.25), 0.6, 15e3  # m, m/s, N
HOME, WEIGHT = np.array([0.0, 0.0, 1.55]), np.array([0.0, 0.0, -1800.0 * 9.81])  # m, N


def ring(radius, turned):
    """Return six points in three pairs, 20° apart on a circle, m."""
    angles = np.deg2rad([turned + 120 * k + side * 10 for k in range(3) for side in (-1, 1)])
    return radius * np.stack([np.cos(angles), np.sin(angles), 0.0 * angles], axis=1)


feet, heads = ring(1.6, 0.0), np.roll(ring(1.2, 60.0), 1, axis=0)
base = pj.stewart(feet, heads, HOME[2], stroke=STROKE, name="motion_base")
print(base)


def legs(position, rotation):
    """Return the cylinders from foot to head, p + R head − foot: the textbook's inverse."""
    return position + heads @ rotation.T - feet


# %%
# How far, along and about each axis alone: `reach` goes straight towards a pose that is far away,
# and stops where a cylinder is at its limit. There the textbook's lengths are those limits, too.
rates = np.linalg.inv(base.home.jacobian().J_eq)  # of cylinders, by the platform's twist
print("alone         to       at once   until")
for axis, name in enumerate(("surge", "sway", "heave", "roll", "pitch", "yaw")):
    twist = 1.5 * np.eye(6)[axis]
    ended = pj.reach(base, pin.SE3(pin.exp3(twist[3:]), HOME + twist[:3]))
    assert ended.status == "at a limit", ended.message
    pose = ended.configuration.tool_pose()
    lengths = np.linalg.norm(legs(pose.translation, pose.rotation), axis=1)
    assert np.abs(lengths[:, None] - STROKE).min() < 1e-8
    far = np.concatenate([pose.translation - HOME, pin.log3(pose.rotation)])[axis]
    fast, stopped = FASTEST / np.abs(rates[:, axis]).max(), ", ".join(ended.joints)
    if axis < 3:
        print(f"{name:6}  {far:6.2f} m  {fast:6.2f} m/s   {stopped}")
    else:
        print(f"{name:6}  {np.rad2deg(far):6.1f} °  {np.rad2deg(fast):6.1f} °/s   {stopped}")

# %%
# What the cylinders push with, level and tilted: the cabin's weight acts 0.6 m above the platform.
# Held against the sum of six forces along the cylinders.
for tilt in (0.0, np.deg2rad(20.0)):
    turned = pin.exp3(np.array([0.0, tilt, 0.0]))
    pose, moment = pj.reach(base, pin.SE3(turned, HOME)), np.cross(0.6 * turned[:, 2], WEIGHT)
    pushes = pose.configuration.statics(np.concatenate([WEIGHT, moment])).efforts
    lines = legs(HOME, turned)
    lines /= np.linalg.norm(lines, axis=1)[:, None]
    assert np.abs(lines.T @ pushes + WEIGHT).max() < 1e-8
    assert np.abs(np.cross(heads @ turned.T, lines).T @ pushes + moment).max() < 1e-8
    print(f"tilted by {np.rad2deg(tilt):.0f}°: {pushes.min():.0f} to {pushes.max():.0f} N", end="")
    print(f" of {STRONGEST:.0f} N")

# %%
# A manoeuvre, a bump while the cabin leans into a bend: does it fit in, and how much of it would?
# Held against the textbook's lengths at 10,000 times.
turn, times = 2.0 * np.pi, np.linspace(0.0, 2.0 * np.pi, 10_000)


def manoeuvre(t, size):
    """Return the cylinders' lengths at a time, for a size of which 1 is wanted."""
    place = HOME + size * np.array([0.2 * np.sin(t), 0.0, 0.12 * np.sin(3.0 * t)])
    leaning = Rotation.from_euler("XY", size * np.array([0.1, 0.13]) * np.sin(t))
    return np.linalg.norm(legs(place, leaning.as_matrix()), axis=1)


wanted, fits, too_large = pj.follow(base, lambda t: manoeuvre(t, 1.0), times=(0, turn)), 1.0, 2.0
print(f"as wanted: {wanted.status}, at up to {np.abs(wanted.rates).max():.2f} of {FASTEST} m/s")
while too_large - fits > 0.02:
    size = (fits + too_large) / 2.0
    tried = pj.follow(base, lambda t, size=size: manoeuvre(t, size), times=(0, turn))
    fits, too_large = (size, too_large) if tried.reached else (fits, size)
print(f"it fits up to {fits:.2f} times as large")
for size in (fits, too_large):
    lengths = np.array([manoeuvre(t, size) for t in times])
    assert (STROKE[0] < lengths.min() and lengths.max() < STROKE[1]) == (size == fits)

# %%
# The base at home.
figure = pj.plot(base.home)
