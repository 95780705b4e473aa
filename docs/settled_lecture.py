"""Two places of the lecture's 3-RPS where its print leaves its own equations.

A. Ghosal, *Robotics: Basics and Selected Advanced Concepts* (NPTEL), lecture 21, "Parallel
Manipulator Jacobian Matrix". Run `python docs/settled_lecture.py`.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

import pmjac_pin as pj

#: J_ω* at pose A, row ω_x, column θ2; and the centroid's principal velocities at pose B.
PRINTED_ENTRY = 0.6696
PRINTED_VELOCITIES = (0.3724, 0.3162, 0.2031)
STEP = 1e-20  # of the complex step: no difference is taken, no digit lost

Values = NDArray[np.complex128]


def balls(lengths: Values, angles: Values) -> Values:
    """Return S1, S2, S3 in rows: legs in vertical planes at 0, 120 and 240 degrees."""
    out, up = 1.0 - lengths * np.cos(angles), lengths * np.sin(angles)
    turns = np.radians([0.0, 120.0, 240.0])
    return np.column_stack([out * np.cos(turns), out * np.sin(turns), up])


def equations_and_centroid(lengths: Values, angles: Values) -> tuple[Values, Values]:
    """Return the squared distances of the pairs (1,2), (2,3), (3,1), and (S1 + S2 + S3)/3."""
    S = balls(lengths, angles)
    return ((S - np.roll(S, -1, axis=0)) ** 2).sum(axis=1), S.mean(axis=0)


def platform(lengths: Values, angles: Values) -> Values:
    """Return R: x along S1 to S2, z along (S2 - S1) x (S3 - S1), y = z x x."""
    first, second, third = balls(lengths, angles)
    x, normal = second - first, np.cross(second - first, third - first)
    x, z = (vector / np.sqrt((vector**2).sum()) for vector in (x, normal))
    return np.column_stack([x, np.cross(z, x), z])


def entry_by_hand(lengths: Values, angles: Values) -> float:
    """Return ω_x for θ̇2 = 1, the third row and second column of Ṙ Rᵀ."""
    rate = platform(lengths, angles + 1j * STEP * np.eye(3)[1]).imag / STEP
    return float((rate @ platform(lengths, angles).real.T)[2, 1])


def velocities_by_hand(lengths: Values, angles: Values) -> NDArray[np.float64]:
    """Return the singular values of [J_v]eq = J_v - J_v* K*⁻¹ K, equations (30) and (33)."""
    steps = 1j * STEP * np.eye(3)
    by_lengths = [equations_and_centroid(lengths + step, angles) for step in steps]
    by_angles = [equations_and_centroid(lengths, angles + step) for step in steps]
    K, J = (np.column_stack(columns).imag / STEP for columns in zip(*by_lengths, strict=True))
    K_star, J_star = (np.column_stack(part).imag / STEP for part in zip(*by_angles, strict=True))
    found: NDArray[np.float64] = np.linalg.svd(J - J_star @ np.linalg.solve(K_star, K))[1]
    return found


def main() -> None:
    """Print both."""
    mechanism = pj.load("three_rps_ss")
    pose_a, pose_b = (mechanism.pose(name) for name in ("lecture_a", "lecture_b"))
    print("pose A, J_w*, row w_x, column theta2:")
    print(f"  printed        {PRINTED_ENTRY:.4f}")
    print(f"  library        {pose_a.jacobian().Jw_star[0, 1]:.4f}")
    print(f"  R' R^T by hand {entry_by_hand(pose_a.actuated, pose_a.passive):.4f}")
    print("pose B, principal velocities of the centroid:")
    found = {
        "printed": PRINTED_VELOCITIES,
        "library": pose_b.jacobian().velocity_ellipsoid().radii,
        "(33) by hand": velocities_by_hand(pose_b.actuated, pose_b.passive),
    }
    for words, values in found.items():
        print(f"  {words:14}", "  ".join(f"{value:.4f}" for value in values))
    print("  (33) by hand on all assembly modes at these lengths:")
    modes = pj.assembly_modes(mechanism, pose_b.actuated)
    for mode in sorted(modes, key=lambda mode: -mode.passive[0]):
        radii = velocities_by_hand(mode.actuated, mode.passive)
        angles = "  ".join(f"{angle:7.4f}" for angle in mode.passive)
        print(f"  theta {angles}   ", "  ".join(f"{value:.4f}" for value in radii))


if __name__ == "__main__":
    main()
