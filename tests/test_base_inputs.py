"""Joints of several degrees of freedom as inputs: a base that moves, a platform that leads."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest

import pmjac_pin as pj
from pmjac_pin.viewer.page_state import page_state
from pmjac_pin.viewer.scene_options import SceneOptions
from pmjac_pin.viewer.session import Session

KINDS = {
    "free": (pin.JointModelFreeFlyer, (0.3, -0.2, 0.4, 0.3, -0.4, 0.5)),
    "planar": (pin.JointModelPlanar, (0.3, -0.2, 0.7)),
    "ball": (pin.JointModelSpherical, (0.3, -0.4, 0.5)),
    "translation": (pin.JointModelTranslation, (0.3, -0.2, 0.4)),
}
LWA = pin.ReferenceFrame.LOCAL_WORLD_ALIGNED


def at(x, y, z=0.0):
    return pin.SE3(np.eye(3), np.array([x, y, z], dtype=float))


def add(model, parent, joint, place, name):
    index = model.addJoint(parent, joint, place, name)
    model.addJointFrame(index)
    return index


def mark(model, name, joint, place):
    model.addFrame(pin.Frame(name, joint, 0, place, pin.FrameType.OP_FRAME))


def walker(kind, motors=None, first=True):
    """A four-bar, 4, 1, 3 and 3.5 m, on a base that moves in some of all ways."""
    model = pin.Model()
    base = add(model, 0, KINDS[kind][0](), at(0.1, 0.2, 0.3), "root")
    crank = add(model, base, pin.JointModelRZ(), at(0, 0), "a")
    coupler = add(model, crank, pin.JointModelRZ(), at(1, 0), "b")
    rocker = add(model, base, pin.JointModelRUBZ(), at(4, 0), "d")
    mark(model, "coupler_end", coupler, at(3, 0))
    mark(model, "rocker_end", rocker, at(3.5, 0))
    mark(model, "foot", coupler, at(1.5, 0.3, 0.1))
    motors = (["root", "a"] if first else ["a", "root"]) if motors is None else motors
    loops = [pj.RevoluteLoop(frames=("coupler_end", "rocker_end"))]
    home = {"root": KINDS[kind][1], "a": 0.9, "b": 0.1, "d": 2.0}
    return pj.Mechanism.from_pinocchio(model, loops, motors, "foot", home=home)


def by_differences(configuration, h=1e-5):
    """J_eq by displacing what is driven by Pinocchio's velocities, and closing the loops again."""
    mechanism = configuration.mechanism
    model, columns = mechanism.model, mechanism.problem.partition.actuated
    found = []
    for column in columns:
        twist = np.zeros(6)
        for way in (1.0, -1.0):
            q = pin.integrate(model, configuration.q, way * h * np.eye(model.nv)[column])
            values = mechanism.coordinates.values(q)[columns]
            pose = mechanism.close(values, guess=configuration).tool_pose()
            turned = pin.log3(pose.rotation @ configuration.tool_pose().rotation.T)
            twist += way / (2.0 * h) * np.r_[pose.translation, turned]
        found.append(twist)
    return np.column_stack(found)


@pytest.mark.parametrize("first", [True, False])
@pytest.mark.parametrize("kind", KINDS)
def test_j_eq_is_the_derivative_by_pinocchios_velocities(kind, first, rng):
    mechanism = walker(kind, first=first)
    values = mechanism.home.actuated + rng.uniform(-0.3, 0.3, len(mechanism.actuated))
    configuration = mechanism.close(values)
    np.testing.assert_allclose(configuration.actuated, values, atol=1e-13)
    J_eq = configuration.jacobian().J_eq
    np.testing.assert_allclose(J_eq, by_differences(configuration), atol=1e-8)


@pytest.mark.parametrize("kind", KINDS)
def test_the_base_moves_the_tool_as_the_open_tree(kind):
    """Its columns are Pinocchio's; the motor's are those of the machine with its base held."""
    driven, left = walker(kind), walker(kind, ["a"])
    configuration = driven.home
    n = len(driven.actuated) - 1
    whole = pin.computeFrameJacobian(
        driven.model,
        driven.model.createData(),
        configuration.q,
        driven.model.getFrameId("foot"),
        LWA,
    )
    J_eq = configuration.jacobian().J_eq
    np.testing.assert_allclose(J_eq[:, :n], whole[:, :n], atol=1e-13)
    one = left.configuration(configuration.q)
    rates = one.split_jacobian()
    solved = -np.linalg.lstsq(rates.K_star, rates.K, rcond=1e-9)[0]
    tool = np.r_[rates.Jv, rates.Jw] + np.r_[rates.Jv_star, rates.Jw_star] @ solved
    np.testing.assert_allclose(J_eq[:, n], tool[:, 0], atol=1e-12)


@pytest.mark.parametrize("kind", KINDS)
def test_where_the_base_stands_is_no_matter_to_the_leg(kind, rng):
    mechanism = walker(kind)
    away = mechanism.close({"root": KINDS[kind][1][::-1], "a": 1.4})
    near = mechanism.close({"root": KINDS[kind][1], "a": 1.4})
    for name in ("b", "d"):
        assert away.joint_values[name] == pytest.approx(near.joint_values[name], abs=1e-12)
    np.testing.assert_allclose(away.joint_values["root"], KINDS[kind][1][::-1], atol=1e-13)


@pytest.mark.parametrize("kind", KINDS)
def test_values_by_name_in_order_and_as_q_are_one(kind):
    mechanism, given = walker(kind), KINDS[kind][1][::-1]
    by_joint = mechanism.close({"root": given, "a": 1.2})
    names = mechanism.actuated
    by_freedom = mechanism.close(dict(zip(reversed(names), (1.2, *given[::-1]), strict=True)))
    joint = mechanism.model.joints[1]
    entries = by_joint.q[joint.idx_q : joint.idx_q + joint.nq]
    for other in (mechanism.close([*given, 1.2]), mechanism.close({"root": entries, "a": 1.2})):
        np.testing.assert_allclose(other.q, by_joint.q, atol=1e-12)
    np.testing.assert_allclose(by_freedom.q, by_joint.q, atol=1e-12)


@pytest.mark.parametrize("kind", KINDS)
def test_batches_and_recorded_poses_are_the_single_calls(kind, rng):
    mechanism = walker(kind)
    targets = mechanism.home.actuated + rng.uniform(-0.2, 0.2, (4, len(mechanism.actuated)))
    batch = pj.batch(mechanism)
    many = batch.close(targets)
    jacobians = batch.jacobian(many.q)
    assert not many.status.any()
    assert not jacobians.status.any()
    for q, J_eq, target in zip(many.q, jacobians.J_eq, targets, strict=True):
        one = walker(kind).close(target)
        np.testing.assert_allclose(q, one.q, atol=1e-12)
        np.testing.assert_allclose(J_eq, one.jacobian().J_eq, atol=1e-12)


@pytest.mark.parametrize("kind", KINDS)
def test_studies_answer(kind):
    mechanism = walker(kind)
    modes = pj.assembly_modes(mechanism, mechanism.home.actuated, rng=0)
    assert len(modes) == 2
    assert modes.evidence.kind == "statistics"
    assert not [f for f in pj.check(mechanism).findings if f.severity == "error"]
    assert pj.certify(mechanism.home).evidence.kind == "proof"
    if kind != "translation":
        with pytest.raises(pj.ArgumentError, match="'root' has several degrees of freedom"):
            pj.parameter_homotopy(mechanism, rng=0)


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ([1.0, 2.0], r"7 motor values \(root.x, .*, a\) expected, got 2"),
        ({"root": 1.0, "a": 2.0}, "joint 'root' takes 6 or 7 values, got 1"),
        ({"root": (0, 0, 0, 1, 1, 1, 1), "a": 2.0}, "quaternion .* is not of unit length"),
        ({"a": 1.0}, "no value is given for motors 'root.x', "),
        ({"root.x": 1.0, "a": 1.0}, "no value is given for motors 'root.y', "),
    ],
)
def test_values_that_do_not_fit(given, message):
    with pytest.raises(pj.ArgumentError, match=message):
        walker("free").close(given)


def test_a_joint_that_is_not_known_is_no_input():
    model = pin.Model()
    composite = pin.JointModelComposite()
    composite.addJoint(pin.JointModelRX())
    composite.addJoint(pin.JointModelPZ())
    mark(model, "tip", add(model, 0, composite, at(0, 0), "both"), at(1, 0))
    with pytest.raises(pj.ArgumentError, match="'both', of 2 degrees of freedom, is of no known"):
        pj.Mechanism.from_pinocchio(model, [], ["both"], "tip")


ANGLES = np.radians([0, 40, 120, 160, 240, 280]), np.radians([-20, 60, 100, 180, 220, 300])
# No similar hexagons, with which the platform would be singular everywhere.
BASE, TOP = (
    size * np.column_stack([np.cos(ring), np.sin(ring), 0 * ring])
    for size, ring in zip((1.0, 0.5), ANGLES, strict=True)
)


def led_platform(actuated):
    """A hexapod whose legs are universal joints and slides, led by its platform or by the legs."""
    model, loops = pin.Model(), []
    platform = add(model, 0, pin.JointModelFreeFlyer(), at(0, 0), "platform")
    home = {"platform": (0.05, -0.1, 1.2, 0.1, 0.15, -0.2)}
    there = pin.SE3(pin.exp3(np.array(home["platform"][3:])), np.array(home["platform"][:3]))
    for k, (foot, top) in enumerate(zip(BASE, TOP, strict=True)):
        first = add(model, 0, pin.JointModelRX(), at(*foot), f"x{k}")
        second = add(model, first, pin.JointModelRY(), at(0, 0), f"y{k}")
        slide = add(model, second, pin.JointModelPZ(), at(0, 0), f"l{k}")
        mark(model, f"leg{k}", slide, at(0, 0))
        mark(model, f"top{k}", platform, at(*top))
        loops.append(pj.PointLoop(frames=(f"leg{k}", f"top{k}")))
        way = there * top - foot
        length = np.linalg.norm(way)
        x, y, z = way / length
        home |= {f"x{k}": np.arctan2(-y, z), f"y{k}": np.arcsin(x), f"l{k}": length}
    return pj.Mechanism.from_pinocchio(model, loops, actuated, "platform", home=home)


def test_a_platform_that_leads_gives_the_inverse_kinematics():
    """Leg rates are n · (v + ω × r), from leg lines alone; they undo those led by the legs."""
    legs = [f"l{k}" for k in range(6)]
    led, driven = led_platform(["platform"]), led_platform(legs)
    pose = (0.2, 0.1, 1.3, -0.2, 0.1, 0.3)
    configuration = led.close({"platform": pose})
    there = pin.SE3(pin.exp3(np.array(pose[3:])), np.array(pose[:3]))
    ways = np.array([there * top - foot for foot, top in zip(BASE, TOP, strict=True)])
    lengths = [configuration.joint_values[name] for name in legs]
    np.testing.assert_allclose(lengths, np.linalg.norm(ways, axis=1), atol=1e-12)

    arms = TOP @ there.rotation.T
    n = ways / np.linalg.norm(ways, axis=1)[:, None]
    lines = np.hstack([n, np.cross(arms, n)])  # by the world's axes
    J_eq = configuration.jacobian().J_eq
    np.testing.assert_allclose(J_eq, np.kron(np.eye(2), there.rotation), atol=1e-12)
    rates = configuration.split_jacobian()
    rows = [rates.partition.passive_names.index(name) for name in legs]
    solved = -np.linalg.solve(rates.K_star, rates.K)[rows]
    np.testing.assert_allclose(solved, lines @ J_eq, atol=1e-11)
    by_legs = driven.configuration(configuration.q).jacobian().J_eq
    np.testing.assert_allclose(lines @ by_legs, np.eye(6), atol=1e-10)


def test_a_platform_and_legs_that_both_lead_never_answer_wrong(rng):
    """Seven motors for six freedoms: what fits is reached, anything else refused."""
    mechanism, free = led_platform(["platform", "l0"]), led_platform(["platform"])
    for _ in range(4):
        pose = np.array(free.home.actuated) + rng.uniform(-0.1, 0.1, 6)
        fitting = free.close(pose)
        length = fitting.joint_values["l0"]
        try:
            reached = mechanism.close([*pose, length])
        except pj.ClosureError:
            pass
        else:
            np.testing.assert_allclose(reached.q, fitting.q, atol=1e-9)
        with pytest.raises(pj.ClosureError):
            mechanism.close([*pose, length + 0.01])


def test_the_page_has_sliders_of_one_freedom_only():
    session = Session(walker("free").home, SceneOptions())
    state = page_state(session, about=True)
    assert [motor.name for motor in state.about.motors] == ["a"]
    assert state.values == pytest.approx((0.9,))
    session.move([1.1])
    assert session.configuration.joint_values["a"] == pytest.approx(1.1)
    root = session.configuration.joint_values["root"]
    np.testing.assert_allclose(root, KINDS["free"][1], atol=1e-12)
