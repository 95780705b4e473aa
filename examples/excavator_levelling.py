"""An excavator pulls level, and lifts
====================================

A boom and a stick, each moved by a cylinder: what do the cylinders do when the bucket is to travel
level, how far does the machine reach, and what do they carry? The machine is a model file with a
URDF beside it, `excavator.toml` and `excavator.urdf`.
"""

# %%
from pathlib import Path

import numpy as np

import pmjac_pin as pj

here = Path(__file__).parent if "__file__" in globals() else Path.cwd()
excavator = pj.load(here / "excavator.toml")
print(excavator)

# %%
# How far the bucket's pin reaches, over all lengths of the cylinders: a grid of closed poses.
lengths = {
    "boom_cylinder": np.linspace(1.70, 2.95, 41),
    "stick_cylinder": np.linspace(2.55, 3.85, 41),
}
many = pj.batch(excavator)
poses = many.grid(lengths, enforce_limits="all")
places = many.measures(poses.q.reshape(-1, 6)).position
closed = poses.status == pj.Status.CLOSED
print(f"{closed.sum()} of {closed.size} poses close; the bucket's pin reaches")
print(f"  {np.nanmax(places[:, 0]):.2f} m forwards, {-np.nanmin(places[:, 2]):.2f} m down")
print(f"  and {np.nanmax(places[:, 2]):.2f} m up, seen from the boom's foot")

# %%
# What the cylinders carry: boom and stick, and 2.3 t at the pin, a bucket and what is in it.
LOAD = 2300.0 * 9.81  # N
carried = excavator.home.statics([0, 0, -LOAD, 0, 0, 0])
strength = np.array([776e3, 491e3])  # N: chosen, as the dimensions are
for motor, force, limit in zip(excavator.actuated, carried.efforts, strength, strict=True):
    print(f"{motor} pushes with {force / 1e3:.0f} kN: {abs(force) / limit:.0%} of what it can")

# %%
# The same by hand. A cylinder of length l between pins a and b from a hinge has the lever arm
# a b sin(angle) / l, with l² = a² + b² − 2 a b cos(angle): moments about the boom's foot.
boom, stick = excavator.home.passive[:2]
a, b, length = np.hypot(0.75, 0.45), np.hypot(2.3, 0.75), 2.4
angle = np.arccos((a**2 + b**2 - length**2) / (2 * a * b))
assert abs(angle - (boom + np.arctan2(0.75, 2.3) + np.arctan2(0.45, 0.75))) < 1e-12


def forwards(x, z, angle):
    """Return how far forwards a point of a link is, whose x axis is at this angle."""
    return x * np.cos(angle) - z * np.sin(angle)


elbow = forwards(5.7, 0.0, boom)
moment = 1800 * 9.81 * forwards(2.7, 0.4, boom)
moment += 900 * 9.81 * (elbow + forwards(1.0, 0.1, boom + stick))
moment += LOAD * (elbow + forwards(2.9, 0.0, boom + stick))
by_hand = moment / (a * b * np.sin(angle) / length)
print(f"by moments about the boom's foot: {by_hand / 1e3:.0f} kN")
assert abs(carried.efforts[0] - by_hand) < 1e-12 * by_hand

# %%
# To pull level by 2.5 m: the path is the tool's, the cylinders' lengths and speeds are the answer.
x, _, z = excavator.home.tool_pose().translation
DURATION = 5.0  # s
pull = pj.follow(
    excavator, [[x, z], [x - 2.5, z]], coordinates=("x", "z"), times=[0.0, DURATION], samples=51
)
assert pull.status == "end", pull.reason
strokes, fastest = np.ptp(pull.actuated, axis=0), np.abs(pull.rates).max(axis=0)
for motor, stroke, rate in zip(excavator.actuated, strokes, fastest, strict=True):
    print(f"{motor} moves by {stroke:.3f} m, at up to {rate:.3f} m/s")
heights = pull.tool_poses[:, 2, 3]
print(f"the pin stays level to {1e3 * np.ptp(heights):.1e} mm")
assert np.ptp(heights) < 1e-9

# %%
# And how hard it pulls straight back, without weight: until a cylinder is at its limit.
holds = excavator.home.jacobian().force_polytope(strength, rows=["vx", "vz"])
print(f"at home it pulls straight back with up to {holds.along([-1.0, 0.0]) / 1e3:.0f} kN")

# %%
# The arm at home, and how fast its pin moves for rates of the cylinders of length 1.
figure = pj.plot(excavator.home)
