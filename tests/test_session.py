"""What the page does, without a browser: commands, the end of the range, the read-out."""

from __future__ import annotations

import json
import math
from collections import Counter

import mechanisms
import numpy as np
import pinocchio as pin
import pytest
import scipy.optimize
from mechanisms import loaded

import pmjac_pin as pj
from pmjac_pin import configuration
from pmjac_pin.model.tool_rows import TWIST_ROWS
from pmjac_pin.rates import tool_reach
from pmjac_pin.rates.ellipsoid import velocity_ellipsoid
from pmjac_pin.viewer.messages import (
    MAXIMAL_MESSAGE,
    Home,
    MoveMotors,
    NamedPose,
    Options,
    Refusal,
    SetLoad,
    decode,
)
from pmjac_pin.viewer.page_state import page_state
from pmjac_pin.viewer.readout import make_readout
from pmjac_pin.viewer.scene_options import SceneOptions
from pmjac_pin.viewer.session import Session
from pmjac_pin.words.plain import encoded


def session_of(name="three_rps", **options):
    return Session(loaded(name).home, SceneOptions(**options))


@pytest.mark.parametrize("name", ["four_bar", "three_rps", "five_bar"])
def test_an_update_finds_each_thing_once(name, monkeypatch):
    """What a move is judged by, the picture and the numbers are of one computation."""
    counted = Counter()

    def counting(module, name, what=lambda *_: ""):
        find = getattr(module, name)

        def found(*given, **named):
            counted[f"{name} {what(*given)}".strip()] += 1
            return find(*given, **named)

        monkeypatch.setattr(module, name, found)

    counting(tool_reach, "velocity_ellipsoid", lambda _, unit, *__: unit)
    counting(tool_reach, "force_ellipsoid")
    counting(configuration, "analyse_singularity")
    counting(pj.Configuration, "jacobian")
    session = session_of(name, linear=True, angular=True, force=True)
    home = session.configuration.actuated
    for step in range(1, 4):
        counted.clear()
        session.obey(MoveMotors(values=(home + 0.01 * step).tolist()))
        session.scene()
        page_state(session)
        assert counted == {
            "velocity_ellipsoid m/s": 1,
            "velocity_ellipsoid rad/s": 1,
            "force_ellipsoid": 1,
            "analyse_singularity": 1,
            "jacobian": 1,
        }


def test_a_move_goes_to_the_values():
    session = session_of()
    session.obey(MoveMotors(values=[1.1, 1.0, 0.9]))
    np.testing.assert_allclose(session.configuration.actuated, [1.1, 1.0, 0.9], atol=1e-12)
    assert session.notice.kind == ""
    assert session.pose is None


def test_moves_follow_the_assembly_mode():
    """Many small steps end where one large one does."""
    session = session_of("four_bar")
    for value in np.linspace(0.9, 4.0, 200):
        session.obey(MoveMotors(values=[value]))
    at_once = session.mechanism.close([4.0])
    np.testing.assert_allclose(session.configuration.q, at_once.q, atol=1e-9)


def test_the_end_of_the_range_stops_the_motion():
    session = session_of()
    session.obey(MoveMotors(values=[1.0, 3.0, 1.0]))
    l1, l2, l3 = session.configuration.actuated
    assert (l1, l3) == pytest.approx((1.0, 1.0), abs=1e-9)
    assert 1.9 < l2 < 2.0
    assert session.notice.kind == "stop"
    assert "l2 stops at 1.97" in session.notice.text
    assert session.configuration.residual_norm < 1e-9


def test_motors_that_are_tied_are_told_and_not_called_the_end_of_a_range():
    session = Session(
        pj.load("five_bar", actuated=["theta1", "theta2", "phi1"]).home, SceneOptions()
    )
    before = session.configuration
    texts = set()
    for way in (0.2, 0.4):
        session.obey(MoveMotors(values=[None, None, before.actuated[2] + way]))
        np.testing.assert_array_equal(session.configuration.q, before.q)
        assert session.notice.kind == "stop"
        assert session.notice.stops == (0, 0, 1)
        texts.add(session.notice.text)
    (text,) = texts
    tied = "Over-actuated by 1, the loops tie motors to each other: here the rate of 'theta1' is +"
    assert text.startswith(tied)
    assert "that of 'theta2' and -" in text
    assert text.endswith("They do not move so together: phi1 stops at -1.5587 rad.")
    assert "reachable range" not in text


def test_tied_motors_move_together_on_the_page():
    single = loaded("five_bar")
    there = single.close(single.home.actuated + 0.1)
    session = Session(
        pj.load("five_bar", actuated=["theta1", "theta2", "phi1"]).home, SceneOptions()
    )
    session.obey(MoveMotors(values=[*there.actuated.tolist(), there.joint_values["phi1"]]))
    assert session.notice.kind == ""
    np.testing.assert_allclose(session.configuration.q, there.q, atol=1e-9)


def test_the_end_of_the_range_can_be_left_again():
    session = session_of()
    for _ in range(3):
        session.obey(MoveMotors(values=[1.0, 3.0, 1.0]))
    assert session.readout().warning.level == "singular"
    session.obey(MoveMotors(values=[1.0, 1.9, 1.0]))
    assert session.notice.kind == ""
    assert session.configuration.actuated[1] == pytest.approx(1.9)
    home = session.mechanism.close([1.0, 1.9, 1.0])
    np.testing.assert_allclose(session.configuration.q, home.q, atol=1e-9)


@pytest.mark.parametrize(
    ("mechanism", "beyond", "back"),
    [
        (loaded("three_rps"), [1.0, 3.0, 1.0], [1.0, 1.5, 1.0]),
        (mechanisms.rocker_rocker(), [3.0], [1.0]),
    ],
    ids=lambda value: getattr(value, "name", None),
)
def test_a_first_pose_at_the_end_of_the_range_can_be_left(mechanism, beyond, back):
    """No path led to it, so that nothing says on which of the two modes to go back."""
    with pytest.raises(pj.ClosureError) as caught:
        mechanism.close(beyond)
    end = caught.value.reached
    started, shown = Session(end, SceneOptions()), Session(mechanism.home, SceneOptions())
    shown.show(end)
    for session in (started, shown):
        session.obey(MoveMotors(values=back))
        assert session.notice.kind == ""
        home = mechanism.close(back)
        np.testing.assert_allclose(session.configuration.q, home.q, atol=1e-9)


def test_beyond_a_fold_there_is_no_way_from_it_either():
    mechanism = mechanisms.rocker_rocker()
    with pytest.raises(pj.ClosureError) as caught:
        mechanism.close([3.0])
    session = Session(caught.value.reached, SceneOptions())
    session.obey(MoveMotors(values=[3.0]))
    assert session.notice.kind == "stop"
    assert session.configuration.actuated == pytest.approx(caught.value.reached.actuated)


def test_at_the_end_of_a_range_no_motor_moves_that_was_not_asked_to():
    session = session_of()
    session.obey(MoveMotors(values=[None, 3.0, None]))
    end = session.configuration.actuated
    for _ in range(5):
        session.obey(MoveMotors(values=[session.configuration.actuated[0] - 0.02, None, None]))
        np.testing.assert_allclose(session.configuration.actuated[1:], end[1:], atol=2e-3)


def test_values_seen_at_the_end_and_sent_again_are_no_trap():
    session = session_of()
    session.obey(MoveMotors(values=[1.0, 3.0, 1.0]))
    session.obey(MoveMotors(values=session.configuration.actuated.tolist()))
    session.obey(MoveMotors(values=[None, 1.5, None]))
    home = session.mechanism.close([1.0, 1.5, 1.0])
    np.testing.assert_allclose(session.configuration.q, home.q, atol=1e-9)


def test_where_branches_cross_the_way_back_is_open():
    parallelogram = pj.load("four_bar", {"l0": 3.0, "l1": 1.0, "l2": 3.0, "l3": 1.0})
    session = Session(parallelogram.home, SceneOptions())
    before = session.configuration.actuated
    session.obey(MoveMotors(values=[0.0]))
    assert session.readout().warning.level == "singular"
    session.obey(MoveMotors(values=before.tolist()))
    np.testing.assert_allclose(session.configuration.q, parallelogram.home.q, atol=1e-9)


def test_two_pages_move_two_motors():
    session = session_of()
    session.obey(MoveMotors(values=[1.1, None, None]))
    session.obey(MoveMotors(values=[None, 0.9, None]))
    np.testing.assert_allclose(session.configuration.actuated, [1.1, 0.9, 1.0])


def test_a_mechanism_without_a_jacobian_is_shown_all_the_same():
    session = Session(mechanisms.over_actuated_four_bar().home, SceneOptions())
    readout = session.readout()
    assert readout.J_eq is None
    assert readout.refusal


def test_a_pose_that_does_not_close_is_left_out(monkeypatch):
    mechanism = loaded("three_rps")
    pose = type(mechanism).pose

    def broken(self, name):
        if name == "lecture_b":
            raise pj.ClosureError("it does not close", residual_norm=1.0, q=None)
        return pose(self, name)

    monkeypatch.setattr(type(mechanism), "pose", broken)
    session = Session(mechanism.home, SceneOptions())
    assert page_state(session, about=True).about.poses == ("home", "lecture_a", "view")
    session.obey(MoveMotors(values=[1.1, 1.0, 1.0]))


@pytest.mark.parametrize(
    "values",
    [
        [],
        [1.0],
        [1.0] * 4,
        [math.nan, 1.0, 1.0],
        [math.inf, 1.0, 1.0],
        [1.0, -math.inf, 1.0],
        [1.0, 3.5, 1.0],
        [1e300, 1.0, 1.0],
    ],
)
def test_a_value_that_is_none_changes_nothing(values):
    session = session_of()
    before = session.configuration
    with pytest.raises(pj.ArgumentError):
        session.obey(MoveMotors(values=values))
    assert session.configuration is before


def test_poses_and_home():
    session = session_of()
    session.obey(NamedPose(name="lecture_b"))
    assert session.pose == "lecture_b"
    assert session.configuration is session.mechanism.pose("lecture_b")
    with pytest.raises(pj.UnknownNameError, match="did you mean 'lecture_b'"):
        session.obey(NamedPose(name="lecture_c"))
    assert session.pose == "lecture_b"
    session.obey(Home())
    assert session.pose == "home"


def test_options_choose_what_is_drawn():
    session = session_of()

    def drawn():
        items = (item for item in session.scene().items if item.visible)
        return {name for item in items for name in item.name.split("/")}

    before = drawn()
    session.obey(Options(linear=True, angular=True, force=False, names=True, scale=2.0))
    assert drawn() - before
    assert page_state(session).drawn.scale == 2.0


def test_another_mechanism_is_refused():
    session = session_of()
    with pytest.raises(pj.ArgumentError, match="four_bar"):
        session.show(loaded("four_bar").home)


def test_the_same_mechanism_loaded_twice_is_welcome():
    session = session_of()
    session.show(loaded("three_rps").close([1.1, 1.0, 1.0]))
    assert session.configuration.actuated[0] == pytest.approx(1.1)
    session.obey(MoveMotors(values=[1.2, 1.0, 1.0]))


def test_an_update_computes_jacobian_and_ellipsoids_once(monkeypatch):
    session, computed = session_of(), []

    def counted(jacobian, unit, *others):
        computed.append(unit)
        return velocity_ellipsoid(jacobian, unit, *others)

    monkeypatch.setattr("pmjac_pin.rates.tool_reach.velocity_ellipsoid", counted)
    session.obey(MoveMotors(values=[1.2, 1.0, 1.0]))
    session.scene()
    page_state(session)
    assert sorted(computed) == ["m/s", "rad/s"]


@pytest.mark.parametrize(
    ("name", "rates", "efforts"),
    [
        ("three_rps", "m/s", "N"),
        ("four_bar", "rad/s", "N m"),
        ("mixed", "m/s and rad/s", "N and N m"),
    ],
)
def test_the_page_says_in_what_motors_are_counted(name, rates, efforts):
    if name == "mixed":
        model = pin.Model()
        slide = model.addJoint(0, pin.JointModelPX(), pin.SE3.Identity(), "slide")
        arm = model.addJoint(slide, pin.JointModelRZ(), pin.SE3.Identity(), "turn")
        place = pin.SE3(np.eye(3), np.array([1.0, 0.0, 0.0]))
        model.addFrame(pin.Frame("tip", arm, place, pin.FrameType.OP_FRAME))
        mechanism = pj.Mechanism.from_pinocchio(model, [], ["slide", "turn"], "tip")
    else:
        mechanism = loaded(name)
    about = page_state(Session(mechanism.home, SceneOptions()), about=True).about
    told = f"Ellipsoids: motor rates together 1 in {rates}, efforts together 1 in {efforts}."
    assert about.counted == told


@pytest.mark.parametrize("name", pj.list_mechanisms())
def test_the_readout_is_the_library_s(name):
    configuration = loaded(name).home
    readout = make_readout(configuration)
    jacobian = configuration.jacobian()
    for frame, rows in readout.J_eq.items():
        expected = configuration.jacobian(frame).J_eq
        np.testing.assert_allclose(rows, expected, rtol=0.0, atol=1e-12)
    tool = configuration.tool_pose()
    np.testing.assert_array_equal(readout.tool_position, tool.translation)
    np.testing.assert_allclose(pin.exp3(np.array(readout.tool_turn)), tool.rotation, atol=1e-12)
    np.testing.assert_array_equal(readout.passive, configuration.passive)
    shown = np.array(readout.J_eq["LOCAL_WORLD_ALIGNED"])
    np.testing.assert_array_equal(shown[shown != 0.0], jacobian.J_eq[shown != 0.0])
    assert (np.abs(shown[shown != 0.0]) > 1e-12).all()
    singular_values = np.linalg.svd(jacobian.Jv_eq, compute_uv=False)
    np.testing.assert_allclose(readout.Jv_singular_values, singular_values, atol=1e-14)
    np.testing.assert_allclose(
        readout.Jw_singular_values, np.linalg.svd(jacobian.Jw_eq, compute_uv=False), atol=1e-14
    )
    assert np.count_nonzero(readout.Jv_singular_values) == jacobian.tool_ranks.linear
    assert np.count_nonzero(readout.Jw_singular_values) == jacobian.tool_ranks.angular
    singularity = configuration.singularity()
    if readout.loops:
        assert (readout.smallest, readout.condition) == (
            singularity.smallest,
            singularity.condition,
        )
    else:
        assert readout.smallest is None
    ellipsoid = jacobian.velocity_ellipsoid()
    for section in readout.sections:
        ellipse = ellipsoid.section(section.plane)
        np.testing.assert_array_equal(section.radii, ellipse.radii)
        np.testing.assert_array_equal(np.transpose(section.axes), ellipse.axes)


def test_near_a_singularity_the_joints_that_come_free_are_named():
    session = session_of()
    session.obey(MoveMotors(values=[1.0, 1.9729, 1.0]))
    readout = session.readout()
    assert readout.smallest < 0.01
    assert readout.warning.level == "near"
    assert "theta1" in readout.warning.text
    assert "theta2" not in readout.warning.text
    assert readout.J_eq is not None


def test_at_a_singularity_there_is_no_jacobian_and_the_readout_says_why():
    session = session_of()
    session.obey(MoveMotors(values=[1.0, 3.0, 1.0]))
    readout = session.readout()
    assert readout.J_eq is None
    assert readout.sections is None
    assert readout.warning.level == "singular"
    assert "gain" in readout.warning.text
    assert "no J_eq exists" in readout.refusal
    state = json.loads(encoded(page_state(session)))
    assert state["readout"]["J_eq"] is None


def test_a_loss_singularity_is_said_and_seen_coming():
    mechanism = loaded("ur5")
    near, there = (mechanism.close([0.3, -1.2, elbow, -0.9, -1.2, 0.2]) for elbow in (0.01, 0.0))
    assert make_readout(near).warning.level == "near"
    warning = make_readout(there).warning
    assert (warning.level, "loss" in warning.text) == ("singular", True)


@pytest.mark.parametrize(("elbow", "words"), [(0.0, "has rank 1"), (0.01, "is near rank 1")])
def test_a_stretched_arm_has_lost_a_direction_of_velocity(elbow, words):
    """It still turns, so that its twist, judged as a whole, has lost nothing."""
    configuration = pj.load("serial_2r", tool_rows=TWIST_ROWS).close([0.5, elbow])
    assert configuration.singularity().kind == "regular"
    warning = make_readout(configuration).warning
    assert warning.level == "loss"
    assert f"[J_v]eq {words} instead of 2" in warning.text
    assert "[J_ω]" not in warning.text


@pytest.mark.parametrize(("elbow", "level"), [(0.0, "singular"), (0.01, "near"), (1.0, "regular")])
def test_an_arm_that_is_there_to_move_its_tip_loses_a_motion(elbow, level):
    readout = make_readout(loaded("serial_2r").close([0.5, elbow]))
    assert readout.warning.level == level
    assert (readout.tool_rank, readout.generic_tool_rank) == (2 if elbow else 1, 2)
    assert readout.judged == ("vx, vy", "judged on vx, vy in the tool's own axes")
    assert ("judged on vx, vy" in readout.warning.text) == (level != "regular")


def test_a_half_of_the_twist_that_is_not_judged_loses_nothing():
    """The twist of a plate that turns about its own middle: the middle rests, as it may."""
    model = pin.buildModelFromXML(
        mechanisms.tree(
            ("x", "prismatic", "ground", "slide", (0, 0, 0), (1, 0, 0)),
            ("turn", "revolute", "slide", "arm", (0, 0, 0), (0, 0, 1)),
            ("tip", "fixed", "arm", "tool", (0, 1, 0)),
        )
    )
    for rows, level in ((TWIST_ROWS, "loss"), (TWIST_ROWS[3:], "regular")):
        mechanism = pj.Mechanism.from_pinocchio(
            model, [], ["x", "turn"], "tool", home=[0, 1.0], tool_rows=rows
        )
        assert make_readout(mechanism.home).warning.level == "regular"
        # Both move the tool along x.
        assert make_readout(mechanism.close([0.0, 0.0])).warning.level == level


@pytest.mark.parametrize("size", [1e-3, 1.0, 1e3])
def test_a_warning_does_not_depend_on_the_size(size):
    axis = (0, 0, 1)
    arm = [
        ("a", "revolute", "ground", "upper", (0, 0, 0), axis),
        ("b", "revolute", "upper", "lower", (size, 0, 0), axis),
        ("end", "fixed", "lower", "tip", (size, 0, 0)),
    ]
    mechanism = mechanisms.build(arm, [], ["a", "b"], "tip", {"a": 0.5, "b": 1.0})
    levels = [make_readout(mechanism.close([0.5, elbow])).warning.level for elbow in (1.0, 0.0)]
    assert levels == ["regular", "loss"]


@pytest.mark.parametrize(("smallest", "level"), [(0.0101, "regular"), (0.0099, "near")])
def test_near_means_within_a_hundredth(smallest, level):
    mechanism = loaded("three_rps")

    def excess(l2):
        return mechanism.close([1.0, l2, 1.0]).singularity().smallest - smallest

    l2 = scipy.optimize.brentq(excess, 1.8, 1.9729, xtol=1e-12)
    session = Session(mechanism.close([1.0, l2, 1.0]), SceneOptions())
    assert session.readout().warning.level == level
    shown = {item.name.split("/")[0] for item in session.scene().items if item.visible}
    assert ("free" in shown) == (level == "near")


def test_a_stop_is_said_in_the_same_words_wherever_beyond_the_target_is():
    session = session_of()
    notices = set()
    for beyond in (1.98, 2.2, 2.9, 2.5):
        session.obey(MoveMotors(values=[None, beyond, None]))
        notices.add(session.notice)
    (notice,) = notices
    assert notice.stops == (0, 1, 0)


def test_home_looks_as_it_did_at_first():
    session = session_of("serial_2r")
    first = [item.transform for item in session.scene().items]
    for value in np.linspace(1.0, -1.0, 30):
        session.obey(MoveMotors(values=[None, value]))
        session.scene()
    session.obey(Home())
    np.testing.assert_array_equal([item.transform for item in session.scene().items], first)


def test_a_warning_has_no_changing_numbers():
    """A screen reader would read every one of them aloud."""
    session = session_of()
    texts = set()
    for l2 in (1.9725, 1.9727, 1.9729):
        session.obey(MoveMotors(values=[1.0, l2, 1.0]))
        texts.add(session.readout().warning.text)
    assert len(texts) == 1


def test_motors_without_limits_get_sensible_sliders():
    model = pin.Model()
    joint = model.addJoint(0, pin.JointModelRUBZ(), pin.SE3.Identity(), "turn")
    slide = model.addJoint(joint, pin.JointModelPX(), pin.SE3(np.eye(3), np.ones(3)), "slide")
    model.addFrame(pin.Frame("tip", slide, pin.SE3(np.eye(3), np.ones(3)), pin.FrameType.OP_FRAME))
    mechanism = pj.Mechanism.from_pinocchio(model, [], ["turn", "slide"], "tip")
    session = Session(mechanism.home, SceneOptions())
    turn, slider = page_state(session, about=True).about.motors
    assert not turn.limited
    assert not slider.limited
    assert (turn.lower, turn.upper) == pytest.approx((-math.pi, math.pi))
    assert -100 < slider.lower < 0 < slider.upper < 100
    session.obey(MoveMotors(values=[9.0, 50.0]))
    with pytest.raises(pj.ArgumentError, match="beyond"):
        session.obey(MoveMotors(values=[0.0, 1e5]))


def test_the_first_view_holds_everything():
    session = session_of(angular=True)
    framing = session.framing()
    items = [item for item in session.scene().items if item.visible]
    eye, extremes = np.array(framing.eye), np.array(framing.extremes)
    right = np.cross((0.0, 0.0, 1.0), eye)
    right /= np.linalg.norm(right)
    view = np.array([right, np.cross(eye, right), eye])
    centres = np.array([item.transform[:3, 3] for item in items]) - framing.centre
    x, y, z = view @ centres.T
    for across, up in [(0.36, 0.36), (0.6, 0.36), (0.17, 0.36)]:  # windows of several shapes
        distance = max(c + max(a / across, b / up) for a, b, c in extremes)
        assert (np.abs(x) <= across * (distance - z) + 1e-9).all()
        assert (np.abs(y) <= up * (distance - z) + 1e-9).all()
    assert np.linalg.norm(framing.eye) == pytest.approx(1.0)


@pytest.mark.parametrize("name", ["four_bar", "five_bar", "planar_3rpr", "planar_3rrr"])
def test_a_flat_mechanism_is_looked_at_from_above(name):
    assert session_of(name).framing().eye[2] > 0.8


@pytest.mark.parametrize(
    "message",
    [
        "",
        "{}",
        "[]",
        "null",
        "1",
        '"home"',
        "{",
        '{"command": "fly"}',
        '{"command": "home", "extra": 1}',
        '{"command": "move"}',
        '{"command": "move", "values": "1"}',
        '{"command": "move", "values": ["1", "1", "1"]}',
        '{"command": "move", "values": [NaN, 1, 1]}',
        '{"command": "move", "values": [1, 1, true]}',
        '{"command": "move", "values": [1, 1, "null"]}',
        '{"command": "options", "linear": 1, "angular": false, "force": false, '
        '"names": true, "scale": 1}',
        '{"command": "options", "linear": true, "angular": false, "force": false, '
        '"names": true, "scale": 0}',
        '{"command": "options", "linear": true, "angular": false, "force": false, '
        '"names": true, "scale": 1e9}',
        '{"command": "home", "id": -1}',
        '{"command": "home", "id": 1.5}',
        '{"command": "home", "id": ' + "9" * 40 + "}",
        "[" * 60_000,
        '{"command": "pose", "name": "' + "x" * MAXIMAL_MESSAGE + '"}',
        "\ud800",
        b'{"command": "home"}',
    ],
)
def test_what_is_no_message_is_refused(message):
    with pytest.raises(pj.ArgumentError):
        decode(message)


def test_messages():
    assert decode('{"command": "move", "values": [1, 2.5], "id": 7}') == MoveMotors(
        id=7, values=[1, 2.5]
    )
    assert json.loads(encoded(Refusal(None, "no"))) == {
        "type": "error",
        "id": None,
        "message": "no",
    }


def pushed(**changes):
    """A command of the load panel."""
    usual = {"kind": "weight", "mass": 0.0, "size": 0.0, "azimuth": 0.0, "elevation": 0.0}
    return SetLoad(**(usual | changes))


@pytest.mark.parametrize("name", mechanisms.CATALOGUE)
def test_efforts_of_a_hung_weight_do_its_work(name):
    """Virtual work without the library's statics: τᵀ θ̇ = m g ż, and what the bodies' own asks."""
    session = session_of(name)
    session.obey(pushed(mass=3.0))
    load, home = page_state(session).load, session.configuration
    own = home.statics().efforts
    jacobian = home.jacobian().Jv_eq
    efforts = np.array([one.value for one in load.efforts]) - own
    size = 3.0 * 9.81 * np.abs(jacobian).max()
    np.testing.assert_allclose(efforts, 3.0 * 9.81 * jacobian[2], atol=1e-9 * size)
    assert load.force == pytest.approx((0.0, 0.0, -3.0 * 9.81))
    assert (load.refusal, load.reason) == ("", "")


def test_a_force_has_size_and_direction():
    session = session_of("five_bar")
    session.obey(pushed(kind="force", size=8.0, azimuth=0.7, elevation=-0.4))
    load = page_state(session).load
    expected = [math.cos(-0.4) * math.cos(0.7), math.cos(-0.4) * math.sin(0.7), math.sin(-0.4)]
    np.testing.assert_allclose(load.force, 8.0 * np.array(expected), atol=1e-14)
    jacobian = session.configuration.jacobian().Jv_eq
    efforts = [one.value for one in load.efforts]
    np.testing.assert_allclose(efforts, -jacobian.T @ load.force, atol=1e-12)


def test_efforts_beyond_their_limits_are_told_and_only_those():
    session = session_of()
    # Three legs that lean by 30° share the weight alike, up to 100 N each.
    limit = 3 * 100.0 * math.cos(math.pi / 6) / 9.81
    for share, beyond in ((0.999, False), (1.001, True)):
        session.obey(pushed(mass=share * limit))
        assert page_state(session).load.beyond == (beyond,) * 3


def test_a_load_stays_while_the_motors_move_and_with_other_lengths():
    session = session_of()
    session.obey(pushed(mass=2.0))
    session.obey(MoveMotors(values=[1.1, 1.0, 0.9]))
    load = page_state(session).load
    assert load.mass == 2.0
    jacobian = session.configuration.jacobian().Jv_eq
    efforts = [one.value for one in load.efforts]
    np.testing.assert_allclose(efforts, 2.0 * 9.81 * jacobian[2], atol=1e-10)


def test_at_a_singular_pose_the_load_is_refused_in_words_and_the_rest_stays():
    session = session_of(velocity_polytope=True, force_polytope=True)
    session.obey(pushed(mass=2.0))
    session.obey(MoveMotors(values=[1.0, 3.0, 1.0]))
    state = page_state(session)
    assert "singular" in state.load.refusal
    assert "no J_eq exists" in state.load.reason
    assert all(math.isnan(one.value) and one.limit == 100.0 for one in state.load.efforts)
    message = json.loads(encoded(state))
    assert [one["value"] for one in message["load"]["efforts"]] == [None] * 3
    assert set(state.drawn.no_polytopes) == {"velocity", "force"}
    assert not [i for i in session.scene().items if i.visible and "polytope" in i.name]
    for back in ([1.0, 1.9, 1.0], [1.1, 1.0, 0.9]):
        session.obey(MoveMotors(values=back))
    state = page_state(session)
    assert (state.load.refusal, state.drawn.no_polytopes) == ("", {})
    assert len([i for i in session.scene().items if i.visible and "polytope" in i.name]) == 6


def test_motors_that_are_tied_have_the_smallest_efforts_and_say_so():
    tied = pj.load("four_bar", actuated=["theta1", "phi1"])
    session = Session(tied.home, SceneOptions(velocity_polytope=True))
    session.obey(pushed(kind="force", size=10.0, azimuth=-math.pi / 2))
    state = page_state(session)
    assert "work against each other" in state.load.note
    efforts = np.array([one.value for one in state.load.efforts])
    allowed = tied.home.allowed_jacobian()
    work = allowed.motor_rates[:, 0] @ efforts + np.dot(allowed.Jv_eq[:, 0], state.load.force)
    assert work == pytest.approx(0.0, abs=1e-12)
    assert "no equivalent Jacobian" in state.drawn.no_polytopes["velocity"]


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"mass": -1.0}, "mass is 0 to 1e\\+06 kg, got -1"),
        ({"mass": 1e9}, "mass is 0 to"),
        ({"size": math.nan}, "size is 0 to 1e\\+06 N, got nan"),
        ({"azimuth": 7.0}, "azimuth is at most a turn, got 7"),
    ],
)
def test_loads_that_are_none_are_refused_and_nothing_changes(changes, said):
    session = session_of()
    session.obey(pushed(mass=2.0))
    with pytest.raises(pj.ArgumentError, match=said):
        session.obey(pushed(**changes))
    assert session.load.mass == 2.0


@pytest.mark.parametrize("name", mechanisms.CATALOGUE)
def test_sliders_of_a_load_go_beyond_what_the_motors_hold_at_home(name):
    session = session_of(name)
    mass, size, azimuth, elevation = page_state(session, about=True).about.load
    assert (mass.unit, size.unit, azimuth.unit, elevation.unit) == ("kg", "N", "rad", "rad")
    assert 0.0 < mass.upper <= 2e6
    assert 0.0 < size.upper <= 2e6
    session.obey(pushed(mass=mass.upper))
    moved = np.abs(session.configuration.jacobian().Jv_eq[2]).max() > 1e-6
    if moved:
        assert any(page_state(session).load.beyond)
