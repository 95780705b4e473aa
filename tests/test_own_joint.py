"""A kind of joint of one's own, a cylindrical one: one entry, and everything works with it.

Pinocchio has it as a composite. Two joints, one after the other, are the same machine.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest
from differences import difference_quotient
from drawn import draws_and_shows
from exported import FORMATS, round_trip

import pmjac_pin as pj
from pmjac_pin.algebra.floats import Floats
from pmjac_pin.kinematics.joint_steps import moved_by
from pmjac_pin.kinematics.tree import Tree
from pmjac_pin.model.joint_kind import JointKind
from pmjac_pin.model.joint_kinds import JOINT_KINDS, kind_named, register
from pmjac_pin.model.linkage import build, edges_of

PARTS = ["JointModelPZ", "JointModelRZ"]


class Cylindrical(JointKind):
    """A slide along z, and a turn about it."""

    def reads(self, joint):
        own = joint.extract() if isinstance(joint, pin.JointModel) else joint
        return [one.shortname() for one in getattr(own, "joints", [])] == PARTS


def cylinder():
    joint = pin.JointModelComposite(pin.JointModelPZ())
    joint.addJoint(pin.JointModelRZ(), pin.SE3.Identity())
    return joint


@pytest.fixture(scope="module", autouse=True)
def registered():
    register(Cylindrical("cylindrical", "", cylinder, (2,), (2,), angle=True))
    yield
    del JOINT_KINDS["cylindrical"]


def machine(*joints):
    """A crank turns and lifts a bush on a post by two rods."""
    model = pin.Model()
    tilted = pin.SE3(pin.rpy.rpyToMatrix(0.3, 1.1, 0.2), np.array([1.0, 0.2, 0.1]))
    crank = model.addJoint(0, pin.JointModelRZ(), tilted, "crank")
    bush = 0
    for name, joint in joints:
        bush = model.addJoint(bush, joint, pin.SE3.Identity(), name)
    places = {
        "A": (crank, (0.3, 0.0, 0.0)),
        "B": (crank, (-0.1, 0.3, 0.2)),
        "C": (bush, (0.4, 0.0, 0.0)),
        "D": (bush, (0.0, 0.3, 0.3)),
        "tool": (bush, (0.2, -0.3, 0.5)),
    }
    for name, (joint, place) in places.items():
        at = pin.SE3(np.eye(3), np.array(place))
        model.addFrame(pin.Frame(name, joint, at, pin.FrameType.OP_FRAME))
    data = model.createData()
    pin.framesForwardKinematics(model, data, pin.neutral(model))
    at = {name: data.oMf[model.getFrameId(name)].translation for name in places}
    loops = [
        pj.DistanceLoop(frames=pair, length=float(np.linalg.norm(at[pair[0]] - at[pair[1]])))
        for pair in (("A", "C"), ("B", "D"))
    ]
    return pj.Mechanism.from_pinocchio(
        model, loops, ["crank"], "tool", home=np.zeros(3), name="bush"
    )


@pytest.fixture(scope="module")
def bush(registered):
    return machine(("bush", cylinder()))


@pytest.fixture(scope="module")
def in_series():
    return machine(("slide", pin.JointModelPZ()), ("turn", pin.JointModelRZ()))


def test_close_and_jacobian(bush, in_series):
    assert bush.passive == ("bush.z", "bush.rz")
    for crank in (0.2, -0.3):
        found, expected = bush.close([crank]), in_series.close([crank])
        np.testing.assert_allclose(found.passive, expected.passive, atol=1e-10)
        J_eq = found.jacobian().J_eq
        np.testing.assert_allclose(J_eq, expected.jacobian().J_eq, atol=1e-9)
        np.testing.assert_allclose(J_eq, difference_quotient(found, 1e-3), atol=1e-8)


def test_all_modes_by_search_and_homotopy(bush, in_series):
    ways = [pj.parameter_homotopy(one, rng=0) for one in (bush, in_series)]
    assert ways[0].count == ways[1].count
    modes, expected = (
        pj.assembly_modes(one, [0.2], rng=0, proof=False, homotopy=way)
        for one, way in zip((bush, in_series), ways, strict=True)
    )
    found = [np.sort([mode.passive[k] for mode in modes]) for k in (0, 1)]
    assert modes.evidence == expected.evidence
    for k in (0, 1):
        np.testing.assert_allclose(found[k], np.sort([m.passive[k] for m in expected]), atol=1e-9)


def test_a_proof_says_why_there_is_none(bush):
    proof = pj.prove(bush, [0.2])
    assert not proof
    assert "'bush' is cylindrical: of several degrees of freedom" in str(proof.evidence)


def test_certificate_and_findings(bush):
    assert pj.certify(bush.close([0.2]))
    kinds = {one.name: one.kind for one in pj.check(bush).freedoms}
    assert kinds == {"crank": "revolute", "bush.z": "cylindrical", "bush.rz": "cylindrical"}


@pytest.mark.parametrize("joint", ["bush", "crank"])
def test_the_jacobian_does_not_depend_on_the_cut(bush, joint):
    cut = pj.recut(bush, joint)
    for crank in (0.1, -0.2):
        found, expected = (one.close([crank]).jacobian().J_eq for one in (cut, bush))
        np.testing.assert_allclose(found, expected, atol=1e-9)


def test_it_is_followed_with_proof(bush, in_series):
    found, expected = (
        pj.follow(one, [[-0.3], [0.3]], samples=9, certified=True) for one in (bush, in_series)
    )
    assert (found.status, found.evidence.kind) == ("end", "proof")
    np.testing.assert_allclose(found.passive, expected.passive, atol=1e-10)
    np.testing.assert_allclose(found.v, expected.v, atol=1e-8)


def test_it_is_reached(bush):
    target = bush.close([0.21])
    found = pj.reach(bush, target.tool_pose())
    assert (found.status, found.actuated) == ("reached", pytest.approx([0.21]))
    modes = pj.working_modes(bush, target.tool_pose(), rng=0)
    np.testing.assert_allclose(modes.actuated, [[0.21]], atol=1e-9)


def test_its_nearest_singularity(bush, in_series):
    found, expected = (pj.nearest_singularity(one.close([0.2]), rng=0) for one in (bush, in_series))
    assert found.freed == expected.freed == "gain"
    assert found.distance == pytest.approx(expected.distance, abs=1e-10)
    assert found.configuration.singularity().is_singular


@pytest.mark.parametrize("to", FORMATS)
def test_it_is_exported(bush, to, tmp_path):
    _, again = round_trip(bush, to, tmp_path)
    J_eq = again.close([0.2]).jacobian().J_eq
    np.testing.assert_allclose(J_eq, bush.close([0.2]).jacobian().J_eq, atol=1e-9)


def test_drawing_and_page(bush, tmp_path):
    assert draws_and_shows(bush, [0.2], tmp_path)


def test_a_joint_that_is_of_no_kind_is_refused_and_closed_all_the_same(in_series):
    unknown = pin.JointModelComposite(pin.JointModelPZ())
    other = machine(("slide", unknown), ("turn", pin.JointModelRZ()))
    expected = in_series.close([0.2]).jacobian().J_eq
    np.testing.assert_allclose(other.close([0.2]).jacobian().J_eq, expected, atol=1e-9)
    known = "known kinds are: revolute, continuous, prismatic, helical, .*, free and|, cylindrical"
    with pytest.raises(pj.ArgumentError, match=f"'slide' is a JointModelComposite, .*; {known}"):
        pj.recut(other, "turn")
    with pytest.raises(pj.UnknownNameError, match="unknown kind of joint 'cylindricle'; did you"):
        kind_named("cylindricle")


def composite(*joints):
    first, *others = joints
    whole = pin.JointModelComposite(first())
    for joint in others:
        whole.addJoint(joint(), pin.SE3.Identity())
    return whole


@pytest.mark.parametrize(
    ("parts", "axes", "message"),
    [
        ((pin.JointModelRZ, pin.JointModelPZ), ((2,), (2,)), "Pinocchio's moves in another way"),
        ((pin.JointModelPX, pin.JointModelRZ), ((0,), (2,)), "Pinocchio's moves in another way"),
        ((pin.JointModelPZ,), ((2,), (2,)), "its sizes or its name differ"),
    ],
)
def test_an_entry_that_is_not_what_pinocchio_does_is_refused(parts, axes, message):
    class Own(JointKind):
        def reads(self, joint):
            return True

    kind = Own("own", "", lambda: composite(*parts), *axes, angle=True)
    with pytest.raises(pj.ArgumentError, match=message):
        register(kind)
    assert "own" not in JOINT_KINDS


def test_turns_about_two_axes_that_are_no_angles_are_refused():
    with pytest.raises(pj.ArgumentError, match="turns about 2 axes"):
        register(JointKind("own", "RX", pin.JointModelRX, (), (0, 1)))


def placement(model, q):
    data = model.createData()
    pin.forwardKinematics(model, data, np.asarray(q))
    return data.oMi[1]


def movable():
    return [kind for kind in JOINT_KINDS.values() if kind.nv and not kind.in_turn]


def test_every_kind_says_all_of_itself(rng):
    """What it builds is read as it, slides and turns as Pinocchio does, and back from a pose."""
    for kind in movable():
        model = pin.Model()
        model.addJoint(0, kind.built(0.3), pin.SE3.Identity(), "joint")
        ((_, edge),) = edges_of(model).items()
        assert (edge.kind, edge.pitch) == (kind, 0.3 if kind.screw else 0.0)
        assert (kind.nq, kind.nv) == (model.nq, model.nv)
        assert kind.nv == 1 or len(kind.letters) == kind.nv
        register(kind)
        places = rng.uniform(-9.0, 9.0, (5, len(kind.along)))
        q, v = kind.drawn(rng, places, (-3.0, 3.0)), rng.uniform(-0.5, 0.5, (5, model.nv))
        sliding = np.arange(model.nv) < kind.slides
        for step in (v * sliding, v * ~sliding):
            expected = [pin.integrate(model, *row) for row in zip(q, step, strict=True)]
            ours = moved_by(Floats(), Tree(model), q.T, step.T).T
            np.testing.assert_allclose(ours, expected, atol=1e-12)
        twin = build(model, [edge.turned().turned()], {})
        for row in q:
            place = placement(model, row)
            back = edge.entries(pin.SE3.Identity(), place)
            assert kind.nq > 1 or back == pytest.approx(row)
            for other in (placement(twin, row), placement(model, back)):
                np.testing.assert_allclose(other.homogeneous, place.homogeneous, atol=1e-12)


def test_what_moves_along_and_about_one_axis_keeps_its_values_when_turned_round():
    for kind in movable():
        if kind.axial:
            model = pin.Model()
            model.addJoint(0, kind.built(0.3), pin.SE3.Random(), "joint")
            ((_, edge),) = edges_of(model).items()
            turned = build(model, [replace(edge.turned(), parent=0, child=1)], {})
            q = pin.integrate(model, pin.neutral(model), np.full(model.nv, 0.7))
            expected = (placement(model, q) * edge.after).inverse()
            data = turned.createData()
            pin.forwardKinematics(turned, data, q)
            found = data.oMi[1] * edge.turned().after
            np.testing.assert_allclose(found.homogeneous, expected.homogeneous, atol=1e-12)
