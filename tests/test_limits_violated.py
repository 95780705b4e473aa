"""Joints beyond their limits: seen, told and, on wish, refused."""

from __future__ import annotations

import json
import pickle
import re

import msgspec
import numpy as np
import pinocchio as pin
import pytest
from mechanisms import loaded

import pmjac_pin as pj
from pmjac_pin.closing.assembly import build_parts
from pmjac_pin.model.limits import Violation
from pmjac_pin.viewer.readout import make_readout
from pmjac_pin.words.modes_report import make_modes_report
from pmjac_pin.words.modes_tables import modes_blocks
from pmjac_pin.words.plain import to_json
from pmjac_pin.words.tables import report_blocks
from pmjac_pin.words.terminal import draw, new_console

NAMES = [name for name in pj.list_mechanisms() if loaded(name).passive]


def limited(name, joint, lower, upper, home=None):
    """Return a machine of the catalogue with other limits of one joint."""
    machine = loaded(name)
    model, spec = machine.model, machine.spec
    entry = model.joints[model.getJointId(joint)].idx_q
    model.lowerPositionLimit[entry], model.upperPositionLimit[entry] = lower, upper
    poses = {"home": machine.home.joint_values if home is None else home}
    spec = msgspec.structs.replace(spec, poses={"home": dict(poses["home"])})
    return pj.Mechanism(build_parts(model, spec, dict(machine.parameters)))


@pytest.fixture(scope="module")
def bar():
    return limited("four_bar", "phi1", 2.0, 2.05)


def test_a_configuration_knows(bar):
    assert not bar.home.limits_violated
    beyond = bar.close([1.5])
    value = beyond.joint_values["phi1"]
    assert dict(beyond.limits_violated) == {"phi1": Violation(value, 2.0, 2.05, "rad")}
    assert "'phi1' beyond its limits" in repr(beyond)


@pytest.mark.parametrize("name", NAMES)
def test_close_refuses_on_wish(name):
    """Of whatever machine: the first passive joint that moves is held to where home has it."""
    plain = loaded(name)
    motors = plain.home.actuated + 0.02
    try:
        closed = plain.close(motors)
    except pj.PmjacError:
        closed = plain.close(motors - 0.04)
    values, home = closed.joint_values, plain.home.joint_values
    one = [n for n in values if n not in plain.actuated and isinstance(values[n], float)]
    moved = [n for n in one if abs(values[n] - home[n]) > 1e-4]
    if not moved:
        pytest.skip("no passive joint of one degree of freedom moves")
    joint, value = moved[0], values[moved[0]]
    near = 0.5 * abs(value - home[moved[0]])
    machine = limited(name, joint, home[joint] - near, home[joint] + near)
    assert joint in machine.close(closed.actuated).limits_violated
    with pytest.raises(pj.LimitError, match=f"'{joint}' = ") as caught:
        machine.close(closed.actuated, enforce_limits="all")
    assert (caught.value.joint, round(caught.value.value, 9)) == (joint, round(value, 9))
    assert not plain.close(closed.actuated, enforce_limits="all").limits_violated


def test_booleans_keep_their_meaning(bar):
    for none in (False, np.False_):
        assert "theta1" in bar.close([6.5], enforce_limits=none).limits_violated
    for motors in (True, np.True_):
        assert bar.close([1.5], enforce_limits=motors).limits_violated
        with pytest.raises(pj.LimitError, match=r"motor 'theta1' = 6\.5 rad is outside its limits"):
            bar.close([6.5], enforce_limits=motors)


@pytest.mark.parametrize("given", [1, 0, None, "motors", "ALL", "", [True], 1.0])
def test_nothing_else_is_accepted(bar, given):
    with pytest.raises(pj.ArgumentError, match="enforce_limits must be"):
        bar.close([1.0], enforce_limits=given)


def test_words_do_not_contradict_themselves():
    assert Violation(0.50000001, -0.5, 0.5, "m").words.startswith("0.50000001 m is outside")
    told = Violation(1.017, -0.5, 0.5, "rad").words
    assert told == "1.017 rad is outside its limits [-0.5, 0.5] rad"


@pytest.mark.parametrize(
    ("value", "hint"), [(90.0, " (90° would be 1.5708 rad)"), (3.5, ""), (1e4, "")]
)
def test_what_may_be_degrees_is_said(value, hint):
    told = Violation(value, -2.0, 2.0, "rad").words
    assert told == f"{value:.6g} rad is outside its limits [-2, 2] rad{hint}"
    assert "°" not in Violation(value, -2.0, 2.0, "m").words


def shown(blocks, capsys):
    draw(new_console(), blocks)
    return " ".join(capsys.readouterr().out.split())


def test_reports_warn(bar, capsys):
    report = pj.report(bar.close([1.5]))
    text = shown(report_blocks(report), capsys)
    assert "Warning: phi1 = " in text
    assert "the machine cannot be here" in text
    [found] = json.loads(to_json(report.told()))["limits_violated"]
    assert (found["name"], found["lower"], found["upper"]) == ("phi1", 2.0, 2.05)
    assert "Warning" not in shown(report_blocks(pj.report(bar.home)), capsys)


def test_modes_beyond_limits_are_marked(bar, capsys):
    modes = pj.assembly_modes(bar, [0.9], rng=0, limits=False)
    text = shown(modes_blocks(make_modes_report(bar, [0.9], modes, limits=False)), capsys)
    assert text.count("phi1 beyond its limits") == len(modes) - 1


def test_the_page_warns(bar):
    assert make_readout(bar.home).beyond == ""
    beyond = make_readout(bar.close([1.5])).beyond
    assert beyond.startswith("Beyond its limits: phi1.")
    assert msgspec.json.decode(msgspec.json.encode(make_readout(bar.close([1.5]))))["beyond"]


def test_check_warns_of_a_pose_given_beyond():
    """Closed already, it is taken as it is."""
    found = pj.check(limited("four_bar", "phi1", 0.5, 0.6))
    [one] = [finding for finding in found.findings if finding.code == "beyond-limits"]
    assert one.severity == "warning"
    assert "The pose 'home' closes where 'phi1' = 2.02" in one.message


def test_nothing_is_said_to_be_the_only_way():
    """But what was seen, beyond the limits and within them."""
    with pytest.raises(pj.ClosureError) as caught:
        limited("four_bar", "phi1", 0.5, 0.6, {"theta1": 0.9, "phi1": 0.55, "phi2": 0.0})
    message = str(caught.value)
    assert "only" not in message
    assert "closes where 'phi1' = " in message
    seen = r"they close elsewhere, at phi1 = |from 64 random starts no pose within all limits was"
    assert re.search(seen, message)


def test_catalogue_machines_keep_their_limits():
    rng = np.random.default_rng(0)
    for name in NAMES:
        machine = loaded(name)
        for _ in range(3):
            try:
                theta = machine.home.actuated + rng.uniform(-0.3, 0.3, len(machine.actuated))
                assert not machine.close(theta).limits_violated, name
            except pj.PmjacError:
                continue


@pytest.mark.parametrize("lower", [2.0, -np.inf])
def test_many_poses_know(lower):
    """As the configuration of each does; one-sided limits, too."""
    mechanism = limited("four_bar", "phi1", max(lower, -1e20), 2.05)
    many, values = pj.batch(mechanism), mechanism.home.actuated + np.linspace(-0.5, 0.5, 9)[:, None]
    poses, over = many.close(values), many.grid({"theta1": values[:, 0]})
    alone = [bool(mechanism.close(one).limits_violated) for one in values]
    assert True in alone
    assert False in alone
    for found in (poses, over, pickle.loads(pickle.dumps(poses))):
        assert not found.status.any()
        assert found.beyond_limits.tolist() == alone
    strict = many.close(values, enforce_limits="all")
    assert (strict.status == pj.Status.LIMITS).tolist() == alone
    with pytest.raises(pj.ArgumentError, match="limits are known to the poses"):
        _ = type(poses)(poses.q, poses.share, poses.status).beyond_limits


@pytest.mark.parametrize(
    ("kind", "slides"),
    [(pin.JointModelPlanar, 2), (pin.JointModelFreeFlyer, 3), (pin.JointModelSpherical, 0)],
)
@pytest.mark.parametrize("limited", [True, False])
def test_limits_that_nothing_looks_at_are_named(kind, slides, limited):
    """A body that floats, or slides in a plane, has none; what its model gives is no secret."""
    model, joint = pin.Model(), kind()
    none, most = np.full(joint.nv, 1e9), np.full(joint.nq, np.finfo(float).max)
    lower, upper = -most, most.copy()
    lower[slides:], upper[slides:] = -1.01, 1.01  # of the numbers of a turn, as Pinocchio has it
    if limited and slides:
        upper[0] = 0.5
    model.addJoint(0, joint, pin.SE3.Identity(), "body", none, none, lower, upper)
    arm = pin.JointModelRZ()
    model.addJoint(0, arm, pin.SE3.Identity(), "arm", *np.array([[1e9], [1e9], [-1.0], [1.0]]))
    frame = pin.Frame("tip", 2, pin.SE3.Identity(), pin.FrameType.OP_FRAME)
    model.addFrame(frame, False)
    mechanism = pj.Mechanism.from_pinocchio(model, [], ["arm"], "tip")
    only = "only joints with one degree of freedom have limits"
    told = [f"the limits of joint 'body' are left out: {only}"]
    assert list(mechanism.notes) == (told if limited and slides else [])
