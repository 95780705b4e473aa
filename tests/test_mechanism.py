"""Mechanism and Configuration as values: shared, copied, pickled, never changed."""

from __future__ import annotations

import concurrent.futures
import copy
import dataclasses
import multiprocessing
import pickle

import mechanisms
import numpy as np
import pinocchio as pin
import pytest
from mechanisms import loaded
from recording import recorded, unrecorded

import pmjac_pin as pj
from pmjac_pin.closing import assembly
from pmjac_pin.values.sealed_pickle import sealed_pickle, unsealed


@pytest.fixture(scope="module")
def three_rps():
    return unrecorded(loaded("three_rps"))


TARGETS = np.random.default_rng(11).uniform(0.85, 1.15, (200, 3))


def solve(mechanism, target):
    configuration = mechanism.close(target)
    return configuration.q, configuration.jacobian().J_eq


def solve_many(mechanism, targets):
    return [solve(mechanism, target) for target in targets]


def same(results, expected):
    for (q, J_eq), (q_expected, J_expected) in zip(results, expected, strict=True):
        np.testing.assert_array_equal(q, q_expected)
        np.testing.assert_array_equal(J_eq, J_expected)


@pytest.mark.parametrize("programs", [recorded, unrecorded])
def test_eight_threads_give_the_numbers_of_one(programs):
    three_rps = programs(loaded("three_rps"))
    three_rps.configuration(three_rps.home.q)
    targets = TARGETS if programs is recorded else TARGETS[:40]  # these take ten times as long
    expected = solve_many(three_rps, targets)
    with concurrent.futures.ThreadPoolExecutor(8) as pool:
        futures = [pool.submit(solve_many, three_rps, targets) for _ in range(8)]
        for future in futures:
            same(future.result(), expected)


def test_worker_processes_give_the_same_numbers(three_rps):
    expected = solve_many(three_rps, TARGETS[:20])
    context = multiprocessing.get_context("spawn")
    with concurrent.futures.ProcessPoolExecutor(2, mp_context=context) as pool:
        halves = [pool.submit(solve_many, three_rps, part) for part in np.split(TARGETS[:20], 2)]
        same([result for half in halves for result in half.result()], expected)


@pytest.mark.parametrize("name", mechanisms.CATALOGUE)
def test_pickling(name):
    mechanism = loaded(name)
    again = pickle.loads(pickle.dumps(mechanism))
    assert again == mechanism
    assert hash(again) == hash(mechanism)
    assert repr(again) == repr(mechanism)
    np.testing.assert_array_equal(again.home.q, mechanism.home.q)
    assert copy.deepcopy(mechanism) is copy.copy(mechanism) is mechanism


def test_a_mechanism_with_parameters_survives_pickling():
    mechanism = pj.load("four_bar", parameters={"l1": 1.2})
    again = pickle.loads(pickle.dumps(mechanism))
    assert again == mechanism != loaded("four_bar")
    assert again.parameters == mechanism.parameters
    assert again.spec == mechanism.spec


def test_a_configuration_survives_pickling_and_stays_closed(three_rps):
    configuration = three_rps.close([1.0, 1.1, 0.9])
    again = pickle.loads(pickle.dumps(configuration))
    np.testing.assert_array_equal(again.q, configuration.q)
    assert again.residual_norm < 1e-12
    assert again.iterations == configuration.iterations
    # Pickled apart from its mechanism, it is still a start for the first one.
    onward = three_rps.close([1.0, 1.1, 0.95], guess=again)
    np.testing.assert_allclose(onward.q, three_rps.close([1.0, 1.1, 0.95]).q, atol=1e-12)


def test_unpickling_assembles_nothing_that_was_found_before(monkeypatch, three_rps):
    pickled = pickle.dumps(three_rps.pose("home"))
    monkeypatch.setattr(assembly, "build_parts", None)
    monkeypatch.setattr(assembly, "assemble_pose", None)
    monkeypatch.setattr("pmjac_pin.closing.parts.ranked", None)
    again = pickle.loads(pickled)
    same([solve(again.mechanism, TARGETS[0])], [solve(three_rps, TARGETS[0])])
    assert again.mechanism.characteristic_length == three_rps.characteristic_length


class ByHand:
    """A pickle of something with one argument of what makes it changed."""

    def __init__(self, value, change):
        self.value, self.change = value, change

    def __reduce__(self):
        make, arguments = self.value.__reduce__()
        return make, tuple(map(self.change, arguments))


def test_a_pickle_made_by_hand_is_no_open_configuration():
    """Holding one is proof that its loops are closed."""

    def opened(argument):
        return argument + 1e-6 if isinstance(argument, np.ndarray) else argument

    pickled = pickle.dumps(ByHand(loaded("five_bar").home, opened))
    with pytest.raises(pj.ClosureError, match="are open by"):
        pickle.loads(pickled)


def test_a_pickle_made_by_hand_has_turns_of_unit_length():
    home = loaded("three_rps").home

    def longer(argument):
        return 1.1 * argument if isinstance(argument, np.ndarray) else argument

    with pytest.raises(pj.ArgumentError, match="not of unit length"):
        pickle.loads(pickle.dumps(ByHand(home, longer)))


def test_a_mechanism_whose_pickle_has_an_open_home_is_assembled_anew(three_rps):
    def opened(argument):
        if not isinstance(argument, bytes):
            return argument
        *built_of, found = unsealed(argument, "a mechanism")
        elsewhere = dataclasses.replace(found, home_q=found.home_q + 0.01)
        return sealed_pickle((*built_of, elsewhere))

    again = pickle.loads(pickle.dumps(ByHand(three_rps, opened)))
    np.testing.assert_array_equal(again.home.q, three_rps.home.q)


@pytest.mark.parametrize("make", ["jacobian", "singularity", "split_jacobian"])
def test_results_survive_pickling_read_only(three_rps, make):
    result = getattr(three_rps.home, make)()
    again = pickle.loads(pickle.dumps(result))
    for field in dataclasses.fields(result):
        one, other = getattr(result, field.name), getattr(again, field.name)
        if isinstance(one, np.ndarray):
            np.testing.assert_array_equal(one, other)
            assert not one.flags.writeable
            assert not other.flags.writeable


def arrays_within(value, seen):
    """Every array that public attributes lead to."""
    if id(value) in seen or isinstance(value, type | str | int | float | pin.SE3 | pin.Model):
        return
    seen[id(value)] = value
    if isinstance(value, np.ndarray):
        yield value
        return
    for name in dir(value):
        if not name.startswith("_"):
            attribute = getattr(value, name)
            if not callable(attribute):
                yield from arrays_within(attribute, seen)


@pytest.mark.parametrize("name", mechanisms.CATALOGUE)
def test_nothing_that_a_user_reaches_is_mutable(name):
    configuration = loaded(name).home
    jacobian = configuration.jacobian()
    values = [configuration, jacobian, configuration.singularity(), jacobian.velocity_ellipsoid()]
    values += [configuration.mechanism, configuration.mechanism.spec]
    for value in values:
        found = list(arrays_within(value, {}))
        for array in found:
            assert not array.flags.writeable
            with pytest.raises(ValueError, match=r"read-only|assignment destination"):
                array[...] = 0.0
        for attribute in ("name", "q", "J_eq", "radii", "anything"):
            with pytest.raises((AttributeError, TypeError)):
                setattr(value, attribute, 1)
    for mapping in (
        configuration.mechanism.parameters,
        configuration.joint_values,
        configuration.mechanism.spec.poses,
        configuration.mechanism.spec.poses["home"],
        configuration.mechanism.spec.parameters,
    ):
        with pytest.raises(TypeError):
            mapping["x"] = 1.0


def test_the_model_is_a_copy(three_rps):
    before = three_rps.home.jacobian().J_eq
    model = three_rps.model
    model.jointPlacements[1] = pin.SE3.Random()
    model.lowerPositionLimit[:] = 99.0
    assert three_rps.model != model
    fresh = three_rps.close([1.0, 1.0, 1.0])
    np.testing.assert_allclose(fresh.jacobian().J_eq, before, atol=1e-12)


def test_the_q_given_is_copied():
    mechanism = loaded("four_bar")
    q = mechanism.home.q.copy()
    configuration = mechanism.configuration(q)
    q[:] = 0.0
    np.testing.assert_array_equal(configuration.q, mechanism.home.q)


def test_public_facts(three_rps):
    assert three_rps.actuated == ("l1", "l2", "l3")
    assert three_rps.passive[:4] == ("theta1", "theta2", "theta3", "platform.x")
    assert (three_rps.nq, three_rps.nv, three_rps.mobility) == (13, 12, 3)
    assert three_rps.poses == ("home", "lecture_a", "lecture_b", "view")
    assert dict(three_rps.parameters) == {"a": 0.5, "b": 1.0}
    assert three_rps.limits("l1") == (0.1, 3.0)
    assert three_rps.home is three_rps.pose("home")
    assert three_rps.home.joint_values["theta2"] == pytest.approx(np.pi / 3)
    np.testing.assert_allclose(three_rps.home.actuated, 1.0)
    height = np.sqrt(3) / 2
    np.testing.assert_allclose(three_rps.home.tool_pose().translation, [0, 0, height], atol=1e-14)


@pytest.mark.parametrize("name", ["three_rps", "bricard", "delta_rods"])
def test_limits_of_all_that_has_a_unit(name):
    mechanism = loaded(name)
    for freedom in mechanism.units:
        lower, upper = mechanism.limits(freedom)
        assert lower < upper
    with pytest.raises(pj.UnknownNameError):
        mechanism.limits("nothing.x")


def test_reprs_are_short(three_rps):
    configuration = three_rps.home
    for value in (
        three_rps,
        configuration,
        configuration.jacobian(),
        configuration.split_jacobian(),
        configuration.singularity(),
        configuration.jacobian().velocity_ellipsoid(),
    ):
        assert len(repr(value)) < 130
        assert "\n" not in repr(value)


@pytest.mark.parametrize(
    ("q", "message"),
    [
        ([0.0, 0.0], "q has nq = 3 entries, got shape (2,)"),
        ([0.0, 0.0, np.inf], "q must be finite, got [0.0, 0.0, inf]"),
        ("abc", "q must be real numbers, got 'abc'"),
    ],
)
def test_bad_q(q, message):
    with pytest.raises(pj.ArgumentError) as caught:
        loaded("four_bar").configuration(q)
    assert str(caught.value) == message


def test_a_quaternion_that_is_none(three_rps):
    q = three_rps.home.q.copy()
    q[3:7] *= 2
    with pytest.raises(pj.ArgumentError, match="not of unit length"):
        three_rps.configuration(q)


@pytest.mark.parametrize("frame", ["locale", "BODY", None, 3])
def test_bad_frame(three_rps, frame):
    with pytest.raises(pj.ArgumentError, match="frame must be LOCAL, WORLD or LOCAL_WORLD_ALIGNED"):
        three_rps.home.jacobian(frame)


def test_frames_are_known_in_small_letters_too(three_rps):
    home = three_rps.home
    assert home.jacobian("local").frame == "LOCAL"
    np.testing.assert_array_equal(home.jacobian("local").J_eq, home.jacobian(pin.LOCAL).J_eq)


def test_a_configuration_cannot_be_forged(three_rps):
    configuration = three_rps.home
    with pytest.raises(pj.ArgumentError, match="is made by"):
        pj.Configuration()
    with pytest.raises((ValueError, TypeError, pj.ArgumentError)):
        dataclasses.replace(configuration, q=np.zeros(13))
    for array in (configuration.q, configuration.residual, configuration.jacobian().J_eq):
        with pytest.raises(ValueError, match="WRITEABLE"):
            array.setflags(write=True)
    with pytest.raises(pj.ArgumentError, match="is made by"):
        pj.Mechanism("three_rps")


def test_joint_values_are_a_guess(three_rps):
    configuration = three_rps.close([1.0, 1.1, 0.9])
    again = three_rps.close(configuration.actuated, guess=configuration.joint_values)
    np.testing.assert_allclose(again.q, configuration.q, atol=1e-11)


def test_a_configuration_at_other_parameters_is_a_guess():
    before = loaded("four_bar").close([2.0])
    after = pj.load("four_bar", parameters={"l1": 1.1}).close([2.0], guess=before)
    assert np.abs(after.passive - before.passive).max() < 0.2


class TestFromPinocchio:
    def four_bar(self, **changes):
        mechanism = loaded("four_bar")
        arguments = {
            "loops": [pj.PointLoop(frames=("coupler_tip", "rocker_tip"))],
            "actuated": ["theta1"],
            "tool": "coupler_midpoint",
            "passive": ["phi1", "phi2"],
            "home": mechanism.home.q,
        }
        return pj.Mechanism.from_pinocchio(mechanism.model, **{**arguments, **changes})

    def test_same_as_the_model_file(self):
        expected = loaded("four_bar").home.jacobian()
        jacobian = self.four_bar().home.jacobian()
        np.testing.assert_allclose(jacobian.J_eq, expected.J_eq, atol=1e-14)
        np.testing.assert_allclose(jacobian.K_star, expected.K_star, atol=1e-14)
        again = pickle.loads(pickle.dumps(self.four_bar()))
        np.testing.assert_allclose(again.home.jacobian().J_eq, expected.J_eq, atol=1e-14)

    def test_later_changes_of_the_model_do_not_reach_it(self):
        model = loaded("serial_2r").model
        mechanism = pj.Mechanism.from_pinocchio(model, [], ["theta1", "theta2"], "tip")
        before = mechanism.close([0.1, 0.2]).tool_pose().homogeneous
        model.jointPlacements[2] = pin.SE3.Random()
        np.testing.assert_array_equal(mechanism.close([0.1, 0.2]).tool_pose().homogeneous, before)

    @pytest.mark.parametrize(
        ("changes", "kind", "message"),
        [
            ({"actuated": ["theta9"]}, pj.UnknownNameError, "unknown joint 'theta9'; did you mean"),
            ({"actuated": "theta1"}, pj.ArgumentError, "actuated is a list of joint names, got"),
            ({"actuated": [1]}, pj.ArgumentError, "actuated is a list of joint names, it holds"),
            ({"actuated": []}, pj.ArgumentError, "`actuated` is empty"),
            (
                {"actuated": ["theta1", "theta1"]},
                pj.ArgumentError,
                "joint 'theta1' is listed twice",
            ),
            ({"tool": "coupler_mid"}, pj.UnknownNameError, "unknown frame 'coupler_mid'"),
            ({"tool": ["a", "b"]}, pj.ArgumentError, "a tool is one frame or three"),
            ({"passive": ["phi1"]}, pj.ArgumentError, "joint 'phi2' moves and is neither"),
            (
                {"actuated": ["coupler_end"]},
                pj.ArgumentError,
                "'coupler_end' is no joint that moves",
            ),
            ({"loops": None}, pj.ArgumentError, "loops is a list of PointLoop, RevoluteLoop"),
            (
                {"loops": [pj.PointLoop(frames=("coupler", "coupler_tip"))]},
                pj.ArgumentError,
                "the frames 'coupler' and 'coupler_tip' of a loop are on one body",
            ),
            (
                {"home": {"theta1": 51.0}},
                pj.LimitError,
                "the pose 'home' has a motor beyond its limits: 'theta1' = 51",
            ),
            ({"home": [0.0]}, pj.ArgumentError, "home has nq = 3 entries, got shape (1,)"),
            ({"home": {"phi9": 1.0}}, pj.UnknownNameError, "unknown joint 'phi9'"),
            (
                {"loops": [("a", "b")]},
                pj.ArgumentError,
                "loop 1 is a tuple; PointLoop, RevoluteLoop, ... or a point or frame anchor",
            ),
            (
                {"loops": [pj.DistanceLoop(frames=("crank", "rocker_tip"), length=100.0)]},
                pj.ClosureError,
                "test: the pose 'home' does not assemble",
            ),
        ],
    )
    def test_bad_input(self, changes, kind, message):
        with pytest.raises(kind) as caught:
            self.four_bar(name="test", **changes)
        assert str(caught.value).startswith(message)

    def test_not_a_model(self):
        with pytest.raises(pj.ArgumentError, match=r"model must be a pinocchio\.Model, got str"):
            pj.Mechanism.from_pinocchio("four_bar.urdf", [], ["theta1"], "tool")

    def anchor(self, kind, model):
        ends = [model.frames[model.getFrameId(name)] for name in ("coupler_tip", "rocker_tip")]
        places = [part for end in ends for part in (end.parentJoint, end.placement)]
        if kind is pin.RigidConstraintModel:
            return kind(pin.ContactType.CONTACT_3D, model, *places)
        return kind(model, *places)

    @pytest.mark.parametrize(
        "kind", [pin.PointAnchorConstraintModel, pin.RigidConstraintModel, "wrapped"]
    )
    def test_constraints_that_a_user_already_has(self, kind):
        model = loaded("four_bar").model
        wrapped = kind == "wrapped"
        constraint = self.anchor(pin.PointAnchorConstraintModel if wrapped else kind, model)
        loop = pin.ConstraintModel(constraint) if wrapped else constraint
        mechanism = self.four_bar(loops=[loop])
        expected = loaded("four_bar").home.jacobian()
        np.testing.assert_allclose(mechanism.home.jacobian().K, expected.K, atol=1e-14)
        np.testing.assert_allclose(mechanism.home.jacobian().J_eq, expected.J_eq, atol=1e-14)
        assert pickle.loads(pickle.dumps(mechanism)) == mechanism

    def test_a_frame_anchor(self):
        """The rocker's own joint as a weld: the four-bar cut behind a hub."""
        recut = pj.recut(loaded("four_bar"), "theta1")
        model = recut.model
        ends = [model.frames[model.getFrameId(name)] for name in recut.spec.loops[-1].frames]
        places = [part for end in ends for part in (end.parentJoint, end.placement)]
        anchor = pin.FrameAnchorConstraintModel(model, *places)
        mechanism = pj.Mechanism.from_pinocchio(
            model, [anchor], ["theta1"], "coupler_midpoint", home=recut.home.q
        )
        np.testing.assert_allclose(
            mechanism.home.jacobian().J_eq, recut.home.jacobian().J_eq, atol=1e-12
        )

    def test_a_robot_wrapper(self):
        robot = pin.RobotWrapper(loaded("four_bar").model)
        loops = [pj.PointLoop(frames=("coupler_tip", "rocker_tip"))]
        mechanism = pj.Mechanism.from_pinocchio(
            robot, loops, ["theta1"], "coupler_midpoint", home=loaded("four_bar").home.q
        )
        assert mechanism.mobility == 1

    def test_constraints_that_would_be_misread(self):
        model = loaded("four_bar").model
        constraint = self.anchor(pin.PointAnchorConstraintModel, model)
        constraint.desired_constraint_offset = np.array([0.0, 0.1, 0.0])
        with pytest.raises(pj.ArgumentError, match="with a desired offset"):
            self.four_bar(loops=[constraint])
        bigger = pin.buildSampleModelManipulator()
        away = pin.PointAnchorConstraintModel(bigger, 1, pin.SE3.Identity(), 6, pin.SE3.Identity())
        with pytest.raises(pj.ArgumentError, match="fixed to joint 6; the model has 4"):
            self.four_bar(loops=[away])

    @pytest.mark.parametrize(
        ("make", "message"),
        [
            (lambda: pj.PointLoop(frames=("a",)), "a loop names two frames"),
            (lambda: pj.PointLoop(frames=5), "a loop names two frames, got 5"),
            (lambda: pj.JointLoop(joints=("a", 2)), "a loop names two joints"),
            (lambda: pj.RevoluteLoop(frames=("a", "b"), axis=(0, 1)), "three components"),
            (lambda: pj.RevoluteLoop(frames=("a", "b"), axis=(0, 0, 0)), "needs a direction"),
            (lambda: pj.UniversalLoop(frames=("a", "b"), axes=((1, 0, 0),)), "two `axes`"),
        ],
    )
    def test_loops_that_are_none(self, make, message):
        with pytest.raises(pj.ArgumentError, match=message):
            make()

    def test_numbers_that_are_none(self):
        model = loaded("four_bar").model
        model.jointPlacements[1] = pin.SE3(np.eye(3), np.array([np.nan, 0.0, 0.0]))
        with pytest.raises(pj.ArgumentError, match="is not finite"):
            pj.Mechanism.from_pinocchio(model, [], list(model.names)[1:], "coupler")
        with pytest.raises(pj.ArgumentError, match="`tolerance` is a number in m, got 'x'"):
            self.four_bar(tolerance="x")

    def test_two_joints_of_one_name(self):
        model = loaded("serial_2r").model
        model.names[2] = "theta1"
        with pytest.raises(pj.ArgumentError, match="two joints of the model are named 'theta1'"):
            pj.Mechanism.from_pinocchio(model, [], ["theta1"], "tip")

    def test_numpy_names_and_numbers(self):
        names = np.array(["theta1"])
        mechanism = self.four_bar(actuated=names, passive=np.array(["phi1", "phi2"]))
        assert mechanism.actuated == ("theta1",)
        loop = pj.DistanceLoop(frames=("crank", "rocker"), length=np.float32(2.0))
        assert loop.length == 2.0


def test_a_joint_that_mimics_another_is_geared_instead():
    """Pinocchio's anchors have other Jacobians through it, or none."""
    model = pin.Model()
    crank = model.addJoint(0, pin.JointModelRZ(), pin.SE3.Identity(), "crank")
    led = pin.JointModelMimic(model.joints[crank], 2.0, 0.1)
    model.addJoint(crank, led, pin.SE3.Identity(), "led")
    advice = r"joint 'led' .* JointLoop\(joints=\('crank', 'led'\)"
    with pytest.raises(pj.ArgumentError, match=advice):
        pj.Mechanism.from_pinocchio(model, [], ["crank"])


def test_what_is_built_on_cannot_be_written_to(three_rps):
    coordinates, partition = three_rps.coordinates, three_rps.problem.partition
    shown = {name: getattr(coordinates, name) for name in vars(coordinates) if name[0] != "_"}
    arrays = [*shown.values(), *vars(partition).values(), three_rps.place, three_rps.home.q]
    arrays = [array for array in arrays if isinstance(array, np.ndarray)]
    assert len(arrays) > 10
    assert not any(array.flags.writeable for array in arrays)
    with pytest.raises(AttributeError):
        three_rps.problem = None


def test_near_the_origin_the_model_to_compute_with_is_the_model(three_rps):
    assert three_rps.kinematics.model == three_rps.model
    assert three_rps.kinematics.model is not three_rps.model
