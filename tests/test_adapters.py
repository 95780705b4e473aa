"""Adapters: what others' libraries compute of our machines is what we compute of them."""

from __future__ import annotations

import ast
import doctest
import importlib
import io
import re
import subprocess
import sys
import tokenize
import warnings
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest
from mechanisms import loaded

import pmjac_pin as pj

LIBRARIES = ("casadi", "crocoddyl", "jax", "mink", "pink")  # TSID: test_tsid.py
DIFFERENT = ("four_bar", "three_rps_ss", "bennett", "agile_eye")
PAGE = Path(__file__).parent.parent / "docs" / "adapters.md"
BLOCKS = re.findall(r"```python\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL)
NO_CODE = {
    tokenize.COMMENT, tokenize.NL, tokenize.NEWLINE, tokenize.INDENT, tokenize.DEDENT,
    tokenize.ENDMARKER,
}  # fmt: skip
slow = pytest.mark.slow  # the libraries are installed with the slow tests only


def adapter(name):
    """Return an adapter, where its library is there; meshcat's sockets may be deprecated ones."""
    pytest.importorskip(name, reason="a library of the extra `adapters`", exc_type=ImportError)
    return importlib.import_module(f"pmjac_pin.adapters.{name}")


@pytest.fixture(autouse=True)
def _warnings_of_others():
    """Their imports warn of each other: Crocoddyl's of meshcat's sockets."""
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", "zmq.eventloop.ioloop", DeprecationWarning)
        if find_spec("crocoddyl"):
            importlib.import_module("crocoddyl")
        yield


@pytest.mark.parametrize("name", [*LIBRARIES, "tsid"])
def test_without_its_library_an_adapter_says_what_to_install(name):
    code = (
        f"import sys; sys.modules['{name}'] = None\n"
        "import pmjac_pin as pj\n"
        f"try: pj.adapters.{name}\n"
        "except pj.MissingDependencyError as error: print(error)"
    )
    done = subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True)
    assert f"pip install 'pmjac_pin[{name}]'" in done.stdout


def code_lines(text):
    """Return which lines have code: not those of docstrings and comments alone."""
    found = set()
    for token in tokenize.generate_tokens(io.StringIO(text).readline):
        if token.type not in NO_CODE:
            found.update(range(token.start[0], token.end[0] + 1))
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef) and ast.get_docstring(
            node
        ):
            found.difference_update(range(node.body[0].lineno, node.body[0].end_lineno + 1))
    return found


def test_lines_of_code_are_counted():
    lines = ['"""Two', 'lines."""', "", "X = 1  # one", "# none", "def f():", '    """It."""']
    text = "\n".join([*lines, '    return """', '    """'])
    assert code_lines(text) == {4, 6, 8, 9}


@pytest.mark.parametrize(
    "path", sorted(Path(pj.adapters.__file__).parent.glob("*.py")), ids=lambda path: path.stem
)
def test_an_adapter_has_at_most_sixty_lines_of_code(path):
    assert len(code_lines(path.read_text(encoding="utf-8"))) <= 60


@slow
@pytest.mark.parametrize("name", LIBRARIES)
def test_examples(name):
    failed, tried = doctest.testmod(adapter(name), optionflags=doctest.ELLIPSIS)
    assert not failed
    assert tried or name in {"crocoddyl", "mink"}  # on the page


@slow
@pytest.mark.filterwarnings("ignore:Crocoddyl .* was built for another:RuntimeWarning")
@pytest.mark.parametrize("block", [block for block in BLOCKS if "adapters.tsid" not in block])
def test_examples_of_the_page(block):
    for name in LIBRARIES:
        if re.search(rf"\b{name}\b", block):
            adapter(name)
    test = doctest.DocTestParser().get_doctest(block, {}, PAGE.name, str(PAGE), 0)
    output: list[str] = []
    flags = doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE
    failed, _ = doctest.DocTestRunner(optionflags=flags).run(test, out=output.append)
    assert not failed, "".join(output)


def derivative_along(mechanism, function, rates):
    """Return the central difference of a function of a pose along motor rates, loops closed."""
    step, start = 1e-5, mechanism.home.actuated
    poses = (mechanism.close(start + s * rates, enforce_limits=False) for s in (step, -step))
    ahead, behind = map(function, poses)
    return (ahead - behind) / (2 * step)


def rate_of_q(mechanism, rates):
    """Return how q changes: quaternions and cosines are longer than what moves them."""
    return derivative_along(mechanism, lambda pose: pose.q, rates)


@slow
@pytest.mark.parametrize("name", [*DIFFERENT, "delta"])
def test_casadi(name, rng):
    of_casadi, mechanism = adapter("casadi"), loaded(name)
    recorded = pj.program(mechanism)
    function = of_casadi.function(recorded)
    for q in (mechanism.home.q, mechanism.home.q + 1e-2 * rng.uniform(-1, 1, mechanism.nq)):
        found = function(q=q)
        if np.allclose(q, pin.normalize(mechanism.model, q)):
            for key, expected in recorded(q).items():
                values = np.array(found[key]).reshape(expected.shape)
                np.testing.assert_allclose(values, expected, atol=1e-11)
    rates = rng.uniform(-1, 1, len(mechanism.actuated))
    by_q = function.factory("slope", ["q"], ["jac:J_eq:q"])(mechanism.home.q).full()
    along = (by_q @ rate_of_q(mechanism, rates)).reshape(-1, 6).T  # CasADi counts by columns
    expected = derivative_along(mechanism, lambda pose: pose.jacobian().J_eq, rates)
    np.testing.assert_allclose(along, expected, atol=1e-6 * max(1.0, np.abs(expected).max()))


def values_of(library, program, q, parameters):
    """Return what an adapter's function gives for one pose of one design."""
    function = adapter(library).function
    if library == "jax":
        importlib.import_module("jax").config.update("jax_enable_x64", True)
        return function(program)(q, parameters)
    found = function(program)(q=q, parameters=parameters)
    return {name: np.array(value) for name, value in found.items()}


@slow
@pytest.mark.parametrize("library", ["casadi", "jax"])
def test_parameters_are_the_second_argument(library):
    mechanism = loaded("four_bar")
    program, design = pj.program(mechanism, parameters=["l2", "l1"]), [3.1, 1.2]
    there = mechanism.with_parameters(l1=1.2, l2=3.1)
    found = values_of(library, program, there.home.q, design)
    J_eq = np.asarray(found["J_eq"]).reshape(6, 1)
    np.testing.assert_allclose(J_eq, there.home.jacobian().J_eq, atol=1e-11)
    for key, expected in program(there.home.q, design).items():
        values = np.asarray(found[key]).reshape(expected.shape)
        np.testing.assert_allclose(values, expected, atol=1e-11)


@slow
def test_in_jax_parameters_are_the_mechanisms_and_shapes_are_looked_at():
    function = adapter("jax").function(
        pj.program(loaded("four_bar"), parameters=["l1"]), dtype="float32"
    )
    q = loaded("four_bar").home.q
    J_eq = np.asarray(function(q)["J_eq"])
    np.testing.assert_allclose(J_eq, loaded("four_bar").home.jacobian().J_eq, atol=1e-5)
    assert function(np.tile(q, (2, 1)), [[1.0], [1.1]])["J_eq"].shape == (2, 6, 1)
    for wrong in ((q[:1],), (q, [1.0, 2.0]), (1.0,)):
        with pytest.raises(pj.ArgumentError, match="q and parameters have"):
            function(*wrong)


@slow
@pytest.mark.parametrize("library", ["casadi", "jax"])
def test_geared_endless_joints(library):
    """Their loop counts angles less whole turns."""
    model = pin.Model()
    for name, place in (("one", 0.0), ("other", 1.0)):
        joint = model.addJoint(
            0, pin.JointModelRUBZ(), pin.SE3(np.eye(3), np.array([place, 0, 0])), name
        )
        model.addFrame(
            pin.Frame(f"{name}_tip", joint, pin.SE3(np.eye(3), np.ones(3)), pin.OP_FRAME)
        )
    gears = [pj.JointLoop(joints=("other", "one"), ratio=-2.0)]
    mechanism = pj.Mechanism.from_pinocchio(model, gears, ["one"], "other_tip")
    pose = mechanism.close([2.5])
    program = pj.program(mechanism)
    assert any(term.operation == "round" for term in program.recording.terms)
    found = (
        values_of(library, program, pose.q, np.zeros(0))
        if library == "jax"
        else (adapter("casadi").function(program)(q=pose.q))
    )
    J_eq = np.array(found["J_eq"]).reshape(6, 1)
    np.testing.assert_allclose(J_eq, pose.jacobian().J_eq, atol=1e-11)
    np.testing.assert_allclose(np.array(found["eta"]).ravel(), 0.0, atol=1e-11)


@slow
@pytest.mark.parametrize("name", ["four_bar", "three_rps_ss"])
def test_jax(name, rng):
    of_jax, mechanism = adapter("jax"), loaded(name)
    jax = importlib.import_module("jax")
    jax.config.update("jax_enable_x64", True)
    recorded = pj.program(mechanism)
    function = of_jax.function(recorded)
    rates = rng.uniform(-1, 1, len(mechanism.actuated))
    motors = [mechanism.home.actuated + 0.01 * k * rates for k in range(3)]
    many = np.array([mechanism.close(each, enforce_limits=False).q for each in motors])
    one, mapped = jax.jit(function)(many[0]), jax.vmap(function)(many)
    for key, expected in recorded(many).items():
        assert one[key].dtype == np.float64
        np.testing.assert_allclose(one[key], expected[0], atol=1e-11)
        np.testing.assert_allclose(mapped[key], expected, atol=1e-11)
    by_q = jax.jit(jax.jacobian(lambda q: function(q)["J_eq"]))(mechanism.home.q)
    expected = derivative_along(mechanism, lambda pose: pose.jacobian().J_eq, rates)
    along = np.asarray(by_q) @ rate_of_q(mechanism, rates)
    np.testing.assert_allclose(along, expected, atol=1e-6 * max(1.0, np.abs(expected).max()))


@slow
def test_jax_is_not_less_exact_than_was_asked_for():
    of_jax, recorded = adapter("jax"), pj.program(loaded("four_bar"))
    jax = importlib.import_module("jax")
    jax.config.update("jax_enable_x64", False)
    try:
        with pytest.raises(pj.ArgumentError, match="single precision"):
            of_jax.function(recorded)
        found = of_jax.function(recorded, "float32")(loaded("four_bar").home.q)
    finally:
        jax.config.update("jax_enable_x64", True)
    assert found["J_eq"].dtype == np.float32
    np.testing.assert_allclose(found["J_eq"], loaded("four_bar").home.jacobian().J_eq, atol=1e-5)
    with pytest.raises(pj.ArgumentError, match="dtype must be"):
        of_jax.function(recorded, "float16")


def in_pink(mechanism):
    pink, model = importlib.import_module("pink"), mechanism.model
    return pink, pink.Configuration(model, model.createData(), mechanism.home.q)


@slow
@pytest.mark.parametrize("name", [*DIFFERENT, "delta", "five_bar"])
def test_pink_moves_as_the_loops_allow(name, rng):
    """Towards a posture that fits them it gets G θ̇; and its steps leave them open by squares."""
    of_pink, mechanism = adapter("pink"), loaded(name)
    pink, configuration = in_pink(mechanism)
    closure = of_pink.LoopClosure(mechanism)
    rates = rng.uniform(-1, 1, len(mechanism.actuated))
    gaps = []
    for size in (1e-2, 5e-3):
        v = mechanism.home.jacobian().motion_map @ (size * rates)
        posture = pink.tasks.PostureTask(1.0)
        posture.set_target(pin.integrate(configuration.model, mechanism.home.q, v))
        options = {"limits": [], "constraints": [closure]}
        found = pink.solve_ik(configuration, [posture], 1.0, "daqp", **options)
        np.testing.assert_allclose(found, v, atol=1e-10)
        q = pin.integrate(configuration.model, mechanism.home.q, found)
        gaps.append(np.linalg.norm(mechanism.loop_equations(q)[0]))
    assert gaps[0] < 0.1 * mechanism.characteristic_length
    assert gaps[0] < 1e-12 or 3.0 < gaps[0] / gaps[1] < 5.0
    configuration.update(q)
    for _ in range(6):  # closes what is open, whatever is wanted
        found = pink.solve_ik(configuration, [posture], 1.0, "daqp", **options)
        configuration.integrate_inplace(found, 1.0)
    assert mechanism.problem.gap(mechanism.loop_equations(configuration.q)[0]) < 1e-11


@slow
def test_a_frame_by_its_motors_in_pink(rng):
    of_pink, mechanism = adapter("pink"), loaded("delta").with_tool("platform")
    pink, configuration = in_pink(mechanism)
    task = of_pink.MotorFrameTask(mechanism, "platform", position_cost=1.0, orientation_cost=1.0)
    wanted = mechanism.close(mechanism.home.actuated + 0.02 * rng.uniform(-1, 1, 3))
    task.set_target(wanted.tool_pose())
    columns = mechanism.problem.partition.actuated
    found, closed = task.compute_jacobian(configuration), mechanism.home
    to_here = mechanism.home.tool_pose().actInv(wanted.tool_pose()).inverse()
    expected = -pin.Jlog6(to_here) @ mechanism.home.jacobian("LOCAL").J_eq
    np.testing.assert_allclose(found[:, columns], expected, atol=1e-12)
    np.testing.assert_array_equal(np.delete(found, columns, axis=1), 0.0)
    for _ in range(6):
        v = pink.solve_ik(configuration, [task], 1.0, "daqp", limits=[])
        closed = mechanism.close(closed.actuated + v[columns], closed)
        configuration.update(closed.q)
    np.testing.assert_allclose(closed.actuated, wanted.actuated, atol=1e-8)


@slow
@pytest.mark.parametrize("name", [*DIFFERENT, "delta", "humanoid_ankle"])
def test_mink_closes_the_loops(name, rng):
    """With tendons, hinges that are two points, and rows that depend on each other."""
    of_mink, mechanism = adapter("mink"), loaded(name)
    mink, model = importlib.import_module("mink"), of_mink.exported_model(mechanism)
    for loop in mechanism.spec.loops:
        assert model.equality("-".join(loop.frames)).name
    configuration = mink.Configuration(model)
    configuration.update_from_keyframe("home")
    closure = of_mink.LoopClosure(mechanism, model)
    assert np.abs(closure.compute_error(configuration)).max() < 1e-11
    allowed = model.nv - len(closure.compute_jacobian(configuration))
    assert allowed == mechanism.nv - mechanism.problem.partition.constraint_rank
    posture, v = mink.PostureTask(model, 1.0), 1e-2 * rng.uniform(-1, 1, model.nv)
    posture.set_target(configuration.integrate(v, 1.0))
    for _ in range(6):
        found = mink.solve_ik(
            configuration, [posture], 1.0, "daqp", limits=[], constraints=[closure]
        )
        configuration.integrate_inplace(found, 1.0)
    assert np.abs(closure.compute_error(configuration)).max() < 1e-11
    assert np.abs(configuration.q - model.key_qpos[0]).max() > 1e-3


def weightless_ankle(rng):
    """An ankle whose foot alone has mass, where nothing falls: with its rods, and without."""
    model = loaded("humanoid_ankle").model
    model.gravity = pin.Motion.Zero()
    inertia = pin.Inertia(1.1, np.array([0.03, 0.01, -0.04]), np.diag([0.004, 0.006, 0.005]))
    model.inertias[model.getJointId("roll")] = inertia
    spec = loaded("humanoid_ankle").spec
    loops = [
        pj.DistanceLoop(frames=loop.frames, length=length)
        for loop, length in zip(spec.loops, (0.195, 0.14), strict=True)
    ]
    home = loaded("humanoid_ankle").home.q
    closed = pj.Mechanism.from_pinocchio(
        model, loops, spec.actuated, "sole", passive=spec.passive, home=home
    )
    motors = [model.getJointId(name) for name in spec.actuated]
    return closed, pin.buildReducedModel(model, motors, pin.neutral(model))


@slow
@pytest.mark.filterwarnings("ignore:Crocoddyl .* was built for another:RuntimeWarning")
def test_crocoddyl_moves_a_foot_as_its_rods_do(rng):
    """Rods without mass: the tree under Rᵀ u accelerates as the closed chain does."""
    of_crocoddyl, (closed, tree) = adapter("crocoddyl"), weightless_ankle(rng)
    crocoddyl = importlib.import_module("crocoddyl")
    state, names = crocoddyl.StateMultibody(tree), ("pitch", "roll")
    geared = pj.transmission(closed, names)
    actuation = of_crocoddyl.TransmissionActuation(state, {names: geared})
    assert actuation.motors == ("pitch/motor1", "pitch/motor2")
    action = crocoddyl.DifferentialActionModelFreeFwdDynamics(
        state, actuation, crocoddyl.CostModelSum(state, 2)
    )
    data = action.createData()
    for _ in range(3):
        x, u = rng.uniform(-0.15, 0.15, 2), rng.uniform(-5, 5, 2)
        v = rng.uniform(-1, 1, 2)
        here = geared.at_joints(x)
        action.calc(data, np.concatenate([x, v]), u)
        action.calcDiff(data, np.concatenate([x, v]), u)
        np.testing.assert_allclose(data.multibody.actuation.dtau_du, here.ratio.T, atol=1e-12)
        dynamics = closed.configuration(here.configuration.q).dynamics(here.motor_rates(v))
        motion = closed.configuration(here.configuration.q).motion(
            here.motor_rates(v), dynamics.accelerations(u)
        )
        np.testing.assert_allclose(data.xout, motion.passive_accelerations, rtol=1e-8, atol=1e-8)
        numeric = crocoddyl.DifferentialActionModelNumDiff(action, False)
        by_steps = numeric.createData()
        numeric.calc(by_steps, np.concatenate([x, v]), u)
        numeric.calcDiff(by_steps, np.concatenate([x, v]), u)
        np.testing.assert_allclose(data.Fx, by_steps.Fx, rtol=1e-4, atol=1e-2)
        other = actuation.createData()
        actuation.commands(other, np.concatenate([x, v]), here.joint_efforts(u))
        np.testing.assert_allclose(other.u, u, atol=1e-10)
        actuation.torqueTransform(other, np.concatenate([x, v]), u)
        np.testing.assert_allclose(other.Mtau, np.linalg.inv(here.ratio.T), atol=1e-10)


@slow
@pytest.mark.filterwarnings("ignore:Crocoddyl .* was built for another:RuntimeWarning")
def test_crocoddyl_is_refused_what_does_not_fit():
    of_crocoddyl, ankle = adapter("crocoddyl"), loaded("humanoid_ankle")
    crocoddyl = importlib.import_module("crocoddyl")
    actuation, state = of_crocoddyl.TransmissionActuation, crocoddyl.StateMultibody(ankle.model)
    geared = pj.transmission(ankle, ["pitch", "roll"])
    with pytest.raises(pj.UnknownNameError, match="roll"):
        actuation(state, {("pitch", "rol"): geared})
    with pytest.raises(pj.ArgumentError, match="2 joints"):
        actuation(state, {("pitch",): geared})
    with pytest.raises(pj.ArgumentError, match="twice"):
        actuation(state, {("pitch", "roll"): geared}, ["roll"])
    humanoid = crocoddyl.StateMultibody(pin.buildSampleModelHumanoid())
    with pytest.raises(pj.ArgumentError, match=r"no single value: root_joint$"):
        actuation(humanoid, {}, ["root_joint", "larm_shoulder1_joint"])
    both = actuation(state, {("pitch", "roll"): geared}, ["motor1"])
    data = both.createData()
    both.calc(data, np.zeros(8), np.array([0.0, 0.0, 3.0]))
    np.testing.assert_array_equal(data.tau, [3.0, 0.0, 0.0, 0.0])
    with pytest.raises(pj.LimitError):
        both.calc(data, np.full(8, 3.0), np.zeros(3))
    both.calcDiff(data, np.zeros(8), np.array([0.0, 0.0, 3.0]))
    np.testing.assert_array_equal(data.dtau_dx, 0.0)  # a motor of its own is no gear
    np.testing.assert_array_equal(data.dtau_du[:2], [[0.0, 0.0, 1.0], [0.0, 0.0, 0.0]])


@slow
@pytest.mark.filterwarnings("ignore:Crocoddyl .* was built for another:RuntimeWarning")
def test_crocoddyl_takes_joints_that_turn_without_end():
    """With cosine and sine in x, as with the angle."""
    of_crocoddyl, names = adapter("crocoddyl"), ("pitch", "roll")
    crocoddyl = importlib.import_module("crocoddyl")
    geared, angles, u = pj.transmission(loaded("humanoid_ankle"), names), [0.1, -0.2], [3.0, -2.0]
    found = []
    for kind in (pin.JointModelRZ, pin.JointModelRUBZ):
        model = pin.Model()
        for parent, name in enumerate(names):
            model.addJoint(parent, kind(), pin.SE3.Identity(), name)
        state = crocoddyl.StateMultibody(model)
        actuation = of_crocoddyl.TransmissionActuation(state, {names: geared})
        data, q = actuation.createData(), pin.integrate(model, pin.neutral(model), np.array(angles))
        actuation.calc(data, np.concatenate([q, np.zeros(2)]), np.array(u))
        actuation.calcDiff(data, np.concatenate([q, np.zeros(2)]), np.array(u))
        found.append((data.tau, data.dtau_dx))
    for straight, endless in zip(*found, strict=True):
        np.testing.assert_allclose(endless, straight, atol=1e-12)
    np.testing.assert_allclose(found[0][0], geared.at_joints(angles).joint_efforts(u), atol=1e-12)


@slow
def test_crocoddyl_built_for_another_pinocchio_is_told():
    """It tells what it finds: whether a pendulum falls in Crocoddyl as it does in Pinocchio."""
    of_crocoddyl, ankle = adapter("crocoddyl"), loaded("humanoid_ankle")
    crocoddyl = importlib.import_module("crocoddyl")
    state, geared = crocoddyl.StateMultibody(ankle.model), pj.transmission(ankle, ["pitch", "roll"])
    arm = pin.buildSampleModelManipulator()
    whole = crocoddyl.StateMultibody(arm)
    free = crocoddyl.DifferentialActionModelFreeFwdDynamics(
        whole, crocoddyl.ActuationModelFull(whole), crocoddyl.CostModelSum(whole, 6)
    )
    data, q, none = free.createData(), np.full(6, 0.3), np.zeros(6)
    free.calc(data, np.concatenate([q, none]), none)
    falls = np.linalg.norm(data.xout) > 0.5 * np.linalg.norm(
        pin.aba(arm, arm.createData(), q, none, none)
    )
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        of_crocoddyl.TransmissionActuation(state, {("pitch", "roll"): geared})
    assert bool([w for w in told if "another Pinocchio" in str(w.message)]) is not bool(falls)
