"""Poses that a file gives beyond the limits of the joints: refused, but for a switch."""

from __future__ import annotations

import pickle

import numpy as np
import pytest
from looped import joint, link, robot

import pmjac_pin as pj
from pmjac_pin.cli import main

BEYOND = "crank = 1.4\nrod = -1.9\nslide = 1.9\n"
LIMIT = '<limit lower="{}" upper="{}" effort="1" velocity="1"/>'
NAMES = pj.list_mechanisms()


def arm(loop_limits=(-4, 4)):
    """A slide that carries a hinge and, closed by a point, a link that follows."""
    return robot(
        *(link(name) for name in ("base", "crank", "rod", "slide", "tip", "end")),
        joint("crank", "revolute", "base", "crank", inside=LIMIT.format(-1, 1)),
        joint("rod", "revolute", "crank", "rod", (1, 0, 0), inside=LIMIT.format(-4, 4)),
        joint(
            "slide", "prismatic", "base", "slide", axis="1 0 0", inside=LIMIT.format(*loop_limits)
        ),
        joint("tip_fixed", "fixed", "rod", "tip", (2, 0, 0)),
        joint("end_fixed", "fixed", "slide", "end", (0, 0, 0)),
    )


@pytest.fixture
def model_file(tmp_path):
    def write(home="crank = 0.5\nrod = -0.7\nslide = 2.8\n", more="", limits=(-4, 4)):
        (tmp_path / "arm.urdf").write_text(arm(limits))
        path = tmp_path / "arm.toml"
        path.write_text(
            f'urdf = "arm.urdf"\nactuated = ["crank"]\ntool.frame = "end"\n{more}\n'
            f'[[loop]]\nkind = "point"\nframes = ["tip", "end"]\n[poses.home]\n{home}'
        )
        return path

    return write


def test_a_motor_beyond_its_limits(model_file):
    path = model_file(BEYOND)
    with pytest.raises(pj.ModelFileError, match=r"'crank' = 1.4 .*enforce_limits=False"):
        pj.load(path)
    mechanism = pj.load(path, enforce_limits=False)
    assert mechanism.home.actuated == pytest.approx([1.4])
    assert list(mechanism.home.limits_violated) == ["crank"]
    within = pj.load(model_file()).close([1.4], enforce_limits=False)
    np.testing.assert_allclose(mechanism.home.q, within.q, rtol=0, atol=1e-9)
    np.testing.assert_allclose(
        mechanism.home.jacobian().J_eq, within.jacobian().J_eq, rtol=0, atol=1e-9
    )


def test_a_pose_that_closes_only_beyond_limits(model_file):
    path = model_file(limits=(3.1, 4))
    with pytest.raises(pj.ClosureError, match=r"closes where 'slide'.*enforce_limits=False"):
        pj.load(path)
    home = pj.load(path, enforce_limits=False).home
    assert list(home.limits_violated) == ["slide"]


def test_a_file_may_say_so_itself_and_a_call_may_say_otherwise(model_file):
    path = model_file(BEYOND, "enforce_limits = false")
    assert list(pj.load(path).home.limits_violated) == ["crank"]
    with pytest.raises(pj.ModelFileError, match="outside its limits"):
        pj.load(path, enforce_limits=True)


def test_motors_are_refused_by_close_all_the_same(model_file):
    mechanism = pj.load(model_file(), enforce_limits=False)
    with pytest.raises(pj.LimitError, match=r"'crank' = 1\.4"):
        mechanism.close([1.4])


def test_it_stays_with_the_mechanism(model_file, tmp_path):
    path = model_file(BEYOND + "[poses.far]\ncrank = 2.0\nrod = -2.5\n")
    mechanism = pj.load(path, enforce_limits=False)
    assert list(mechanism.pose("far").limits_violated) == ["crank"]
    pj.convert(path, tmp_path / "mine.toml", enforce_limits=False)
    for other in (
        pickle.loads(pickle.dumps(mechanism)),
        mechanism.with_tool("tip"),
        pj.load(tmp_path / "mine.toml"),
    ):
        np.testing.assert_allclose(other.pose("far").q, mechanism.pose("far").q, atol=1e-9)


def test_a_joint_that_is_locked_beyond_its_limits(model_file):
    options = {"actuated": ["rod"], "locked": {"crank": 1.4}}
    with pytest.raises(pj.ModelFileError, match=r"cannot be locked at 1\.4.*enforce_limits=False"):
        pj.load(model_file("rod = -1.9\nslide = 1.9\n"), **options)
    path = model_file("rod = -1.9\nslide = 1.9\n")
    path.write_text(path.read_text().replace('frames = ["tip", "end"]', 'frames = ["rod", "base"]'))
    path.write_text(path.read_text().replace('kind = "point"', 'kind = "distance"\nlength = 1.0'))
    assert pj.load(path, **options, enforce_limits=False).spec.locked == {"crank": 1.4}


def test_a_pinocchio_model(model_file):
    model = pj.load(model_file()).model
    loops, home = [pj.PointLoop(frames=("tip", "end"))], {"crank": 1.4, "rod": -1.9, "slide": 1.9}
    with pytest.raises(pj.LimitError, match="enforce_limits=False"):
        pj.Mechanism.from_pinocchio(model, loops, ["crank"], "end", home=home)
    found = pj.Mechanism.from_pinocchio(
        model, loops, ["crank"], "end", home=home, enforce_limits=False
    )
    assert list(found.home.limits_violated) == ["crank"]


@pytest.mark.parametrize("name", NAMES)
def test_a_file_that_keeps_to_its_limits_means_the_same_pose_either_way(name):
    one, other = pj.load(name), pj.load(name, enforce_limits=False)
    np.testing.assert_array_equal(other.home.q, one.home.q)


def test_commands(model_file, capsys):
    path = str(model_file(BEYOND))
    assert main(["report", path]) == 2
    assert "[-1, 1] rad; --beyond-limits takes it all the same" in capsys.readouterr().err
    assert main(["report", path, "--beyond-limits"]) == 0
    assert "crank = 1.4 rad is outside its limits" in capsys.readouterr().out
    assert main(["report", path, "--beyond-limits", "--at", "1.2"]) == 0
    assert main(["modes", path, "--beyond-limits", "--at", "1.2"]) == 0
    assert main(["check", path, "--beyond-limits"]) == 0
    assert "closes where" in " ".join(capsys.readouterr().out.split())
