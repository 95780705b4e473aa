"""The command ``pmjac modes``: tables, JSON, the picture, and one line when it goes wrong."""

from __future__ import annotations

import json

import pytest

import pmjac_pin as pj
from pmjac_pin.cli import main


@pytest.fixture
def run(capsys, monkeypatch, tmp_path):
    """Run in this process; returns status, output, error output."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "80")

    def run(*argv):
        status = main(("modes", *argv))
        captured = capsys.readouterr()
        return status, captured.out, captured.err

    return run


def test_the_lectures_eight(run):
    status, out, err = run("three_rps_ss", "--from", "lecture_a")
    assert (status, err) == (0, "")
    assert "8 assembly modes within the limits of the joints." in out
    assert out.count("lecture_a") == 1
    assert "That there are no more rests on proof: exactly 8" in out
    assert [out.lower().count(word) for word in ("exactly", "rests on", "complete")] == [1, 1, 0]
    assert max(map(len, out.splitlines())) <= 80


def test_json_equals_the_python_interface(run):
    status, out, _ = run("four_bar", "--at", "0.9", "--seed", "4", "--json")
    found, modes = json.loads(out), pj.assembly_modes(pj.load("four_bar"), [0.9], rng=4)
    assert status == 0
    assert [mode["q"] for mode in found["modes"]] == [mode.q.tolist() for mode in modes]
    assert found["limits"] is True


def test_without_motor_values_those_of_home(run):
    _, out, _ = run("four_bar", "--json")
    [named] = [mode for mode in json.loads(out)["modes"] if mode["poses"]]
    assert named["poses"] == ["home"]


def test_options_reach_the_search(run):
    _, out, _ = run(
        "four_bar", "--set", "l1=1.2", "--no-limits", "--unseen", "0.2", "--no-proof", "--json"
    )
    found = json.loads(out)
    assert {parameter["name"]: parameter["value"] for parameter in found["parameters"]}["l1"] == 1.2
    assert (found["limits"], found["starts"]) == (False, 2560)
    _, out, _ = run("four_bar", "--most-starts", "1", "--confidence", "0.9", "--no-proof", "--json")
    evidence = json.loads(out)["evidence"]
    assert (evidence["kind"], evidence["confidence"]) == ("nothing", 0.9)


def test_all_complex_solutions(run):
    status, out, _ = run("four_bar", "--homotopy", "--no-proof", "--most-starts", "1")
    assert status == 0
    assert "That there are no more rests on tolerance: of 2 paths of complex solutions" in out
    text = " ".join(out.split())
    assert "there are 2 solutions; 2 real, limits left aside; 2 proven to be there." in text
    assert "operation" not in out.lower()


@pytest.mark.slow
def test_operation_modes(run):
    argv = ("four_bar", "--set", "l0=3,l1=1,l2=3,l3=1", "--operation-modes")
    status, out, _ = run(*argv)
    assert status == 0
    assert "at almost all motor values they have: 1, 1 (tolerance" in " ".join(out.split())
    _, out, _ = run(*argv, "--json")
    found = json.loads(out)
    assert found["solutions"]["operation_modes"] == [1, 1]
    assert sorted(mode["operation_mode"] for mode in found["modes"]) == [1, 2]


@pytest.mark.parametrize("json_too", [(), ("--json",)])
def test_the_picture(run, tmp_path, json_too):
    status, out, _ = run("four_bar", "-o", "modes.png", *json_too)
    assert status == 0
    assert (tmp_path / "modes.png").read_bytes().startswith(b"\x89PNG")
    assert json.loads(out) if json_too else out.endswith("\nmodes.png\n")


@pytest.mark.parametrize(
    ("argv", "message"),
    [
        (("three_rps", "--at", "1,1"), "3 motor values (l1, l2, l3) expected, got 2"),
        (("three_rps", "--at", "1,1,9"), "motor 'l3' = 9 m is outside its limits [0.1, 3] m"),
        (("four_bar", "--at", "1", "--from", "home"), "--at and --from both give motor values"),
        (("four_bar", "--from", "hom"), "did you mean 'home'"),
        (("four_bar", "--unseen", "2"), "unseen is a share between 0 and 1, got 2.0"),
        (("four_bar", "--seed", "-1"), "rng is a numpy Generator or a whole number ≥ 0, got -1"),
        (("four_bar", "-o", "modes.xyz"), "its suffix must be one of"),
        (
            ("four_bar", "--set", "l1=3,l2=2.5,l3=2", "--at", "2.5", "-o", "modes.png"),
            "there are no assembly modes to draw",
        ),
    ],
)
def test_mistakes(run, tmp_path, argv, message):
    status, out, err = run(*argv)
    assert (status, out) == (2, "")
    assert message in err
    assert len(err.splitlines()) == 1
    assert list(tmp_path.iterdir()) == []
