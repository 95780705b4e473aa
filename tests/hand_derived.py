"""Formulas derived by hand, the independent reference of the tests: NumPy and nothing else.

The mechanisms, symbols and printed figures are those of A. Ghosal, *Robotics: Basics and Selected
Advanced Concepts* (NPTEL), lecture 21, "Parallel Manipulator Jacobian Matrix". A star marks the
passive columns. Metres and radians; tool Jacobians of the cut tree, world-aligned at the tool.
"""
# ruff: noqa: E741 - l is the lecture's leg length

import numpy as np

# --- Printed figures. 3-RPS, pose A (a = 1/2, b = 1) ---------------------------------------------
RPS_A = 0.5
POSE_A_L = (2 / 3, 3 / 5, 3 / 4)
POSE_A_THETA = (0.7593, 0.2851, 0.8028)
POSE_A_THETA_EXACT = (0.75931201, 0.28510144, 0.80278893)
POSE_A_JW = ((0.0644, -0.2801, -0.9548), (-1.1519, 0.1361, 0.4815), (-0.1953, 0.5339, -0.3803))
# Entry (0, 1) is printed 0.6696: two digits changed places. The equations give 0.6686.
POSE_A_JW_STAR = ((-0.0307, 0.6686, -0.3398), (-0.3961, 0.4256, 0.1713), (0.3069, 0.0308, -0.1353))
POSE_A_JW_STAR_MISPRINT = ((0, 1), 0.6696)
POSE_A_JV_EQ = ((-0.2313, 0.5372, 0.0114), (0.0722, -0.6758, 0.1951), (1.1765, -1.6830, 0.9223))
POSE_A_JW_EQ = ((2.1409, -6.4331, 0.4665), (0.0072, -4.1216, 1.6048), (0.1565, 0.4570, -0.3285))
# The modes come in +- pairs (mirror images below the base); the first is the printed one.
POSE_A_MODES = (
    (0.75931201, 0.28510144, 0.80278893),
    (0.74709682, 0.48093603, 0.81110182),
    (0.66831139, 0.64666409, -0.21037810),
    (0.03951542, -0.69420756, -0.74615223),
)
POSE_A_DET_K_STAR = (-0.2418, 0.2187, -1.1477, 0.9258)  # mode by mode, not in the print
# --- 3-RPS, pose B. The platform's normal z points down on both modes ----------------------------
POSE_B_L = (0.5, 1.0, 2.0)
POSE_B_THETA = (0.4, 0.7535, 0.2402)
POSE_B_MODES = ((0.4000, 0.7535, 0.2402), (1.0907, 0.5736, 0.2572))  # and their mirror images
POSE_B_DET_K_STAR = (0.5304, -0.1202)
# Principal velocities, mode by mode: what equation (33) gives, the singular values of Jv_eq ...
POSE_B_VELOCITIES = ((2.3429, 0.5645, 0.2980), (1.6579, 0.6842, 0.0646))
# ... and what the lecture prints for the first mode, which does not follow from its equations.
POSE_B_PRINTED_VELOCITIES = (0.3724, 0.3162, 0.2031)
POSE_B_PRINTED_DIRECTIONS = (
    (0.9921, -0.0394, 0.1187),
    (0.1166, 0.6338, -0.7646),
    (-0.0452, 0.7724, 0.6335),
)
# --- 3-RPS, symmetric pose: level platform, normal up --------------------------------------------
SYMMETRIC_L = (1.0, 1.0, 1.0)
SYMMETRIC_THETA = (np.pi / 3, np.pi / 3, np.pi / 3)
SYMMETRIC_DET_K_STAR = 4.3843


def central_difference(f, x, h=1e-6):
    """Jacobian of an array-valued f at the vector x, shape f(x).shape + (x.size,)."""
    x = np.array(x, dtype=float)
    steps = h * np.eye(x.size)
    columns = [(np.asarray(f(x + e)) - np.asarray(f(x - e))) / (2 * h) for e in steps]
    return np.stack(columns, axis=-1)


def _wrap(angle):
    """Bring an angle to [-pi, pi]."""
    return np.arctan2(np.sin(angle), np.cos(angle))


# --- Planar four-bar; lengths = (l0, l1, l2, l3), phi = (phi1, phi2) -----------------------------
# Below, psi = theta1 + phi2 is the coupler's absolute angle.


def four_bar_closure(theta1, lengths, branch):
    """(phi1, phi2) where the coupler's circle about the crank tip A meets the rocker's about D.

    On branch +1 the joint lies to the left of the line from A to D, on branch -1 to the right:
    the branch is the sign of det K* = l2 l3 sin(phi1 - psi). ValueError when they do not meet.
    """
    l0, l1, l2, l3 = lengths
    A = l1 * np.array([np.cos(theta1), np.sin(theta1)])
    AD = np.array([l0, 0.0]) - A
    d = np.hypot(*AD)
    if not abs(l2 - l3) <= d <= l2 + l3 or d == 0:
        raise ValueError(f"four-bar {lengths} cannot be assembled at theta1 = {theta1}")
    along = (d**2 + l2**2 - l3**2) / (2 * d)
    across = branch * np.sqrt(max(l2**2 - along**2, 0.0))
    left = np.array([-AD[1], AD[0]])
    x, y = A + (along * AD + across * left) / d
    psi = np.arctan2(y - A[1], x - A[0])
    return np.array([np.arctan2(y, x - l0), _wrap(psi - theta1)])


def four_bar_residual(theta1, phi, lengths):
    """Coupler tip minus rocker tip, the lecture's eta (2,)."""
    l0, l1, l2, l3 = lengths
    psi = theta1 + phi[1]
    x = l1 * np.cos(theta1) + l2 * np.cos(psi) - l0 - l3 * np.cos(phi[0])
    y = l1 * np.sin(theta1) + l2 * np.sin(psi) - l3 * np.sin(phi[0])
    return np.array([x, y])


def four_bar_K(theta1, phi, lengths):
    """d eta / d theta1 (2, 1)."""
    _, l1, l2, _ = lengths
    psi = theta1 + phi[1]
    x, y = l1 * np.cos(theta1) + l2 * np.cos(psi), l1 * np.sin(theta1) + l2 * np.sin(psi)
    return np.array([[-y], [x]])


def four_bar_K_star(theta1, phi, lengths):
    """d eta / d (phi1, phi2) (2, 2)."""
    _, _, l2, l3 = lengths
    psi = theta1 + phi[1]
    x = [l3 * np.sin(phi[0]), -l2 * np.sin(psi)]
    y = [-l3 * np.cos(phi[0]), l2 * np.cos(psi)]
    return np.array([x, y])


def four_bar_tool(theta1, phi, lengths):
    """Midpoint of the coupler (3,) and its rotation (3, 3), x along the coupler, z = ground's z."""
    _, l1, l2, _ = lengths
    c, s = np.cos(theta1 + phi[1]), np.sin(theta1 + phi[1])
    p = [l1 * np.cos(theta1) + l2 / 2 * c, l1 * np.sin(theta1) + l2 / 2 * s, 0.0]
    return np.array(p), np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])


def four_bar_Jv(theta1, phi, lengths):
    """d (midpoint) / d theta1 (3, 1): z x midpoint."""
    (x, y, _), _ = four_bar_tool(theta1, phi, lengths)
    return np.array([[-y], [x], [0.0]])


def four_bar_Jv_star(theta1, phi, lengths):
    """d (midpoint) / d (phi1, phi2) (3, 2): the rocker is on the other side of the cut."""
    l2, psi = lengths[2], theta1 + phi[1]
    return np.array([[0.0, -l2 / 2 * np.sin(psi)], [0.0, l2 / 2 * np.cos(psi)], [0.0, 0.0]])


def four_bar_Jw(theta1, phi, lengths):
    """Angular velocity by theta1 (3, 1): the coupler turns at the rate of psi = theta1 + phi2."""
    return np.array([[0.0], [0.0], [1.0]])


def four_bar_Jw_star(theta1, phi, lengths):
    """Angular velocity by (phi1, phi2) (3, 2)."""
    return np.array([[0.0, 0.0], [0.0, 0.0], [0.0, 1.0]])


def four_bar_crank_limit(lengths):
    """(theta1, phi) where a growing theta1 is stopped: coupler and rocker aligned, K* singular.

    d^2 = l0^2 + l1^2 - 2 l0 l1 cos theta1, d from crank tip to rocker ground, grows on (0, pi).
    - l2 + l3 < l0 + l1: stopped in (0, pi), at d = l2 + l3 (stretched).
    - else |l2 - l3| > |l0 - l1|: the crank passes pi, where d is largest, and is stopped in
      (pi, 2 pi), at d = |l2 - l3| (folded). Its mirror image in (0, pi), (2 pi - theta1, -phi),
      is where a falling theta1 is stopped.
    - else ValueError: the crank turns fully, or nothing can be assembled.
    """
    l0, l1, l2, l3 = lengths
    stretched = l2 + l3 < l0 + l1
    d = l2 + l3 if stretched else abs(l2 - l3)
    if not abs(l0 - l1) < d < l0 + l1:
        raise ValueError(f"the crank of the four-bar {lengths} turns fully or not at all")
    theta1 = np.arccos((l0**2 + l1**2 - d**2) / (2 * l0 * l1))
    theta1 = theta1 if stretched else 2 * np.pi - theta1
    to_D = np.arctan2(-l1 * np.sin(theta1), l0 - l1 * np.cos(theta1))
    psi = to_D if stretched or l2 > l3 else to_D + np.pi
    phi1 = psi + np.pi if stretched else psi
    return float(theta1), np.array([_wrap(phi1), _wrap(psi - theta1)])


# --- 3-RPS; l, theta (3,), platform circumradius a, base radius b --------------------------------


def rps_points(l, theta, b=1.0):
    """Spherical joints S1, S2, S3, the rows of a (3, 3)."""
    (r1, r2, r3), (z1, z2, z3) = b - l * np.cos(theta), l * np.sin(theta)
    h = np.sqrt(3) / 2
    return np.array([[r1, 0.0, z1], [-r2 / 2, h * r2, z2], [-r3 / 2, -h * r3, z3]])


def rps_residual(l, theta, a, b=1.0):
    """|Si - Sj|^2 - 3 a^2 for (i, j) = (1, 2), (2, 3), (3, 1), as the lecture expands it (3,).

    With r = b - l c, |Si - Sj|^2 = ri^2 + rj^2 + ri rj + (li si - lj sj)^2.
    """
    c, s = np.cos(theta), np.sin(theta)

    def eta(i, j):
        crossed = l[i] * l[j] * (c[i] * c[j] - 2 * s[i] * s[j])
        leaning = 3 * b * (l[i] * c[i] + l[j] * c[j])
        return 3 * b**2 - 3 * a**2 + l[i] ** 2 + l[j] ** 2 + crossed - leaning

    return np.array([eta(0, 1), eta(1, 2), eta(2, 0)])


def _by_pairs(k):
    """Rows (1, 2), (2, 3), (3, 1) of the pair equations: k(i, j) under i, k(j, i) under j."""
    return np.array([[k(0, 1), k(1, 0), 0.0], [0.0, k(1, 2), k(2, 1)], [k(0, 2), 0.0, k(2, 0)]])


def rps_K(l, theta, b=1.0):
    """d eta / d l (3, 3)."""
    c, s = np.cos(theta), np.sin(theta)

    def k(i, j):  # d eta_ij / d li
        return 2 * l[i] + l[j] * c[i] * c[j] - 2 * l[j] * s[i] * s[j] - 3 * b * c[i]

    return _by_pairs(k)


def rps_K_star(l, theta, b=1.0):
    """d eta / d theta (3, 3)."""
    c, s = np.cos(theta), np.sin(theta)

    def k(i, j):  # d eta_ij / d theta_i
        return 3 * b * l[i] * s[i] - l[i] * l[j] * (s[i] * c[j] + 2 * c[i] * s[j])

    return _by_pairs(k)


def rps_rotation(l, theta, b=1.0):
    """Tool rotation: x along S1 -> S2, z along (S2 - S1) x (S3 - S1), y = z x x."""
    S1, S2, S3 = rps_points(l, theta, b)
    x = (S2 - S1) / np.linalg.norm(S2 - S1)
    z = np.cross(S2 - S1, S3 - S1)
    z = z / np.linalg.norm(z)
    return np.column_stack([x, np.cross(z, x), z])


def rps_Jv(l, theta):
    """d (centroid) / d l (3, 3)."""
    (c1, c2, c3), (s1, s2, s3) = np.cos(theta), np.sin(theta)
    h = np.sqrt(3) / 2
    return np.array([[-c1, c2 / 2, c3 / 2], [0.0, -h * c2, h * c3], [s1, s2, s3]]) / 3


def rps_Jv_star(l, theta):
    """d (centroid) / d theta (3, 3)."""
    (x1, x2, x3), (z1, z2, z3) = l * np.sin(theta), l * np.cos(theta)
    h = np.sqrt(3) / 2
    return np.array([[x1, -x2 / 2, -x3 / 2], [0.0, h * x2, -h * x3], [z1, z2, z3]]) / 3


def _angular_rate(S, dS):
    """Angular velocity, the vee of Rdot R^T, of the platform through S whose joints move by dS."""

    def unit_rate(u, du):  # d (u / |u|), by the quotient rule
        n = np.linalg.norm(u)
        return u / n, du / n - u * (u @ du) / n**3

    p, q, dp, dq = S[1] - S[0], S[2] - S[0], dS[1] - dS[0], dS[2] - dS[0]
    x, dx = unit_rate(p, dp)
    z, dz = unit_rate(np.cross(p, q), np.cross(dp, q) + np.cross(p, dq))
    y, dy = np.cross(z, x), np.cross(dz, x) + np.cross(z, dx)
    W = np.column_stack([dx, dy, dz]) @ np.column_stack([x, y, z]).T
    W = (W - W.T) / 2
    return np.array([W[2, 1], W[0, 2], W[1, 0]])


def rps_Jw(l, theta, b=1.0):
    """Angular velocity by l (3, 3): leg i carries Si alone, dSi = -c ei + s z."""
    S, dS = rps_points(l, theta, b), rps_Jv(l, theta).T * 3
    return np.column_stack([_angular_rate(S, np.outer(e, e @ dS)) for e in np.eye(3)])


def rps_Jw_star(l, theta, b=1.0):
    """Angular velocity by theta (3, 3): leg i carries Si alone, dSi = l s ei + l c z."""
    S, dS = rps_points(l, theta, b), rps_Jv_star(l, theta).T * 3
    return np.column_stack([_angular_rate(S, np.outer(e, e @ dS)) for e in np.eye(3)])


def rps_equivalent(l, theta, a, b=1.0):
    """(Jv_eq, Jw_eq) = J - J* K*^-1 K, equations (30) to (32).

    They mean something at closed poses only: ValueError when the residual exceeds 1e-3, which
    the four digits of the lecture's angles satisfy.
    """
    if np.abs(rps_residual(l, theta, a, b)).max() > 1e-3:
        raise ValueError(f"the 3-RPS is not closed at l = {l}, theta = {theta}")
    rates = -np.linalg.solve(rps_K_star(l, theta, b), rps_K(l, theta, b))
    Jv_eq = rps_Jv(l, theta) + rps_Jv_star(l, theta) @ rates
    return Jv_eq, rps_Jw(l, theta, b) + rps_Jw_star(l, theta, b) @ rates


def rps_newton(l, theta_start, a, b=1.0):
    """Theta (3,) that closes the legs l by plain Newton, to 1e-14 of the equations' largest term.

    RuntimeError when it does not converge in 50 steps.
    """
    theta = np.array(theta_start, dtype=float)
    size = max(1.0, 3 * a**2, 3 * b**2, np.max(l) ** 2)
    for _ in range(50):
        residual = rps_residual(l, theta, a, b)
        if np.abs(residual).max() <= 1e-14 * size:
            return _wrap(theta)
        K_star = rps_K_star(l, theta, b)
        if np.linalg.cond(K_star) > 1e14:
            break
        theta = theta - np.linalg.solve(K_star, residual)
    raise RuntimeError(f"no closure of the 3-RPS at l = {l} from theta = {theta_start}")


def rps_singular_pose(start, l2, l3, a, b=1.0):
    """(l, theta), closed and singular: Newton on eta = 0, det K* = 0 in start = (theta, l1).

    RuntimeError unless |eta| < 1e-13 and K* lost one rank and no more: its smallest singular
    value is below 1e-12, the next one above 1e-3.
    """

    def equations(u):
        l, theta = np.array([u[3], l2, l3]), u[:3]
        det = np.linalg.det(rps_K_star(l, theta, b))
        return np.append(rps_residual(l, theta, a, b), det)

    u = np.array(start, dtype=float)
    for _ in range(30):
        slope = central_difference(equations, u)
        if np.linalg.norm(u) > 100 or np.linalg.cond(slope) > 1e10:
            break  # diverging
        u = u - np.linalg.solve(slope, equations(u))
    l, theta = np.array([u[3], l2, l3]), _wrap(u[:3])
    _, middle, smallest = np.linalg.svd(rps_K_star(l, theta, b), compute_uv=False)
    closed = np.abs(rps_residual(l, theta, a, b)).max() < 1e-13
    if not (closed and smallest < 1e-12 and middle > 1e-3):
        raise RuntimeError(f"no singular pose from {start}")
    return l, theta


def rps_singular_poses(rng, count, a=RPS_A, b=1.0):
    """`count` distinct singular poses (l, theta), l in [0.1, 3], drawn from a seeded rng."""
    poses = []
    for _ in range(200 * count):
        l1, l2, l3 = b * rng.uniform(0.3, 1.8, 3)
        start = np.append(rng.uniform(-0.5, 1.5, 3), l1)
        try:
            l, theta = rps_singular_pose(start, l2, l3, a, b)
        except RuntimeError:
            continue
        known = any(np.abs(np.append(l, theta) - np.append(*p)).max() < 1e-3 for p in poses)
        if not known and l.min() >= 0.1 and l.max() <= 3:
            poses.append((l, theta))
        if len(poses) == count:
            return poses
    raise RuntimeError(f"found {len(poses)} of {count} singular poses")
