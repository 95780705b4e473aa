"""Which reader reads what, and motors and tools given from outside."""

from __future__ import annotations

import pickle

import looped
import mjcf_models
import numpy as np
import pytest

import pmjac_pin as pj
from pmjac_pin.files.catalog import SUFFIXES
from pmjac_pin.files.source import READERS, read_source
from pmjac_pin.files.urdf.looped_urdf import read_looped_urdf
from pmjac_pin.model.tool_spec import Tool


@pytest.fixture
def path(tmp_path):
    path = tmp_path / "machine.urdf"
    path.write_text(looped.two_parents())
    return path


def test_every_suffix_has_a_reader():
    assert {".toml", ".yaml", *READERS} == set(SUFFIXES)  # that of an extended URDF is for it


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("a.urdf.xacro", "xacro's macros are not read; write what they make with: xacro"),
        ("a.json", "the end of its name tells no format; there are .toml, .urdf, .yaml, .sdf"),
    ],
)
def test_an_end_of_a_name_that_tells_no_format(tmp_path, name, message):
    (tmp_path / name).write_text("<robot/>")
    with pytest.raises(pj.ModelFileError, match=f"{name}: {message}"):
        pj.load(tmp_path / name)


def test_a_tool_is_one_frame(path):
    for given in (path, "four_bar"):
        with pytest.raises(pj.ArgumentError, match="`tool` is the name of one frame, got"):
            pj.load(given, actuated=["theta1"], tool=["a", "b", "c"])


def test_a_model_file_takes_other_motors_and_another_tool():
    given = pj.load("four_bar", actuated=["phi1"], tool="crank")
    assert (given.actuated, given.passive) == (("phi1",), ("theta1", "phi2"))
    assert given.spec.tool == Tool(frame="crank")
    kept = pj.load("four_bar", tool="crank")
    assert kept.passive == ("phi1", "phi2")
    assert kept.notes == ("no masses are given: they are 0 in `model`",)


def test_motors_of_a_model_file_that_do_not_exist():
    with pytest.raises(pj.UnknownNameError, match="unknown joint 'theta'; did you mean 'theta1'"):
        pj.load("four_bar", actuated=["theta"])
    with pytest.raises(pj.UnknownNameError, match="unknown frame 'cranc'; did you mean 'crank'"):
        pj.load("four_bar", tool="cranc")


@pytest.mark.parametrize("actuated", ["theta1", 3, [1], [None]])
def test_motors_are_a_list_of_names(path, actuated):
    with pytest.raises(pj.ArgumentError, match="actuated is a list of joint names"):
        pj.load(path, actuated=actuated, tool=looped.TOOL)


def test_a_generator_of_motors(path):
    mechanism = pj.load(path, actuated=(name for name in ["theta1"]), tool=looped.TOOL)
    assert mechanism.actuated == ("theta1",)


def test_motors_given_twice(path):
    with pytest.raises(pj.PmjacError, match="'theta1' is listed twice in `actuated`"):
        pj.load(path, actuated=["theta1", "theta1"], tool=looped.TOOL)


@pytest.mark.parametrize("name", ["machine.URDF", "machine.urdf"])
def test_a_urdf_beside_nothing_is_read_with_its_loops(tmp_path, name):
    path = tmp_path / name
    path.write_text(looped.two_parents())
    source = read_source(path, ["theta1"], looped.TOOL)
    assert source.spec.loops == read_looped_urdf(path).loops
    assert source.notes


@pytest.mark.parametrize("suffix", [".xml", ".mjcf"])
def test_mjcf_tells_its_motors(tmp_path, suffix):
    path = tmp_path / f"machine{suffix}"
    path.write_text(mjcf_models.FOUR_BAR)
    mechanism = pj.load(path, tool="coupler")
    assert (mechanism.actuated, mechanism.mobility) == (("t",), 1)


def test_sdf(tmp_path):
    path = tmp_path / "arm.sdf"
    path.write_text(
        '<sdf version="1.7"><model name="arm"><link name="base"/><link name="rod"/>'
        '<joint name="swing" type="revolute"><parent>base</parent><child>rod</child>'
        "<axis><xyz>0 0 1</xyz></axis></joint></model></sdf>"
    )
    mechanism = pj.load(path, actuated=["swing"], tool="rod")
    assert any(note.startswith("no joint holds the model") for note in mechanism.notes)


def test_parameters_are_those_of_a_model_file(path):
    with pytest.raises(pj.UnknownNameError, match="unknown parameter 'l1'; there are none"):
        pj.load(path, {"l1": 1.0}, actuated=["theta1"], tool=looped.TOOL)


def test_notes_survive_pickling(path):
    mechanism = pj.load(path, actuated=["theta1"], tool=looped.TOOL)
    (note,) = mechanism.notes
    assert note.startswith("joint 'hinge' leads to link 'pin'")
    again = pickle.loads(pickle.dumps(mechanism))
    assert again == mechanism
    assert again.notes == mechanism.notes
    np.testing.assert_array_equal(again.home.jacobian().J_eq, mechanism.home.jacobian().J_eq)


def test_a_home_that_does_not_assemble_is_a_closure_error(tmp_path):
    far = looped.with_element(looped.loop_element().replace('xyz="', 'xyz="9', 1))
    path = tmp_path / "far.urdf"
    path.write_text(far)
    with pytest.raises(pj.ClosureError, match="far: the pose 'home' does not assemble"):
        pj.load(path, actuated=["theta1"], tool=looped.TOOL)
