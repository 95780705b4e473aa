"""What `check` says of mechanisms whose defects are known, and of some that are not even built."""

from __future__ import annotations

import pickle
import re
from pathlib import Path

import looped
import mechanisms
import numpy as np
import pinocchio as pin
import pytest
from mechanisms import Z, loaded

import pmjac_pin as pj
from pmjac_pin.studies.check.undriven import commanding, undriven

ROOT = Path(__file__).resolve().parent.parent


def finding(diagnosis, code):
    """The only finding of this code."""
    [found] = [item for item in diagnosis.findings if item.code == code]
    return found


def codes(diagnosis, *severities):
    return {item.code for item in diagnosis.findings if item.severity in severities}


def failed(*arguments, **options):
    """The diagnosis of a mechanism that cannot be built."""
    with pytest.raises(pj.PmjacError) as caught:
        mechanisms.build(*arguments, **options)
    return pj.check(caught.value)


SOUND = [*pj.list_mechanisms(), "rssr", "three_crank_parallelogram", "yawing_four_bar"]


@pytest.fixture(scope="module", params=SOUND)
def sound(request):
    name = request.param
    return loaded(name) if name in pj.list_mechanisms() else getattr(mechanisms, name)()


def moving(rates):
    return {name for name, rate in rates.items() if rate}


# --- laws --------------------------------------------------------------------------------------


def test_counts_agree(sound):
    diagnosis = pj.check(sound)
    count, actuation = diagnosis.mobility, diagnosis.actuation
    redundancy = diagnosis.redundancy
    assert count.freedoms == sound.nv == len(diagnosis.freedoms)
    assert count.rows == len(sound.rows) == sum(len(loop.equations) for loop in diagnosis.loops)
    assert count.mobility == sound.mobility == count.freedoms - count.rank
    assert redundancy.rows == count.rows - count.rank == redundancy.inside + redundancy.between
    assert len(redundancy.dependent) == redundancy.rows
    assert count.mobility == len(actuation.allowed_rates) + len(actuation.free_motions)
    assert actuation.motors == len(actuation.allowed_rates) + len(actuation.forbidden_rates)
    assert diagnosis.severity in ("ok", "note", "warning")


def test_what_a_loop_is_needed_for_is_the_mobility_that_comes_without_it(sound):
    tool = sound.spec.tool.frame or sound.spec.tool.points
    loops = [resolved(loop, sound.parameters) for loop in sound.spec.loops]
    for k, entry in enumerate(pj.check(sound).loops):
        without = pj.Mechanism.from_pinocchio(
            sound.model, loops[:k] + loops[k + 1 :], sound.actuated, tool, home=sound.home.q
        )
        assert without.mobility == sound.mobility + entry.needed


def resolved(loop, parameters):
    if not isinstance(loop, pj.DistanceLoop):
        return loop
    return pj.DistanceLoop(frames=loop.frames, length=loop.resolved_length(parameters))


def test_dependent_rows_follow_from_what_they_are_said_to(sound):
    jacobian = sound.home.jacobian().constraint_jacobian
    dependent = pj.check(sound).redundancy.dependent
    for entry in dependent:
        row = jacobian[sound.rows.index(entry.row)]
        others = jacobian[[sound.rows.index(name) for name in entry.follows_from]]
        if not others.size:
            np.testing.assert_allclose(row, 0.0, atol=1e-9)
            continue
        shares = np.linalg.lstsq(others.T, row, rcond=None)[0]
        np.testing.assert_allclose(shares @ others, row, atol=1e-8)
        assert not {other.row for other in dependent} & set(entry.follows_from)


@pytest.mark.parametrize("joint", [None, "theta1", "phi1", "phi2"])
def test_the_count_in_groups_does_not_depend_on_the_cut(joint):
    bar = loaded("four_bar")
    loop = pj.RevoluteLoop(frames=bar.spec.loops[0].frames)
    arguments = (bar.model, [loop], ["theta1"], "coupler_midpoint")
    mechanism = pj.Mechanism.from_pinocchio(*arguments, home=bar.home.q)
    diagnosis = pj.check(pj.recut(mechanism, joint) if joint else mechanism)
    assert diagnosis.mobility.gruebler == -2
    assert diagnosis.mobility.gruebler_in_groups == diagnosis.mobility.mobility == 1
    assert [loop.group for loop in diagnosis.loops] == ["planar"]


# --- loops and counts ----------------------------------------------------------------------------


def test_a_planar_loop_closed_in_space():
    diagnosis = pj.check("four_bar")
    [loop] = diagnosis.loops
    assert (loop.kind, loop.group, loop.group_rows, loop.rank, loop.needed) == (
        "point", "planar", 2, 2, 2,
    )  # fmt: skip
    assert (diagnosis.mobility.gruebler, diagnosis.mobility.gruebler_in_groups) == (0, 1)
    assert diagnosis.redundancy.dependent[0].row == "coupler_tip-rocker_tip z"
    assert diagnosis.redundancy.dependent[0].follows_from == ()
    assert "inside loops: 1 of 'coupler_tip-rocker_tip'" in str(
        finding(diagnosis, "redundant-rows")
    )
    assert "planar loops have, they agree" in finding(diagnosis, "mobility").message


def test_nothing_is_wrong_with_the_3_rps():
    diagnosis = pj.check(loaded("three_rps"))
    assert diagnosis.severity == "note"
    assert codes(diagnosis, "ok") == {
        "assembles", "actuation", "conditioning", "independent-rows", "mobility",
    }  # fmt: skip
    assert diagnosis.mobility.gruebler == 3
    [plate] = [body for body in diagnosis.bodies if body.tool]
    assert (plate.name, plate.joint, len(plate.loops)) == ("plate", "platform", 3)


@pytest.mark.parametrize(
    ("name", "group", "gruebler", "in_groups", "mobility"),
    [
        ("slider_crank", "planar", -2, 1, 1),
        ("planar_3rrr", "planar", 0, 3, 3),
        ("agile_eye", "spherical", -3, 3, 3),
        ("bennett", "spatial", -2, -2, 1),
        ("bricard", "spatial", 0, 0, 1),
        ("sarrus", "spatial", 0, 0, 1),
        ("stewart_gough", "spatial", 6, 6, 6),
    ],
)
def test_the_counts_of_the_textbooks(name, group, gruebler, in_groups, mobility):
    """Planar and spherical formulas are right; the paradoxical linkages defy them all."""
    diagnosis = pj.check(name)
    count = diagnosis.mobility
    assert {loop.group for loop in diagnosis.loops} == {group}
    found = (count.gruebler, count.gruebler_in_groups, count.mobility)
    assert found == (gruebler, in_groups, mobility)
    special = "special dimensions" in finding(diagnosis, "mobility").message
    assert special == (in_groups != mobility)


def test_special_dimensions_are_not_mistaken_for_a_planar_loop():
    diagnosis = pj.check(mechanisms.three_crank_parallelogram())
    count = diagnosis.mobility
    assert (count.gruebler, count.gruebler_in_groups, count.mobility) == (-2, 0, 1)
    assert (diagnosis.redundancy.inside, diagnosis.redundancy.between) == (2, 1)
    assert [(loop.rank, loop.needed) for loop in diagnosis.loops] == [(2, 1), (2, 1)]
    assert "special dimensions" in finding(diagnosis, "mobility").message


def test_two_loops_between_the_same_bodies_are_no_special_dimensions():
    diagnosis = pj.check(mechanisms.four_bar_cut_at("A", 0.9, (2.0236, 0.0075)))
    assert "'K1-H1' and 'crank-H2' join the same two bodies" in str(finding(diagnosis, "mobility"))


def test_a_loop_that_closes_nothing():
    joints = [
        ("a", "revolute", "ground", "arm", (0, 0, 0), Z),
        ("center", "fixed", "arm", "hub", (0, 0, 0)),
        ("base", "fixed", "ground", "pin", (0, 0, 0)),
    ]
    diagnosis = pj.check(mechanisms.build(joints, [("hub", "pin")], ["a"], "arm", {}))
    assert finding(diagnosis, "loop-without-effect").severity == "warning"
    assert diagnosis.redundancy.inside == 3


# --- actuation -----------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("tool", "felt", "code", "severity"),
    [
        ("rocker_tip", False, "idle-motion", "note"),
        ("rod_side", True, "under-actuated", "error"),
    ],
)
def test_an_idle_rod(tool, felt, code, severity):
    mechanism = mechanisms.rssr(tool)
    diagnosis = pj.check(mechanism)
    actuation = diagnosis.actuation
    [motion] = actuation.free_motions
    assert (actuation.idle, actuation.gained, actuation.felt) == (1, 0, int(felt))
    assert (motion.felt, motion.bodies) == (felt, ("rod1", "rod2", "rod"))
    assert moving(motion.rates) == {"rx", "ry", "rz"}
    assert finding(diagnosis, code).severity == severity
    told = re.search(r"(\S+) m and (\S+) rad for each rad of", finding(diagnosis, code).message)
    assert bool(told) == felt
    if felt:
        with pytest.raises(pj.IdleMotionError):
            mechanism.home.jacobian()


@pytest.mark.parametrize("offset", [0.1, 5.6e-4, 1e-8])
def test_an_idle_motion_has_a_size_in_m_and_rad(offset):
    """A point beside the axis of a rod that spins: its distance from it for each rad of spin."""
    joints = [
        ("theta", "revolute", "ground", "crank", (0, 0, 0), Z),
        ("spin", "revolute", "crank", "rod", (1.0, 0, 0), (1, 0, 0)),
        ("end", "fixed", "rod", "rod_tip", (2.0, 0, 0)),
        ("side", "fixed", "rod", "rod_side", (1.0, offset, 0)),
        ("psi", "revolute", "ground", "rocker", (3.0, 0, 0), Z),
    ]
    loops = [pj.PointLoop(frames=("rod_tip", "rocker"))]
    model = pin.buildModelFromXML(mechanisms.tree(*joints))
    machine = pj.Mechanism.from_pinocchio(model, loops, ["psi"], "rod_side", home={})
    [motion] = [m for m in pj.check(machine).actuation.free_motions if "spin" in moving(m.rates)]
    assert motion.rates["spin"] == pytest.approx(1.0)
    assert motion.tool_linear == pytest.approx(offset)
    assert motion.tool_angular == pytest.approx(1.0)
    code = "under-actuated" if motion.felt else "idle-motion"
    told = f"{offset:.3g} m and 1 rad for each rad of 'spin'"
    message = finding(pj.check(machine), code).message
    assert told in message
    assert "'spin' turns or slides freely" in message


def test_idle_motions_of_several_rods_come_apart():
    """Two S-S rods between the same crank and rocker, each spinning about itself."""
    joints = [
        ("theta", "revolute", "ground", "crank", (0, 0, 0), Z),
        ("psi", "revolute", "ground", "rocker", (2.0, 0, 0), Z),
    ]
    loops, home = [], {"theta": 0.5, "psi": 0.5}
    for k, height in enumerate((0.0, 0.3)):
        joints += [
            (f"c{k}", "fixed", "crank", f"crank_tip{k}", (0, 1.0, height)),
            (f"r{k}", "fixed", "rocker", f"rocker_tip{k}", (0, 1.0, height)),
            (f"x{k}", "revolute", f"crank_tip{k}", f"rod_x{k}", (0, 0, 0), (1, 0, 0)),
            (f"y{k}", "revolute", f"rod_x{k}", f"rod_y{k}", (0, 0, 0), (0, 1, 0)),
            (f"z{k}", "revolute", f"rod_y{k}", f"rod{k}", (0, 0, 0), Z),
            (f"e{k}", "fixed", f"rod{k}", f"rod_tip{k}", (2.0, 0, 0)),
        ]
        loops.append((f"rod_tip{k}", f"rocker_tip{k}"))
        home[f"z{k}"] = -0.5
    diagnosis = pj.check(mechanisms.build(joints, loops, ["theta"], "rocker", home))
    assert [motion.bodies for motion in diagnosis.actuation.free_motions] == [
        ("rod_x0", "rod_y0", "rod0"),
        ("rod_x1", "rod_y1", "rod1"),
    ]
    assert diagnosis.actuation.idle == 2


def test_over_actuation_is_put_into_words():
    mechanism = mechanisms.over_actuated_four_bar()
    home = loaded("four_bar").close([2.0]).q
    away = mechanisms.with_motors(mechanism, ["theta1", "phi1"], home=home)
    diagnosis = pj.check(away)
    [forbidden], [allowed] = (
        diagnosis.actuation.forbidden_rates,
        diagnosis.actuation.allowed_rates,
    )
    assert sum(forbidden[name] * allowed[name] for name in forbidden) == pytest.approx(0, abs=1e-12)
    ratio = loaded("four_bar").close([2.0]).jacobian().passive_rates[0, 0]
    assert allowed["phi1"] / allowed["theta1"] == pytest.approx(ratio, rel=1e-9)
    found = finding(diagnosis, "over-actuated")
    assert found.severity == "error"
    assert "forbid 'theta1' against 'phi1'" in found.message or (
        "forbid 'phi1' against 'theta1'" in found.message
    )
    with pytest.raises(pj.ForbiddenRatesError):
        away.home.jacobian()


def test_a_structure_cannot_move():
    joints = [
        ("a", "revolute", "ground", "arm", (0, 0, 0), Z),
        ("tip", "fixed", "arm", "end", (1, 0, 0)),
        ("anchor", "fixed", "ground", "pin", (1, 0, 0)),
    ]
    diagnosis = pj.check(mechanisms.build(joints, [("end", "pin")], ["a"], "end", {}))
    assert diagnosis.mobility.mobility == 0
    assert "No motor can move: it is a structure" in finding(diagnosis, "over-actuated").message


def test_a_five_bar_with_one_motor_is_under_actuated():
    five_bar = loaded("five_bar")
    mechanism = mechanisms.with_motors(five_bar, five_bar.actuated[:1])
    diagnosis = pj.check(mechanism)
    assert (diagnosis.mobility.mobility, diagnosis.actuation.idle) == (2, 1)
    found = finding(diagnosis, "under-actuated")
    assert found.severity == "error"
    # The motor that it suggests is one: with it, J_eq exists.
    [suggested] = re.findall(r"motor \('(\w+)', for", found.advice)
    motors = [*five_bar.actuated[:1], suggested]
    repaired = pj.Mechanism.from_pinocchio(
        five_bar.model, five_bar.spec.loops, motors, "tip", home=five_bar.home.q
    )
    assert not codes(pj.check(repaired), "error")
    repaired.home.jacobian()


@pytest.mark.parametrize(("tool", "severity"), [("arm", "warning"), ("flap", "error")])
def test_a_passive_joint_in_no_loop(tool, severity):
    joints = [
        ("a", "revolute", "ground", "arm", (0, 0, 0), Z),
        ("b", "revolute", "arm", "flap", (1, 0, 0), (0, 1, 0)),
    ]
    found = finding(pj.check(mechanisms.build(joints, [], ["a"], tool, {})), "free-joint")
    assert found.severity == severity
    assert "'b' is passive and in no loop" in found.message


LOOSE_BASE = """<robot name="base">
<link name="world"/><link name="trunk"/><link name="leg"/>
<joint name="root" type="{kind}"><parent link="world"/><child link="trunk"/>
  <axis xyz="0 0 1"/></joint>
<joint name="hip" type="continuous"><parent link="trunk"/><child link="leg"/></joint></robot>"""


@pytest.mark.parametrize(("kind", "freedoms"), [("floating", 6), ("planar", 3)])
def test_a_loose_base_is_one_finding_with_advice_that_is_taken(tmp_path, kind, freedoms):
    """Not one for each freedom; it may be held, and its motion may be an input."""
    path = tmp_path / "base.urdf"
    path.write_text(LOOSE_BASE.format(kind=kind))
    says = {"actuated": ["hip"], "tool": "leg"}
    found = finding(pj.check(path, **says), "free-joint")
    assert found.severity == "error"
    assert f"'root' ({kind}, {freedoms} degrees of freedom)" in found.message
    assert "name it under `actuated`" in found.advice
    led = pj.load(path, actuated=["root", "hip"], tool="leg")
    assert not codes(pj.check(led), "error")
    assert led.home.jacobian().J_eq.shape == (6, freedoms + 1)
    locked = re.findall(r"`locked=\[\"(\w+)\"\]`", found.advice)
    assert locked == ["root"]
    assert not codes(pj.check(path, **says, locked=locked), "error")
    pj.load(path, **says, locked=locked).home.jacobian()


# --- no motors -----------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["four_bar", "five_bar", "planar_3rrr", "watt_six_bar", "sarrus"])
def test_without_motors_what_does_not_depend_on_them_is_known(tmp_path, name):
    """Loops, mobility and their evidence are those of the machine with its motors."""
    known = loaded(name)
    model_file, _ = pj.convert(name, tmp_path / "mine.toml")
    driven = pj.check(model_file)
    joints = known.coordinates
    candidates = [name for name in joints.names if joints.degrees_of_freedom(name) == 1]
    found = undriven(driven, *commanding(known, known.home.q, candidates))
    untold = finding(found, "no-motors")
    assert untold.severity == found.severity == "error"
    assert (found.mobility, found.loops, found.evidence) == (
        driven.mobility,
        driven.loops,
        driven.evidence,
    )
    suggested = re.search("`--actuated ([^`]*)`", untold.advice)[1].split(",")
    assert len(suggested) == known.mobility
    told = pj.check(pj.load(model_file, actuated=suggested))
    assert not codes(told, "error")
    assert {one.role for one in found.freedoms} == {"unknown"}
    assert found.actuation is None
    assert not {one.code for one in found.findings} & {"actuation", "conditioning", "no-limits"}


@pytest.mark.parametrize("tool", [None, "middle"])
def test_loops_without_motors_are_a_page(tmp_path, tool):
    path = tmp_path / "loops.urdf"
    path.write_text(looped.two_parents())
    found = pj.check(path, tool=tool)
    assert found.mobility.mobility == 1
    assert ("no-tool" in codes(found, "warning")) == (tool is None)
    assert re.search(
        r"Name 1 motor .* of: theta1, phi2(, \w+)?; such as", str(found).replace("\n", " ")
    )
    assert "motor" not in {row.role for row in found.freedoms}


def test_loops_that_do_not_assemble_without_motors_are_a_page(tmp_path):
    path = tmp_path / "loops.urdf"
    text = looped.with_element(looped.loop_element()).replace('xyz="4', 'xyz="400')
    path.write_text(text)
    found = pj.check(path)
    assert codes(found, "error") >= {"no-motors", "home-open"}


# --- limits in degrees ---------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("limits", "odd"),
    [
        ((-90.0, 90.0), True),
        ((0.0, 360.0), True),
        ((-17.0, 117.0), True),
        ((-180.0, 180.0), True),
        ((-np.pi, np.pi), False),
        ((-4.0 * np.pi, 4.0 * np.pi), False),
        ((-10.0, 10.0), False),
        ((-31.4159, 31.4159), False),
        ((-100.0, 100.0), False),
        ((-1e4, 1e4), False),
        ((-1e16, 1e16), False),
    ],
)
def test_limits_that_look_like_degrees(tmp_path, limits, odd):
    lower, upper = limits
    path = tmp_path / "arm.urdf"
    limit = f'<limit lower="{lower!r}" upper="{upper!r}" effort="1" velocity="1"/>'
    links = '<link name="a"/><link name="b"/><link name="c"/>'
    turn = f'<joint name="t" type="revolute"><parent link="a"/><child link="b"/>{limit}</joint>'
    slide = f'<joint name="s" type="prismatic"><parent link="b"/><child link="c"/>{limit}</joint>'
    path.write_text(f'<robot name="arm">{links}{turn}{slide}</robot>')
    found = pj.check(path, tool="c")
    if not odd:
        assert "limits-in-degrees" not in codes(found, "note")
        return
    hint = finding(found, "limits-in-degrees")
    assert hint.severity == "note"
    assert "'s'" not in hint.message
    written = re.search(r"\[(.*), (.*)\] rad", hint.advice)
    np.testing.assert_allclose(
        [float(end) for end in written.groups()], np.deg2rad(limits), rtol=1e-3
    )


# --- poses ---------------------------------------------------------------------------------------


def test_a_home_pose_open_by_a_metre():
    """The file's rocker points elsewhere; the page says by how much and what moved."""
    model, home = loaded("four_bar").model, {"theta1": 0.9, "phi1": 1.0, "phi2": 0.0}
    mechanism = pj.Mechanism.from_pinocchio(
        model, loaded("four_bar").spec.loops, ["theta1"], "coupler_midpoint", home=home
    )
    diagnosis = pj.check(mechanism)
    [loop], [pose] = diagnosis.loops, diagnosis.poses
    q = np.array([home[name] for name in list(model.names)[1:]])
    gap = np.linalg.norm(mechanism.loop_equations(q)[0])
    assert gap > 1.0
    assert loop.gap_given == pose.gap_given == pytest.approx(gap, rel=1e-12)
    assert pose.moved == dict(mechanism.moved())
    found = finding(diagnosis, "wide-open")
    assert found.severity == "warning"
    farthest = max(pose.moved, key=lambda name: abs(pose.moved[name]))
    assert f"{farthest!r} moved by" in found.message


def test_motors_that_had_to_move():
    mechanism = mechanisms.rocker_rocker()
    home = {"theta1": 1.5, "phi1": 2.0, "phi2": 0.5}
    beyond = mechanisms.with_motors(mechanism, mechanism.actuated, home=home)
    assert "'theta1' by -" in finding(pj.check(beyond), "motors-moved").message


def test_an_impossible_closure_names_the_loop():
    diagnosis = pj.check("four_bar", parameters={"l1": 100.0})
    found = finding(diagnosis, "home-open")
    assert found.severity == diagnosis.severity == "error"
    assert diagnosis.failure.loop == "coupler_tip-rocker_tip"
    # Crank 100 against ground 4, coupler 3 and rocker 3.5: 89.5 is missing.
    assert diagnosis.failure.gap >= 89.5 - 1e-9
    assert diagnosis.loops[0].gap_alone == pytest.approx(89.5, abs=1e-3)
    assert "did not close from here or around even alone" in found.advice
    assert diagnosis.mobility.mobility is None
    assert diagnosis.mobility.gruebler_in_groups == 1
    assert [freedom.home for freedom in diagnosis.freedoms] == [None] * 3


def test_loops_that_close_alone_but_not_together():
    joints = [
        ("slide", "prismatic", "ground", "slider", (0, 0, 0), (1, 0, 0)),
        ("one", "fixed", "ground", "one_metre", (1, 0, 0)),
        ("two", "fixed", "ground", "two_metres", (2, 0, 0)),
    ]
    loops = [("slider", "one_metre"), ("slider", "two_metres")]
    diagnosis = failed(joints, loops, ["slide"], "slider", {})
    assert "Each loop closes alone, all together did not" in finding(diagnosis, "home-open").advice
    assert max(loop.gap_alone for loop in diagnosis.loops) < 1e-9
    assert diagnosis.failure.gap == pytest.approx(np.sqrt(0.5), abs=1e-9)


def test_a_singular_home_is_not_taken_for_the_general_case():
    """The folded parallelogram: redundant rows and idle motions are those of the poses near it."""
    flat = {"l0": 2.0, "l1": 1.0, "l2": 2.0, "l3": 1.0}
    model = pj.load("four_bar", flat).model
    loops = loaded("four_bar").spec.loops
    mechanism = pj.Mechanism.from_pinocchio(
        model, loops, ["theta1"], "coupler_midpoint", home=[0.0, 0.0, 0.0]
    )
    diagnosis = pj.check(mechanism)
    assert "configuration space" in finding(diagnosis, "singular-pose").message
    assert (diagnosis.redundancy.rows, diagnosis.actuation.idle) == (1, 0)
    assert diagnosis.actuation.gained == 1
    assert diagnosis.actuation.free_motions == ()
    assert diagnosis.severity == "warning"


@pytest.fixture
def model_file(tmp_path):
    """Write a four-bar whose model file is changed."""

    def write(*changes, urdf=()):
        for source, target, replaced in (
            ("models/four_bar.toml", "bar.toml", changes),
            ("urdf/four_bar.urdf", "four_bar.urdf", urdf),
        ):
            text = (ROOT / source).read_text(encoding="utf-8")
            for old, new in replaced:
                assert old in text
                text = text.replace(old, new)
            (tmp_path / target).write_text(text, encoding="utf-8")
        return tmp_path / "bar.toml"

    return write


def test_a_motor_outside_its_limits_is_a_page(model_file):
    diagnosis = pj.check(model_file(("theta1 = 0.9", "theta1 = 50.0")))
    found = finding(diagnosis, "home-outside-limits")
    assert "a motor beyond its limits: 'theta1' = 50 rad is outside its limits" in found.message
    assert diagnosis.freedoms[0].given == 50.0


SLIDER = """
urdf = "slider.urdf"
actuated = ["motor"]
tool.frame = "slider"
[[loop]]
kind = "distance"
frames = ["slider", "ground"]
length = 1.0
[poses.home]
slide = 0.9
[poses.behind]
slide = -0.4
"""


@pytest.fixture
def slider(tmp_path):
    """A slider at a metre from the origin: in front of it, for its limits exclude behind."""
    joints = [
        ("motor", "revolute", "ground", "arm", (0, 0, 0), (1, 0, 0)),
        ("slide", "prismatic", "arm", "slider", (0, 0, 0), (1, 0, 0)),
    ]
    urdf = mechanisms.tree(*joints).replace('lower="-100"', 'lower="-0.5"')
    (tmp_path / "slider.urdf").write_text(urdf, encoding="utf-8")
    (tmp_path / "slider.toml").write_text(SLIDER, encoding="utf-8")
    return tmp_path / "slider.toml"


def test_a_named_pose_is_assembled_within_the_limits(slider):
    """Nearest it would close behind the origin, outside the slide's limits."""
    behind = pj.check(slider).poses[1]
    assert (behind.failure, behind.kind) == (None, "regular")
    assert pj.load(slider).moved("behind")["slide"] == pytest.approx(1.4)


def test_a_named_pose_that_does_not_assemble(slider, monkeypatch):
    """From where the pose puts it, and from nowhere else."""
    monkeypatch.setattr("pmjac_pin.closing.held_motors.SHAKES", ())
    monkeypatch.setattr("pmjac_pin.closing.pose_assembly.FOLDS", ())
    diagnosis = pj.check(slider)
    home, behind = diagnosis.poses
    assert (home.failure, home.kind) == (None, "regular")
    assert (behind.kind, behind.failure.code) == (None, "outside-limits")
    assert behind.gap_given == pytest.approx((1 - 0.4**2) / 2)  # (length² − distance²) / 2 length
    found = finding(diagnosis, "pose-outside-limits")
    assert "closes where 'slide' = -1 m is outside its limits [-0.5, 100] m" in found.message
    assert found.severity == "error"


def test_a_value_outside_a_passive_joints_limits(model_file):
    found = finding(
        pj.check(model_file(("phi1 = 2.0236", "phi1 = 8.3068"))), "given-outside-limits"
    )
    assert found.message.startswith("The home pose gives 'phi1' = 8.3068, outside [-6.28319, 6.28")


def test_a_motor_without_limits():
    model = loaded("four_bar").model
    model.lowerPositionLimit[:], model.upperPositionLimit[:] = -np.inf, np.inf
    arguments = (loaded("four_bar").spec.loops, ["theta1"], "coupler_midpoint")
    mechanism = pj.Mechanism.from_pinocchio(model, *arguments, home=loaded("four_bar").home.q)
    assert finding(pj.check(mechanism), "no-limits").message == "The motor 'theta1' has no limits."


@pytest.mark.parametrize(
    ("offset", "code"), [(0.0, "singular-pose"), (1e-7, "near-singular"), (0.1, "conditioning")]
)
def test_home_poses_at_and_near_a_fold(offset, code):
    """The rocker-rocker at the end of its crank's range, where coupler and rocker are in line."""
    mechanism = mechanisms.rocker_rocker()
    l0, l1, l2, l3 = mechanisms.NON_GRASHOF
    theta = np.arccos((l0**2 + l1**2 - (l2 + l3) ** 2) / (2 * l0 * l1)) - offset
    towards = np.arctan2(-l1 * np.sin(theta), l0 - l1 * np.cos(theta))
    if offset:
        home = mechanism.close([theta]).q
    else:
        home = {"theta1": theta, "phi1": towards + np.pi, "phi2": towards - theta}
    at = pj.Mechanism.from_pinocchio(
        mechanism.model, mechanism.spec.loops, ["theta1"], "coupler_midpoint", home=home
    )
    diagnosis = pj.check(at)
    found = finding(diagnosis, code)
    assert found.severity == ("ok" if code == "conditioning" else "warning")
    [pose] = diagnosis.poses
    assert pose.smallest == at.home.singularity().smallest
    if code == "singular-pose":
        assert diagnosis.actuation.gained == 1
        assert not {"idle-motion", "under-actuated"} & {item.code for item in diagnosis.findings}


def test_a_tolerance_of_the_file_is_told(model_file):
    diagnosis = pj.check(model_file(("urdf =", "tolerance = 1e-4\nurdf =")))
    assert finding(diagnosis, "tolerance").severity == "note"


# --- what cannot be checked ----------------------------------------------------------------------


def test_an_error_without_a_mechanism_is_raised_again(tmp_path):
    with pytest.raises(pj.ModelFileError, match="none"):
        pj.check(tmp_path / "none.toml")
    with pytest.raises(pj.UnknownNameError):
        pj.check("four_bra")
    with pytest.raises(pj.ArgumentError, match="own words"):
        pj.check(pj.ArgumentError("own words"))


def test_errors_stay_small_when_pickled():
    with pytest.raises(pj.ClosureError) as caught:
        pj.load("four_bar", parameters={"l1": 100.0})
    again = pickle.loads(pickle.dumps(caught.value))
    assert again.loop == "coupler_tip-rocker_tip"
    with pytest.raises(pj.ClosureError):
        pj.check(again)


def test_a_spherical_joint_has_no_limits_and_three_rows():
    model = pin.Model()
    kind = pin.JointModelSpherical()
    ball = model.addJoint(0, kind, pin.SE3.Identity(), "ball")
    model.addFrame(pin.Frame("tip", ball, pin.SE3.Identity(), pin.FrameType.OP_FRAME))
    spin = model.addJoint(ball, pin.JointModelRZ(), pin.SE3.Identity(), "spin")
    model.addFrame(pin.Frame("top", spin, pin.SE3.Identity(), pin.FrameType.OP_FRAME))
    mechanism = pj.Mechanism.from_pinocchio(model, [], ["spin"], "top", home=None, name="ball")
    diagnosis = pj.check(mechanism)
    kinds = {freedom.name: freedom.kind for freedom in diagnosis.freedoms}
    assert kinds == {
        "spin": "revolute", "ball.rx": "spherical", "ball.ry": "spherical", "ball.rz": "spherical",
    }  # fmt: skip
    assert diagnosis.severity == "error"
