"""Where branches of closed poses meet on a path: their tangents, and a pose further on each.

The path's equations G(x) = 0 have x in one dimension more than G. Where G_x loses a rank, with
wᵀ G_x = 0 and z₁, z₂ spanning its null space, tangents x = Σ αᵢ zᵢ solve the bifurcation equation

    Σ B_ij αᵢ αⱼ = 0,    B_ij = wᵀ (G_x' zᵢ) zⱼ.

Two of them are two branches that cross; where B has one sign, the pose stands alone, and where its
determinant vanishes, more would have to be known.

References
----------
Keller, *Numerical solution of bifurcation and nonlinear eigenvalue problems*, 1977.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from pmjac_pin.studies.follow.bordered import SingularSpot
from pmjac_pin.studies.follow.event import PathBranch
from pmjac_pin.studies.follow.path_equations import PathEquations
from pmjac_pin.values.arrays import Array, norm

_DEGENERATE = 1e-6  # of B²: its determinant
_MOTORS_STILL = 1e-6  # of a tangent: the parameter's share on a branch that turns back
_AHEAD = 1e-3  # of a length: how far a pose on a branch is looked for
_NARROWER = 0.25  # of how far branches are apart there: how far a pose may be from its tangent
_STEPS_ACROSS = 12
_STEP_ACROSS = 1e-13


def branch_tangents(spot: SingularSpot) -> list[Array]:
    """Return the unit tangents of both branches, none where these are not told."""
    basis = np.linalg.qr(spot.null)[0]
    slopes = spot.equations.slopes(spot.q, spot.t, basis)
    B = np.einsum("r,irc,cj->ij", spot.left, slopes, basis)
    values, axes = np.linalg.eigh(0.5 * (B + B.T))
    if values[0] * values[1] >= -_DEGENERATE * norm(B) ** 2:
        return []
    both = [
        basis @ (np.sqrt(values[1]) * axes[:, 0] + side * np.sqrt(-values[0]) * axes[:, 1])
        for side in (1.0, -1.0)
    ]
    return [x / norm(x) * (1.0 if x[-1] >= 0.0 else -1.0) for x in both]


def pose_ahead(
    spot: SingularSpot, tangent: Array, other: Array, size: float = _AHEAD
) -> tuple[Array, float] | None:
    """Return q and t of a closed pose on a branch, by Newton's method across its tangent."""
    equations, length = spot.equations, spot.equations.course.problem.partition.length
    far = size * length
    q, t = equations.moved(spot.q, spot.t, far * tangent)
    off = np.zeros(tangent.size)
    allowed = _NARROWER * far * norm(tangent - (tangent @ other) * other)
    for _ in range(_STEPS_ACROSS):
        G, Gx = equations.at(q, t)
        try:
            step = -np.linalg.solve(np.vstack([Gx, tangent]), np.append(G, 0.0))
        except np.linalg.LinAlgError:
            break
        off = off + step
        if not norm(off) <= allowed:
            break
        q, t = equations.moved(q, t, step)
        if norm(step) <= _STEP_ACROSS * length:
            return q, t
    return None


def branches(spot: SingularSpot, incoming: Array) -> tuple[PathBranch, ...]:
    """Return both branches at a spot; that along the path's own motion goes on.

    Parameters
    ----------
    spot : SingularSpot
    incoming : ndarray, shape (nv,)
        dq/dt of the path before it.
    """
    found = branch_tangents(spot)
    if not found:
        return ()
    course = spot.equations.course
    motions = [_motion(spot, x) for x in found]
    cosines = [along(spot, x, incoming) for x in found]
    result = []
    for k, (x, v) in enumerate(zip(found, motions, strict=True)):
        there = pose_ahead(spot, x, found[1 - k])
        pose = None if there is None else course.configuration(there[0])
        rests, goes_on = bool(x[-1] <= _MOTORS_STILL), cosines[k] == max(cosines)
        result.append(PathBranch(v, rests, goes_on, pose))
    return tuple(sorted(result, key=lambda branch: not branch.goes_on))


def along(spot: SingularSpot, x: Array, incoming: Array) -> float:
    """Return |cos| of the angle between a tangent and dq/dt of the path before it."""
    scale = spot.equations.course.problem.partition.column_scale
    arriving, leaving = incoming / scale, spot.equations.velocity(spot.t, x) / scale
    return abs(float(arriving @ leaving)) / (norm(arriving) * norm(leaving))


def _motion(spot: SingularSpot, x: Array) -> Array:
    """Return dq/dt of a tangent; of one at which motors rest, the motion of a length."""
    if x[-1] <= _MOTORS_STILL:
        length = spot.equations.course.problem.partition.length
        return spot.equations.velocity(spot.t, x * length)
    return spot.equations.rate(spot.t, x)


def on_next_piece(spot: SingularSpot, equations: PathEquations) -> SingularSpot | None:
    """Return the same spot as the beginning of another piece; None where it is regular there."""
    _, Gx = equations.at(spot.q, spot.t)
    left, values, right = np.linalg.svd(Gx)
    if values[-1] > _MOTORS_STILL * values[0]:
        return None
    return replace(spot, equations=equations, null=right[-2:].T, left=left[:, -1])
