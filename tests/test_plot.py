"""The machine beside its ellipsoid: which panels there are, and what is refused."""

from __future__ import annotations

import io

import numpy as np
import pytest
from mechanisms import loaded

import pmjac_pin as pj

ALL = ["Z–Y plane", "Z–X plane", "X–Y plane"]


def titles(figure):
    return [axes.get_title() for axes in figure.axes if axes.get_title()]


@pytest.mark.parametrize("name", ["four_bar", "five_bar", "planar_3rrr", "watt_six_bar"])
def test_planar_machines_have_one_panel_beside_them(name):
    home = loaded(name).home
    figure = pj.plot(home)
    assert titles(figure) == ["X–Y plane"]
    assert len(figure.axes) == 2


@pytest.mark.parametrize("name", ["three_rps", "sarrus", "agile_eye", "ur5"])
@pytest.mark.parametrize("quantity", ["linear", "angular"])
def test_others_are_seen_in_space_and_in_three_planes(name, quantity):
    figure = pj.plot(loaded(name).home, quantity)
    assert titles(figure) == ALL
    assert len(figure.axes) == 5


@pytest.mark.parametrize("planes", ["xy", ["zx"], ["xy", "zy"], ["zy", "zx", "xy"]])
def test_planes_are_those_asked_for(planes):
    figure = pj.plot(loaded("three_rps").pose("lecture_b"), planes=planes)
    wanted = [planes] if isinstance(planes, str) else planes
    assert titles(figure) == [f"{'–'.join(plane.upper())} plane" for plane in wanted]


def test_size_and_picture():
    figure = pj.plot(loaded("five_bar").home, size=(5.0, 3.0))
    assert figure.get_size_inches().tolist() == [5.0, 3.0]
    assert figure._repr_png_().startswith(b"\x89PNG")
    drawn = io.BytesIO()
    figure.savefig(drawn, format="svg")
    assert b"<svg" in drawn.getvalue()


def test_force_in_newtons_and_its_words():
    figure = pj.plot(loaded("three_rps").pose("lecture_b"), "force")
    assert any("f_x" in axes.get_xlabel() and "N" in axes.get_xlabel() for axes in figure.axes)


@pytest.mark.parametrize(
    ("keywords", "said"),
    [
        ({"quantity": "lin"}, "did you mean 'linear'"),
        ({"quantity": None}, "there are: linear, angular, force"),
        ({"planes": ["xz"]}, "planes are some of zy, zx, xy, each once"),
        ({"planes": ["xy", "xy"]}, "each once"),
        ({"planes": []}, "each once"),
        ({"planes": 3}, "each once, got 3"),
        ({"size": (0, 1)}, "1 to 100 inches"),
        ({"size": (5, 5, 5)}, "1 to 100 inches"),
        ({"frame": "tool"}, "frame must be"),
    ],
)
def test_what_cannot_be_drawn(keywords, said):
    with pytest.raises(pj.ArgumentError, match=said):
        pj.plot(loaded("five_bar").home, **keywords)


def test_only_poses_are_drawn():
    with pytest.raises(pj.ArgumentError, match="a Configuration is wanted, got Mechanism"):
        pj.plot(loaded("five_bar"))


@pytest.mark.parametrize(
    ("name", "planes"), [("five_bar", ["zx"]), ("five_bar", ["xy", "zx"]), ("four_bar", None)]
)
def test_an_unbounded_ellipsoid_is_refused(name, planes):
    with pytest.raises(pj.ArgumentError, match="unbounded"):
        pj.plot(loaded(name).home, "force", planes=planes)


def lines(axes):
    return {line.get_label(): line.get_xydata() for line in axes.get_lines()}


@pytest.mark.parametrize("quantity", ["linear", "force"])
@pytest.mark.parametrize("name", ["five_bar", "three_rps", "stewart_gough", "sarrus", "ur5"])
def test_the_polytope_is_drawn_and_the_ellipsoid_is_inscribed_in_it(name, quantity, rng):
    """By supports: uᵀv ≤ Σ |uᵀ Jᵢ| limitᵢ of all that is drawn, and the outline reaches it."""
    home = loaded(name).home
    block = home.jacobian().Jv_eq
    limits = rng.uniform(0.5, 2.0, block.shape[1])
    figure = pj.plot(home, quantity, limits=limits, planes=["zy", "zx", "xy"])
    for axes, plane in zip(figure.axes[2:], ("zy", "zx", "xy"), strict=True):
        assert axes.get_title() == f"{'–'.join(plane.upper())} plane"
        drawn, rows = lines(axes), ["xyz".index(letter) for letter in plane]
        for angle in rng.uniform(0, 7, 12):
            way = np.array([np.cos(angle), np.sin(angle)])
            outer = (drawn["polytope, projection"] @ way).max()
            assert (drawn["projection"] @ way).max() <= outer * (1 + 1e-9) + 1e-12
            if quantity == "linear":
                most = np.abs(way @ block[rows]) @ limits
                assert outer == pytest.approx(most, abs=1e-9 * limits.max())


def test_limits_are_those_of_the_model_or_said_to_be_none():
    home = loaded("five_bar").home
    given, stated = (pj.plot(home, limits=limits).axes[1] for limits in ([10.0, 10.0], "model"))
    for label, drawn in lines(given).items():
        if "polytope" in label:
            np.testing.assert_array_equal(drawn, lines(stated)[label])
    arm = loaded("serial_2r")
    model = arm.model
    model.upperVelocityLimit = model.lowerVelocityLimit = np.array([0.0, 7.0])
    free = pj.Mechanism.from_pinocchio(model, [], arm.actuated, arm.spec.tool.names[0])
    with pytest.raises(pj.ArgumentError, match="the model states no rate limit of theta1"):
        pj.plot(free.close([0.3, 0.9]), limits="model")
    with pytest.raises(pj.ArgumentError, match="motor limits are numbers or 'model', got 'file'"):
        pj.plot(home, limits="file")
    with pytest.raises(pj.ArgumentError, match="2 numbers expected"):
        pj.plot(home, limits=[1.0])


def test_forces_of_a_planar_machine_are_bounded_where_it_moves():
    figure = pj.plot(loaded("five_bar").home, "force", limits="model")
    assert titles(figure) == ["X–Y plane"]


@pytest.mark.parametrize("name", ["five_bar", "planar_3rrr"])
@pytest.mark.parametrize("planes", [None, ["xy"]])
def test_forces_of_a_planar_machine_are_those_in_its_plane(name, planes):
    """|J_vᵀ f| = 1 on the outline; across the plane the structure bears any force."""
    home = loaded(name).home
    figure = pj.plot(home, "force", planes=planes)
    [panel] = [axes for axes in figure.axes if axes.get_title() == "X–Y plane"]
    assert len(figure.axes) == 2
    [outline] = [line for line in panel.lines if line.get_label() == "section"]
    efforts = outline.get_xydata() @ home.jacobian().Jv_eq[:2]
    np.testing.assert_allclose(np.linalg.norm(efforts, axis=1), 1.0, atol=1e-9)
