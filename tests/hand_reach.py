"""Inverse kinematics by hand: cranks and rods, annuli, a UR5's eight solutions."""

from __future__ import annotations

from itertools import product

import numpy as np


def crank_angles(foot, centre, out, up, arm, rod):
    """The angles at which a crank's tip is a rod's length from a foot: a circle meets a sphere.

    tip = centre + arm (cos θ out + sin θ up); |foot − tip| = rod is A cos θ + B sin θ = C.
    """
    d = foot - centre
    a, b, c = 2 * arm * d @ out, 2 * arm * d @ up, arm**2 + d @ d - rod**2
    middle, spread = np.arctan2(b, a), np.arccos(c / np.hypot(a, b))
    return np.array([middle + spread, middle - spread])


HEAD = {"radius": 0.03666, "half": 0.01, "height": 0.0766, "plate": 0.02917, "ball": 0.007}


def head_angles(t, R, arm=0.038, rod=0.09):
    """The two angles of each of six cranks that hold a head at a pose, shape (6, 2)."""
    up, found = np.array([0.0, 0.0, 1.0]), []
    for pair, side in product((np.pi / 3, np.pi, -np.pi / 3), (1, -1)):
        radial = np.array([np.cos(pair), np.sin(pair), 0.0])
        out = side * np.array([np.sin(pair), -np.cos(pair), 0.0])
        centre = HEAD["radius"] * radial + HEAD["half"] * out + HEAD["height"] * up
        foot = t + R @ (HEAD["plate"] * radial + HEAD["ball"] * out)
        found.append(crank_angles(foot, centre, out, up, arm, rod))
    return np.array(found)


def delta_angles(centre, base=0.2, arm=0.3, rod=0.7, plate=0.06):
    """The two angles, downwards, of each arm of a Delta whose plate is at `centre`: (3, 2)."""
    found = []
    for pair in (0.0, 2 * np.pi / 3, -2 * np.pi / 3):
        out = np.array([np.cos(pair), np.sin(pair), 0.0])
        foot = centre + plate * out
        found.append(crank_angles(foot, base * out, out, np.array([0.0, 0.0, -1.0]), arm, rod))
    return np.array(found)


def five_bar_angles(tip, l0, l1, l2, l3, l4):
    """The two angles of each motor that put the tip of a five-bar there, shape (2, 2)."""
    x, y = np.eye(3)[:2]
    foot, second = np.array([*tip, 0.0]), np.array([l0, 0.0, 0.0])
    return np.array(
        [crank_angles(foot, 0.0 * x, x, y, l1, l2), crank_angles(foot, second, x, y, l4, l3)]
    )


def combinations(angles):
    """All choices of one angle in each row, shape (2^n, n)."""
    return np.array(list(product(*angles)))


D1, A2, A3, D4, D5, D6 = 0.089159, -0.425, -0.39225, 0.10915, 0.09465, 0.0823


def _denavit_hartenberg(angle, d, a, alpha):
    c, s, ca, sa = np.cos(angle), np.sin(angle), np.cos(alpha), np.sin(alpha)
    return np.array(
        [[c, -s * ca, s * sa, a * c], [s, c * ca, -c * sa, a * s], [0, sa, ca, d], [0, 0, 0, 1]]
    )


def ur5_angles(pose):
    """The up to eight solutions of a UR5's inverse kinematics, by its DH parameters, (k, 6).

    Shoulder left or right, wrist up or down, elbow up or down; the model's base is turned by half
    a turn about z from that of the parameters.
    """
    T = np.diag([-1.0, -1.0, 1.0, 1.0]) @ pose
    found = []
    wrist = T @ np.array([0.0, 0.0, -D6, 1.0])
    for shoulder in (1, -1):
        side = np.arccos(D4 / np.hypot(wrist[0], wrist[1]))
        q1 = np.arctan2(wrist[1], wrist[0]) + shoulder * side + np.pi / 2
        s1, c1 = np.sin(q1), np.cos(q1)
        for flip in (1, -1):
            q5 = flip * np.arccos((T[0, 3] * s1 - T[1, 3] * c1 - D4) / D6)
            x, y = T[:3, 0] @ [s1, -c1, 0.0], T[:3, 1] @ [s1, -c1, 0.0]
            q6 = np.arctan2(-y / np.sin(q5), x / np.sin(q5))
            T1 = _denavit_hartenberg(q1, D1, 0.0, np.pi / 2)
            T5 = _denavit_hartenberg(q5, D5, 0.0, -np.pi / 2)
            T6 = _denavit_hartenberg(q6, D6, 0.0, 0.0)
            T14 = np.linalg.inv(T1) @ T @ np.linalg.inv(T5 @ T6)
            p13 = (T14 @ np.array([0.0, -D4, 0.0, 1.0]))[:3]
            cosine = (p13 @ p13 - A2**2 - A3**2) / (2 * A2 * A3)
            if abs(cosine) > 1.0:
                continue
            for elbow in (1, -1):
                q3 = elbow * np.arccos(cosine)
                q2 = np.arctan2(p13[1], p13[0]) - np.arctan2(A3 * np.sin(q3), A2 + A3 * np.cos(q3))
                T24 = (
                    np.linalg.inv(
                        _denavit_hartenberg(q2, 0.0, A2, 0.0)
                        @ _denavit_hartenberg(q3, 0.0, A3, 0.0)
                    )
                    @ T14
                )
                q4 = np.arctan2(T24[1, 0], T24[0, 0])
                found.append([q1, q2, q3, q4, q5, q6])
    return np.array(found)
