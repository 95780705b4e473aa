"""Operation modes, against what is known of them in closed form."""

from __future__ import annotations

import mechanisms
import numpy as np
import pinocchio as pin
import pytest
from mechanisms import loaded, mostly_slow

import pmjac_pin as pj


@pytest.fixture(scope="module")
def three_rps():
    homotopy = mechanisms.homotopy_of("three_rps_ss")
    return homotopy, homotopy.operation_modes(rng=0)


def platform_rotation(mode):
    """What turns the base's triangle into the platform's."""
    model = mode.mechanism.model
    data = model.createData()
    pin.framesForwardKinematics(model, data, mode.q)
    S1, S2, S3 = (data.oMf[model.getFrameId(name)].translation for name in ("S1", "S2", "S3"))
    x, y = S1 - (S1 + S2 + S3) / 3.0, S2 - S3
    x, y = x / np.linalg.norm(x), y / np.linalg.norm(y)
    return np.column_stack([x, y, np.cross(x, y)])


@pytest.mark.slow
def test_the_two_operation_modes_of_the_3_rps(three_rps):
    """Schadlbauer, Walter and Husty: the rotation's quaternion has w = 0, or z = 0.

    R₁₁ + R₂₂ − R₃₃ = 1 where z = 0, the trace −1 where w = 0, z along the base's normal.
    """
    homotopy, found = three_rps
    assert found.sizes == (8, 8)
    assert found.evidence.kind == "tolerance"
    seen = {}
    for lengths in ([2 / 3, 3 / 5, 3 / 4], [0.5, 1.0, 2.0], [2.9, 3.0, 3.1]):
        modes = homotopy.at(lengths)
        for mode, label in zip(modes.real, found.of(modes), strict=True):
            R = platform_rotation(mode)
            no_torsion = abs(R[0, 0] + R[1, 1] - R[2, 2] - 1.0) < 1e-8
            half_turn = abs(np.trace(R) + 1.0) < 1e-8
            assert no_torsion != half_turn
            seen.setdefault(label, set()).add(bool(no_torsion))
    assert sorted(seen) == [0, 1]
    assert all(len(kinds) == 1 for kinds in seen.values())
    assert seen[0] != seen[1]


@pytest.mark.parametrize(
    ("name", "sizes"),
    mostly_slow([("four_bar", (2,)), ("slider_crank", (2,))], [("four_bar", (2,))]),
)
def test_irreducible_mechanisms_have_one(name, sizes):
    found = mechanisms.homotopy_of(name).operation_modes(rng=0)
    assert (found.sizes, len(found), found.evidence.kind) == (sizes, 1, "tolerance")


@pytest.mark.slow
def test_a_parallelogram_has_two():
    """Parallelogram and crossed four-bar: they meet only where all bars are in line."""
    mechanism = pj.load("four_bar", {"l0": 3.0, "l1": 1.0, "l2": 3.0, "l3": 1.0})
    homotopy = pj.parameter_homotopy(mechanism, rng=0)
    found = homotopy.operation_modes(rng=0)
    assert found.sizes == (1, 1)
    for theta in (0.4, 1.2, 2.0):
        modes = homotopy.at([theta])
        parallel = [abs(np.sin(mode.joint_values["phi1"] - theta)) < 1e-9 for mode in modes.real]
        assert sorted(parallel) == [False, True]
        labels = found.of(modes)
        assert len(set(labels)) == 2
        if theta == 0.4:
            first = labels[parallel.index(True)]
        assert labels[parallel.index(True)] == first


@pytest.mark.slow
def test_the_agile_eyes_four_and_four_times_one():
    """Bonev, Chablat and Wenger (2006): four modes in which the motors do not move the eye."""
    mechanism = loaded("agile_eye")
    homotopy = pj.parameter_homotopy(mechanism, rng=0)
    found = homotopy.operation_modes(rng=0)
    assert found.sizes == (4, 1, 1, 1, 1)
    poses = {}
    for theta in ([0.2, 0.1, -0.3], [0.3, -0.2, 0.4], [-0.5, 0.1, 0.2]):
        modes = homotopy.at(theta)
        for mode, label in zip(modes.real, found.of(modes), strict=True):
            poses.setdefault(label, []).append(mode.tool_pose().rotation)
    for label in (1, 2, 3, 4):
        assert len(poses[label]) == 3
        for other in poses[label][1:]:
            np.testing.assert_allclose(other, poses[label][0], atol=1e-9)
    assert len(poses[0]) == 12
    assert np.abs(poses[0][0] - poses[0][4]).max() > 0.1


@pytest.mark.slow
def test_dietmaiers_platform_has_one():
    """Its forty solutions all hang together."""
    homotopy = mechanisms.homotopy_of("stewart_gough_dietmaier")
    assert homotopy.operation_modes(rng=0).sizes == (40,)


@pytest.mark.slow
def test_too_few_rounds_are_admitted():
    homotopy = mechanisms.homotopy_of("three_rps_ss")
    found = homotopy.operation_modes(rng=0, most_rounds=1)
    assert found.evidence.kind == "nothing"
    assert "is not whole" in str(found.evidence)


@pytest.mark.slow
def test_an_incomplete_homotopy_knows_no_operation_modes():
    homotopy = pj.parameter_homotopy(loaded("three_rps_ss"), rng=0, most_rounds=2)
    found = homotopy.operation_modes(rng=0, most_rounds=5)
    assert found.evidence.kind == "nothing"
    assert "solutions are missing" in str(found.evidence)


@pytest.mark.slow
def test_they_are_those_of_one_homotopy():
    mechanism = loaded("four_bar")
    one, other = (pj.parameter_homotopy(mechanism, rng=seed) for seed in (0, 1))
    found = one.operation_modes(rng=0)
    assert found.of(one.at([0.9])) == (0, 0)
    for strange in (other.at([0.9]), pj.assembly_modes(mechanism, [0.9], rng=0), "x"):
        with pytest.raises(pj.ArgumentError, match="of the same homotopy"):
            found.of(strange)


def parallelogram(last):
    """Cranks of length 1, 3 apart; the coupler is a ball and a point loop, or a distance."""

    def place(*xyz):
        return pin.SE3(np.eye(3), np.array(xyz, float))

    model = pin.Model()
    crank = model.addJoint(0, pin.JointModelRZ(), place(0, 0, 0), "left")
    home, coupler = {"left": 1.0, "right": 1.0}, crank
    if last == "ball":
        coupler = model.addJoint(crank, pin.JointModelSpherical(), place(1, 0, 0), "ball")
    reach = place(3, 0, 0) if last == "ball" else place(1, 0, 0)
    rocker = model.addJoint(0, pin.JointModelRZ(), place(3, 0, 0), "right")
    kind = pin.FrameType.OP_FRAME
    model.addFrame(pin.Frame("coupler_tip", coupler, 0, reach, kind))
    model.addFrame(pin.Frame("rocker_tip", rocker, 0, place(1, 0, 0), kind))
    frames = ("coupler_tip", "rocker_tip")
    rod = pj.DistanceLoop(frames=frames, length=3.0)
    loop = pj.PointLoop(frames=frames) if last == "ball" else rod
    return pj.Mechanism.from_pinocchio(model, [loop], ["left"], "rocker_tip", home=home)


@pytest.mark.slow
@pytest.mark.parametrize("last", ["ball", "distance"])
def test_a_leg_without_a_motor_keeps_its_length(last):
    found = pj.parameter_homotopy(parallelogram(last), rng=0).operation_modes(rng=0)
    assert found.sizes == (1, 1)
