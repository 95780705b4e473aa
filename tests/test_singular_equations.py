"""The equations of singular poses: exact derivatives, quadratic, and what they find is singular."""

import numpy as np
import pytest
from mechanisms import loaded, rssr, with_motors

import pmjac_pin as pj
from pmjac_pin.studies.singularities.curve_equations import EXACT
from pmjac_pin.studies.singularities.singular_equations import SingularEquations

NONE_HELD = np.zeros(0, dtype=np.intp)
GAINS = ("five_bar", "planar_3rpr", "planar_3rrr", "three_rps", "three_rps_ss", "ankle")
LOSSES = ("five_bar", "planar_3rrr", "delta", "humanoid_ankle", "serial_2r", "slider_crank")
CASES = [(name, "gain") for name in GAINS] + [(name, "loss") for name in LOSSES]


def allowed(equations, q):
    """Motions of q that the loops allow, as columns on the scaled columns."""
    mechanism, partition = equations.mechanism, equations.partition
    _, jacobian = mechanism.loop_equations(q)
    right = np.linalg.svd(partition.scaled(jacobian))[2]
    return right[partition.constraint_rank :].T


@pytest.mark.parametrize(("name", "freed"), CASES)
def test_derivatives_are_those_of_differences_along_allowed_motions(name, freed):
    equations = SingularEquations(loaded(name), freed)
    point = equations.begin(equations.mechanism.home.q)
    _, jacobian = equations.evaluate(point)
    motions, rng, h = allowed(equations, point.q), np.random.default_rng(3), 1e-5
    along = motions @ rng.standard_normal(motions.shape[1])
    step = np.concatenate([along, rng.standard_normal(point.u.size)])
    ends = [equations.residual(equations.moved(point, k * h * step)) for k in (1, -1)]
    assert (ends[0] - ends[1]) / (2.0 * h) == pytest.approx(jacobian @ step, abs=1e-8)


@pytest.mark.parametrize(("name", "freed"), CASES)
def test_what_is_found_is_closed_and_singular(name, freed):
    equations = SingularEquations(loaded(name), freed)
    point = equations.corrected(equations.begin(equations.mechanism.home.q))
    assert np.linalg.norm(equations.residual(point)) <= 100 * EXACT
    found = equations.mechanism.configuration(point.q).singularity()
    assert found.gained > 0 if freed == "gain" else found.lost > 0


def test_newton_converges_quadratically_at_a_fold(monkeypatch):
    equations = SingularEquations(loaded("three_rps_ss"), "gain")
    sizes, bordered = [], equations.bordered

    def noted(*arguments):
        found = bordered(*arguments)
        sizes.append(np.linalg.norm(found[0]))
        return found

    monkeypatch.setattr(equations, "bordered", noted)
    assert equations.corrected(equations.begin(equations.mechanism.home.q)) is not None
    near = [k for k, size in enumerate(sizes[:-1]) if size < 0.05]
    assert near
    assert all(sizes[k + 1] <= max(20.0 * sizes[k] ** 2, 1e-14) for k in near)


def test_tangents_stay_on_the_locus():
    equations = SingularEquations(loaded("five_bar"), "gain")
    point = equations.corrected(equations.begin(equations.mechanism.home.q))
    (tangent,) = equations.tangent(point, NONE_HELD)
    sizes = [
        np.linalg.norm(equations.residual(equations.moved(point, h * tangent)))
        for h in (1e-2, 1e-3)
    ]
    assert sizes[1] == pytest.approx(1e-2 * sizes[0], rel=0.1)


def test_a_fold_says_how_both_modes_part():
    """θ = θ* + t normal closes on two modes that part like √t; the other way on none."""
    equations = SingularEquations(loaded("five_bar"), "gain")
    mechanism = equations.mechanism
    point = equations.corrected(equations.begin(mechanism.home.q))
    fold, motors = equations.fold(point), mechanism.configuration(point.q).actuated
    way = -np.sign(fold.curvature) * fold.normal / np.linalg.norm(fold.normal)
    counts = [len(pj.assembly_modes(mechanism, motors + 1e-3 * s * way)) for s in (1, -1)]
    assert counts[0] == counts[1] + 2


def test_a_rod_that_spins_changes_no_dead_point():
    """As a distance it has no idle motion; as a body u is orthogonal to what idles."""
    found = []
    for rod in (False, True):
        equations = SingularEquations(with_motors(rssr(rod=rod), ["psi"]), "gain")
        point = equations.corrected(equations.begin(equations.mechanism.home.q))
        assert equations.dimension(NONE_HELD) == 0
        assert point.idle.shape[1] == int(rod)
        turned = equations.turned(point)
        assert np.linalg.norm(equations.residual(turned)) <= 1e-11
        assert turned.u @ point.u > 0.0
        pose = equations.mechanism.configuration(point.q)
        assert pose.singularity().gained == 1
        found.append(pose.joint_values)
    for name in ("theta", "psi"):
        assert found[0][name] == pytest.approx(found[1][name], abs=1e-10)


def test_what_has_no_equations_is_refused():
    with pytest.raises(pj.ArgumentError, match="nothing that could lose rank"):
        SingularEquations(loaded("serial_2r"), "gain")
