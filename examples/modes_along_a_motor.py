"""Which assembly modes are there along a motor's range?
=====================================================

A 3-RPS can be put together in eight ways at the legs of the lecture's pose A, four of them with the
platform below the base. Where one leg grows or shrinks, ways meet in pairs and end: there the
platform is soft. How many are there for which length, and which ones meet where?
"""

# %%
import numpy as np
from matplotlib.figure import Figure

import pmjac_pin as pj

machine = pj.load("three_rps_ss")
legs = np.array([2 / 3, 3 / 5, 3 / 4])  # m
modes = pj.assembly_modes(machine, legs, rng=0)
print(f"{len(modes)} modes: {modes.evidence}")

# %%
# From each mode all lengths of the first leg are closed at once, others at rest; each pose is on
# the branch of its mode, or its status says that the way there meets a singular pose.
lengths = np.linspace(0.30, 1.20, 181)
values = np.tile(legs, (lengths.size, 1))
values[:, 0] = lengths
many = pj.batch(machine)
on = [many.close(values, guess=mode) for mode in modes]
there = np.array([poses.status == pj.Status.CLOSED for poses in on])
counts = there.sum(axis=0)
for count in np.unique(counts):
    least, most = lengths[counts == count][[0, -1]]
    print(f"{count} of the eight are there between l1 = {least:.3f} and {most:.3f} m")

# %%
# The other way round: all modes are searched for, and proven, at single lengths. Where more were
# found than were followed, some would begin there that do not lead to pose A.
for length in (0.35, 0.50, 0.62, 0.90, 1.15):
    found = pj.assembly_modes(machine, [length, *legs[1:]], rng=0)
    followed = counts[np.argmin(np.abs(lengths - length))]
    print(f"l1 = {length:.2f} m: {len(found)} by {found.evidence.kind}, {followed} followed")
    assert len(found) == followed

# %%
# Where exactly each one ends: `follow` finds the folds. Two modes meet where they end at one pose.
ends = []
for number, mode in enumerate(modes):
    for end in lengths[[0, -1]]:
        way = pj.follow(machine, [legs, [end, *legs[1:]]], start=mode)
        if way.status == "fold":
            ends.append((number, way.end))
meetings = [
    (one, other, a)
    for k, (one, a) in enumerate(ends)
    for other, b in ends[k + 1 :]
    if np.abs(a.q - b.q).max() < 1e-3
]
for one, other, pose in meetings:
    print(f"modes {one} and {other} meet at l1 = {pose.actuated[0]:.6f} m")


# %%
# Held against the lecture's K*, by hand: its determinant is zero where they meet.
def row(one, phi, other, psi):
    """Return the derivatives of one side of the platform by the angles of its two legs."""
    c, s, d, t = np.cos(phi), np.sin(phi), np.cos(psi), np.sin(psi)
    return (
        3 * one * s - one * other * (s * d + 2 * c * t),
        3 * other * t - one * other * (t * c + 2 * d * s),
    )


for _, _, pose in meetings:
    K_star, length, phi = np.zeros((3, 3)), pose.actuated, pose.passive
    for i, j in ((0, 1), (1, 2), (2, 0)):
        K_star[i, [i, j]] = row(length[i], phi[i], length[j], phi[j])
    assert abs(np.linalg.det(K_star)) < 1e-4
print(f"det K* is zero at all {len(meetings)} meetings")

# %%
# All of it as a picture: branches meet where two modes become one, and go no further.
figure = Figure(figsize=(6, 4), layout="constrained")
axes = figure.subplots()
for number, (poses, seen) in enumerate(zip(on, there, strict=True), start=1):
    axes.plot(lengths[seen], poses.joint("theta1")[seen], label=f"mode {number}")
axes.set(xlabel="$l_1$ (m)", ylabel="$\\theta_1$ (rad)")
figure.legend(loc="outside right")
