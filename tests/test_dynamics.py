"""The equations of motion in motor coordinates: masses, gravity, forces through the loops."""

from __future__ import annotations

import mechanisms
import numpy as np
import pinocchio as pin
import pytest
from random_machines import Tree
from random_machines import at as placed
from test_second_order import somewhere
from transformed import rebuilt

import pmjac_pin as pj

Z = (0, 0, 1)


def heavy(name, rng, rotors=True):
    """A catalogue machine whose bodies all have some mass."""
    mechanism = pj.load(name)
    model = mechanism.model
    size = mechanism.characteristic_length
    for joint in range(1, model.njoints):
        lever = 0.3 * size * rng.uniform(-1, 1, 3)
        spread = size**2 * (0.02 + 0.05 * rng.random()) * np.eye(3)
        model.inertias[joint] = pin.Inertia(rng.uniform(0.5, 3.0), lever, spread)
    if rotors:
        model.armature = rng.uniform(0.0, 0.2, model.nv) * size**2
    return rebuilt(mechanism, model)


def away(mechanism, rng, size=0.05):
    scale = mechanism.problem.partition.column_scale[mechanism.problem.partition.actuated]
    step = size * mechanism.characteristic_length * scale * rng.uniform(-1, 1, scale.size)
    return mechanism.close(mechanism.home.actuated + step, enforce_limits=False)


@pytest.mark.parametrize("name", mechanisms.CATALOGUE)
def test_forward_undoes_inverse_dynamics(name, rng):
    configuration = away(heavy(name, rng), rng)
    n = len(configuration.mechanism.actuated)
    rates, accelerations = rng.normal(size=(2, n))
    dynamics, wrench = configuration.dynamics(rates), rng.normal(size=6)
    efforts = dynamics.efforts(accelerations, wrench)
    np.testing.assert_allclose(dynamics.accelerations(efforts, wrench), accelerations, atol=1e-9)
    np.testing.assert_array_equal(dynamics.mass_matrix, dynamics.mass_matrix.T)
    assert (np.linalg.eigvalsh(dynamics.mass_matrix) > 0.0).all()


def multipliers(configuration, rates, efforts, wrench):
    """v̇ of M v̇ + h = τ + Jᵀw + Cᵀλ with C v̇ + γ = 0, all at once, by least squares."""
    mechanism = configuration.mechanism
    model, data = mechanism.model, mechanism.model.createData()
    motion = configuration.motion(rates)
    upper = np.triu(pin.crba(model, data, configuration.q))
    mass = upper + np.triu(upper, 1).T
    C, J = motion.jacobian.constraint_jacobian, motion.jacobian.tool_jacobian
    gamma = motion.jacobian.slopes(motion.v[:, None])[0][0] @ motion.v
    drive = J.T @ wrench - pin.rnea(model, data, configuration.q, motion.v, 0 * motion.v)
    drive[mechanism.problem.partition.actuated] += efforts
    whole = np.block([[mass, -C.T], [C, np.zeros((len(C), len(C)))]])
    return np.linalg.lstsq(whole, np.r_[drive, -gamma], rcond=1e-12)[0][: model.nv]


@pytest.mark.parametrize("name", mechanisms.CATALOGUE)
def test_accelerations_are_those_of_all_equations_at_once(name, rng):
    """By Lagrange's multipliers: what idles accelerates as the forces will have it."""
    check_by_multipliers(away(heavy(name, rng), rng), rng)


@pytest.mark.parametrize("spinning", [0.0, 0.05, 0.3])
def test_what_idles_is_driven_by_nobody(spinning, rng):
    """A rod between two balls spins as its masses beside its axis will have it."""
    mechanism = mechanisms.rssr()
    model = mechanism.model
    for joint in range(1, model.njoints):
        rod = model.names[joint] == "rz"
        centre = np.array([1.0, spinning, 0.0]) if rod else rng.uniform(-0.3, 0.3, 3)
        mass = 0.0 if model.names[joint] in {"rx", "ry"} else 2.0
        model.inertias[joint] = pin.Inertia(mass, centre, mass * 0.02 * np.eye(3))
    mechanism = rebuilt(mechanism, model)
    assert mechanism.home.singularity().idle_motions.shape[1] == 1
    configuration = mechanism.close([0.7])
    check_by_multipliers(configuration, rng)
    dynamics = configuration.dynamics([2.0])
    moving = pin.computeKineticEnergy(
        mechanism.model, mechanism.model.createData(), configuration.q, dynamics.motion.v
    )
    assert dynamics.kinetic_energy == pytest.approx(moving)


def check_by_multipliers(configuration, rng):
    mechanism = configuration.mechanism
    rates, efforts = rng.normal(size=(2, len(mechanism.actuated)))
    wrench = rng.normal(size=6)
    wanted = multipliers(configuration, rates, efforts, wrench)
    found = configuration.dynamics(rates).accelerations(efforts, wrench)
    motors = mechanism.problem.partition.actuated
    np.testing.assert_allclose(found, wanted[motors], atol=1e-8 * max(1.0, np.abs(wanted).max()))


@pytest.mark.parametrize("name", mechanisms.CATALOGUE)
def test_power_is_the_change_of_energy(name, rng):
    """d/dt (kinetic + potential + springs') = θ̇ᵀτ + twistᵀw, the former two by Pinocchio."""
    mechanism = heavy(name, rng)
    configuration = away(mechanism, rng)
    n = len(mechanism.actuated)
    rates, accelerations = rng.normal(size=(2, n))
    wrench, model, data = rng.normal(size=6), mechanism.model, mechanism.model.createData()
    bare = model.copy()  # of some joints, Pinocchio's energy leaves armatures out
    bare.armature = np.zeros(model.nv)
    joints = [name for name, value in configuration.joint_values.items() if np.isscalar(value)]
    springs = {joint: rng.uniform(0.5, 2.0, 2) for joint in joints[::2]}
    entries = [model.joints[model.getJointId(joint)].idx_q for joint in springs]
    stiffness, rest = np.array(list(springs.values())).T
    efforts = configuration.dynamics(rates, springs=springs).efforts(accelerations, wrench)
    power = rates @ efforts + configuration.motion(rates).twist @ wrench

    def energy(t):
        theta = configuration.actuated + t * rates + 0.5 * t**2 * accelerations
        there = mechanism.close(theta, guess=configuration, enforce_limits=False)
        v = there.jacobian().motion_map @ (rates + t * accelerations)
        stored = 0.5 * model.armature @ v**2 + 0.5 * stiffness @ (there.q[entries] - rest) ** 2
        moving = pin.computeKineticEnergy(bare, data, there.q, v)
        return moving + stored + pin.computePotentialEnergy(model, data, there.q)

    h = 1e-3
    found = (8 * (energy(h) - energy(-h)) - (energy(2 * h) - energy(-2 * h))) / (12 * h)
    assert power == pytest.approx(found, rel=1e-6, abs=1e-6)


@pytest.mark.parametrize("name", ["four_bar", "five_bar", "slider_crank", "watt_six_bar"])
def test_accelerations_are_those_of_pinocchios_constrained_dynamics(name, rng):
    """In the plane, with one joint of two cut: contacts of three rows, proximal."""
    mechanism = heavy(name, rng)
    configuration = away(mechanism, rng)
    model, n = mechanism.model, len(mechanism.actuated)
    efforts, rates = rng.normal(size=(2, n)) * 5.0
    motion = configuration.motion(rates)
    tau = np.zeros(model.nv)
    tau[mechanism.problem.partition.actuated] = efforts
    contacts = pin.StdVec_RigidConstraintModel()
    for loop in mechanism.spec.loops:
        one, other = (model.frames[model.getFrameId(frame)] for frame in loop.frames)
        contacts.append(
            pin.RigidConstraintModel(
                pin.ContactType.CONTACT_3D,
                model,
                one.parentJoint,
                one.placement,
                other.parentJoint,
                other.placement,
            )
        )
    data = model.createData()
    scratch = pin.StdVec_RigidConstraintData()
    for contact in contacts:
        scratch.append(contact.createData())
    pin.initConstraintDynamics(model, data, contacts, scratch)
    settings = pin.ProximalSettings(1e-14, 1e-14, 1000)
    there = pin.constraintDynamics(
        model, data, configuration.q, motion.v, tau, contacts, scratch, settings
    )
    found = configuration.dynamics(rates).accelerations(efforts)
    wanted = there[mechanism.problem.partition.actuated]
    np.testing.assert_allclose(found, wanted, atol=1e-6 * max(1.0, np.abs(wanted).max()))


@pytest.mark.parametrize("name", ["four_bar", "watt_six_bar", "three_rps", "stewart_gough"])
def test_no_cut_is_special(name, rng):
    mechanism = heavy(name, rng, rotors=False)
    model = mechanism.model
    model.armature[mechanism.problem.partition.actuated] = 0.3
    mechanism = rebuilt(mechanism, model)
    rates = rng.normal(size=len(mechanism.actuated))
    known = mechanism.home.dynamics(rates)
    passive = [joint for joint in mechanism.passive if joint in mechanism.coordinates.names]
    for joint in passive[:3]:
        try:
            cut = pj.recut(mechanism, joint)
        except pj.ArgumentError:
            continue
        found = cut.home.dynamics(rates)
        for name in ("mass_matrix", "gravity", "bias"):
            one, other = getattr(known, name), getattr(found, name)
            np.testing.assert_allclose(one, other, atol=1e-9 * np.abs(one).max())


def parallelogram(theta):
    """Links 0.5, 1 and 0.5 m on a ground of 1 m, 3.3 kg each at its joint's origin."""
    inertia = pin.Inertia(3.3, np.zeros(3), np.diag([0.01, 0.01, 0.042673]))
    model = pin.Model()
    model.gravity = pin.Motion(np.array([0.0, -9.81, 0.0]), np.zeros(3))

    def add(parent, at, name):
        place = pin.SE3(np.eye(3), np.array([at, 0.0, 0.0]))
        joint = model.addJoint(parent, pin.JointModelRZ(), place, name)
        model.addJointFrame(joint)
        model.appendBodyToJoint(joint, inertia, pin.SE3.Identity())
        return joint

    crank = add(0, 0.0, "q")
    coupler = add(crank, 0.5, "coupler")
    rocker = add(0, 1.0, "rocker")
    for name, joint, at in (("tip", coupler, 1.0), ("end", rocker, 0.5)):
        place = pin.SE3(np.eye(3), np.array([at, 0.0, 0.0]))
        model.addFrame(pin.Frame(name, joint, 0, place, pin.FrameType.OP_FRAME))
    home = {"q": theta, "coupler": -theta, "rocker": theta}
    return pj.Mechanism.from_pinocchio(
        model, [pj.PointLoop(frames=("tip", "end"))], ["q"], "coupler", home=home
    )


@pytest.mark.parametrize("theta", [0.2, 0.7, 1.3, 2.5, -1.0])
def test_a_parallelogram_by_its_closed_form(theta):
    """M = 2 I + m l² at every pose, and gravity as of one link's mass at the crank's tip."""
    dynamics = parallelogram(theta).home.dynamics([3.0])
    assert dynamics.mass_matrix[0, 0] == pytest.approx(0.910346, abs=1e-12)
    assert dynamics.gravity[0] == pytest.approx(16.18650 * np.cos(theta), abs=1e-12)
    assert dynamics.bias[0] == pytest.approx(dynamics.gravity[0], abs=1e-12)  # M is constant


def test_of_an_open_chain_it_is_pinocchios(rng):
    mechanism = pj.load("ur5")
    configuration = somewhere("ur5", rng, 0.5)
    model, data = mechanism.model, mechanism.model.createData()
    rates, accelerations = rng.normal(size=(2, 6))
    dynamics = configuration.dynamics(rates)
    wanted = pin.rnea(model, data, configuration.q, rates, accelerations)
    np.testing.assert_allclose(dynamics.efforts(accelerations), wanted, atol=1e-11)
    there = pin.aba(model, data, configuration.q, rates, wanted)
    np.testing.assert_allclose(dynamics.accelerations(wanted), there, atol=1e-8)


def test_what_has_no_mass_is_named():
    with pytest.raises(pj.NoInertiaError, match="bodies without one are phi1, theta1, phi2"):
        pj.load("four_bar").home.dynamics()


@pytest.mark.parametrize(
    ("accelerations", "wrench", "message"),
    [
        ([1.0, 2.0], None, r"motor accelerations: 6 numbers expected, got shape \(2,\)"),
        (np.zeros(6), [1.0], r"a wrench: 6 numbers expected, got shape \(1,\)"),
        (np.full(6, np.nan), None, "finite"),
        (np.zeros(6), "x", "a wrench"),
    ],
)
def test_what_does_not_fit(accelerations, wrench, message):
    with pytest.raises(pj.ArgumentError, match=message):
        pj.load("ur5").home.dynamics().efforts(accelerations, wrench)


def test_an_armature_that_is_lost_with_its_joint_is_said(rng):
    mechanism = heavy("four_bar", rng)
    assert "joint 'phi1' is cut: its armature is lost, and no mass matrix has it" in (
        pj.recut(mechanism, "phi1").notes
    )


@pytest.mark.parametrize("size", [0.0, 1e-12, 1.0])
def test_what_idles_may_have_any_mass(size, rng):
    """A rod between two balls, light or heavy: the mass of all kinetic energy at motor rates."""
    mechanism = mechanisms.rssr()
    model = mechanism.model
    for joint in range(1, model.njoints):
        model.inertias[joint] = pin.Inertia(2.0, np.array([0.1, 0.2, 0.0]), 0.02 * np.eye(3))
    for name in ("rx", "ry", "rz"):
        model.inertias[model.getJointId(name)] = pin.Inertia.Zero()
    straight = pin.Inertia(size, np.array([1.0, 0.0, 0.0]), np.zeros((3, 3)))
    model.inertias[model.getJointId("rz")] = straight if size else pin.Inertia.Zero()
    mechanism = rebuilt(mechanism, model)
    configuration, rates = mechanism.close([0.7]), rng.normal(size=1)
    dynamics = configuration.dynamics(rates)
    data, v = mechanism.model.createData(), configuration.motion(rates).v
    moving = pin.computeKineticEnergy(mechanism.model, data, configuration.q, v)
    assert rates @ dynamics.mass_matrix @ rates / 2.0 == pytest.approx(moving)

    def mass(theta):
        return mechanism.close([theta], guess=configuration).dynamics([0.0]).mass_matrix[0, 0]

    # In one coordinate the bias is M'(θ) θ̇²/2 and gravity.
    h = 1e-3
    slope = (8 * (mass(0.7 + h) - mass(0.7 - h)) - (mass(0.7 + 2 * h) - mass(0.7 - 2 * h))) / 12 / h
    bias = dynamics.bias - configuration.dynamics([0.0]).bias
    assert bias[0] == pytest.approx(0.5 * slope * rates[0] ** 2, rel=1e-6, abs=1e-9)


DRIVEN = {
    "ankle": ["pitch", "roll"],
    "five_bar": ["phi1", "phi2"],
    "four_bar": ["phi1"],
    "slider_crank": ["x"],
    "three_rps": ["theta1", "theta2", "theta3"],
}


@pytest.mark.parametrize("name", DRIVEN)
def test_in_the_coordinates_of_other_joints_it_is_the_same_machine(name, rng):
    """θ̇ = R ẋ: M_x = Rᵀ M R, g_x = Rᵀ g, h_x = Rᵀ (M Ṙ ẋ + h), and the same accelerations."""
    configuration = away(heavy(name, rng), rng)
    mechanism = configuration.mechanism
    joints = DRIVEN[name]
    other = mechanism.driven_by(joints).configuration(configuration.q)
    n = len(mechanism.actuated)
    columns = mechanism.problem.partition.actuated
    x_rates, efforts, wrench = rng.normal(size=n), rng.normal(size=n), rng.normal(size=6)
    led = other.motion(x_rates)
    R, bias = other.jacobian().motion_map[columns], led.bias[columns]
    rates = R @ x_rates
    one, two = configuration.dynamics(rates), other.dynamics(x_rates)
    size = np.abs(two.mass_matrix).max()
    np.testing.assert_allclose(two.mass_matrix, R.T @ one.mass_matrix @ R, atol=1e-9 * size)
    np.testing.assert_allclose(two.gravity, R.T @ one.gravity, atol=1e-9 * size)
    wanted = R.T @ (one.mass_matrix @ bias + one.bias)
    np.testing.assert_allclose(two.bias, wanted, atol=1e-9 * max(size, np.abs(wanted).max()))
    found = one.accelerations(efforts, wrench)
    by_joints = R @ two.accelerations(R.T @ efforts, wrench) + bias
    np.testing.assert_allclose(found, by_joints, atol=1e-8 * max(1.0, np.abs(found).max()))
    held = other.statics(wrench).efforts
    np.testing.assert_allclose(
        held, R.T @ configuration.statics(wrench).efforts, atol=1e-9 * max(1.0, np.abs(held).max())
    )


@pytest.mark.parametrize("name", ["four_bar", "five_bar", "three_rps", "delta", "watt_six_bar"])
def test_energy_along_a_simulated_motion_is_the_work_of_the_motors(name, rng):
    """By Runge and Kutta's steps, the loops closed at each: E(t) − E(0) = ∫ (θ̇ᵀτ + twistᵀw) dt."""
    mechanism = heavy(name, rng)
    model, data = mechanism.model, mechanism.model.createData()
    bare = model.copy()  # of some joints, Pinocchio's energy leaves armatures out
    bare.armature = np.zeros(model.nv)
    n, steps = len(mechanism.actuated), 40
    pushing, wrench = rng.normal(size=n), rng.normal(size=6)
    scale = mechanism.problem.partition.motor_scale
    start = mechanism.home
    dynamics = start.dynamics()
    efforts = dynamics.gravity + pushing * np.abs(dynamics.mass_matrix).max() * scale.min()
    h = 0.1 / steps

    def flow(state, guess):
        theta, rates = state[:n], state[n : 2 * n]
        there = mechanism.close(theta, guess=guess, enforce_limits=False)
        moving = there.dynamics(rates)
        power = rates @ efforts + moving.motion.twist @ wrench
        return np.r_[rates, moving.accelerations(efforts, wrench), power], there

    def energy(state, guess):
        there = mechanism.close(state[:n], guess=guess, enforce_limits=False)
        v = there.jacobian().motion_map @ state[n : 2 * n]
        rotors = 0.5 * model.armature @ v**2
        weight = pin.computePotentialEnergy(model, data, there.q)
        return pin.computeKineticEnergy(bare, data, there.q, v) + rotors + weight

    state = np.r_[start.actuated, rng.normal(size=n) * scale, 0.0]
    first, there = energy(state, start), start
    for _ in range(steps):
        k1, there = flow(state, there)
        k2, _ = flow(state + 0.5 * h * k1, there)
        k3, _ = flow(state + 0.5 * h * k2, there)
        k4, _ = flow(state + h * k3, there)
        state = state + h / 6.0 * (k1 + 2 * k2 + 2 * k3 + k4)
    gained = energy(state, there) - first
    assert gained == pytest.approx(state[-1], rel=1e-6, abs=1e-6)
    assert abs(gained) > 1e-3


def five_bar_of(order, rng):
    """A five-bar with masses, its joints added in this order: a name and its parent's."""
    tree, bodies = Tree(), {"ground": 0}
    hinges = {"left": [0, 0, 0], "right": [4, 0, 0], "left arm": [-1, 2, 0], "right arm": [5, 2, 0]}
    for name, parent in order:
        bodies[name] = tree.joint(bodies[parent], name, placed(hinges[name]))
    for name in sorted(hinges):
        lever, turned = rng.uniform(-1, 1, 3), np.diag(rng.uniform(0.5, 0.7, 3))
        tree.model.inertias[bodies[name]] = pin.Inertia(rng.uniform(1, 3), lever, turned)
    for side in ("left", "right"):
        tree.frame(bodies[f"{side} arm"], f"{side} tip", placed([2, 4, 0]))
    loops = [pj.PointLoop(frames=("left tip", "right tip"))]
    return pj.Mechanism.from_pinocchio(tree.model, loops, ["left", "right"], "left tip")


def test_joints_may_be_added_in_any_order():
    """Pinocchio's `crba` has other numbers where a subtree's joints do not follow each other."""
    arms = [("left arm", "left"), ("right arm", "right")]
    cranks = [("left", "ground"), ("right", "ground")]
    rates, accelerations = np.array([1.5, -0.7]), np.array([0.4, 2.0])
    efforts = []
    for order in ([cranks[0], arms[0], cranks[1], arms[1]], [*cranks, *arms]):
        pose = five_bar_of(order, np.random.default_rng(3)).home
        dynamics, model = pose.dynamics(rates), pose.mechanism.model
        of_bodies = pin.computeKineticEnergy(
            model, model.createData(), pose.q, pose.motion(rates).v
        )
        assert dynamics.kinetic_energy == pytest.approx(of_bodies, rel=1e-12)
        efforts.append(dynamics.efforts(accelerations))
    np.testing.assert_allclose(*efforts, rtol=1e-12)
