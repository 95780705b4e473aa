"""A million poses of an ankle
============================

Where does an ankle's foot get to, and how evenly do its motors turn it there? A million of their
values are closed at once, and for each there is J_eq: enough to see what is rare, to draw maps, or
to teach a network.
"""

# %%
import time

import numpy as np
from scipy.spatial.transform import Rotation

import pmjac_pin as pj

COUNT, RANGE = 1_000_000, 1.2  # rad to both sides, of each motor
ankle = pj.load("humanoid_ankle")
many = pj.batch(ankle)
print(f"{ankle}, by {many.runs_on}")

# %%
# One status a pose says what `close` would have said: where the straight way from home meets a
# singular pose, it is STOPPED, and nothing is raised for a single one.
values = np.random.default_rng(0).uniform(-RANGE, RANGE, (COUNT, 2))
start = time.perf_counter()
poses = many.close(values)
closing = time.perf_counter() - start
closed = poses.status == pj.Status.CLOSED
print(f"closed in {closing:.1f} s, {1e6 * closing / COUNT:.1f} µs a pose")
for status in pj.Status:
    if count := (poses.status == status).sum():
        print(f"  {count} {status.name}")

# %%
# Where the foot gets to, and how fast it turns there for 1 rad/s of both motors together.
pitch, roll = (np.rad2deg(poses.joint(name)[closed]) for name in ("pitch", "roll"))
print(
    f"pitch {pitch.min():.1f}° to {pitch.max():.1f}°, roll {roll.min():.1f}° to {roll.max():.1f}°"
)
start = time.perf_counter()
found = many.ellipsoids(poses.q[closed])
print(f"J_eq and its radii in {time.perf_counter() - start:.1f} s")
regular = found.status == pj.Status.CLOSED
fast, slow = found.angular_radii[regular, :2].T
uneven = 100 * (fast > 2 * slow).mean()
print(f"the foot turns at {slow.min():.2f} to {fast.max():.2f} rad/s by which way one asks for")
print(f"in {uneven:.1f} % of the poses it turns more than twice as fast one way as across it")

# %%
# Held against geometry, at all of them: both rods have their lengths, 195 and 140 mm.
turned = Rotation.from_euler("YX", np.stack([poses.joint("pitch"), poses.joint("roll")], axis=1))
for motor, zero, rod, side in (("motor1", 1.2028, 0.195, -1), ("motor2", -1.2030, 0.140, 1)):
    angle = poses.joint(motor) + zero
    crank = [np.full(COUNT, -0.041), -0.025 * np.sin(angle), rod + 0.025 * np.cos(angle)]
    heel = turned.apply([-0.041, side * 0.025, 0.009])
    assert np.abs(np.linalg.norm(np.transpose(crank) - heel, axis=1) - rod).max() < 1e-12

# %%
# And ten of them against single calls.
for k in np.flatnonzero(closed)[:10]:
    alone = ankle.close(values[k])
    assert np.abs(alone.q - poses.q[k]).max() < 1e-11
print("all rods have their lengths; single calls say the same")

# %%
# The ankle at home, and how fast its foot turns in either direction.
figure = pj.plot(ankle.home, "angular")
