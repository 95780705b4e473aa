"""Spatial mechanisms of the catalogue by hand, from NumPy alone: what their tests compare with.

Metres and radians, world axes. Poses of the tool are a translation t (3,) and a rotation R (3, 3).
"""

import numpy as np

THIRDS = 2 * np.pi / 3 * np.array([0, 1, -1])
X, Y, Z = np.eye(3)


def turn(axis, angle):
    """Rotation about a unit axis, by Rodrigues' formula."""
    x, y, z = axis
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross


# --- Delta ---------------------------------------------------------------------------------------


def delta_rods(theta, centre, base, arm, plate):
    """Vectors s_i (3, 3) from the elbows to the level plate, and the elbows' velocities (3, 3)."""
    rods, elbow_rates = [], []
    for angle, azimuth in zip(theta, THIRDS, strict=True):
        out = np.array([np.cos(azimuth), np.sin(azimuth), 0])
        elbow = (base + arm * np.cos(angle)) * out - arm * np.sin(angle) * Z
        rods.append(centre + plate * out - elbow)
        elbow_rates.append(-arm * np.sin(angle) * out - arm * np.cos(angle) * Z)
    return np.array(rods), np.array(elbow_rates)


def delta_Jv(theta, centre, base, arm, plate):
    """|s_i| is constant: s_i · v = (s_i · e_i) θ̇_i, hence v = A⁻¹ B θ̇."""
    rods, elbow_rates = delta_rods(theta, centre, base, arm, plate)
    return np.linalg.solve(rods, np.diag((rods * elbow_rates).sum(axis=1)))


# --- Stewart-Gough platform ----------------------------------------------------------------------

# P. Dietmaier, "The Stewart-Gough platform of general geometry can have 40 real postures",
# Advances in Robot Kinematics: Analysis and Control (1998), 7-16.
DIETMAIER_BASE = (
    (0.0, 0.0, 0.0),
    (1.107915, 0.0, 0.0),
    (0.549094, 0.756063, 0.0),
    (0.735077, -0.223935, 0.525991),
    (0.514188, -0.526063, -0.368418),
    (0.590473, 0.094733, -0.205018),
)
DIETMAIER_PLATFORM = (
    (0.0, 0.0, 0.0),
    (0.542805, 0.0, 0.0),
    (0.956919, -0.528915, 0.0),
    (0.665885, -0.353482, 1.402538),
    (0.478359, 1.158742, 0.107672),
    (-0.137087, -0.235121, 0.353913),
)
DIETMAIER_LENGTHS = (1.0, 0.645275, 1.086284, 1.503439, 1.281933, 0.771071)


def stewart_inverse(t, R, base, platform):
    """Leg lengths (6,) and the inverse Jacobian (6, 6), rows (u_i, b_i × u_i).

    The tool is at the middle of the platform's six points; b_i is from there to point i and u_i
    the direction of leg i, both in the world.
    """
    base, platform = np.array(base), np.array(platform)
    arms = (platform - platform.mean(axis=0)) @ R.T
    legs = t + arms - base
    lengths = np.linalg.norm(legs, axis=1)
    u = legs / lengths[:, None]
    return lengths, np.hstack([u, np.cross(arms, u)])


# --- Agile Eye -----------------------------------------------------------------------------------

_SINK = np.sqrt(1 / 3)
_OUT = np.sqrt(2 / 3)
#: The motors' axes u_i: at right angles to each other, their middle straight down.
EYE_MOTORS = np.array(
    [[_OUT * np.cos(a), _OUT * np.sin(a), -_SINK] for a in (0.0, -2 * np.pi / 3, 2 * np.pi / 3)]
)


def agile_eye(theta, R):
    """w_i · v_i (3,), zero where it is closed, and the Jacobian of ω, A⁻¹ B.

    With w_i · v_i = 0, u_i the motors' axes: (w_i × v_i) · ω = (u_i × w_i) · v_i θ̇_i.
    """
    rows, diagonal, closure = [], [], []
    for i, angle in enumerate(theta):
        u = EYE_MOTORS[i]
        w = turn(u, angle) @ -EYE_MOTORS[(i + 1) % 3]
        v = R @ EYE_MOTORS[(i + 2) % 3]
        rows.append(np.cross(w, v))
        diagonal.append(np.cross(u, w) @ v)
        closure.append(w @ v)
    return np.array(closure), np.linalg.solve(np.array(rows), np.diag(diagonal))


# --- Bennett, Bricard, Sarrus --------------------------------------------------------------------

BENNETT_TWISTS = (np.pi / 6, np.pi / 2)


def bennett_product():
    """tan(θ₁/2) tan(θ₂/2) at every pose, by the twists α of the short and β of the long sides."""
    alpha, beta = BENNETT_TWISTS
    return np.sin((beta + alpha) / 2) / np.sin((beta - alpha) / 2)


def bricard_second(theta1):
    """θ₂ and dθ₂/dθ₁ of the threefold-symmetric loop with right-angled twists.

    With angles from the cube, (1 + sin θ₁)(1 + sin θ₂) = 1, θ₁ = θ₃ = θ₅, θ₂ = θ₄ = θ₆:
    Y. Chen, Z. You, T. Tarnai, "Threefold-symmetric Bricard linkages for deployable structures",
    Int. J. Solids and Structures 42 (2005), 2287-2301, where sin is cos, of the angle between
    the edges.
    """
    s = np.sin(theta1)
    theta2 = -np.arcsin(s / (1 + s))
    return theta2, -np.cos(theta1) / ((1 + s) ** 2 * np.cos(theta2))


def sarrus_height(alpha, panel):
    """Height of the plate above the base's hinges and its derivative."""
    return 2 * panel * np.sin(alpha), 2 * panel * np.cos(alpha)


# --- Ankle ---------------------------------------------------------------------------------------


def ankle(theta, R, crank, heel, half, rods):
    """Rod lengths (2,) and the foot's angular velocity per motor rate (3, 2).

    The foot is at R = R_y(pitch) R_x(roll). Each rod s, from crank tip to heel point h, keeps
    its length: s · (ω × h) = s · (θ̇ y × c), with c from the motor to the crank's tip.
    """
    pitch_axis, roll_axis = Y, R @ X
    lengths, foot_rows, motor_rows = [], [], []
    for angle, rod, side in zip(theta, rods, (1, -1), strict=True):
        c = turn(Y, angle) @ np.array([-crank, 0.0, 0.0])
        h = R @ np.array([-heel, side * half, 0.0])
        s = h - (np.array([0.0, side * half, rod]) + c)
        lengths.append(np.linalg.norm(s))
        foot_rows.append([s @ np.cross(pitch_axis, h), s @ np.cross(roll_axis, h)])
        motor_rows.append(s @ np.cross(Y, c))
    angle_rates = np.linalg.solve(np.array(foot_rows), np.diag(motor_rows))
    return np.array(lengths), np.column_stack([pitch_axis, roll_axis]) @ angle_rates
