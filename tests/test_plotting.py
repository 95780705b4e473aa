"""The ellipsoid's figure: what its panels say, and that saving never loses a file."""

import runpy
import stat
import sys

import matplotlib.image
import numpy as np
import pinocchio as pin
import pytest

import pmjac_pin as pj
from pmjac_pin.errors import ArgumentError, MissingDependencyError, OutputError
from pmjac_pin.pictures import plotting
from pmjac_pin.pictures.figures import save_figure
from pmjac_pin.pictures.plotting import plot_ellipsoid
from pmjac_pin.rates.ellipsoid import force_ellipsoid, velocity_ellipsoid

SHAPES = {
    "full": np.diag([2.0, 1.0, 0.5]),
    "almost flat": np.diag([1.0, 0.5, 1e-7]),
    "disc": np.array([[1, 0.3], [0.2, -0.8], [0.5, 0.4]]),
    "needle": np.array([[0.7], [-0.3], [0.1]]),
    "needle on an axis": np.array([[0.7], [0.0], [0.0]]),
    "ball": np.eye(3),
    "point": np.zeros((3, 2)),
    "huge": 1e300 * np.diag([2.0, 1.0, 0.5]),
    "tiny": 1e-320 * np.diag([2.0, 1.0, 0.5]),
}


@pytest.fixture
def figure():
    return plot_ellipsoid(velocity_ellipsoid(SHAPES["full"]), title="Robot, home", subtitle="l = 1")


def line(axes, label):
    return next(x for x in axes.get_lines() if x.get_label() == label).get_xydata()


def test_panels_are_named_and_labelled_with_units(figure):
    space, *panels = figure.axes
    assert figure.get_suptitle() == "Robot, home"
    assert [sub.get_suptitle() for sub in figure.subfigs] == ["l = 1"]
    assert space.get_title() == "Linear velocity of the tool, |motor rates| = 1"
    assert space.get_xlabel() == "$v_x$ [m/s]"
    assert space.get_ylabel() == "$v_y$ [m/s]"
    assert space.get_zlabel() == "$v_z$ [m/s]"
    assert [axes.get_title() for axes in panels] == ["Z–Y plane", "Z–X plane", "X–Y plane"]
    labels = [axes.get_xlabel() + axes.get_ylabel() for axes in panels]
    assert labels == [f"$v_{h}$ [m/s]$v_{v}$ [m/s]" for h, v in ("zy", "zx", "xy")]


def test_panels_have_equal_scales_and_limits(figure):
    space, *panels = figure.axes
    assert space.get_aspect() == "equal"
    assert space.get_zlim() == space.get_xlim() == space.get_ylim() == (-2.3, 2.3)
    for axes in panels:
        assert axes.get_aspect() == 1
        assert axes.get_xlim() == axes.get_ylim() == (-2.3, 2.3)


def test_principal_axes_show_their_values(figure):
    space, *_ = figure.axes
    assert [text.get_text() for text in space.texts] == ["2", "1", "0.5"]
    (legend,) = figure.legends
    assert [text.get_text() for text in legend.get_texts()] == [
        "section",
        "projection",
        "axis 1: 2 m/s",
        "axis 2: 1 m/s",
        "axis 3: 0.5 m/s",
    ]


@pytest.mark.parametrize("name", ["full", "ball"])
def test_outlines_are_those_of_the_ellipsoid(name):
    ellipsoid = velocity_ellipsoid(SHAPES[name])
    for axes, plane in zip(
        plot_ellipsoid(ellipsoid, title="").axes[1:], plotting.PLANES, strict=True
    ):
        np.testing.assert_array_equal(line(axes, "section"), ellipsoid.section(plane).points())
        np.testing.assert_array_equal(
            line(axes, "projection"), ellipsoid.projection(plane).points()
        )


def test_flat_outlines_run_from_end_to_end_once():
    figure = plot_ellipsoid(velocity_ellipsoid(SHAPES["needle on an axis"]), title="")
    shadow = line(figure.axes[3], "projection")
    assert shadow[0] == pytest.approx([0.7, 0])
    assert shadow[-1] == pytest.approx([-0.7, 0])
    assert (np.diff(shadow[:, 0]) < 0).all()


def test_sections_that_are_points_are_marked():
    figure = plot_ellipsoid(velocity_ellipsoid(SHAPES["needle on an axis"]), title="")
    marked = [[x.get_marker() for x in axes.get_lines()].count("o") for axes in figure.axes[1:]]
    assert marked == [1, 0, 0]  # the needle on the x axis crosses the Z–Y plane only


@pytest.mark.parametrize(
    ("unit", "label", "heading"),
    [
        ("rad/s", "$ω_x$ [rad/s]", "Angular velocity of the tool, |motor rates| = 1"),
        ("N", "$f_x$ [N]", "Force at the tool, |motor efforts| = 1"),
        ("furlong", "$v_x$ [furlong]", ""),
        ("", "$v_x$", ""),
    ],
)
def test_symbol_and_heading_follow_the_unit(unit, label, heading):
    space = plot_ellipsoid(velocity_ellipsoid(np.eye(3), unit), title="").axes[0]
    assert (space.get_xlabel(), space.get_title()) == (label, heading)


def test_symbol_and_heading_can_be_given():
    ellipsoid = velocity_ellipsoid(np.eye(3))
    space = plot_ellipsoid(ellipsoid, title="", symbol="p", quantity="Momentum").axes[0]
    assert (space.get_xlabel(), space.get_title()) == ("$p_x$ [m/s]", "Momentum")


@pytest.mark.parametrize(("scale", "power"), [(3e7, 6), (2e-13, -15), (4e-4, -6)])
def test_extreme_radii_move_into_the_unit(scale, power):
    figure = plot_ellipsoid(velocity_ellipsoid(scale * np.eye(3)), title="")
    assert figure.axes[1].get_xlabel() == f"$v_z$ [$10^{{{power}}}$ m/s]"
    assert figure.axes[0].texts[0].get_text() == f"{scale / 10.0**power:.4g}"
    assert figure.legends[0].get_texts()[2].get_text() == f"axis 1: {scale:.4g} m/s"


def test_flat_ellipsoids_are_not_seen_edge_on():
    # The usual line of sight lies in this disc.
    sight = np.array([np.sqrt(3) / 4, -0.75, 0.5])
    figure = plot_ellipsoid(
        velocity_ellipsoid(np.column_stack([sight, [0.5, np.sqrt(3) / 6, 0]])), title=""
    )
    azimuth, elevation = np.radians([figure.axes[0].azim, figure.axes[0].elev])
    horizontal = np.cos(elevation) * np.array([np.cos(azimuth), np.sin(azimuth)])
    normal = np.cross(sight, [np.sqrt(3) / 2, 0.5, 0])
    assert abs(normal @ [*horizontal, np.sin(elevation)]) > 0.25


@pytest.mark.slow
@pytest.mark.parametrize("name", SHAPES)
def test_every_shape_is_drawn_without_a_display_or_pyplot(monkeypatch, tmp_path, name):
    monkeypatch.delenv("DISPLAY", raising=False)
    monkeypatch.setitem(sys.modules, "matplotlib.pyplot", None)
    path = tmp_path / "figure.png"
    save_figure(plot_ellipsoid(velocity_ellipsoid(SHAPES[name]), title=name), path, dpi=40)
    assert path.read_bytes().startswith(b"\x89PNG\r\n")
    pixels = matplotlib.image.imread(path)[..., :3]
    assert pixels.shape[:2] == (352, 336)
    height, width = (size // 2 for size in pixels.shape[:2])
    for rows in (slice(0, height), slice(height, None)):
        for columns in (slice(0, width), slice(width, None)):
            assert pixels[rows, columns].std() > 0.02


@pytest.mark.parametrize("suffix", ["pdf", "svg", "PNG", "jpg"])
def test_other_formats(tmp_path, figure, suffix):
    path = tmp_path / f"figure.{suffix}"
    save_figure(figure, str(path), dpi=30)
    assert path.stat().st_size > 1000
    assert list(tmp_path.iterdir()) == [path]


def test_the_file_is_readable_by_others_as_any_new_file_is(tmp_path, figure):
    save_figure(figure, tmp_path / "figure.png", dpi=30)
    (tmp_path / "new").touch()
    modes = {stat.S_IMODE(path.stat().st_mode) for path in tmp_path.iterdir()}
    assert len(modes) == 1


def test_links_are_followed(tmp_path, figure):
    (tmp_path / "deep").mkdir()
    target, link = tmp_path / "deep" / "figure.png", tmp_path / "link.png"
    target.write_text("old")
    link.symlink_to(target)
    save_figure(figure, link, dpi=30)
    assert link.is_symlink()
    assert target.read_bytes().startswith(b"\x89PNG")


def test_a_failure_keeps_the_file_that_was_there(tmp_path, figure, monkeypatch):
    path = tmp_path / "figure.png"
    path.write_text("precious")

    def half_written(draft, **_):
        draft.write(b"rubbish")
        raise OSError("disk full")

    monkeypatch.setattr(figure, "savefig", half_written)
    with pytest.raises(OSError, match="disk full"):
        save_figure(figure, path)
    assert path.read_text() == "precious"
    assert list(tmp_path.iterdir()) == [path]


def refusal(call, *arguments, **keywords):
    with pytest.raises(ArgumentError) as caught:
        call(*arguments, **keywords)
    return str(caught.value)


def test_bad_targets_are_refused(tmp_path, figure):
    here = str(tmp_path.resolve())
    formats = ", ".join(f".{name}" for name in sorted(figure.canvas.get_supported_filetypes()))
    assert ".pdf, " in formats
    for name in (f"{here}/a.xyz", f"{here}/a", f"{here}/.png"):
        assert refusal(save_figure, figure, name) == (
            f"cannot save {name!r}: its suffix must be one of {formats}"
        )
    with pytest.raises(OutputError, match="there is no folder"):
        save_figure(figure, f"{here}/none/a.png")
    with pytest.raises(OutputError, match="is a folder; give the name of a file in it"):
        save_figure(figure, here)
    for dpi in (0, -1, 1e-320, 2401):
        assert refusal(save_figure, figure, f"{here}/a.png", dpi) == (
            f"dpi must be 1 to 2400; got {dpi}"
        )
    for dpi in (float("nan"), float("inf"), "many", 10**400, [300]):
        assert refusal(save_figure, figure, f"{here}/a.png", dpi).startswith("dpi must be ")
    assert not list(tmp_path.iterdir())


def test_what_cannot_be_drawn_is_refused():
    assert refusal(plot_ellipsoid, force_ellipsoid([[1.0], [0], [0]]), title="") == (
        "an unbounded ellipsoid cannot be drawn; got Ellipsoid(radii=[inf inf 1] N, rank=3): "
        "its infinite radii are the directions that the structure bears without motor effort"
    )
    assert refusal(plot_ellipsoid, np.eye(3), title="") == (
        "an Ellipsoid is needed, such as jacobian.velocity_ellipsoid(); got ndarray"
    )


def test_without_matplotlib_the_message_says_what_to_install(monkeypatch):
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    runpy.run_path(plotting.__file__)  # importing the module needs no matplotlib
    with pytest.raises(MissingDependencyError) as caught:
        plot_ellipsoid(velocity_ellipsoid(np.eye(3)), title="")
    assert str(caught.value).startswith(
        "plotting needs matplotlib: pip install 'pmjac_pin[plot]' ("
    )
    assert isinstance(caught.value, ImportError)


@pytest.mark.parametrize("kind", ["linear", "angular"])
@pytest.mark.parametrize("count", [1, 2])
def test_machines_of_fewer_than_three_points(count, kind):
    """One joint, and the tool at it or away: no plane is told by so few points."""
    model = pin.Model()
    joint = model.addJoint(0, pin.JointModelRZ(), pin.SE3.Identity(), "turn")
    place = pin.SE3(np.eye(3), np.array([count - 1.0, 0.0, 0.0]))
    model.addFrame(pin.Frame("tip", joint, 0, place, pin.FrameType.OP_FRAME))
    mechanism = pj.Mechanism.from_pinocchio(model, [], ["turn"], "tip")
    assert pj.plot(mechanism.home, kind) is not None
