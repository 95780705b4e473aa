"""`pmjac follow`: waypoints from files, what is told and written, and what an interrupt keeps."""

import csv
import json

import cuspidal
import numpy as np
import pytest
from mechanisms import loaded
from rich.progress import Progress

import pmjac_pin as pj
from pmjac_pin.cli import main
from pmjac_pin.studies.follow.waypoints_file import read_waypoints

CSV = "t,theta1\n0,0.9\n1,2.5\n3,4.0\n"
TOML = "[waypoints]\nt = [0, 1, 3]\ntheta1 = [0.9, 2.5, 4.0]\n"
SHORT = ["--set", "l0=4,l1=3,l2=2.5,l3=2"]  # a crank that cannot turn fully


@pytest.fixture
def way(tmp_path):
    path = tmp_path / "way.csv"
    path.write_text(CSV)
    return path


def run(*argv):
    return main(["follow", *map(str, argv)])


def test_both_formats_say_the_same(tmp_path, way, capsys):
    other = tmp_path / "way.toml"
    other.write_text(TOML)
    assert run("four_bar", "--waypoints", way, "--json") == 0
    first = capsys.readouterr().out
    assert run("four_bar", "--waypoints", other, "--json") == 0
    assert capsys.readouterr().out == first
    told = json.loads(first)
    direct = pj.follow(loaded("four_bar"), [[0.9], [2.5], [4.0]], times=[0, 1, 3])
    assert told["t"] == direct.t.tolist()
    assert told["passive"] == direct.passive.tolist()
    assert told["status"] == "end"


def test_a_stop_is_told_and_is_the_status(way, capsys):
    assert run("four_bar", "--waypoints", way, *SHORT) == 1
    told = capsys.readouterr().out
    assert "Events" in told
    assert "this assembly mode ends" in told
    assert "0.29472764971" in told


def test_a_proof_is_told(way, capsys):
    assert run("four_bar", "--waypoints", way, "--certified") == 0
    assert "proof: up to t = 3 each t has exactly one closed pose" in capsys.readouterr().out


def test_branches_are_passed_when_asked(way, capsys):
    lengths = ["--set", "l0=2,l1=1,l2=2,l3=1"]
    assert run("four_bar", "--waypoints", way, *lengths) == 1
    assert "two branches" in capsys.readouterr().out
    assert run("four_bar", "--waypoints", way, *lengths, "--pass", "--json") == 0
    told = json.loads(capsys.readouterr().out)
    [event] = told["events"]
    assert [branch["goes_on"] for branch in event["branches"]] == [True, False]
    assert np.array(told["passive"])[-1, 0] == pytest.approx(4.0)


def test_poses_are_written_and_nothing_is_replaced(way, tmp_path, capsys):
    out = tmp_path / "poses.csv"
    assert run("four_bar", "--waypoints", way, "--samples", 7, "-o", out) == 0
    rows = list(csv.DictReader(out.read_text().splitlines()))
    assert [float(row["t"]) for row in rows] == np.linspace(0.0, 3.0, 7).tolist()
    for row in rows:
        pose = loaded("four_bar").close([float(row["theta1"])])
        assert float(row["phi1"]) == pytest.approx(pose.joint_values["phi1"], abs=1e-9)
    capsys.readouterr()
    assert run("four_bar", "--waypoints", way, "-o", out) == 2
    assert "exists already" in capsys.readouterr().err
    assert run("four_bar", "--waypoints", way, "-o", tmp_path / "poses.json") == 0
    assert json.loads((tmp_path / "poses.json").read_text())["status"] == "end"


@pytest.mark.slow
def test_a_loop_about_a_cusp_ends_on_another_mode(tmp_path, capsys):
    """A polygon of motor values from a file, about the cusp of a machine from a file, proven."""
    turns = 5.1 + np.linspace(0.0, 2.0 * np.pi, 41)
    second, third = (
        centre + 0.3 * wave(turns)
        for centre, wave in zip(cuspidal.CUSP, (np.cos, np.sin), strict=True)
    )
    way = np.column_stack([np.full(turns.size, 17.0), second, third])
    way[-1] = way[0]
    np.savetxt(tmp_path / "loop.csv", way, "%.17g", ",", header="rho1,rho2,rho3", comments="")
    lengths, told = tuple(way[0].tolist()), []
    for k, angles in enumerate(cuspidal.solutions(lengths)):
        file = tmp_path / f"machine{k}.toml"
        pj.export(cuspidal.mechanism(angles, lengths), to="toml", file=file)
        status = run(file, "--waypoints", tmp_path / "loop.csv", "--certified")
        shown = " ".join(capsys.readouterr().out.split())
        assert ("this assembly mode ends" in shown) == (status == 1)
        assert "proof: up to t = " in shown
        told.append("ends on another assembly mode, met no singular pose: a cuspidal" in shown)
    assert told.count(True) == 1


@pytest.mark.parametrize("argument", [[], ["--json"], ["--certified"]])
def test_an_interrupt_keeps_what_is_done(way, tmp_path, capsys, monkeypatch, argument):
    seen, out = [], tmp_path / "poses.csv"

    def update(bar, task, *, completed, total):
        assert total == 3.0
        seen.append(completed)
        if completed > 1.0:
            raise KeyboardInterrupt

    monkeypatch.setattr(Progress, "update", update)
    assert run("four_bar", "--waypoints", way, "-o", out, *argument) == 130
    rows = list(csv.DictReader(out.read_text().splitlines()))
    assert float(rows[-1]["t"]) == seen[-1]
    told = capsys.readouterr().out
    assert "interrupted" in told
    assert (f"proof: up to t = {seen[-1]:.9g} " in told) == ("--certified" in argument)


@pytest.mark.parametrize(
    ("name", "text", "said"),
    [
        ("way.txt", CSV, "read from .csv or .toml"),
        ("way.csv", "", "the file is empty"),
        ("way.csv", "t,theta1\n0,0.9\n1\n", "row 3 has 1 values for 2 columns"),
        ("way.csv", "t,theta1\n0,fast\n", "row 2, column 'theta1': a number is wanted"),
        ("way.csv", "t,t\n0,1\n", "names each column once"),
        ("way.csv", "t,theta1\n0,nan\n1,2\n", "must be finite"),
        ("way.csv", 't,theta1\n0,"0.9\n', "not valid CSV"),
        ("way.csv", "t,theta9\n0,0.9\n1,2\n", "theta9"),
        ("way.csv", "t,theta1\n0,0.9\n", "two or more numbers"),
        ("way.toml", "[waypoint]\nt = [1]\n", "unknown key `waypoint`"),
        ("way.toml", "[waypoints\n", "not valid TOML"),
        ("way.toml", "[waypoints]\ntheta1 = [0.9, 'a']\n", "float"),
    ],
)
def test_what_is_no_file_of_waypoints_is_told(tmp_path, capsys, name, text, said):
    path = tmp_path / name
    path.write_text(text)
    assert run("four_bar", "--waypoints", path) == 2
    error = capsys.readouterr().err
    assert said in error
    assert error.count("\n") == 1


def test_columns_without_times(tmp_path):
    path = tmp_path / "way.csv"
    path.write_text("theta1, theta2\n1,2\n\n3,4\n")
    found = read_waypoints(path)
    assert found.times is None
    assert {name: values.tolist() for name, values in found.columns.items()} == {
        "theta1": [1.0, 3.0],
        "theta2": [2.0, 4.0],
    }


def test_what_cannot_be_written_is_told_first(way, capsys):
    assert run("four_bar", "--waypoints", way, "-o", "poses.npz") == 2
    assert "ends in one of .csv, .json" in capsys.readouterr().err
