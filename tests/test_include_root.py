"""Files that an MJCF includes from a folder above its own: below a root that is named."""

from __future__ import annotations

import mjcf_models
import numpy as np
import pytest

import pmjac_pin as pj
from pmjac_pin.cli import main

PART = '<any><body name="a"><joint name="j"/><geom size=".1"/></body></any>'


def robot(name):
    return f'<mujoco><worldbody><include file="{name}"/></worldbody></mujoco>'


@pytest.fixture
def tree(tmp_path):
    """A model in shop/robots/arm, parts in shop/parts, and what is none of its business above."""
    (tmp_path / "shop" / "robots" / "arm").mkdir(parents=True)
    (tmp_path / "shop" / "parts").mkdir()
    (tmp_path / "shop" / "parts" / "part.xml").write_text(PART)
    (tmp_path / "secret.xml").write_text(PART)
    (tmp_path / "shop" / "link.xml").symlink_to(tmp_path / "secret.xml")
    return tmp_path


def write(tree, name):
    path = tree / "shop" / "robots" / "arm" / "arm.xml"
    path.write_text(robot(name))
    return path


def load(path, **options):
    return pj.load(path, actuated=["j"], tool="a", **options)


def test_without_a_root_it_is_refused_and_the_refusal_names_the_option(tree):
    said = (
        r"part.xml'>: only files in or below the model's own folder are read; give .*include_root"
    )
    with pytest.raises(pj.ModelFileError, match=said):
        load(write(tree, "../../parts/part.xml"))


@pytest.mark.parametrize("name", ["../../parts/part.xml", "{}/parts/part.xml"])
def test_below_the_root_it_is_read(tree, name):
    shop = tree / "shop"
    mechanism = load(write(tree, name.format(shop)), include_root=shop)
    whole = tree / "whole.xml"
    whole.write_text(mjcf_models.mjcf(PART[5:-6]))
    np.testing.assert_array_equal(mechanism.home.jacobian().J_eq, load(whole).home.jacobian().J_eq)


@pytest.mark.parametrize("name", ["../../../secret.xml", "{}/secret.xml", "../../link.xml"])
def test_above_the_root_nothing_is_read(tree, name):
    path = write(tree, name.format(tree))
    with pytest.raises(pj.ModelFileError, match=r"only files in or below '.*shop', the include"):
        load(path, include_root=tree / "shop")


def test_what_an_attached_model_includes_is_held_to_the_same_root(tree):
    path = tree / "shop" / "robots" / "arm" / "arm.xml"
    model = '<asset><model name="m" file="../../parts/m.xml"/></asset>'
    path.write_text(
        f'<mujoco>{model}<worldbody><attach model="m" prefix="p"/></worldbody></mujoco>'
    )
    for name, fits in (("part.xml", True), ("../../secret.xml", False)):
        (tree / "shop" / "parts" / "m.xml").write_text(robot(name))
        if fits:
            assert pj.load(path, actuated=["pj"], tool="pa", include_root=tree / "shop")
            continue
        with pytest.raises(pj.ModelFileError, match="only files in or below"):
            pj.load(path, actuated=["pj"], tool="pa", include_root=tree / "shop")


@pytest.mark.parametrize("root", ["parts", "shop/parts", "nothing", "secret.xml"])
def test_a_root_that_does_not_hold_the_model_is_refused(tree, root):
    path = write(tree, "../../parts/part.xml")
    with pytest.raises(pj.ArgumentError, match="`include_root` is a folder that holds the model"):
        load(path, include_root=tree / root)


def test_other_formats_include_nothing(tree):
    with pytest.raises(pj.ArgumentError, match="`include_root` is of MJCF files"):
        pj.load("four_bar", include_root=tree)


def test_commands_take_it(tree, capsys):
    path = str(write(tree, "../../parts/part.xml"))
    given = ["--actuated", "j", "--tool", "a", "--include-root", str(tree / "shop")]
    assert main(["check", path, *given]) == 0
    assert main(["convert", path, "-o", str(tree / "arm.toml"), *given]) == 0
    assert pj.load(tree / "arm.toml").actuated == ("j",)
    assert main(["check", path, *given[:4]]) != 0
    assert "--include-root" in capsys.readouterr().err
