"""What is exported besides kinematics, what is refused, and that files are whole or not there."""

from __future__ import annotations

import struct
from pathlib import Path
from xml.etree.ElementTree import parse

import numpy as np
import pinocchio as pin
import pytest
import transformed
from exported import FORMATS, geared, heavy, limited, path_of, round_trip, same, screwed
from mechanisms import Z, loaded, mostly_slow, tree
from test_own_kind import known, lever, registered  # noqa: F401

import pmjac_pin as pj
from pmjac_pin.cli import main

XML = FORMATS[:-1]


def tetrahedron():
    """Binary STL of one."""
    corners = np.vstack([np.zeros(3), np.eye(3)])
    facets = [corners[[k for k in range(4) if k != left]] for left in range(4)]
    body = b"".join(struct.pack("<12fH", 0, 0, 0, *facet.ravel(), 0) for facet in facets)
    return bytes(80) + struct.pack("<I", 4) + body


def equivalent_masses(mechanism):
    """GᵀMG at home, which does not depend on the tree."""
    model, home = mechanism.model, mechanism.home
    mass = pin.crba(model, model.createData(), home.q, pin.Convention.WORLD)
    motions = home.jacobian().motion_map
    return motions.T @ (np.triu(mass) + np.triu(mass, 1).T) @ motions


@pytest.mark.parametrize("to", mostly_slow(FORMATS, ("sdf",)))
def test_masses_and_rotors_come_back(to, tmp_path):
    mechanism = heavy()
    _, again = round_trip(mechanism, to, tmp_path)
    expected = equivalent_masses(mechanism)
    order = [again.actuated.index(name) for name in mechanism.actuated]
    found = equivalent_masses(again)[np.ix_(order, order)]
    np.testing.assert_allclose(found, expected, rtol=1e-9)


@pytest.mark.parametrize("to", mostly_slow(FORMATS, ("toml",)))
def test_limits_come_back(to, tmp_path):
    mechanism = limited()
    exported, again = round_trip(mechanism, to, tmp_path)
    start = 0.0 if to in ("mjcf", "toml") else 1.0
    assert any("count from home" in note for note in exported.notes) == bool(start)
    for name in mechanism.coordinates.names:
        home = start * mechanism.home.joint_values[name]
        expected = [limit - home for limit in mechanism.limits(name)]
        np.testing.assert_allclose(again.limits(name), expected, rtol=0, atol=1e-12)


def test_home_beyond_its_limits_is_told(tmp_path):
    model = pin.buildModelFromXML(tree(("q", "revolute", "ground", "arm", (0, 0, 0), Z)))
    model.upperPositionLimit = np.array([0.5])
    given = {"home": {"q": 0.8}, "enforce_limits": False, "name": "beyond"}
    mechanism = pj.Mechanism.from_pinocchio(model, [], ["q"], "arm", **given)
    exported, again = round_trip(mechanism, "urdf-plus", tmp_path)
    assert "home is beyond the limits of 'q', which are widened to hold it" in exported.notes
    same(mechanism, again, exported)


def test_motors_keep_their_order_and_efforts(tmp_path):
    mechanism = pj.load("five_bar", actuated=loaded("five_bar").actuated[::-1])
    for to in ("mjcf", "extended-urdf"):
        _, again = round_trip(mechanism, to, tmp_path)
        assert again.actuated == mechanism.actuated
    model = mechanism.model
    model.upperEffortLimit = model.upperEffortLimit * 0 + 7.0
    model.lowerEffortLimit = -model.upperEffortLimit
    driven = pj.Mechanism.from_pinocchio(model, [], mechanism.actuated, home=mechanism.home.q)
    pj.export(driven, to="mjcf", file=tmp_path / "strong.xml")
    motors = parse(tmp_path / "strong.xml").getroot().findall("actuator/motor")
    assert [motor.get("joint") for motor in motors] == list(mechanism.actuated)
    assert {motor.get("ctrlrange") for motor in motors} == {"-7.0 7.0"}


@pytest.mark.parametrize("to", ["extended-urdf", "urdf-plus", "toml"])
def test_what_motors_can_do_comes_back(to, tmp_path):
    model = loaded("five_bar").model
    rng = np.random.default_rng(3)
    model.upperEffortLimit, model.upperVelocityLimit = rng.uniform(1, 2, (2, model.nv))
    model.lowerEffortLimit, model.lowerVelocityLimit = (
        -model.upperEffortLimit,
        -model.upperVelocityLimit,
    )
    mechanism = transformed.rebuilt(loaded("five_bar"), model)
    _, again = round_trip(mechanism, to, tmp_path)
    mine, theirs = mechanism.problem.partition, again.problem.partition
    np.testing.assert_array_equal(theirs.effort_limits, mine.effort_limits)
    np.testing.assert_array_equal(theirs.rate_limits, mine.rate_limits)
    assert np.isfinite([mine.effort_limits, mine.rate_limits]).all()


def test_order_of_motors_is_told_where_a_format_has_none(tmp_path):
    mechanism = pj.load("five_bar", actuated=loaded("five_bar").actuated[::-1])
    exported, again = round_trip(mechanism, "urdf-plus", tmp_path)
    assert again.actuated == mechanism.actuated[::-1]
    assert any("in the order of the file's joints" in note for note in exported.notes)


# --- shapes ----------------------------------------------------------------------------------


@pytest.fixture
def drawn(tmp_path):
    """A link with each shape and two meshes: one that is there, one that is not."""
    folder = tmp_path / "given" / "robot"
    folder.mkdir(parents=True)
    (folder / "part.stl").write_bytes(tetrahedron())
    shapes = (
        '<box size="1 2 3"/>',
        '<cylinder radius="0.1" length="2"/>',
        '<sphere radius="0.3"/>',
        '<capsule radius="0.1" length="2"/>',
        '<mesh filename="package://robot/part.stl" scale="0.1 0.1 0.1"/>',
        '<mesh filename="part.dae"/>',
    )
    paint = '<material name="blue"><color rgba="0.1 0.2 0.7 1"/></material>'
    visuals = "".join(
        f'<visual><origin xyz="{k} 0 0" rpy="0.1 0.2 {k}"/><geometry>{shape}</geometry>{paint}'
        "</visual>"
        for k, shape in enumerate(shapes)
    )
    text = tree(("q", "revolute", "ground", "arm", (0, 0, 1), Z, (0.3, 0, 0)))
    path = folder / "robot.urdf"
    path.write_text(text.replace('<link name="arm"/>', f'<link name="arm">{visuals}</link>'))
    return pj.load(path, tool="arm")


@pytest.mark.parametrize("to", mostly_slow(FORMATS, ("mjcf", "sdf")))
def test_shapes_and_colours(drawn, to, tmp_path):
    exported = pj.export(drawn, to=to, file=path_of(tmp_path, to))
    root = parse(exported.paths[1 if to == "toml" else 0]).getroot()
    if to == "mjcf":
        geoms = root.findall(".//geom")
        assert [g.get("type") for g in geoms] == ["box", "cylinder", "sphere", "capsule", "mesh"]
        assert [float(x) for x in geoms[0].get("size").split()] == [0.5, 1.0, 1.5]
        assert {geom.get("rgba") for geom in geoms} == {"0.1 0.2 0.7 1.0"}
        assert root.find("asset/mesh").get("file") == "given/robot/part.stl"
        assert any("left out" in note and "'part.dae'" in note for note in exported.notes)
        mujoco = pytest.importorskip("mujoco")
        assert mujoco.MjModel.from_xml_path(str(exported.paths[0])).nmesh == 1
    elif to == "sdf":
        assert len(root.findall(".//visual")) == 6
        assert [uri.text for uri in root.iter("uri")] == ["given/robot/part.stl", "part.dae"]
    else:
        assert len(root.findall("link/visual")) == 6


# --- what cannot be said ---------------------------------------------------------------------


@pytest.mark.parametrize("to", mostly_slow(["sdf", "extended-urdf", "urdf-plus"], ("sdf",)))
def test_gears_in_which_no_order_is_are_refused(to, tmp_path):
    for ties, motors, why in (
        ([(("a", "b"), 2.0, 0.0)], ("a", "b"), "'a' and 'b', two motors, are geared"),
        (
            [(("a", "b"), 2.0, 0.0), (("b", "c"), 2.0, 0.0), (("a", "c"), 4.0, 0.0)],
            ("a", "d"),
            "joints that follow more than one, are geared",
        ),
    ):
        mechanism = geared(*ties, motors=motors)
        with pytest.raises(pj.ArgumentError, match=f"{to} cannot say that .*{why}; mjcf or toml"):
            pj.export(mechanism, to=to, file=path_of(tmp_path, to))
        assert not list(tmp_path.iterdir())
        exported, again = round_trip(mechanism, "mjcf", tmp_path)
        same(mechanism, again, exported)
        exported.paths[0].unlink()


@pytest.mark.parametrize("to", mostly_slow(XML, ("mjcf",)))
def test_a_kind_of_loop_of_ones_own_has_a_hub(lever, to, tmp_path):  # noqa: F811
    exported, again = round_trip(lever, to, tmp_path)
    assert any("is a link that moves so, welded" in note for note in exported.notes)
    same(lever, again, exported)


@pytest.mark.parametrize("to", mostly_slow(FORMATS, ("mjcf",)))
@pytest.mark.parametrize("name", ["bell\x07", "\ufffe"])
def test_names_that_no_file_holds_are_refused(name, to, tmp_path):
    model = pin.buildModelFromXML(tree(("q", "revolute", "ground", "arm", (0, 0, 0), Z)))
    model.names[1] = name
    mechanism = pj.Mechanism.from_pinocchio(model, [], [name], "arm", name="odd")
    with pytest.raises(pj.ArgumentError, match=r"the name .* rename it in the model"):
        pj.export(mechanism, to=to, file=path_of(tmp_path, to))
    assert not list(tmp_path.iterdir())


def test_a_format_that_there_is_not(tmp_path):
    with pytest.raises(pj.ArgumentError, match=r"got 'mjfc'; did you mean 'mjcf'"):
        pj.export(loaded("four_bar"), to="mjfc", file=tmp_path / "x.xml")
    with pytest.raises(pj.ArgumentError, match="Mechanism"):
        pj.export("four_bar", to="mjcf", file=tmp_path / "x.xml")


def test_without_mujoco_the_evidence_is_nothing(monkeypatch, tmp_path):
    from pmjac_pin.files.mjcf import mujoco as reader

    def missing():
        raise pj.MissingDependencyError("MJCF is read by MuJoCo, which is not installed")

    monkeypatch.setattr(reader, "_mujoco", missing)
    exported = pj.export(loaded("four_bar"), to="mjcf", file=tmp_path / "x.xml")
    assert exported.evidence.kind == "nothing"
    assert "not read again: MJCF is read by MuJoCo" in exported.evidence.statement


# --- files -----------------------------------------------------------------------------------


@pytest.mark.parametrize("to", mostly_slow(FORMATS, ("extended-urdf",)))
def test_what_exists_is_replaced_by_force_only(to, tmp_path):
    paths = pj.export(loaded("four_bar"), to=to, file=path_of(tmp_path, to)).paths
    assert sorted(tmp_path.iterdir()) == sorted(paths)
    for path in paths:
        for other in paths:
            other.unlink(missing_ok=True)
        path.write_text("precious")
        with pytest.raises(pj.OutputError, match="exists already; --force replaces it"):
            pj.export(loaded("four_bar"), to=to, file=path_of(tmp_path, to))
        assert [(p, p.read_text()) for p in tmp_path.iterdir()] == [(path, "precious")]
        pj.export(loaded("four_bar"), to=to, file=path_of(tmp_path, to), force=True)
        assert path.read_text() != "precious"


def test_what_was_read_is_never_replaced(drawn, tmp_path):
    path = tmp_path / "given" / "robot" / "robot.urdf"
    before = path.read_text()
    for to in ("urdf-plus", "extended-urdf"):
        with pytest.raises(pj.OutputError, match=r"robot\.urdf: is what was read"):
            pj.export(drawn, to=to, file=path, force=True)
    paths = pj.export(drawn, to="toml", file=path.with_suffix(".toml"), force=True).paths
    assert [place.name for place in paths] == ["robot.toml", "robot_tree.urdf"]
    assert path.read_text() == before


def test_names_of_files(tmp_path):
    for to in FORMATS:
        with pytest.raises(pj.OutputError, match=r"ends in \."):
            pj.export(loaded("four_bar"), to=to, file=tmp_path / "machine.txt")
    with pytest.raises(pj.OutputError, match="there is no folder"):
        pj.export(loaded("four_bar"), to="sdf", file=tmp_path / "none" / "machine.sdf")
    assert not list(tmp_path.iterdir())


def test_a_yaml_that_would_be_read_with_the_file(tmp_path):
    (tmp_path / "robot.yaml").write_text("closed_loop: []\n")
    with pytest.raises(pj.OutputError, match=r"robot\.yaml: would be read with"):
        pj.export(loaded("four_bar"), to="urdf-plus", file=tmp_path / "mine.urdf")
    exported = pj.export(loaded("four_bar"), to="extended-urdf", file=tmp_path / "mine.urdf")
    assert pj.load(exported.paths[0]).actuated == ("theta1",)


def test_through_a_link(tmp_path):
    (tmp_path / "far").mkdir()
    (tmp_path / "mine.urdf").symlink_to(tmp_path / "far" / "real.urdf")
    exported = pj.export(loaded("four_bar"), to="extended-urdf", file=tmp_path / "mine.urdf")
    assert [path.name for path in exported.paths] == ["real.urdf", "real.yaml"]
    assert {path.parent for path in exported.paths} == {tmp_path / "far"}


# --- the command -----------------------------------------------------------------------------


def test_the_command(tmp_path, capsys):
    path = tmp_path / "bar.sdf"
    assert main(["export", "four_bar", "--to", "sdf", "-o", str(path), "--set", "l1=1.2"]) == 0
    said = capsys.readouterr()
    assert said.out == f"{path}\n"
    lines = said.err.splitlines()
    assert all(line.startswith("pmjac: ") for line in lines)
    assert (
        "pmjac: sdf does not say which joints are motors: read it with --actuated theta1" in lines
    )
    assert "pmjac: sdf does not say what the tool is: 'coupler_midpoint'" in lines
    assert main(["export", "four_bar", "--to", "sdf", "-o", str(path)]) == 2
    assert capsys.readouterr().err.strip().endswith("exists already; --force replaces it")
    assert main(["export", "four_bar", "--to", "usd", "-o", str(path)]) == 2
    assert "got 'usd'; did you mean 'sdf'?" in capsys.readouterr().err


def test_names_are_those_of_the_notes(tmp_path):
    exported, again = round_trip(screwed("world", "a::b", "__tool__"), "sdf", tmp_path)
    assert exported.tool == ("__tool___link",)
    assert exported.actuated == ("world_joint", "a_b")
    assert Path(exported.paths[0]).read_text().count("::") == 0
    assert again.actuated == exported.actuated
