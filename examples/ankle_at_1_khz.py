"""A humanoid's ankle in a loop of 1 kHz
======================================

Two motors in the shank move a foot by two rods. The controller thinks in pitch and roll, the drives
take torques of the motors: what leads from one to the other changes with the pose, so it is asked
for in every millisecond.
"""

# %%
# The machine, and the joints that the controller thinks in. Calls to `close` and `jacobian` go
# through a recorded program once it has been made: `pj.batch` makes it before the loop starts.
import time

import numpy as np
from scipy.spatial.transform import Rotation

import pmjac_pin as pj

mechanism = pj.load("humanoid_ankle")
ankle = pj.transmission(mechanism, ["pitch", "roll"])
for driven in (ankle.by_motors, ankle.by_joints):
    pj.batch(driven)

# %%
# The plant, for want of a robot: a foot by its moments of inertia about two axes, and somebody who
# leans on it with 40 N m from 1 s on. The controller sees the motors' encoders, and
# how fast pitch and roll change.
INERTIA = np.array([0.010, 0.006])  # kg m²
STIFFNESS, DAMPING = np.array([600.0, 400.0]), np.array([4.9, 3.1])  # N m/rad, N m s/rad
STEP, LIMIT = 1e-3, 60.0  # s, N m of each motor


def target(t):
    """Return pitch and roll that are wanted at t, rad."""
    return np.array([-0.05 + 0.2 * np.sin(3.0 * t), 0.1 * np.sin(5.0 * t)])


geared = ankle.at_motors(mechanism.home.actuated)
joints, rates = np.array(geared.joints), np.zeros(2)
seconds, errors, efforts = [], [], []
for tick in range(2000):
    encoders = ankle.at_joints(joints, geared.configuration).motors  # the plant's side
    start = time.perf_counter()
    geared = ankle.at_motors(encoders, geared.configuration)  # from where it was: the same branch
    error = target(tick * STEP) - geared.joints
    wanted = STIFFNESS * error - DAMPING * rates
    torques = np.clip(geared.motor_efforts(wanted), -LIMIT, LIMIT)
    seconds.append(time.perf_counter() - start)
    leaning = np.array([40.0 if tick > 1000 else 0.0, 0.0])
    rates = rates + STEP * (geared.joint_efforts(torques) + leaning) / INERTIA
    joints = joints + STEP * rates
    errors.append(error)
    efforts.append(torques)

# %%
# What a person wants to know of it.
micro = 1e6 * np.array(seconds)
worst = np.abs(np.rad2deg(errors)).max(axis=0)
print(f"one tick: median {np.median(micro):.0f} µs, 99 % within {np.quantile(micro, 0.99):.0f} µs")
print(f"ticks that took longer than 1 ms: {(micro > 1000).sum()} of {len(micro)}")
print(f"largest error: pitch {worst[0]:.1f}°, roll {worst[1]:.1f}°")
print(f"largest motor torque: {np.abs(efforts).max():.1f} N m of {LIMIT:.0f} N m")

# %%
# Held against geometry that knows nothing of the library: a rod of 195 mm leads from the tip of the
# first crank to the right of the heel, one of 140 mm from that of the second to the left.
turn = Rotation.from_euler("YX", geared.joints)
angles = geared.motors + np.array([1.2028, -1.2030])  # of the cranks from upright
for angle, rod, side in zip(angles, [0.195, 0.140], [-1, 1], strict=True):
    tip = np.array([-0.041, -0.025 * np.sin(angle), rod + 0.025 * np.cos(angle)])
    heel = turn.apply([-0.041, side * 0.025, 0.009])
    assert abs(np.linalg.norm(tip - heel) - rod) < 1e-12
assert worst.max() < 6.0
assert np.abs(efforts).max() < LIMIT
print("at the end both rods have their lengths, to 1e-12 m")

# %%
# The ankle where the second ended.
figure = pj.plot(geared.configuration, "angular")
