"""Any format becomes our model file: the same J_eq, and no file lost."""

from __future__ import annotations

import contextlib

import looped
import mechanisms
import numpy as np
import pytest
from mechanisms import loaded
from peer_models import peer_model

import pmjac_pin as pj
from pmjac_pin.cli import main
from pmjac_pin.studies import convert as convert_module

LOOPED = {"actuated": ["theta1"], "tool": looped.TOOL}


@pytest.fixture
def machine(tmp_path):
    folder = tmp_path / "given"
    folder.mkdir()
    path = folder / "machine.urdf"
    path.write_text(looped.two_parents())
    return path


def same(first, second):
    """One home pose, and one J_eq where there is one."""
    assert (first.actuated, first.passive) == (second.actuated, second.passive)
    np.testing.assert_allclose(first.home.q, second.home.q, rtol=0, atol=1e-12)
    mine, theirs = first.home.split_jacobian(), second.home.split_jacobian()
    for name in ("constraint_jacobian", "tool_jacobian"):
        np.testing.assert_allclose(getattr(mine, name), getattr(theirs, name), atol=1e-11)
    with contextlib.suppress(pj.NoJacobianError):
        J_eq, expected = first.home.jacobian().J_eq, second.home.jacobian().J_eq
        np.testing.assert_allclose(J_eq, expected, rtol=0, atol=1e-10)


def test_looped_urdf(machine, tmp_path):
    model_file, urdf = pj.convert(machine, tmp_path / "mine.toml", **LOOPED)
    assert (model_file, urdf) == (tmp_path / "mine.toml", tmp_path / "mine.urdf")
    same(pj.load(model_file), pj.load(machine, **LOOPED))
    text = model_file.read_text()
    assert text.startswith(
        "# From machine.urdf.\n# joint 'hinge' leads to link 'pin', which 'weld'"
    )
    assert sorted(path.name for path in tmp_path.iterdir()) == ["given", "mine.toml", "mine.urdf"]


@pytest.mark.parametrize("name", mechanisms.mostly_slow(mechanisms.CATALOGUE))
def test_the_catalogue(name, tmp_path):
    mine = pj.load(pj.convert(name, tmp_path / "mine.toml")[0])
    theirs = loaded(name)
    same(mine, theirs)
    assert mine.spec.parameters == theirs.spec.parameters
    assert mine.poses == theirs.poses
    assert mine.name == "mine"
    for parameter in list(theirs.parameters)[:1]:
        values = {parameter: 1.05 * theirs.parameters[parameter]}
        same(pj.load(tmp_path / "mine.toml", values), pj.load(name, values))


@pytest.mark.parametrize(
    ("path", "tool"),
    [
        ("urdf_plus/four_bar.urdf", "link3"),
        ("extended_urdf/5bar_linkage/robot.urdf", "effector"),
        ("extended_urdf/5bar_linkage_iso3d/robot.urdf", "effector"),
        ("extended_urdf/robot_delta/robot.urdf", "eff"),
        ("extended_urdf/cassie_like/robot.urdf", "foot"),
        ("extended_urdf/digit_like_2legs/robot.urdf", "foot"),
    ],
)
def test_peer_models(path, tool, tmp_path):
    given = peer_model(path)
    model_file, _ = pj.convert(given, tmp_path / "mine.toml", tool=tool)
    same(pj.load(model_file), pj.load(given, tool=tool))


def test_motors_and_tool_are_written(tmp_path):
    path, _ = pj.convert("four_bar", tmp_path / "mine.toml", actuated=["phi1"], tool="crank")
    mechanism = pj.load(path)
    assert mechanism.actuated == ("phi1",)
    assert mechanism.spec.tool.frame == "crank"


def test_every_kind_of_loop(tmp_path):
    for kind in ("revolute", "cylindrical", "planar", "spherical", "continuous"):
        path = tmp_path / f"{kind}.urdf"
        gear = '<mimic joint="left" multiplier="-2" offset="0.5"/>'
        finger = looped.link("finger") + looped.joint(
            "finger",
            "revolute",
            "ground",
            "finger",
            (9, 0, 0),
            inside=gear.replace("left", "theta1"),
        )
        path.write_text(looped.with_element(looped.loop_element(kind) + finger))
        out = tmp_path / f"{kind}.toml"
        pj.convert(path, out, **LOOPED)
        mine, theirs = pj.load(out), pj.load(path, **LOOPED)
        assert mine.spec.loops == theirs.spec.loops
        same(mine, theirs)


# --- files -------------------------------------------------------------------------------------


def test_what_exists_stays(machine, tmp_path):
    target = tmp_path / "mine.toml"
    target.write_text("precious")
    with pytest.raises(pj.OutputError, match=r"mine\.toml: exists already; --force replaces it"):
        pj.convert(machine, target, **LOOPED)
    assert target.read_text() == "precious"
    target.rename(tmp_path / "mine.urdf")
    with pytest.raises(pj.OutputError, match=r"mine\.urdf: exists already"):
        pj.convert(machine, target, **LOOPED)
    assert not target.exists()
    pj.convert(machine, target, force=True, **LOOPED)
    same(pj.load(target), pj.load(machine, **LOOPED))


def test_what_is_read_stays(machine):
    before = machine.read_text()
    model_file, urdf = pj.convert(machine, machine.with_suffix(".toml"), **LOOPED)
    assert urdf.name == "machine_tree.urdf"
    assert machine.read_text() == before
    with pytest.raises(pj.OutputError, match="is what is read, and is not replaced"):
        pj.convert(model_file, model_file, force=True)
    again = pj.convert(model_file, model_file.with_name("machine_tree.toml"), force=True)
    assert again[1].name == "machine_tree_tree.urdf"
    assert urdf.exists()


def test_what_a_link_leads_to_is_written_and_read(machine, tmp_path):
    """The URDF beside the file, not beside the link, which may be read all the same."""
    target, link = machine.with_name("mine.toml"), tmp_path / "link.toml"
    link.symlink_to(target)
    for force in (False, True):
        assert pj.convert(machine, link, force=force, **LOOPED)[0] == target
        assert sorted(path.name for path in tmp_path.iterdir()) == ["given", "link.toml"]
        for path in (link, target):
            same(pj.load(path), pj.load(machine, **LOOPED))
    target.with_suffix(".urdf").unlink()
    with pytest.raises(pj.ModelFileError, match=r"neither .*mine\.urdf nor .*given/mine\.urdf"):
        pj.load(link)
    (tmp_path / "mine.urdf").write_text("another")
    with pytest.raises(pj.OutputError, match=r"mine\.urdf: would be read with link\.toml in place"):
        pj.convert(machine, link, force=True, **LOOPED)


def test_a_folder_is_not_replaced(machine, tmp_path):
    (tmp_path / "mine.toml").mkdir()
    with pytest.raises(pj.OutputError, match=r"mine\.toml: is a folder"):
        pj.convert(machine, tmp_path / "mine.toml", force=True, **LOOPED)


@pytest.mark.parametrize(
    ("name", "message"),
    [("mine.txt", r"ends in \.toml"), ("none/mine.toml", "there is no folder .*none")],
)
def test_where_nothing_can_be_written(machine, tmp_path, name, message):
    with pytest.raises(pj.OutputError, match=message):
        pj.convert(machine, tmp_path / name, **LOOPED)


def test_nothing_is_left_when_the_result_does_not_load(machine, tmp_path, monkeypatch):
    def refuse(text, path):
        raise pj.ModelFileError("no")

    monkeypatch.setattr(convert_module, "parse_model_file", refuse)
    with pytest.raises(pj.ModelFileError, match="no"):
        pj.convert(machine, tmp_path / "mine.toml", **LOOPED)
    assert [path.name for path in tmp_path.iterdir()] == ["given"]


def test_a_home_that_does_not_close_is_not_written(tmp_path):
    far = tmp_path / "far.urdf"
    far.write_text(looped.with_element(looped.loop_element().replace('xyz="', 'xyz="9', 1)))
    with pytest.raises(pj.ClosureError):
        pj.convert(far, tmp_path / "mine.toml", **LOOPED)
    assert [path.name for path in tmp_path.iterdir()] == ["far.urdf"]


# --- the command line ----------------------------------------------------------------------------


def test_the_command(machine, tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    arguments = ("convert", str(machine), "--actuated", "theta1", "--tool", looped.TOOL)
    assert main((*arguments, "-o", "mine.toml")) == 0
    assert capsys.readouterr().out == "mine.toml\nmine.urdf\n"
    assert main((*arguments, "-o", "mine.toml")) == 2
    captured = capsys.readouterr()
    assert captured.err == "pmjac: mine.toml: exists already; --force replaces it\n"
    assert main((*arguments, "-o", "mine.toml", "--force")) == 0


@pytest.mark.parametrize("command", ["convert", "plot", "modes", "demo"])
def test_an_output_without_a_name(command, capsys, monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)
    arguments = [] if command == "demo" else ["four_bar"]
    assert main((command, *arguments, "-o", "")) == 2
    wanted = "pmjac: the path of a file is wanted, got an empty text\n"
    assert capsys.readouterr().err == wanted


def test_notes_in_a_report(machine, capsys):
    assert main(("report", str(machine), "--actuated=theta1", f"--tool={looped.TOOL}")) == 0
    assert "Note: joint 'hinge' leads to link 'pin', which 'weld' holds" in capsys.readouterr().out


def test_the_command_asks_for_what_the_file_does_not_tell(machine, capsys):
    assert main(("report", str(machine))) == 2
    error = capsys.readouterr().err
    assert error.count("\n") == 1
    assert "does not say which joints are motors; give `actuated`, of: theta1, phi2" in error
    assert main(("report", str(machine), "--actuated", "theta1, phi9", "--tool", "pin")) == 2
    assert "unknown joint 'phi9'; did you mean 'phi2'" in capsys.readouterr().err
