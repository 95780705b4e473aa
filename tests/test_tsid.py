"""TSID: what holds of a closed machine's accelerations and efforts, in its own constraints.

With TSID itself where it is there, and with a stand-in that has its names.
"""

from __future__ import annotations

import doctest
import importlib
import re
import sys
import warnings
from pathlib import Path

import mechanisms
import numpy as np
import pinocchio as pin
import pytest
import tsid_stand_in
from mechanisms import CATALOGUE, loaded, mostly_slow
from test_dynamics import away, heavy, multipliers
from transformed import rebuilt

import pmjac_pin as pj

PAGE = Path(__file__).parent.parent / "docs" / "adapters.md"
ADAPTER = "pmjac_pin.adapters.tsid"
only_itself = pytest.mark.parametrize(
    "tsid", [pytest.param("itself", marks=pytest.mark.slow)], indirect=True
)


@pytest.fixture(params=[pytest.param("itself", marks=pytest.mark.slow), "stand-in"])
def tsid(request, monkeypatch):
    """TSID, for which the adapter is imported anew."""
    monkeypatch.delitem(sys.modules, ADAPTER, raising=False)
    if request.param == "stand-in":
        monkeypatch.setitem(sys.modules, "tsid", tsid_stand_in)
        yield tsid_stand_in
    else:
        with warnings.catch_warnings():
            warnings.filterwarnings("ignore", "to-Python converter", RuntimeWarning)
            yield pytest.importorskip("tsid", exc_type=ImportError)
    sys.modules.pop(ADAPTER, None)


def equations_at(*given, **gains):
    return importlib.import_module(ADAPTER).equations_of_motion(*given, **gains)


def stacked(constraints):
    matrices = [np.reshape(one.matrix, (one.rows, one.cols)) for one in constraints]
    return np.vstack(matrices), np.concatenate([one.vector for one in constraints])


def solved(tsid, hard, soft=()):
    """Return y of TSID's solver."""
    levels, problem = (tsid.ConstraintLevel(), tsid.ConstraintLevel()), tsid.HQPData()
    for level, constraints in zip(levels, (hard, soft), strict=True):
        for constraint in constraints:
            level.append(1.0, constraint)
        problem.append(level)
    solution = tsid.SolverHQuadProgFast("test").solve(problem)
    assert solution.status == 0
    return solution.x


def moving(name, rng):
    """Return equations of a moving machine, its pose, and rates and accelerations of its motors."""
    pose = away(heavy(name, rng), rng)
    rates, accelerations = rng.normal(size=(2, len(pose.actuated)))
    v = pose.motion(rates).v
    return equations_at(pose.mechanism, pose.q, v), pose, rates, accelerations


def assert_near(found, expected):
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-9 * max(1, np.abs(expected).max()))


@pytest.mark.parametrize("name", mostly_slow(CATALOGUE))
def test_inverse_and_forward_dynamics_are_those_of_the_closed_machine(name, tsid, rng):
    equations, pose, rates, accelerations = moving(name, rng)
    dynamics, motors = pose.dynamics(rates), pose.mechanism.problem.partition.actuated
    efforts, always = dynamics.efforts(accelerations), [equations.closure, equations.passive]
    task = tsid.ConstraintEquality("motors", np.eye(pose.mechanism.nv)[motors], accelerations)
    wanted = multipliers(pose, rates, efforts, np.zeros(6))  # of all joints, idle ones too
    for last in (equations.of_accelerations(task), equations.of_efforts(efforts)):
        matrix, vector = stacked([*always, last])
        for y in (np.linalg.solve(matrix, vector), solved(tsid, [*always, last])):
            assert_near(equations.efforts(y), efforts)
            assert_near(equations.accelerations(y)[motors], accelerations)
            np.testing.assert_allclose(
                equations.accelerations(y), wanted, rtol=0, atol=1e-8 * max(1, np.abs(wanted).max())
            )


@pytest.mark.parametrize("name", ["four_bar", "delta"])
def test_a_cost_that_can_be_had_is_had(name, tsid, rng):
    """On level 1, to what TSID regularises costs by."""
    equations, pose, rates, accelerations = moving(name, rng)
    motors = pose.mechanism.problem.partition.actuated
    task = tsid.ConstraintEquality("motors", np.eye(pose.mechanism.nv)[motors], accelerations)
    hard, soft = [equations.closure, equations.passive], [equations.of_accelerations(task)]
    found = equations.efforts(solved(tsid, hard, soft))
    np.testing.assert_allclose(found, pose.dynamics(rates).efforts(accelerations), rtol=1e-5)


def test_motors_that_the_loops_tie_to_each_other(tsid, rng):
    """By virtual work: one effort as good as both."""
    one = heavy("four_bar", rng)
    both = pj.Mechanism.from_pinocchio(
        one.model, one.spec.loops, ["theta1", "phi1"], one.spec.tool.frame, home=one.home.q
    )
    efforts, motion = np.array([2.0, -3.0]), one.home.motion([1.5])
    equations = equations_at(both, both.home.q, motion.v)
    hard = [equations.closure, equations.passive, equations.of_efforts(efforts)]
    found = equations.accelerations(solved(tsid, hard))
    follows = motion.jacobian.motion_map[both.problem.partition.actuated, 0]
    assert follows[0] == 1.0
    expected = one.home.dynamics([1.5]).accelerations([follows @ efforts])
    assert_near(found, one.home.motion([1.5], expected).a)


@pytest.mark.parametrize("name", ["four_bar", "bennett", "three_rps_ss"])
def test_open_loops_close_by_the_gains(name, tsid, rng):
    """At rest gaps accelerate by −Kp of themselves, in as many equations as are independent."""
    mechanism = heavy(name, rng)
    scale = mechanism.problem.partition.column_scale * mechanism.characteristic_length
    q = pin.integrate(mechanism.model, mechanism.home.q, 0.02 * scale * rng.normal(size=len(scale)))
    equations = equations_at(mechanism, q, np.zeros(mechanism.nv), Kp=30.0)
    motors = np.eye(mechanism.nv)[mechanism.problem.partition.actuated]
    task = tsid.ConstraintEquality("motors", motors, rng.normal(size=len(motors)))
    hard = [equations.closure, equations.passive, equations.of_accelerations(task)]
    dv, step = equations.accelerations(solved(tsid, hard)), 1e-6

    def gaps(size):
        return mechanism.loop_equations(pin.integrate(mechanism.model, q, size * dv))[0]

    off = (gaps(step) - gaps(-step)) / (2 * step) + 30.0 * gaps(0.0)
    partition = mechanism.problem.partition
    weights = partition.row_scale
    moved = weights[:, None] * mechanism.loop_equations(q)[1] * partition.column_scale
    independent = np.linalg.svd(moved)[0][:, : partition.constraint_rank].T
    assert np.abs(independent @ (weights * gaps(0.0))).max() > 1e-3 * partition.length
    assert np.abs(independent @ (weights * off)).max() < 1e-7 * partition.length
    assert np.abs(dv).max() > 0.1


@pytest.mark.parametrize("gain", [0.0, 20.0])
def test_what_opens_is_brought_back(gain, tsid, rng):
    """A four-bar let go with open loops and rates that they do not allow."""
    mechanism, step = heavy("four_bar", rng), 0.01
    model, v = mechanism.model, 0.1 * rng.normal(size=3)
    q = pin.integrate(model, mechanism.home.q, 0.01 * rng.normal(size=3))

    def falling(q, v):
        equations = equations_at(mechanism, q, v, Kp=gain**2 / 4, Kd=gain)
        hard = [equations.closure, equations.passive, equations.of_efforts([0.0])]
        return np.linalg.solve(*stacked(hard))[: mechanism.nv]

    first = mechanism.problem.gap(mechanism.loop_equations(q)[0])
    for _ in range(200):
        half = v + 0.5 * step * falling(q, v)  # by midpoints
        a = falling(pin.integrate(model, q, 0.5 * step * v), half)
        q, v = pin.integrate(model, q, step * half), v + step * a
    last = mechanism.problem.gap(mechanism.loop_equations(q)[0])
    assert last < 1e-4 * first if gain else last > 0.1 * first


def test_bounds_are_of_the_efforts(tsid, rng):
    equations, _, _, _ = moving("five_bar", rng)
    lower, upper = np.array([-1.0, -2.0]), np.array([3.0, 4.0])
    bounds, y = equations.effort_bounds(lower, upper), rng.normal(size=equations.closure.cols)
    assert_near(bounds.matrix @ y - bounds.lowerBound, equations.efforts(y) - lower)
    assert_near(bounds.matrix @ y - bounds.upperBound, equations.efforts(y) - upper)


def test_an_open_chain_has_no_closure(tsid, rng):
    equations, pose, rates, accelerations = moving("serial_2r", rng)
    assert (equations.closure.rows, equations.passive.rows) == (0, 0)
    found = equations.efforts(accelerations)
    assert_near(found, pose.dynamics(rates).efforts(accelerations))


def test_what_does_not_fit_is_refused(tsid, rng):
    mechanism = heavy("four_bar", rng)
    q, v = mechanism.home.q, np.zeros(3)
    for wrong in (("four_bar", q, v), (mechanism, q[:2], v), (mechanism, q, [0.0, np.nan, 0.0])):
        with pytest.raises(pj.ArgumentError):
            equations_at(*wrong)
    with pytest.raises(pj.ArgumentError, match="Kp"):
        equations_at(mechanism, q, v, Kp="much")
    equations = equations_at(mechanism, q, v)
    for method in (equations.efforts, equations.accelerations):
        with pytest.raises(pj.ArgumentError, match="y: 5 numbers"):
            method(v)
    with pytest.raises(pj.ArgumentError, match="motor efforts: 1 number"):
        equations.of_efforts(v)
    with pytest.raises(pj.ArgumentError, match="on 3 accelerations expected, got one on 5"):
        equations.of_accelerations(equations.closure)
    with pytest.raises(pj.ArgumentError, match="from lower to upper"):
        equations.effort_bounds([1.0], [-1.0])
    between = tsid.ConstraintInequality("between", np.eye(3), -np.ones(3), np.ones(3))
    for no_equality in (between, None):  # TSID gives the lower ends as an inequality's `vector`
        with pytest.raises(pj.ArgumentError, match="a ConstraintEquality expected"):
            equations.of_accelerations(no_equality)
    with pytest.raises(pj.NoInertiaError, match="bodies without one are phi1, theta1"):
        equations_at(loaded("four_bar"), q, v)


def test_what_idles_needs_a_mass(tsid):
    """Its row would be 0 = 0, which solvers refuse without saying which it is."""
    mechanism = mechanisms.rssr()
    model = mechanism.model
    for joint in range(1, model.njoints):
        mass = 0.0 if model.names[joint] in {"rx", "ry", "rz"} else 2.0
        model.inertias[joint] = pin.Inertia(mass, np.zeros(3), mass * 0.02 * np.eye(3))
    bare = rebuilt(mechanism, model)
    assert bare.home.dynamics().mass_matrix > 0.0  # what its motor moves has one
    with pytest.raises(pj.NoInertiaError, match="bodies without one are rx, ry, rz"):
        equations_at(bare, bare.home.q, np.zeros(bare.nv))


def test_singular_loops_have_no_independent_equations(tsid):
    """A parallelogram laid flat."""
    flat = pj.load("four_bar", {"l0": 4.0, "l1": 1.0, "l2": 4.0, "l3": 1.0})
    q = np.zeros(3)
    assert flat.problem.gap(flat.loop_equations(q)[0]) < 1e-12
    with pytest.raises(pj.SingularError, match="the loops of 'four_bar' are singular"):
        equations_at(flat, q, np.zeros(3))


def of_this_pinocchio(tsid, model):
    """Return TSID's own robot, which its wheel, for another Pinocchio, cannot make."""
    try:
        return tsid.RobotWrapper(model, tsid.FIXED_BASE_SYSTEM, False)
    except MemoryError:
        pytest.skip("TSID was not built for this Pinocchio")


@only_itself
def test_tasks_of_tsid_move_the_tool(tsid, rng):
    """A Delta's platform accelerates by Kp of what it is off."""
    mechanism = heavy("delta", rng).with_tool("platform")
    robot, home, nothing = of_this_pinocchio(tsid, mechanism.model), mechanism.home, np.zeros(6)
    task, data = tsid.TaskSE3Equality("platform", robot, "platform"), robot.data()
    task.setKp(25.0 * np.ones(6))
    task.setMask(np.array([1.0, 1.0, 1.0, 0.0, 0.0, 0.0]))
    task.useLocalFrame(False)
    off = np.array([0.01, -0.02, 0.03])
    wanted = home.tool_pose()
    wanted.translation = wanted.translation + off
    task.setReference(tsid.TrajectorySE3Constant("still", wanted).computeNext())
    still = np.zeros(mechanism.nv)
    robot.computeAllTerms(data, home.q, still)
    equations = equations_at(mechanism, home.q, still)
    on_y = equations.of_accelerations(task.compute(0.0, home.q, still, data))
    y = solved(tsid, [equations.closure, equations.passive, on_y])
    motors = equations.accelerations(y)[mechanism.problem.partition.actuated]
    assert_near(home.motion(nothing[:3], motors).acceleration[:3], 25.0 * off)
    assert_near(home.dynamics().efforts(motors), equations.efforts(y))


@only_itself
def test_bounds_hold_in_tsid(tsid, rng):
    """Where efforts do not reach, the loops stay closed still."""
    equations, pose, _, accelerations = moving("five_bar", rng)
    motors = pose.mechanism.problem.partition.actuated
    task = tsid.ConstraintEquality("motors", np.eye(pose.mechanism.nv)[motors], accelerations)
    hard, soft = [equations.closure, equations.passive], [equations.of_accelerations(task)]
    free = np.abs(equations.efforts(solved(tsid, hard, soft)))
    bounds = equations.effort_bounds(-0.5 * free, 0.5 * free)
    y = solved(tsid, [*hard, bounds], soft)
    found, (matrix, vector) = np.abs(equations.efforts(y)), stacked(hard)
    assert (found < 0.5 * free + 1e-6 * free.max()).all()
    assert (found > 0.5 * free - 1e-6 * free.max()).any()
    assert_near(matrix @ y, vector)


@only_itself
def test_a_contact_of_tsid_repeats_rows_of_a_planar_loop(tsid, rng):
    """So that its fast solver gives status 4: why rows are combined."""
    mechanism = heavy("four_bar", rng)
    robot = of_this_pinocchio(tsid, mechanism.model)
    formulation = tsid.InverseDynamicsFormulationAccForce("bar", robot, False)
    formulation.computeProblemData(0.0, mechanism.home.q, np.zeros(3))
    frames = mechanism.spec.loops[0].frames
    contact = tsid.ContactTwoFramePositions("loop", robot, *frames, -1e3, 1e3)
    formulation.addRigidContact(contact, 1e-5)
    problem = formulation.computeProblemData(0.0, mechanism.home.q, np.zeros(3))
    assert tsid.SolverHQuadProgFast("own").solve(problem).status == 4


def test_the_example_of_the_page(tsid):
    [block] = [
        found
        for found in re.findall(r"```python\n(.*?)```", PAGE.read_text("utf-8"), re.DOTALL)
        if "adapters.tsid" in found
    ]
    example = doctest.DocTestParser().get_doctest(block, {}, PAGE.name, str(PAGE), 0)
    assert not doctest.DocTestRunner().run(example).failed
