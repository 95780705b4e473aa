"""The command line: every option, every mistake, and nothing but one line when it goes wrong."""

from __future__ import annotations

import json
import math
import os
import re
from pathlib import Path

import mechanisms
import msgspec
import numpy as np
import pytest

import pmjac_pin as pj
from pmjac_pin.cli import main
from pmjac_pin.cli.running import app

COMMANDS = (
    "list",
    "report",
    "modes",
    "check",
    "plot",
    "demo",
    "convert",
    "sweep",
    "transmission",
    "follow",
    "reach",
    "workspace",
    "locus",
)
ROOT = Path(__file__).resolve().parent.parent
FOLD = ("report", "four_bar", "--set", "l1=3,l2=2.5,l3=2", "--at", "1.3715642395497258")


@pytest.fixture(autouse=True)
def plain_terminal(monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "80")
    for name in ("NO_COLOR", "FORCE_COLOR", "TTY_COMPATIBLE"):
        monkeypatch.delenv(name, raising=False)


@pytest.fixture
def run(capsys):
    """Run in this process; returns status, output, error output."""

    def run(*argv):
        status = main(argv)
        captured = capsys.readouterr()
        return status, captured.out, captured.err

    return run


@pytest.fixture
def shown(run):
    """Run what must succeed; returns its output."""

    def shown(*argv):
        status, out, err = run(*argv)
        assert (status, err) == (0, "")
        return out

    return shown


@pytest.fixture
def reported(shown):
    """Run a report that must succeed; returns what its JSON says."""

    def refuse(token):
        raise AssertionError(f"{token} is no JSON")

    return lambda *argv: json.loads(shown("report", *argv, "--json"), parse_constant=refuse)


def equals(report, key, expected):
    np.testing.assert_array_equal(report["matrices"][key]["values"], expected)


# --- what it shows ---------------------------------------------------------------------------


def test_alone_it_shows_its_help(shown):
    text = shown()
    assert text == shown("--help")
    for command in COMMANDS:
        assert re.search(rf"│ {command} +\w", text)


@pytest.mark.parametrize("command", COMMANDS)
def test_help_of_a_command(shown, command):
    text = shown(command, "--help")
    assert f"Usage: pmjac {command}" in text
    assert re.findall(r"^Example: pmjac (\w+)", text, re.MULTILINE) == [command]
    assert max(map(len, text.splitlines())) <= 80


def test_version(shown):
    assert re.fullmatch(r"pmjac (\d+\.\d+\S*|\(not installed.*\))\n", shown("--version"))


def test_list_as_json_has_the_numbers_of_the_table(shown):
    told = json.loads(shown("list", "--json"))
    assert list(told) == list(pj.list_mechanisms())
    delta = pj.load("delta")
    expected = (delta.mobility, delta.nv, len(delta.actuated), len(delta.spec.loops))
    keys = ("mobility", "freedoms", "motors", "loops")
    assert tuple(told["delta"][key] for key in keys) == expected
    assert told["three_rps"]["poses"] == list(pj.load("three_rps").poses)


def test_report_of_single_matrices(shown, run):
    text = shown("report", "five_bar", "--only", "J_eq,K")
    assert re.findall(r"^\w+$", text, re.MULTILINE) == ["J_eq", "K"]
    told = json.loads(shown("report", "five_bar", "--only", "J_eq", "--json"))
    np.testing.assert_array_equal(told["J_eq"]["values"], pj.load("five_bar").home.jacobian().J_eq)
    assert run("report", "five_bar", "--only", "J_eg") == (
        2,
        "",
        "pmjac: no matrix 'J_eg'; did you mean 'J_eq' or 'Jw_eq'?\n",
    )


def test_list_shows_the_catalogue(shown):
    text = shown("list")
    numbers, poses = text.split("\n\n")
    for name in pj.list_mechanisms():
        mechanism = pj.load(name)
        loops, rows = len(mechanism.spec.loops), len(mechanism.rows)
        row = [
            name,
            f"{mechanism.mobility}",
            f"{len(mechanism.actuated)}",
            rf"{loops} \({rows}\)" if loops else "0",
            f"{np.linalg.matrix_rank(mechanism.home.jacobian().constraint_jacobian, tol=1e-9)}",
            mechanism.spec.description.split()[0],
        ]
        assert re.search(rf"^{' +'.join(row)}", numbers, re.MULTILINE)
        assert set(mechanism.spec.description.split()) <= set(numbers.split())
        assert re.search(rf"^{name} +{mechanism.poses[0]}", poses, re.MULTILINE)
    assert max(map(len, text.splitlines())) <= 80


def test_report_without_options_shows_home(shown):
    text = shown("report", "four_bar")
    assert text.startswith("four_bar, pose home\n")
    for part in ("Parameters", "Joints", "Loop equations η", "K* = ", "[J_v]eq", "Singularity"):
        assert part in text


@pytest.mark.parametrize("columns", [80, 120])
@pytest.mark.parametrize("name", mechanisms.mostly_slow(mechanisms.CATALOGUE))
def test_reports_fit_the_terminal(monkeypatch, shown, name, columns):
    monkeypatch.setenv("COLUMNS", str(columns))
    text = shown("report", name)
    assert max(map(len, text.splitlines())) <= columns
    assert "\x1b" not in text


def test_json_equals_the_python_interface(reported):
    report = reported("three_rps_ss")
    configuration = pj.load("three_rps_ss").home
    for key in ("K", "K_star", "Jv", "Jw_star", "passive_rates", "Jv_eq", "Jw_eq", "gw_eq"):
        equals(report, key, getattr(configuration.jacobian(), key))


def test_from_shows_a_pose(reported):
    report = reported("three_rps", "--from", "lecture_b")
    equals(report, "Jv_eq", pj.load("three_rps").pose("lecture_b").jacobian().Jv_eq)
    assert (report["pose"], report["start"]) == ("lecture_b", None)


def test_at_walks_from_home(reported):
    report = reported("three_rps", "--at", "1,1.1,0.95")
    configuration = pj.load("three_rps").close([1.0, 1.1, 0.95])
    equals(report, "Jv_eq", configuration.jacobian().Jv_eq)
    assert report["iterations"] == configuration.iterations
    assert (report["pose"], report["start"]) == (None, "home")


def test_at_and_from_walk_from_that_pose(reported):
    report = reported("three_rps_ss", "--at", "0.5,1,1.9", "--from", "lecture_b")
    configuration = pj.load("three_rps_ss").close([0.5, 1.0, 1.9], guess="lecture_b")
    equals(report, "Jv_eq", configuration.jacobian().Jv_eq)
    assert (report["pose"], report["start"]) == (None, "lecture_b")


@pytest.mark.parametrize("at", [("--at", "-0.5,1"), ("--at=-0.5,1",), ("--at", "-.5, 1")])
def test_negative_values(reported, at):
    report = reported("serial_2r", *at)
    assert [joint["value"] for joint in report["joints"]] == pytest.approx([-0.5, 1.0], abs=1e-15)


@pytest.mark.parametrize("frame", ["LOCAL", "WORLD", "LOCAL_WORLD_ALIGNED", "world"])
def test_frame(reported, frame):
    report = reported("three_rps", "--frame", frame, "--from", "lecture_a")
    jacobian = pj.load("three_rps").pose("lecture_a").jacobian(frame.upper())
    equals(report, "Jv_eq", jacobian.Jv_eq)
    assert report["frame"] == frame.upper()


@pytest.mark.parametrize(
    "settings",
    [
        ("--set", "l1=1.2,l2=3.1"),
        ("--set", "l1=1.2", "--set", "l2=3.1"),
        ("--set=l1=1.2, l2 =3.1",),
    ],
)
def test_set(reported, settings):
    report = reported("four_bar", "--at", "1", *settings)
    mechanism = pj.load("four_bar", {"l1": 1.2, "l2": 3.1})
    equals(report, "Jv_eq", mechanism.close([1.0]).jacobian().Jv_eq)
    assert [entry["value"] for entry in report["parameters"]] == [4.0, 1.2, 3.1, 3.5]


def test_titles_say_where_it_is(shown):
    text = shown("report", "three_rps_ss", "--at", "0.5,1,1.9", "--from", "lecture_b")
    assert text.startswith("three_rps_ss at l1 = 0.5 m, l2 = 1 m, l3 = 1.9 m\n")
    assert "Reached from the pose 'lecture_b'. The tool's twist is in the frame" in text


def test_a_singular_pose_is_no_error(shown, reported):
    text = shown(*FOLD)
    assert "J_eq does not exist here: K* has rank 1 here and 2 in general" in text
    assert re.search(r"^kind +gain$", text, re.MULTILINE)
    assert "phi2 [rad/s]   -0.8000" in text
    report = reported(*FOLD[1:])
    assert report["matrices"]["Jv_eq"] is None
    assert report["singularity"]["free_motions"][0].keys() == {"phi1", "phi2"}


@pytest.mark.parametrize("columns", [80, 120])
@pytest.mark.parametrize("name", mechanisms.mostly_slow(mechanisms.CATALOGUE))
def test_checks_fit_the_terminal(monkeypatch, shown, name, columns):
    monkeypatch.setenv("COLUMNS", str(columns))
    text = shown("check", name)
    assert text.startswith(f"{name}: ")
    assert max(map(len, text.splitlines())) <= columns
    assert "\x1b" not in text


def test_check_of_what_does_not_assemble_is_a_page_with_exit_status_1(run):
    status, out, err = run("check", "four_bar", "--set", "l1=100")
    assert (status, err) == (1, "")
    assert out.startswith("four_bar: 1 error, 1 note\n")
    assert max(map(len, out.splitlines())) <= 80
    status, out, err = run("check", "four_bar", "--set", "l1=100", "--json")
    assert (status, err) == (1, "")
    assert json.loads(out)["findings"][0]["code"] == "home-open"


def test_check_as_json_equals_the_python_interface(shown):
    written = shown("check", "four_bar", "--set", "l1=1.2", "--json")
    expected = pj.check("four_bar", parameters={"l1": 1.2})
    assert msgspec.json.decode(written, type=pj.Diagnosis) == expected


def test_a_model_file_of_ones_own_from_anywhere(monkeypatch, tmp_path, reported):
    folder = tmp_path / "my models"
    folder.mkdir()
    model = (ROOT / "models" / "four_bar.toml").read_text(encoding="utf-8")
    (folder / "mine.toml").write_text(model, encoding="utf-8")
    urdf = (ROOT / "urdf" / "four_bar.urdf").read_text(encoding="utf-8")
    (folder / "four_bar.urdf").write_text(urdf, encoding="utf-8")
    expected = pj.load("four_bar").home.jacobian().Jv_eq
    monkeypatch.chdir("/")
    report = reported(str(folder / "mine.toml"))
    equals(report, "Jv_eq", expected)
    assert report["mechanism"] == "mine"
    monkeypatch.chdir(folder)
    equals(reported("mine.toml"), "Jv_eq", expected)
    monkeypatch.chdir(tmp_path)
    equals(reported("my models/mine.toml"), "Jv_eq", expected)


def test_plot_writes_a_figure_and_prints_its_path(shown, tmp_path):
    path = tmp_path / ("a rather long name of a file " * 4 + ".png")
    options = ("--at", "1,1.1,0.95", "--set", "a=0.4", "--frame", "LOCAL")
    assert shown("plot", "three_rps", *options, "-o", str(path)) == f"{path}\n"
    assert path.read_bytes().startswith(b"\x89PNG")


@pytest.mark.parametrize(("suffix", "start"), [("pdf", b"%PDF"), ("svg", b"<?xml")])
def test_plot_formats(shown, tmp_path, suffix, start):
    assert shown("plot", "four_bar", "--output", f"figure.{suffix}") == f"figure.{suffix}\n"
    assert (tmp_path / f"figure.{suffix}").read_bytes().startswith(start)


@pytest.mark.parametrize(
    ("argv", "title", "subtitle"),
    [
        (("three_rps",), "three_rps, pose home", "l1 = 1 m, l2 = 1 m, l3 = 1 m"),
        (("four_bar", "--at", "1"), "four_bar at theta1 = 1 rad", "frame LOCAL_WORLD_ALIGNED"),
        (("ur5", "--at", "0.3,-1.2,1.4,-0.9,-1.2,0.25"), "ur5", "shoulder_lift_joint = -1.2 rad"),
    ],
)
def test_the_figure_says_mechanism_and_pose(monkeypatch, shown, argv, title, subtitle):
    titles = []

    def save(figure, path):
        titles.append(figure.get_suptitle())
        titles.extend(part.get_suptitle() for part in figure.subfigs)

    monkeypatch.setattr("pmjac_pin.pictures.pose_figure.save_figure", save)
    shown("plot", *argv, "-o", "figure.png")
    assert titles[0] == title
    assert subtitle in titles[1].replace("\xa0", " ")


def test_names_that_matplotlib_or_json_would_trip_over(shown, tmp_path):
    model = (ROOT / "models" / "serial_2r.toml").read_text(encoding="utf-8")
    model = model.replace("serial_2r.urdf", str(ROOT / "urdf" / "serial_2r.urdf"))
    for name in ("a$b$_{c.toml", os.fsdecode(b"\xff.toml")):
        path = tmp_path / name
        path.write_text(model, encoding="utf-8")
        assert json.loads(shown("report", str(path), "--json"))["mechanism"]
        assert shown("plot", str(path), "-o", "figure.png").strip() == "figure.png"


# --- mistakes ----------------------------------------------------------------------------------

MISTAKES = {
    "report fourr_bar": "unknown mechanism 'fourr_bar'; did you mean 'four_bar'?",
    "reprot four_bar": 'Unknown command "reprot". Did you mean "report"? '
    "Available commands: list, report, modes, check, plot, demo, view, convert, ...",
    "--nope": 'Unknown command "--nope". '
    "Available commands: list, report, modes, check, plot, demo, view, convert, ...",
    "report": 'Command "report" parameter MECHANISM requires an argument.',
    "report four_bar --frmae LOCAL": "Unknown option: --frmae. Did you mean --frame?",
    "report four_bar --no-json": "Unknown option: --no-json. Did you mean --json?",
    "report four_bar extra": "unexpected argument 'extra'",
    "check three_rsp": "unknown mechanism 'three_rsp'; did you mean 'three_rps' or 'three_rps_ss'?",
    "check four_bar --set l9=1": "unknown parameter 'l9'; there are: l0, l1, l2, l3",
    "check /none/here.toml": "/none/here.toml: No such file or directory",
    "list extra": "unexpected argument 'extra'",
    "report three_rps --at 1, 1.1, 0.9": "unexpected argument '1.1,' '0.9'; "
    "numbers are joined by commas, without blanks: --at 0.5,1,2",
    "report four_bar --at": 'Command "report" parameter --at requires an argument.',
    "report four_bar --at --json": 'Command "report" parameter --at requires an argument.',
    "report four_bar --at 1 --at 2": "Parameter --at specified multiple times.",
    "report four_bar --from hom": "unknown pose 'hom'; did you mean 'home'?",
    "report four_bar --at 1,2": "1 motor value (theta1) expected, got 2",
    "report four_bar --at one": "--at takes numbers joined by commas, such as 0.5,1,2; got 'one'",
    "report four_bar --at 1,": "--at takes numbers joined by commas, such as 0.5,1,2; got '1,'",
    "report four_bar --at nan": "motor values must be finite, got [nan]",
    "report four_bar --at 1e999": "motor values must be finite, got [inf]",
    "report three_rps --at 1,1,5": "motor 'l3' = 5 m is outside its limits [0.1, 3] m; "
    "--beyond-limits takes it all the same",
    "report four_bar --frame BASE": "frame must be LOCAL, WORLD or LOCAL_WORLD_ALIGNED, got 'BASE'",
    "report four_bar --set l9=1": "unknown parameter 'l9'; there are: l0, l1, l2, l3",
    "report four_bar --set l1": "--set takes NAME=NUMBER, such as l1=1.2; got 'l1'",
    "report four_bar --set l1=x": "--set takes NAME=NUMBER, such as l1=1.2; got 'l1=x'",
    "report four_bar --set l1=1 --set l1=1": "--set gives 'l1' twice",
    "report four_bar --set l1=0": "parameter 'l1' = 0 m is not within [0.001, 1e+06]",
    "report four_bar --set l1=nan": "parameter 'l1' = nan m is not within [0.001, 1e+06]",
    "report /none/here.toml": "/none/here.toml: No such file or directory",
    "plot four_bar": 'Command "plot" parameter --output requires an argument.',
    "plot four_bar -o /none/a.png": "/none/a.png: there is no folder /none",
    "plot four_bar -o /tmp": "/tmp: is a folder; give the name of a file in it",
    "demo -o /none/a.png": "/none/a.png: there is no folder /none",
}


@pytest.mark.parametrize(("line", "message"), MISTAKES.items(), ids=MISTAKES)
def test_mistakes_get_one_line(run, line, message):
    assert run(*line.split()) == (2, "", f"pmjac: {message}\n")


@pytest.mark.parametrize(
    ("argv", "pattern"),
    [
        (("report", "four_bar", "--set", "l1=100"), "four_bar: the pose 'home' does not assemble"),
        (("report", "three_rps", "--at", "2.9,0.15,0.15"), "three_rps: the straight path to the"),
        (("plot", "four_bar", "-o", "figure.nope"), "cannot save 'figure.nope': its suffix must"),
        (("plot", *FOLD[1:], "-o", "figure.png"), r"K\* has rank 1 here and 2 in general"),
        (("report", "a\nb"), r"unknown mechanism 'a\\nb'"),
        (("report", ""), "unknown mechanism ''"),
        (("report", "/proc/self/."), "/proc/self: there is no URDF in this folder"),
        (
            ("report", "three_rps_ss", "--set", "a=100"),
            "three_rps_ss: the pose 'home' closes where",
        ),
    ],
)
def test_longer_messages_are_one_line_too(run, argv, pattern):
    status, out, err = run(*argv)
    assert (status, out) == (2, "")
    assert re.fullmatch(rf"pmjac: {pattern}.*\n", err)


@pytest.mark.parametrize("content", [b"", b"actuated = [", b"\xff\xfe", b"x = 1\n", b"\0" * 99])
def test_broken_model_files(run, tmp_path, content):
    path = tmp_path / "broken.toml"
    path.write_bytes(content)
    for command in ("report", "check"):
        status, out, err = run(command, str(path))
        assert (status, out) == (2, "")
        assert re.fullmatch(rf"pmjac: {re.escape(str(path))}: .*\n", err)


def test_messages_of_several_lines_are_joined(monkeypatch, run):
    def fail(name, parameters, **options):
        raise pj.ModelFileError("first line\n  second line\n")

    monkeypatch.setattr("pmjac_pin.cli.options.load", fail)
    assert run("report", "four_bar") == (2, "", "pmjac: first line second line\n")


def test_a_full_disk_names_the_file_asked_for(monkeypatch, run):
    def fail(descriptor):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("os.fsync", fail)
    expected = "pmjac: figure.png: No space left on device\n"
    assert run("plot", "four_bar", "-o", "figure.png") == (2, "", expected)


def test_ctrl_c(monkeypatch, run):
    def interrupt(name, parameters, **options):
        raise KeyboardInterrupt

    monkeypatch.setattr("pmjac_pin.cli.options.load", interrupt)
    assert run("report", "four_bar") == (130, "", "")


def test_arguments_are_the_processs_own_by_default(monkeypatch, capsys):
    monkeypatch.setattr("signal.signal", lambda *_: None)  # this process goes on
    monkeypatch.setattr("sys.argv", ["pmjac", "report", "serial_2r"])
    assert main() == 0
    assert capsys.readouterr().out.startswith("serial_2r, pose home\n")


def test_without_error_output_nothing_happens(monkeypatch, run):
    monkeypatch.setattr("sys.stderr", None)
    assert main(["report", "nope"]) == 2


def test_the_entry_point_is_main():
    assert app.name == ("pmjac",)
    assert 'pmjac = "pmjac_pin.cli:main"' in (ROOT / "pyproject.toml").read_text(encoding="utf-8")


def test_the_fold_is_where_coupler_and_rocker_align():
    l0, l1, l2, l3 = mechanisms.NON_GRASHOF
    end = math.acos((l0**2 + l1**2 - (l2 + l3) ** 2) / (2 * l0 * l1))
    assert float(FOLD[-1]) == end


def test_joints_to_hold_and_a_tolerance(run, tmp_path):
    path = tmp_path / "arm.urdf"
    path.write_text(
        mechanisms.tree(
            ("a", "revolute", "ground", "one", (0, 0, 0), (0, 0, 1)),
            ("b", "revolute", "one", "two", (1, 0, 0), (0, 0, 1)),
            ("c", "revolute", "two", "three", (1, 0, 0), (0, 0, 1)),
        )
    )
    status, out, _ = run(
        "report", str(path), "--actuated", "a,b", "--tool", "three", "--locked", "c", "--json"
    )
    assert (status, json.loads(out)["dimensions"]["nv"]) == (0, 2)
    status, _, err = run("report", "four_bar", "--tolerance", "-1")
    assert status == 2
    assert "`tolerance` is a length above 0 m, got -1" in err
