"""Whatever is given: an answer, or an error of this library, short and on one line."""

from __future__ import annotations

import os
import resource
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import pmjac_pin as pj
from pmjac_pin.cli import main
from pmjac_pin.errors import enumerated, quoted, shortened
from pmjac_pin.files.catalog import find_model_file, find_urdf
from pmjac_pin.files.user_path import user_path
from pmjac_pin.pictures.figures import save_figure
from pmjac_pin.rates.ellipsoid import force_ellipsoid, velocity_ellipsoid

LONG = "x" * 1_000_000
LONGEST_MESSAGE = 700  # characters

NUMBERS = [0, -1, 10**400, 1e308, -1e308, float("nan"), float("inf"), 1e-320, np.float64(1e200), 1j]
TEXTS = [
    "",
    "~nosuch",
    "~nosuch/x.toml",
    "\ud800",
    "\ud800.toml",
    "x\0y",
    LONG,
    f"{LONG}.toml",
    f"{LONG}.png",
    "../" * 2000 + "x.toml",
    "a" * 300 + ".toml",
    "/" + "a/" * 3000,
    "/dev/full",
    "no\nlines",
]
OTHERS = [
    None,
    b"bytes",
    [],
    [[]],
    {},
    {"a": 1},
    {LONG: 1.0},
    set(),
    object(),
    Path(),
    Path("\ud800.toml"),
    Path("~nosuch"),
    [None],
    [LONG],
    ["\ud800"],
    [1e308],
    [1e-320],
    {"theta1": LONG},
    {"theta1": 1e308},
    {"phi1": [1, 2, 3]},
    {"l1": 1e308},
    {None: 1},
    np.array("x"),
    np.zeros((0, 3)),
    np.full((6, 3), 1e308),
    np.full((6, 1), 1e-320),
]
VALUES = [*NUMBERS, *TEXTS, *OTHERS]

FOUR_BAR = pj.load("four_bar")
HOME = FOUR_BAR.home
PLATFORM = pj.load("three_rps_ss")
ELLIPSOID = PLATFORM.home.jacobian().velocity_ellipsoid()
K, J = np.array([[-2.0, 1.0, -1.0], [1.0, 0.5, 2.0]]), np.ones((6, 3))
ENDS = ("coupler_tip", "rocker_tip")


def from_pinocchio(**changes):
    given = {"loops": [], "actuated": ["theta1"], "tool": "crank", **changes}
    return pj.Mechanism.from_pinocchio(given.pop("model", FOUR_BAR.model), **given)


def modes(**changes):
    return pj.assembly_modes(FOUR_BAR, **{"actuated": [1.0], "rng": 0, "proof": False, **changes})


def partition(**changes):
    given = {"constraint_jacobian": K, "tool_jacobian": J, "actuated": [0], "passive": [1, 2]}
    return pj.Partition.from_matrices(**{**given, **changes})


CALLS = {
    "load": pj.load,
    "parameters": lambda value: pj.load("four_bar", value),
    "a parameter": lambda value: pj.load("four_bar", {"l1": value}),
    "locked": lambda value: pj.load("four_bar", locked=value),
    "a locked joint": lambda value: pj.load("four_bar", locked=[value]),
    "a locked value": lambda value: pj.load("four_bar", locked={"phi1": value}),
    "actuated": lambda value: pj.load("four_bar", actuated=value),
    "an actuated joint": lambda value: pj.load("four_bar", actuated=[value]),
    "tool": lambda value: pj.load("four_bar", tool=value),
    "tolerance": lambda value: pj.load("four_bar", tolerance=value),
    "check": pj.check,
    "check's tool": lambda value: pj.check("serial_2r", tool=value),
    "pose": FOUR_BAR.pose,
    "moved": FOUR_BAR.moved,
    "limits": FOUR_BAR.limits,
    "recut": lambda value: pj.recut(FOUR_BAR, value),
    "close": FOUR_BAR.close,
    "a motor's value": lambda value: FOUR_BAR.close([value]),
    "guess": lambda value: FOUR_BAR.close([1.0], guess=value),
    "a guessed value": lambda value: FOUR_BAR.close([1.0], guess={"phi1": value}),
    "loop_equations": FOUR_BAR.loop_equations,
    "entries of q": lambda value: FOUR_BAR.loop_equations([value] * 3),
    "configuration": FOUR_BAR.configuration,
    "frame": HOME.jacobian,
    "frame of a split Jacobian": HOME.split_jacobian,
    "modes' motors": lambda value: modes(actuated=value),
    "modes' generator": lambda value: modes(rng=value),
    "modes' confidence": lambda value: modes(confidence=value),
    "a homotopy's mechanism": lambda value: pj.parameter_homotopy(value, rng=0),
    "section": ELLIPSOID.section,
    "projection": ELLIPSOID.projection,
    "points": lambda value: ELLIPSOID.points(4, value),
    "an outline's points": ELLIPSOID.section("xy").points,
    "velocity_ellipsoid": velocity_ellipsoid,
    "force_ellipsoid": force_ellipsoid,
    "rounding": lambda value: velocity_ellipsoid(J[:3], rounding=value),
    "a unit": lambda value: velocity_ellipsoid(J[:3], value),
    "a constraint Jacobian": lambda value: partition(constraint_jacobian=value),
    "a tool Jacobian": lambda value: partition(tool_jacobian=value),
    "columns": lambda value: partition(passive=value),
    "a length": lambda value: partition(length=value),
    "equivalent_jacobian": pj.equivalent_jacobian,
    "loop frames": lambda value: pj.PointLoop(frames=value),
    "a loop frame": lambda value: pj.PointLoop(frames=(value, "b")),
    "axis": lambda value: pj.RevoluteLoop(frames=ENDS, axis=value),
    "an axis' entry": lambda value: pj.RevoluteLoop(frames=ENDS, axis=(value, 0, 1)),
    "axes": lambda value: pj.UniversalLoop(frames=ENDS, axes=value),
    "length of a rod": lambda value: from_pinocchio(
        loops=[pj.DistanceLoop(frames=ENDS, length=value)]
    ),
    "geared joints": lambda value: pj.JointLoop(joints=value),
    "ratio": lambda value: from_pinocchio(
        loops=[pj.JointLoop(joints=("theta1", "phi1"), ratio=value)]
    ),
    "offset": lambda value: from_pinocchio(
        loops=[pj.JointLoop(joints=("theta1", "phi1"), offset=value)]
    ),
    "a model": lambda value: from_pinocchio(model=value),
    "loops": lambda value: from_pinocchio(loops=value),
    "a loop": lambda value: from_pinocchio(loops=[value]),
    "motors": lambda value: from_pinocchio(actuated=value),
    "a motor": lambda value: from_pinocchio(actuated=[value]),
    "a tool": lambda value: from_pinocchio(tool=value),
    "passive joints": lambda value: from_pinocchio(passive=value),
    "a home pose": lambda value: from_pinocchio(home=value),
    "a home value": lambda value: from_pinocchio(home={"phi1": value}),
    "a name": lambda value: from_pinocchio(name=value),
    "a tolerance": lambda value: from_pinocchio(tolerance=value),
    "view": lambda value: pj.view(value, open_browser=False, port=0),
    "port": lambda value: pj.view(HOME, open_browser=False, port=value).close(),
    "convert": lambda value: pj.convert(value, "x.toml", force=True),
    "convert's output": lambda value: pj.convert("serial_2r", value, force=True),
    "a path": user_path,
}


@pytest.mark.parametrize("call", CALLS.values(), ids=CALLS)
def test_an_answer_or_an_error_of_ours(call, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with np.errstate(all="ignore"):
        for value in VALUES:
            try:
                call(value)
            except pj.PmjacError as error:
                message = str(error)
                assert len(message) <= LONGEST_MESSAGE, message[:999]
                assert "\n" not in message


@pytest.mark.parametrize("path", [value for value in VALUES if isinstance(value, str)])
def test_figures_are_saved_or_refused(path, tmp_path, monkeypatch):
    figure = pytest.importorskip("matplotlib.figure").Figure()
    monkeypatch.chdir(tmp_path)
    with pytest.raises(pj.PmjacError) as caught:
        save_figure(figure, path)
    assert len(str(caught.value)) <= LONGEST_MESSAGE


OPTIONS = {
    "report": ("--at", "--from", "--set", "--frame", "--tool", "--actuated", "--locked"),
    "check": ("--tolerance", "--tool", "--set"),
    "modes": ("--at", "--seed", "--unseen"),
    "plot": ("--frame",),
    "view": ("--port",),
    "convert": ("-o",),
}
OUTPUT = {"plot": ["-o", "x.png"]}
TOKENS = [
    "",
    "~nosuch",
    "~nosuch/x.toml",
    "\ud800",
    "x" * 100_000,
    "1e308",
    "1e-320",
    "nan",
    "9" * 400,
]


@pytest.mark.parametrize(
    ("command", "option"), [(name, option) for name, some in OPTIONS.items() for option in some]
)
def test_options_get_an_answer_or_one_line(command, option, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("pmjac_pin.viewer.serving.serve_until_interrupted", lambda *_, **__: None)
    for token in TOKENS:
        status = main([command, "serial_2r", f"{option}={token}", *OUTPUT.get(command, [])])
        error = capsys.readouterr().err
        assert status in (0, 1, 2)
        assert len(error) <= LONGEST_MESSAGE
        assert error.count("\n") == (status == 2)


@pytest.mark.parametrize("command", OPTIONS)
@pytest.mark.parametrize("name", TOKENS)
def test_names_get_one_line(command, name, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert main([command, name, *(["-o", "x.png"] if command in ("plot", "convert") else [])]) == 2
    error = capsys.readouterr().err
    assert len(error) <= LONGEST_MESSAGE
    assert error.count("\n") == 1


# --- files -------------------------------------------------------------------------------------


def test_links_in_a_circle(tmp_path):
    one, other = tmp_path / "one.toml", tmp_path / "other.toml"
    one.symlink_to(other)
    other.symlink_to(one)
    with pytest.raises(pj.ModelFileError, match="Too many levels of symbolic links"):
        pj.load(one)
    with pytest.raises(pj.PmjacError):
        pj.convert(one, tmp_path / "x.toml")
    with pytest.raises(pj.OutputError, match="a link in a circle"):
        pj.convert("serial_2r", one, force=True)


def test_links_in_a_circle_beside_a_file_and_in_it(tmp_path):
    circle = tmp_path / "circle.urdf"
    circle.symlink_to(circle)
    model_file = tmp_path / "x.toml"
    text = find_model_file("four_bar").read_text()
    for urdf in ("circle.urdf", "~nosuch/x.urdf", "x" * 5000, "a/" * 5000, "\\u0000"):
        model_file.write_text(text.replace("four_bar.urdf", urdf))
        with pytest.raises(pj.ModelFileError) as caught:
            pj.load(model_file)
        assert str(caught.value).startswith(f"{model_file}: ")
        assert len(str(caught.value)) < 2 * LONGEST_MESSAGE  # two places are named
    robot = tmp_path / "robot.urdf"
    robot.write_bytes(find_urdf("four_bar.urdf", find_model_file("four_bar")).read_bytes())
    (tmp_path / "robot.yaml").symlink_to(tmp_path / "robot.yaml")
    assert pj.load(robot, tool="crank").actuated == ("theta1", "phi2", "phi1")


@pytest.mark.parametrize("name", ["x" * 300, "a/" * 5000, "~nosuch"])
def test_includes(tmp_path, name):
    path = tmp_path / "x.xml"
    path.write_text(f'<mujoco><include file="{name}"/></mujoco>')
    with pytest.raises(pj.ModelFileError) as caught:
        pj.load(path)
    assert len(str(caught.value)) <= LONGEST_MESSAGE


def test_lone_surrogates_in_yaml(tmp_path):
    urdf = find_urdf("four_bar.urdf", find_model_file("four_bar")).read_bytes()
    (tmp_path / "robot.urdf").write_bytes(urdf)
    for text in (
        'closed_loop: [["\\ud800", b]]\nname_mot: [theta1]\n',
        'closed_loop: []\nname_mot: ["\\ud800"]\n',
        'closed_loop: []\n"\\ud800": 1\n',
    ):
        (tmp_path / "robot.yaml").write_text(text)
        with pytest.raises(pj.ModelFileError, match="a lone surrogate in it is no character"):
            pj.load(tmp_path / "robot.urdf", tool="crank")


def test_a_name_that_is_no_text(tmp_path, capsys):
    """Names of files are bytes; what they name can be shown and written all the same."""
    text = find_model_file("four_bar").read_text()
    path = tmp_path / os.fsdecode(b"x\xff.toml")
    path.write_text(text)
    (tmp_path / "four_bar.urdf").write_bytes(
        find_urdf("four_bar.urdf", find_model_file("four_bar")).read_bytes()
    )
    assert pj.load(path).name == "x\N{REPLACEMENT CHARACTER}"
    for command in (["report", "--json"], ["check"], ["plot", "-o", str(tmp_path / "x.png")]):
        assert main([command[0], str(path), *command[1:]]) == 0
    capsys.readouterr()
    with pytest.raises(pj.OutputError, match="UTF-8"):
        pj.convert("four_bar", tmp_path / os.fsdecode(b"y\xff.toml"))


@pytest.mark.parametrize("number", ["1e-320", "1e-160", "1e160", "1e308"])
def test_numbers_that_are_not_of_this_world(tmp_path, number):
    """A rod's length, a joint's value, a gear's ratio: the message says which is out of range."""
    text = find_model_file("three_rps_ss").read_text()
    urdf = find_urdf("three_rps_ss.urdf", find_model_file("three_rps_ss"))
    (tmp_path / "three_rps_ss.urdf").write_bytes(urdf.read_bytes())
    path = tmp_path / "x.toml"
    rods = text.replace("a = 1.7320508075688772", f"a = {number}", 1)
    gear = f'\n[[loop]]\nkind = "joint"\njoints = ["l1", "l2"]\nratio = {number}\n'
    for changed, what in ((rods, "length"), (text + gear, "`ratio`")):
        path.write_text(changed)
        with pytest.raises(pj.ModelFileError, match=rf"{what}.*1e"):
            pj.load(path)
    if number.startswith("1e-"):
        return
    with pytest.raises(pj.ArgumentError, match=r"must be of magnitude 1e\+09 or less"):
        FOUR_BAR.close([0.9], guess={"theta1": float(number)})


# --- without descriptors -----------------------------------------------------------------------


def _descriptors():
    return sorted(path.name for path in Path("/proc/self/fd").iterdir())


@pytest.mark.parametrize("spare", range(0, 12, 2))
def test_a_viewer_without_file_descriptors(spare):
    """However many are left: it starts, or says why not, and leaves none open."""
    pj.view(HOME, open_browser=False, port=0).close()  # imports what it needs
    before = resource.getrlimit(resource.RLIMIT_NOFILE)
    used = _descriptors()
    descriptors = [os.open(os.devnull, os.O_RDONLY) for _ in range(40)]
    resource.setrlimit(resource.RLIMIT_NOFILE, (max(descriptors) + 1, before[1]))
    try:
        for descriptor in descriptors[len(descriptors) - spare :]:
            os.close(descriptor)
        del descriptors[len(descriptors) - spare :]
        try:
            pj.view(HOME, open_browser=False, port=0).close()
        except pj.PmjacError as error:
            assert "Too many open files" in str(error)
    finally:
        resource.setrlimit(resource.RLIMIT_NOFILE, before)
        for descriptor in descriptors:
            os.close(descriptor)
    assert _descriptors() == used


def test_a_viewer_that_was_not_imported_before_there_were_no_file_descriptors():
    code = (
        "import os, resource, pmjac_pin as pj\n"
        "home = pj.load('serial_2r').home\n"
        "used = max(int(name) for name in os.listdir('/proc/self/fd'))\n"
        "resource.setrlimit(resource.RLIMIT_NOFILE, (used, used))\n"
        "try: pj.view(home)\n"
        "except pj.PmjacError as error: print(error)\n"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout == "pmjac_pin.view cannot be imported: Too many open files\n"


# --- quoting -----------------------------------------------------------------------------------


class Unspeakable:
    def __repr__(self):
        raise RuntimeError


def test_what_is_quoted_is_short():
    for value in (LONG, [LONG] * 9, {LONG: LONG}, 10**5000, np.zeros(10**6), [[[LONG]]], VALUES):
        assert len(quoted(value)) <= 200
        assert "\n" not in quoted(value)
    assert quoted(Unspeakable()).startswith("<Unspeakable instance at")
    assert quoted("theta1") == "'theta1'"
    assert shortened("a\nb") == "a b"
    assert enumerated([LONG] * 99).endswith(" more")
    assert len(enumerated([LONG] * 99)) < LONGEST_MESSAGE
