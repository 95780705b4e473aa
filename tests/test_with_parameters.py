"""A mechanism at other values of its parameters is what its file would give, to the last bit."""

from __future__ import annotations

import dataclasses
import pickle
import shutil
from pathlib import Path

import mechanisms
import numpy as np
import pinocchio as pin
import pytest
from mechanisms import loaded

import pmjac_pin as pj
from pmjac_pin.closing import home_on_the_way
from pmjac_pin.files import xml_text

WITH_PARAMETERS = [name for name in mechanisms.CATALOGUE if loaded(name).spec.parameters]


def drawn(mechanism, rng, share):
    """Values around the defaults, some of them."""
    values = {}
    for name, parameter in mechanism.spec.parameters.items():
        if rng.random() < 0.8:
            size = max(abs(parameter.default), 0.1)
            value = parameter.default + share * size * rng.uniform(-1.0, 1.0)
            values[name] = max(value, parameter.minimum or -np.inf)
    return values


def told(make):
    """All that is known of a mechanism, or why there is none."""
    try:
        mechanism = make()
    except pj.PmjacError as error:
        return type(error), str(error)
    found = {
        field.name: getattr(mechanism.problem.partition, field.name)
        for field in dataclasses.fields(mechanism.problem.partition)
    }
    found |= {
        "urdf": mechanism.urdf.text,
        "model": mechanism.model.saveToString(),
        "values": dict(mechanism.parameters),
        "place": mechanism.place,
        "tolerance": mechanism.tolerance,
        "notes": (mechanism.notes, mechanism.unread),
        "home": mechanism.home.q,
    }
    try:
        found["J_eq"] = mechanism.home.jacobian().J_eq
        found["pose"] = mechanism.close(mechanism.home.actuated + 0.01).q
    except pj.PmjacError as error:
        found["error"] = str(error)
    return found


def assert_same(one, other):
    assert type(one) is type(other)
    if isinstance(one, tuple):
        assert one == other
        return
    assert one.keys() == other.keys()
    for key, value in one.items():
        if isinstance(value, np.ndarray):
            np.testing.assert_array_equal(value, other[key], err_msg=key, strict=True)
        else:
            assert value == other[key], key


@pytest.mark.parametrize("name", WITH_PARAMETERS)
def test_a_sibling_is_what_the_file_gives(name, rng):
    mechanism = loaded(name)
    values = drawn(mechanism, rng, 0.2)
    fresh = told(lambda: pj.load(name, values))
    assert_same(told(lambda: mechanism.with_parameters(values)), fresh)


@pytest.mark.slow
@pytest.mark.parametrize("name", WITH_PARAMETERS)
@pytest.mark.parametrize("share", [0.01, 0.1, 0.5, 2.0])
def test_many_siblings_are_what_the_file_gives(name, share, rng):
    mechanism = pj.load(name)
    for _ in range(8):
        values = drawn(mechanism, rng, share)
        fresh = told(lambda: pj.load(name, values))  # noqa: B023
        assert_same(told(lambda: mechanism.with_parameters(values)), fresh)  # noqa: B023


@pytest.mark.parametrize("name", ["four_bar", "three_rps"])
def test_it_does_not_matter_from_where(name, rng):
    """Not from which mechanism it is asked for, nor what was asked before."""
    mechanism = pj.load(name)
    every = mechanism.spec.parameters
    values = {name: 1.1 * parameter.default for name, parameter in every.items()}
    others = {name: 0.8 * parameter.default for name, parameter in every.items()}
    expected = told(lambda: pj.load(name, values))
    far = mechanism.with_parameters(others)
    assert_same(told(lambda: far.with_parameters(values)), expected)
    assert_same(told(lambda: mechanism.with_parameters(values)), expected)
    again = pickle.loads(pickle.dumps(far))
    assert_same(told(lambda: again.with_parameters(values)), expected)


def test_what_is_not_named_stays():
    mechanism = pj.load("four_bar", {"l1": 1.2})
    assert dict(mechanism.with_parameters(l2=2.9).parameters) == {
        "l0": 4.0, "l1": 1.2, "l2": 2.9, "l3": 3.5,
    }  # fmt: skip
    assert mechanism.with_parameters({"l2": 2.8}, l2=2.9).parameters["l2"] == 2.9
    assert mechanism.with_parameters() is mechanism
    assert mechanism.with_parameters(l1=1.2) is mechanism
    assert mechanism.with_parameters(l1=1.0) == pj.load("four_bar")


def test_nothing_is_read_again(monkeypatch):
    mechanism = pj.load("three_rps")
    monkeypatch.setattr(xml_text, "bounded_tree", None)
    monkeypatch.setattr(pj.Mechanism, "from_pinocchio", None)
    assert mechanism.with_parameters(a=0.6).close([0.7, 0.7, 0.7]).residual_norm < 1e-12


@pytest.mark.parametrize("name", ["four_bar", "three_rps", "watt_six_bar"])
def test_no_machine_is_built_on_the_way(name, monkeypatch):
    """One model for each design, and at first that of the defaults."""
    mechanism, models = pj.load(name), []

    def build(text, read=pin.buildModelFromXML):
        models.append(text)
        return read(text)

    monkeypatch.setattr(pin, "buildModelFromXML", build)
    for count, factor in ((2, 1.02), (3, 0.98), (4, 1.01)):
        mechanism.with_parameters({k: factor * v for k, v in mechanism.parameters.items()})
        assert len(models) == count


def test_numbers_of_numpy():
    mechanism = pj.load("four_bar")
    assert mechanism.with_parameters(l1=np.float64(1.2)) == mechanism.with_parameters(l1=1.2)


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"L1": 1.0}, "unknown parameter 'L1'; did you mean 'l1'"),
        ({"length": 1.0}, "unknown parameter 'length'; there are: l0, l1, l2, l3"),
        ({"l1": -1.0}, "parameter 'l1' = -1 m is not within"),
        ({"l1": "1"}, "parameter 'l1' must be a number in m, got '1'"),
        ({"l1": np.nan}, "is not within"),
        ([1.0], "parameters must be a mapping of names to numbers"),
        (0, "parameters must be a mapping of names to numbers"),
    ],
)
def test_what_is_no_parameter(given, message):
    with pytest.raises(pj.PmjacError, match=message):
        pj.load("four_bar").with_parameters(given)


def test_dimensions_that_do_not_assemble():
    with pytest.raises(pj.ClosureError, match="does not assemble"):
        pj.load("four_bar").with_parameters(l0=100.0)


def test_a_mechanism_without_a_file():
    mechanism = mechanisms.rocker_rocker()
    cut = pj.recut(mechanism, "phi1")
    with pytest.raises(pj.UnknownNameError, match="unknown parameter 'l1'; there are none"):
        cut.with_parameters(l1=2.0)
    assert cut.with_parameters() is cut


OPTIONS = {
    "motors": ("five_bar", {"actuated": ["theta1", "phi1"]}),
    "locked": ("five_bar", {"actuated": ["theta1"], "locked": ["theta2"]}),
    "rows": ("four_bar", {"tool_rows": ["vx", "vy"], "tool_axes": "LOCAL"}),
    "tool": ("four_bar", {"tool": "rocker_tip"}),
    "tolerance": ("three_rps", {"tolerance": 1e-6}),
}


@pytest.mark.parametrize("case", OPTIONS)
def test_what_load_was_told_holds(case, rng):
    name, options = OPTIONS[case]
    mechanism = pj.load(name, **options)
    values = drawn(mechanism, rng, 0.05)
    fresh = told(lambda: pj.load(name, values, **options))
    assert_same(told(lambda: mechanism.with_parameters(values)), fresh)


def test_another_tool_stays(rng):
    """Whichever is asked for first."""
    mechanism = pj.load("four_bar")
    values = drawn(mechanism, rng, 0.05)
    fresh = pj.load("four_bar", values, tool="rocker_tip")
    sibling = mechanism.with_tool("rocker_tip").with_parameters(values)
    assert_same(told(lambda: sibling), told(lambda: fresh))
    for other in (mechanism.with_parameters(values).with_tool("rocker_tip"), sibling):
        assert other == fresh
        assert other.with_parameters(l0=4.1) == fresh.with_parameters(l0=4.1)


MACHINE = """
name = "press"
urdf = "press.urdf"
actuated = ["theta"]
tool.frame = "tip"
loop = [
  {kind = "distance", frames = ["pin", "slide"], length = {rod = 1.0}},
  {kind = "joint", joints = ["theta", "gear"], ratio = -2.5},
]
[parameters.crank]
default = 0.3
unit = "m"
meaning = "crank"
moves = [{joint = "at_pin", xyz = [1.0, 0.0, 0.0]}, {visual = "bar", size = [1.0, 0.0, 0.0]}]
[parameters.turn]
default = 0.0
unit = "rad"
meaning = "how the slide's guide is inclined"
moves = [{joint = "x", rpy = [0.0, 0.0, 1.0]}]
[parameters.rod]
default = 1.0
unit = "m"
meaning = "rod"
[parameters.reach]
default = 0.1
unit = "m"
meaning = "tool"
moves = [{joint = "at_tip", xyz = [0.0, 1.0, 0.0]}]
[poses.home]
theta = 0.7
x = 1.1
"""
URDF = """
<robot name="press"><link name="base"/><link name="crank">
  <visual name="bar"><geometry><box size="0.3 0.1 0.1"/></geometry></visual></link>
  <link name="pin"/><link name="slide"/><link name="tip"/><link name="wheel"/>
  <joint name="theta" type="revolute"><parent link="base"/><child link="crank"/>
    <axis xyz="0 0 1"/><limit lower="-3" upper="3" effort="1" velocity="1"/></joint>
  <joint name="at_pin" type="fixed"><parent link="crank"/><child link="pin"/>
    <origin xyz="0.3 0 0"/></joint>
  <joint name="x" type="prismatic"><parent link="base"/><child link="slide"/>
    <axis xyz="1 0 0"/><limit lower="0.5" upper="1.4" effort="1" velocity="1"/></joint>
  <joint name="at_tip" type="fixed"><parent link="slide"/><child link="tip"/>
    <origin xyz="0 0.1 0" rpy="0 0.2 0"/></joint>
  <joint name="gear" type="revolute"><parent link="slide"/><child link="wheel"/>
    <axis xyz="0 0 1"/><limit lower="-9" upper="9" effort="1" velocity="1"/></joint>
</robot>"""


@pytest.fixture
def press(tmp_path):
    """Parameters that turn a guide, are a rod, move the tool, and lead to the end of a stroke."""
    (tmp_path / "press.urdf").write_text(URDF)
    path = tmp_path / "press.toml"
    path.write_text(MACHINE)
    return path


@pytest.mark.parametrize(
    ("share", "count"),
    mechanisms.mostly_slow(
        [(0.2, 1), (2.0, 1), *((share, 3) for share in (0.02, 0.2, 0.5, 1.0, 2.0))],
        [(0.2, 1), (2.0, 1)],
    ),
)
def test_a_file_of_ones_own(press, share, count, rng):
    mechanism = pj.load(press)
    for _ in range(count):
        values = drawn(mechanism, rng, share)
        fresh = told(lambda: pj.load(press, values))  # noqa: B023
        assert_same(told(lambda: mechanism.with_parameters(values)), fresh)  # noqa: B023


def test_a_file_that_is_gone(press):
    mechanism = pj.load(press)
    press.unlink()
    (press.parent / "press.urdf").unlink()
    assert mechanism.with_parameters(rod=1.05).parameters["rod"] == 1.05


def test_errors_name_the_file(press):
    mechanism = pj.load(press)
    with pytest.raises(pj.ModelFileError, match="press") as caught:
        mechanism.with_parameters(crank=-0.4)  # its bar would have no length
    assert "must be positive" in str(caught.value)


def home_of(lengths):
    return pj.load("four_bar", dict(zip(("l0", "l1", "l2", "l3"), lengths, strict=True))).home.q


def test_a_long_way_keeps_the_assembly_mode():
    """At once, or in many steps by way of mechanisms in between: the same."""
    begin, end = np.array([4.0, 1.0, 3.0, 3.5]), np.array([6.0, 2.6, 4.0, 5.0])
    mechanism = pj.load("four_bar")
    q = mechanism.home
    for share in np.linspace(0.05, 1.0, 20):
        lengths = dict(zip(("l0", "l1", "l2", "l3"), begin + share * (end - begin), strict=True))
        q = mechanism.with_parameters(lengths).close(mechanism.home.actuated, guess=q)
    np.testing.assert_allclose(home_of(end), q.q, atol=1e-9)


@pytest.mark.parametrize("name", ["four_bar", "five_bar"])
@pytest.mark.parametrize("joint", ["phi1", "phi2"])
def test_a_hinge_whose_origin_turns_about_it_turns_back(name, joint, tmp_path):
    """By hand: all else stays, however far it turns; no regular pose is left for another mode."""
    repository = Path(__file__).parents[1]
    text = (repository / "models" / f"{name}.toml").read_text()
    shutil.copy(repository / "urdf" / f"{name}.urdf", tmp_path)
    move = f'moves = [{{ joint = "{joint}", rpy = [0.0, 0.0, 1.0] }}]'
    given = f'\n[parameters.turned]\ndefault = 0.0\nunit = "rad"\nmeaning = "of {joint}"\n{move}\n'
    (tmp_path / "turned.toml").write_text(text + given)
    machine = pj.load(tmp_path / "turned.toml")
    home, turning = machine.home.passive, np.array(machine.passive) == joint
    for angle in (0.4, -2.2, 4.8, 5.3, -5.8):
        found = machine.with_parameters(turned=angle).home.passive
        away = np.exp(1j * (found - home + angle * turning))
        np.testing.assert_allclose(away, 1.0, atol=1e-9)


@pytest.mark.parametrize("share", [0.02, 0.1])
@pytest.mark.parametrize("name", mechanisms.mostly_slow(WITH_PARAMETERS, ("four_bar", "ankle")))
def test_one_step_home_leads_where_twelve_do(name, share, rng, monkeypatch):
    mechanism, taken, at_once = loaded(name), [], home_on_the_way._at_once

    def counted(problem, first):
        found = at_once(problem, first)
        taken.append(found is not None)
        return found

    def homes():
        found = []
        for values in designs:
            try:
                found.append(mechanism.with_parameters(values).home.q)
            except pj.PmjacError as error:
                found.append(str(error))
        return found

    designs = [drawn(mechanism, rng, share) for _ in range(10)]
    monkeypatch.setattr(home_on_the_way, "_at_once", counted)
    found = homes()
    monkeypatch.setattr(home_on_the_way, "_at_once", lambda *_: None)
    for one, other in zip(found, homes(), strict=True):
        assert type(one) is type(other)
        if isinstance(one, str):
            assert one == other
        else:
            np.testing.assert_allclose(one, other, atol=1e-9)
    assert name != "four_bar" or share > 0.05 or any(taken)
