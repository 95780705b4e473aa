"""Teaching the lecture: a 3-RPS on the blackboard and in the machine
===================================================================

A. Ghosal, *Robotics: Basics and Selected Advanced Concepts*, lecture 21, "Parallel Manipulator
Jacobian Matrix", in the order of a blackboard: each line is an equation of the lecture in NumPy,
and beside it stands what the library says. Equation numbers are the lecture's.
"""

# %%
import numpy as np
from scipy.spatial.transform import Rotation

import pmjac_pin as pj

A, B = 0.5, 1.0  # circumradius of the platform and of the base, m
machine = pj.load("three_rps_ss")
pose = machine.pose("lecture_a")
legs = pose.actuated  # the lecture's l: the motors, θ in its equations
leaning = pose.passive  # the lecture's θ: the passive joints, φ in its equations
print(f"legs of {legs.round(4)} m lean by {leaning.round(4)} rad")

# %%
# **The points.** Leg i stands at B on a circle, 120° apart, and leans inwards by its passive angle:
# S = R (B − l cos φ, 0, l sin φ). With it go its derivatives by l and by φ.
S, S_l, S_phi = np.zeros((3, 3, 3))
for leg, (length, phi) in enumerate(zip(legs, leaning, strict=True)):
    R = Rotation.from_euler("z", 120 * leg, degrees=True).as_matrix()
    S[leg] = R @ [B - length * np.cos(phi), 0, length * np.sin(phi)]
    S_l[leg] = R @ [-np.cos(phi), 0, np.sin(phi)]
    S_phi[leg] = R @ [length * np.sin(phi), 0, length * np.cos(phi)]

# %%
# **The loops.** The platform is an equilateral triangle with sides √3 A: three equations η = 0.
# Their derivatives are K by the motors and K* by the passive angles.
sides = [(0, 1), (1, 2), (2, 0)]
eta = [np.sum((S[i] - S[j]) ** 2) - 3 * A**2 for i, j in sides]
K, K_star = np.zeros((3, 3)), np.zeros((3, 3))
for row, (i, j) in enumerate(sides):
    for one, other in ((i, j), (j, i)):
        K[row, one] = 2 * (S[one] - S[other]) @ S_l[one]
        K_star[row, one] = 2 * (S[one] - S[other]) @ S_phi[one]
jacobian = pose.jacobian()
print(jacobian.table("K_star"))
assert np.abs(eta).max() < 1e-12
assert np.abs(K - jacobian.K).max() < 1e-12
assert np.abs(K_star - jacobian.K_star).max() < 1e-12

# %%
# **The tool** is the platform's middle, the mean of the three points: J and J* of the cut machine.
# K θ̇ + K* φ̇ = 0 takes the passive rates out of it: J_eq = J − J* K*⁻¹ K (30).
J, J_star = S_l.T / 3, S_phi.T / 3
J_eq = J - J_star @ np.linalg.solve(K_star, K)
print(jacobian.table("J_eq"))
assert np.abs(J_eq - jacobian.Jv_eq).max() < 1e-12

# %%
# **The ellipsoid.** Motor rates of length 1 move the middle by the singular values of J_eq (33). At
# the lecture's pose B these are not the numbers that are printed there; which of both is right is
# a question to the class: the columns of J_eq are what each motor alone does to the middle.
printed = np.array([0.3724, 0.3162, 0.2031])
b = machine.pose("lecture_b")
radii = b.jacobian().velocity_ellipsoid().radii
print(f"pose B: {radii.round(4)} m/s by the equations, {printed} in print")
for motor, name in enumerate(machine.actuated):
    ahead, back = (
        machine.close(b.actuated + step * np.eye(3)[motor], guess=b) for step in (1e-6, -1e-6)
    )
    column = (ahead.tool_pose().translation - back.tool_pose().translation) / 2e-6
    print(f"  {name} alone, closed twice beside it: {np.linalg.norm(column):.4f} m/s")
    assert np.abs(column - b.jacobian().Jv_eq[:, motor]).max() < 1e-6
    assert np.linalg.norm(column) < radii[0]

# %%
# **Exercises.** 1. Which column alone shows that 0.3724 cannot be the largest? 2. The same machine
# is cut at its balls in `three_rps`: which of K, K* and J_eq change? 3. How many ways are there to
# assemble it at these legs, and which two are alike?
contact = pj.load("three_rps").pose("lecture_b").jacobian()
assert np.abs(contact.J_eq - b.jacobian().J_eq).max() < 1e-12
modes = pj.assembly_modes(machine, legs, rng=0)
print(f"K* of the other cut is {contact.K_star.shape}; {len(modes)} ways to assemble it")
print("mirror images:", modes.mirror_images)

# %%
# The figure to draw by hand: pose B.
figure = pj.plot(b)
