"""Second order: Hessians of J_eq, gradients of its measures, accelerations."""

from __future__ import annotations

import mechanisms
import numpy as np
import pinocchio as pin
import pytest
from test_catalogue_planar import PMKS_CRANK, PMKS_POINTS, watt_six_bar_at
from test_one_kinematics import JOINTS, LOOPS, closed_frame, machine
from transformed import moved

import pmjac_pin as pj
from pmjac_pin.closing.path_kernel import path_kernel

FRAMES = ("LOCAL_WORLD_ALIGNED", "LOCAL", "WORLD")
MEASURES = {
    "smallest singular value": lambda values: values[-1],
    "largest singular value": lambda values: values[0],
    "product of singular values": np.prod,
    "condition number": lambda values: values[0] / values[-1],
    "log det": lambda values: np.log(values).sum(),
}


def somewhere(name, rng, size=0.05):
    """A pose of a catalogue machine a little away from home."""
    mechanism = pj.load(name)
    scale = mechanism.problem.partition.column_scale[mechanism.problem.partition.actuated]
    step = size * mechanism.characteristic_length * scale * rng.uniform(-1, 1, scale.size)
    return mechanism.close(mechanism.home.actuated + step, enforce_limits=False)


def through_the_closure(configuration, of, h):
    """∂f/∂θ by closing the loops at θ ± h and θ ± 2h, to fourth order; motors last."""
    mechanism, theta = configuration.mechanism, configuration.actuated

    def at(step):
        return of(mechanism.close(theta + step, guess=configuration, enforce_limits=False))

    columns = []
    for step in h * np.eye(theta.size):
        near, far = at(step) - at(-step), at(2 * step) - at(-2 * step)
        columns.append((8 * near - far) / (12 * h))
    return np.stack(columns, axis=-1)


@pytest.mark.parametrize("frame", FRAMES)
@pytest.mark.parametrize("name", mechanisms.CATALOGUE)
def test_the_hessian_is_the_derivative_through_the_closure(name, frame, rng):
    configuration = somewhere(name, rng)
    hessian = configuration.jacobian(frame).hessian
    found = through_the_closure(configuration, lambda c: c.jacobian(frame).J_eq, 1e-3)
    np.testing.assert_allclose(hessian, found, atol=1e-6 * max(1.0, np.abs(hessian).max()))


@pytest.mark.parametrize("before", [1e-1, 1e-2, 1e-3])
def test_the_hessian_beside_a_fold(before):
    """∂²φ/∂θ² of a rocker four-bar grows as the distance to its fold to −3/2."""
    mechanism = mechanisms.rocker_rocker()
    l0, l1, l2, l3 = mechanism.parameters.values()
    fold = np.arccos((l0**2 + l1**2 - (l2 + l3) ** 2) / (2 * l0 * l1))
    configuration = mechanism.close([fold - before], enforce_limits=False)
    hessian = configuration.jacobian().hessian
    found = through_the_closure(configuration, lambda c: c.jacobian().J_eq, before / 50)
    np.testing.assert_allclose(hessian, found, rtol=1e-4, atol=1e-4 * np.abs(found).max())


@pytest.mark.parametrize("name", mechanisms.CATALOGUE)
def test_accelerations_keep_the_loops_closed(name, rng):
    """K a + γ = 0, the accelerations by differences along the motion itself."""
    configuration = somewhere(name, rng)
    mechanism = configuration.mechanism
    n = len(mechanism.actuated)
    rates, accelerations = rng.normal(size=(2, n)) * mechanism.characteristic_length
    motion = configuration.motion(rates, accelerations)
    h = 1e-3

    def at(t):
        theta = configuration.actuated + t * rates + 0.5 * t**2 * accelerations
        return mechanism.close(theta, guess=configuration, enforce_limits=False)

    def v(t):
        twist = at(t).jacobian()
        return twist.motion_map @ (rates + t * accelerations), twist.J_eq @ (
            rates + t * accelerations
        )

    def slope(which):
        near, far = v(h)[which] - v(-h)[which], v(2 * h)[which] - v(-2 * h)[which]
        return (8 * near - far) / (12 * h)

    size = max(1.0, np.abs(motion.a).max())
    np.testing.assert_allclose(motion.a, slope(0), atol=2e-6 * size)
    np.testing.assert_allclose(motion.acceleration, slope(1), atol=2e-6 * size)
    constraint = configuration.split_jacobian().constraint_jacobian
    gamma = motion.jacobian.slopes(motion.v[:, None])[0][0] @ motion.v
    scale = np.abs(constraint).max(initial=1.0) * size
    np.testing.assert_allclose(constraint @ motion.a + gamma, 0, atol=1e-11 * scale)


@pytest.mark.parametrize("frame", FRAMES)
def test_of_an_open_chain_it_is_pinocchios(frame, rng):
    """Spatial in LOCAL and WORLD, classical in LOCAL_WORLD_ALIGNED."""
    mechanism = pj.load("ur5")
    model, data = mechanism.model, mechanism.model.createData()
    configuration = somewhere("ur5", rng, 0.5)
    rates, accelerations = rng.normal(size=(2, 6))
    motion = configuration.motion(rates, accelerations, frame)
    pin.forwardKinematics(model, data, configuration.q, motion.v, motion.a)
    pin.updateFramePlacements(model, data)
    tool = model.getFrameId(mechanism.spec.tool.frame)
    reference = getattr(pin.ReferenceFrame, frame)
    of = (
        pin.getFrameClassicalAcceleration if frame.endswith("ALIGNED") else pin.getFrameAcceleration
    )
    wanted = of(model, data, tool, reference).vector
    if frame == "LOCAL":  # its components' rates, as those of the twist are
        twist = pin.getFrameVelocity(model, data, tool, reference)
        wanted = of(model, data, tool, reference).vector
        assert np.allclose(motion.twist[3:], twist.angular)
    np.testing.assert_allclose(motion.acceleration[3:], wanted[3:], atol=1e-11)
    np.testing.assert_allclose(motion.acceleration[:3], wanted[:3], atol=1e-11)


def test_a_slider_crank_by_its_closed_form():
    """r = 1, l = 3, θ = π/3: x = cos θ + √(9 − sin²θ) and its derivatives."""
    mechanism = pj.load("slider_crank", {"r": 1.0, "l": 3.0})
    configuration = mechanism.close([np.pi / 3])
    jacobian = configuration.jacobian()
    assert configuration.tool_pose().translation[0] == pytest.approx(3.3722813232690143, abs=1e-14)
    assert jacobian.J_eq[0, 0] == pytest.approx(-1.0167810760733205, abs=1e-14)
    assert jacobian.hessian[0, 0, 0] == pytest.approx(-0.3338349647695613, abs=1e-14)


#: At ω = 10 rad/s of the crank and no acceleration, PMKS; B and C by its first loop.
TURNING = {"BCD": -814.73718899, "GCF": 571.70249184}
ACCELERATIONS = {
    "C": (-1630.71572022, -3708.37733188),
    "D": (1767.55695183, -3172.70864624),
}


@pytest.mark.parametrize(
    ("frame", "point", "link"),
    [("C_of_BCD", "C", "BCD"), ("C_of_GCF", "C", "GCF"), ("DE", "D", None)],
)
def test_a_six_bar_as_published(frame, point, link):
    mechanism = watt_six_bar_at(PMKS_POINTS, frame)
    found = mechanism.home.motion([PMKS_CRANK]).acceleration
    np.testing.assert_allclose(found[:2], ACCELERATIONS[point], rtol=1e-10)
    if link:
        assert found[5] == pytest.approx(TURNING[link], rel=1e-10)


@pytest.mark.parametrize("frame", ["E_of_DE", "E_of_EF", "EF"])
def test_the_six_bars_second_loop_by_differences(frame):
    """Its published table is wrong there."""
    mechanism = watt_six_bar_at(PMKS_POINTS, frame)
    found = mechanism.home.motion([PMKS_CRANK]).acceleration
    slope = through_the_closure(mechanism.home, lambda c: c.jacobian().J_eq[:, 0], 1e-4)[:, 0]
    np.testing.assert_allclose(found, PMKS_CRANK**2 * slope, rtol=1e-7, atol=1e-5)


@pytest.mark.parametrize("measure", MEASURES)
@pytest.mark.parametrize(
    ("name", "rows"),
    [
        ("five_bar", ["vx", "vy"]),
        ("serial_2r", ["vx", "vy"]),
        ("three_rps", ["vz", "wx", "wy"]),
        ("delta", ["vx", "vy", "vz"]),
        ("stewart_gough", ["vx", "vy", "vz"]),
        ("ur5", ["wx", "wy", "wz"]),
    ],
)
def test_gradients_are_derivatives_through_the_closure(name, rows, measure, rng):
    configuration = somewhere(name, rng, 0.1)
    which = [("vx", "vy", "vz", "wx", "wy", "wz").index(row) for row in rows]

    def of(c):
        return MEASURES[measure](np.linalg.svd(c.jacobian().J_eq[which], compute_uv=False))

    gradient = configuration.jacobian().gradient(measure, rows)
    found = through_the_closure(configuration, of, 1e-4)
    np.testing.assert_allclose(gradient, found, atol=1e-6 * max(1.0, np.abs(found).max()))


def test_where_there_is_no_gradient():
    jacobian = pj.load("delta").home.jacobian()  # two radii are equal there
    with pytest.raises(pj.NoGradientError, match="singular values are equal"):
        jacobian.gradient("largest singular value")
    assert jacobian.gradient("log det").shape == (3,)
    flat = pj.load("planar_3rrr").close([0.9, 1.1, 1.0]).jacobian()  # never out of its plane
    with pytest.raises(pj.NoGradientError, match="is 0 here"):
        flat.gradient("smallest singular value")
    with pytest.raises(pj.UnknownNameError, match="did you mean 'condition number'"):
        jacobian.gradient("condition numbr")
    with pytest.raises(pj.ArgumentError, match="unknown row 'x'"):
        jacobian.gradient("log det", ["x"])


def test_matrices_from_elsewhere_have_no_derivatives():
    split = pj.load("four_bar").home.split_jacobian()
    alone = pj.equivalent_jacobian(
        pj.SplitJacobian(
            split.constraint_jacobian, split.tool_jacobian, split.frame, split.partition
        )
    )
    assert np.isnan(alone.hessian).all()
    with pytest.raises(pj.NoGradientError, match="from elsewhere"):
        alone.gradient("log det")


def test_far_away_it_is_the_same(rng):
    """The acceleration of a machine that stands 10⁷ m away."""
    mechanism = pj.load("three_rps")
    away = moved(mechanism, pin.SE3(np.eye(3), np.array([1e7, -2e7, 0.0])))
    rates = rng.normal(size=3)
    one, other = (each.home.motion(rates).acceleration for each in (mechanism, away))
    np.testing.assert_allclose(one, other, atol=1e-6)


@pytest.mark.parametrize(
    ("rates", "message"),
    [
        ([1.0], r"3 motor rates \(l1, l2, l3\) expected, got 1"),
        ({"l1": 1.0}, "no value is given for motors 'l2', 'l3'"),
        ([1.0, np.nan, 0.0], "finite"),
    ],
)
def test_rates_that_do_not_fit(rates, message):
    with pytest.raises(pj.ArgumentError, match=message):
        pj.load("three_rps").home.motion(rates)


def test_at_a_singular_pose_nothing_is_half_computed():
    mechanism = mechanisms.rocker_rocker()
    l0, l1, l2, l3 = mechanism.parameters.values()
    fold = np.arccos((l0**2 + l1**2 - (l2 + l3) ** 2) / (2 * l0 * l1))
    singular = mechanism.close([fold], enforce_limits=False)
    with pytest.raises(pj.SingularError):
        singular.motion([1.0])


@pytest.mark.parametrize("name", mechanisms.CATALOGUE)
def test_recorded_programs_and_complex_steps_are_one(name, rng):
    """Forward mode over a program, and complex steps over the kinematics: nothing in common."""
    configuration = somewhere(name, rng)
    recorded = configuration.mechanism.recorded
    if path_kernel() is None:
        pytest.skip("no kernel was built")
    for _ in range(30):
        known = recorded.slopes()
    motions = rng.normal(size=(configuration.mechanism.nv, 3))
    one, other = (
        each.at(configuration.q, motions) for each in (known, configuration.mechanism.slopes)
    )
    size = max(1.0, np.abs(other.constraint).max(initial=0.0))
    np.testing.assert_allclose(one.constraint, other.constraint, atol=1e-13 * size)
    for frame in FRAMES:
        np.testing.assert_allclose(one.tool(frame), other.tool(frame), atol=1e-13 * size)


@pytest.mark.parametrize("name", mechanisms.CATALOGUE)
def test_a_recorded_motion_is_that_of_the_matrices(name, rng):
    """One program for G, its change and the drift; by slopes and by singular values without."""
    configuration = somewhere(name, rng)
    mechanism, n = configuration.mechanism, len(configuration.mechanism.actuated)
    if path_kernel() is None or mechanism.recorded._one_pose() is None:
        pytest.skip("no kernel was built, or ranks decide at each pose")
    motion = mechanism.recorded._recorded_motion()
    jacobian = configuration.jacobian()
    for _ in range(3):
        rates, accelerations = rng.normal(size=(2, n))
        plain = pj.Motion(jacobian, rates, accelerations)
        known = pj.Motion(jacobian, rates, accelerations).known(*motion.at(configuration.q, rates))
        for field in ("v", "a", "bias", "drift", "acceleration", "twist", "passive_accelerations"):
            one, other = getattr(known, field), getattr(plain, field)
            size = max(1.0, np.abs(other).max(initial=0.0))
            np.testing.assert_allclose(one, other, atol=1e-11 * size, err_msg=field)
        assert known.ways[1].shape == plain.ways[1].shape


def test_a_motion_is_recorded_when_it_is_asked_for_often(rng):
    mechanism = mechanisms.loaded("four_bar")
    if path_kernel() is None:
        pytest.skip("no kernel was built")
    found = [mechanism.close([0.9]).motion([1.5], [0.5]).acceleration for _ in range(400)]
    assert mechanism.recorded.motion() is not None
    np.testing.assert_allclose(found[-1], found[0], atol=1e-12)


@pytest.mark.parametrize("joint", JOINTS)
@pytest.mark.parametrize("kind", LOOPS)
def test_of_every_kind_of_loop_and_joint(kind, joint, rng):
    """γ = dC[v] v is η's second derivative along q ⊕ t v where C v = 0: η is Pinocchio's."""
    model = machine(JOINTS[joint], rng)
    q = pin.integrate(model, pin.neutral(model), rng.normal(size=model.nv))
    loop = LOOPS[kind](("one", closed_frame(model, q)))
    if kind == "distance":
        data = model.createData()
        pin.framesForwardKinematics(model, data, q)
        ends = [data.oMf[model.getFrameId(name)].translation for name in ("one", "two")]
        loop = pj.DistanceLoop(
            frames=("one", "two"), length=float(np.linalg.norm(ends[0] - ends[1]))
        )
    elif kind == "universal":
        loop = pj.UniversalLoop(frames=loop.frames, axes=((1, 0, 0), (0, 0, 1)))
    mechanism = pj.Mechanism.from_pinocchio(model, [loop], ["base"], "on base", home=q)
    configuration = mechanism.home
    _, values, right = np.linalg.svd(configuration.split_jacobian().constraint_jacobian)
    allowed = right[np.count_nonzero(values > 1e-9 * values[0]) :].T
    v = allowed @ rng.normal(size=allowed.shape[1])
    v /= np.linalg.norm(v)
    gamma = mechanism.slopes.at(configuration.q, v[:, None]).constraint[0] @ v
    h = 2e-3

    def eta(t):
        return mechanism.loop_equations(pin.integrate(mechanism.model, configuration.q, t * v))[0]

    near, far = eta(h) + eta(-h), eta(2 * h) + eta(-2 * h)
    found = (16 * near - far - 30 * eta(0.0)) / (12 * h * h)
    np.testing.assert_allclose(gamma, found, atol=1e-6 * max(1.0, np.abs(gamma).max()))
