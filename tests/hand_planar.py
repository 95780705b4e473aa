"""Closed formulas of planar mechanisms, the independent reference of the tests: NumPy alone.

Points are (2,) arrays in the plane z = 0; lengths in m, angles in rad.
"""

from __future__ import annotations

import numpy as np


def unit(angle):
    """The direction at this angle from x."""
    return np.array([np.cos(angle), np.sin(angle)])


def quarter(vector):
    """z x vector: a quarter turn to the left."""
    return np.array([-vector[1], vector[0]])


def meet(p, q, from_p, from_q, side):
    """The point at these distances from p and q: left of the line from p to q on side +1."""
    line = q - p
    d = np.hypot(*line)
    along = (d**2 + from_p**2 - from_q**2) / (2 * d)
    across = side * np.sqrt(from_p**2 - along**2)
    return p + (along * line + across * quarter(line)) / d


def spin(p, q, p_dot, q_dot):
    """The rate of a link through p and q."""
    return quarter(q - p) @ (q_dot - p_dot) / ((q - p) @ (q - p))


def slider_crank(theta, r, l, e):  # noqa: E741 - l is the rod
    """(x, dx/dtheta) of the piston on the outer side of the crank.

    x = r cos(theta) + sqrt(l^2 - (r sin(theta) - e)^2).
    """
    height = r * np.sin(theta) - e
    run = np.sqrt(l**2 - height**2)
    return r * np.cos(theta) + run, -r * np.sin(theta) - height * r * np.cos(theta) / run


def five_bar(thetas, lengths, side):
    """(tip, J) of the planar 5R, J (3, 2): velocity of the tip and rate of the first distal link.

    Each distal vector d_i turns about the elbow B_i and keeps its length:
    d_i . v = d_i . (z x (B_i - A_i)) theta_i', that is A v = B theta'.
    """
    l0, l1, l2, l3, l4 = lengths
    proximal = np.array([l1 * unit(thetas[0]), l4 * unit(thetas[1])])
    elbows = np.array([[0.0, 0.0], [l0, 0.0]]) + proximal
    tip = meet(*elbows, l2, l3, side)
    A = tip - elbows
    B = np.diag([d @ quarter(p) for d, p in zip(A, proximal, strict=True)])
    velocity = np.linalg.solve(A, B)
    elbow = np.column_stack([quarter(proximal[0]), [0.0, 0.0]])
    turning = [spin(elbows[0], tip, elbow[:, k], velocity[:, k]) for k in (0, 1)]
    return tip, np.vstack([velocity, turning])


def watt_six_bar(points):
    """Velocities of B to F and the rate of DE for a crank rate of 1 rad/s.

    `points` maps A to G. Two points of one link keep their distance: (P - Q) . (v_P - v_Q) = 0,
    twice for C (links BCD and GCF) and twice for E (links DE and EF).
    """
    A, B, C, D, E, F, G = (np.array(points[name], dtype=float) for name in "ABCDEFG")

    def held(P, Q, v_Q, R, v_R):
        return np.linalg.solve([P - Q, P - R], [(P - Q) @ v_Q, (P - R) @ v_R])

    v_B, still = quarter(B - A), np.zeros(2)
    v_C = held(C, B, v_B, G, still)
    v_D = v_B + spin(B, C, v_B, v_C) * quarter(D - B)
    v_F = spin(G, C, still, v_C) * quarter(F - G)
    v_E = held(E, D, v_D, F, v_F)
    return {"B": v_B, "C": v_C, "D": v_D, "E": v_E, "F": v_F}, spin(D, E, v_D, v_E)


def watt_six_bar_points(crank, lengths, angles, sides):
    """The points A to G of a Watt six-bar with its ground along x."""
    AG, AB, BC, CD, GC, CF, DE, EF = lengths
    A, G, B = np.zeros(2), np.array([AG, 0.0]), AB * unit(crank)
    C = meet(B, G, BC, GC, sides[0])
    along_BC, along_GC = (np.arctan2(*(C - P)[::-1]) for P in (B, G))
    D, F = C + CD * unit(along_BC + angles[0]), C + CF * unit(along_GC + angles[1])
    E = meet(D, F, DE, EF, sides[1])
    return dict(zip("ABCDEFG", (A, B, C, D, E, F, G), strict=True))


def platform_joints(pose, radius):
    """The three joints of a platform at (x, y, angle), shape (3, 2)."""
    angles = np.array([0.0, 2.0, 4.0]) * np.pi / 3 + pose[2]
    return np.array([pose[:2] + radius * unit(angle) for angle in angles])


def leg_rows(pose, joints, directions):
    """[u_i, b_i x u_i]: the speed of each joint of a platform along u_i by (v_x, v_y, omega)."""
    arms = joints - pose[:2]
    moments = arms[:, 0] * directions[:, 1] - arms[:, 1] * directions[:, 0]
    return np.column_stack([directions, moments])


def inverse_3rrr(pose, thetas, a, b, l1):
    """(J^-1, distal lengths): theta' = J^-1 (v_x, v_y, omega).

    Motor i sees u_i . v_P = u_i . (z x p_i) theta_i', u_i along its distal link, p_i its
    proximal link, which points to the middle at theta_i = 0.
    """
    joints, base = platform_joints(pose, a), platform_joints(np.zeros(3), b)
    inwards = np.arctan2(-base[:, 1], -base[:, 0])
    proximal = l1 * np.array([unit(angle) for angle in inwards + thetas])
    distal = joints - base - proximal
    lengths = np.linalg.norm(distal, axis=1)
    directions = distal / lengths[:, None]
    factors = [u @ quarter(p) for u, p in zip(directions, proximal, strict=True)]
    return leg_rows(pose, joints, directions) / np.array(factors)[:, None], lengths


def inverse_3rpr(pose, a, b):
    """(J^-1, leg lengths): l' = J^-1 (v_x, v_y, omega), rows [u_i, b_i x u_i]."""
    joints = platform_joints(pose, a)
    legs = joints - platform_joints(np.zeros(3), b)
    lengths = np.linalg.norm(legs, axis=1)
    return leg_rows(pose, joints, legs / lengths[:, None]), lengths
