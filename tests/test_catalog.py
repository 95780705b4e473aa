"""The catalogue: what comes with the library, and where files are looked for."""

from __future__ import annotations

import math

import mechanisms
import pytest

import pmjac_pin as pj


def test_the_catalogue_is_what_these_tests_cover():
    assert pj.list_mechanisms() == mechanisms.CATALOGUE


@pytest.mark.parametrize("name", mechanisms.CATALOGUE)
def test_every_mechanism_loads_with_all_its_poses(name):
    mechanism = pj.load(name)
    assert mechanism.name == name
    assert mechanism.spec.description
    for pose in mechanism.poses:
        configuration = mechanism.pose(pose)
        assert configuration.residual_norm < 1e-12
        assert configuration.singularity().kind == "regular"
        # The file's own joint values, not some other pose that the search ran to.
        given = mechanism.spec.poses[pose]
        for joint, value in configuration.joint_values.items():
            if not isinstance(value, tuple):
                assert value == pytest.approx(given.get(joint, value), abs=2e-4)


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("four_baar", "unknown mechanism 'four_baar'; did you mean 'four_bar'?"),
        ("xyz", f"unknown mechanism 'xyz'; there are: {', '.join(mechanisms.CATALOGUE[:3])}"),
        ("", "unknown mechanism ''; there are: "),
    ],
)
def test_unknown_names(name, message):
    with pytest.raises(pj.UnknownNameError) as caught:
        pj.load(name)
    assert str(caught.value).startswith(message)
    assert isinstance(caught.value, KeyError)


def test_a_file_with_no_suffix_is_pointed_out(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "robot").write_text("x")
    with pytest.raises(pj.UnknownNameError, match=r"write '\./robot'"):
        pj.load("robot")


def test_urdf_beside_the_model_file_or_in_the_folder_urdf(tmp_path):
    from pmjac_pin.files.catalog import find_model_file, find_urdf

    model = find_model_file("serial_2r")
    source = find_urdf("serial_2r.urdf", model).read_text()
    (tmp_path / "models").mkdir()
    (tmp_path / "urdf").mkdir()
    mine = tmp_path / "models" / "arm.toml"
    mine.write_text(model.read_text())
    (tmp_path / "urdf" / "serial_2r.urdf").write_text(source)
    assert find_urdf("serial_2r.urdf", mine).parent.name == "urdf"
    assert pj.load(mine).mobility == 2
    (tmp_path / "models" / "serial_2r.urdf").write_text(source.replace('"0.8 0 0"', '"0.5 0 0"'))
    assert find_urdf("serial_2r.urdf", mine).parent.name == "models"


def test_a_package_urdf_that_does_not_exist(tmp_path):
    path = tmp_path / "x.toml"
    path.write_text(
        'urdf = "example-robot-data:none.urdf"\nactuated = ["a"]\ntool.frame = "t"\n[poses.home]\n'
    )
    with pytest.raises(
        pj.ModelFileError, match=r"the URDF 'example-robot-data:none\.urdf' does not"
    ):
        pj.load(path)


@pytest.mark.slow
@pytest.mark.parametrize("a", [0.2, 0.5, 0.8])
@pytest.mark.parametrize("b", [0.45, 0.5, 0.7, 1.0, 1.3, 1.6])
def test_home_follows_the_parameters_alike_in_both_cuts(a, b):
    """Whatever the parameters: one machine, one home, motors where they were if that closes."""
    legs, platform = (
        pj.load(name, parameters={"a": a, "b": b}).home for name in ("three_rps_ss", "three_rps")
    )
    assert legs.actuated == pytest.approx(platform.actuated, abs=1e-3)
    assert legs.passive[:3] == pytest.approx(platform.passive[:3], abs=5e-3)
    if abs(b - a) < 1.0:
        assert legs.actuated == pytest.approx([1.0, 1.0, 1.0], abs=1e-12)
        assert legs.passive == pytest.approx([math.acos(b - a)] * 3, abs=1e-6)
    assert legs.singularity().smallest > 0.01


@pytest.mark.slow
def test_home_refuses_to_leave_the_motors_limits():
    with pytest.raises(pj.ClosureError, match=r"closes where 'l1' = .* is outside its limits"):
        pj.load("three_rps", parameters={"a": 1000.0})


def test_a_folder_of_that_name_is_hinted_at(tmp_path, monkeypatch):
    (tmp_path / "leg").mkdir()
    monkeypatch.chdir(tmp_path)
    with pytest.raises(pj.UnknownNameError, match=r"for the folder of this name write '\./leg'"):
        pj.load("leg")
