"""`pmjac transmission`, and the figure that it draws."""

from __future__ import annotations

import re

import numpy as np
import pytest
from transmission_machines import table_of

import pmjac_pin as pj
from pmjac_pin.cli import main
from pmjac_pin.values.brief import at_least, at_most

ANKLE = ["transmission", "humanoid_ankle", "--joints", "pitch,roll"]
OVER = ["--over", "pitch=-0.2:0.2,roll=-0.1:0.1"]
ROCKER = ["transmission", "four_bar", "--joints", "phi1", "--over", "phi1=2.2:2.4"]


def test_files_by_their_suffixes(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    outputs = [f"ankle.{suffix}" for suffix in ("h", "npz", "csv", "png")]
    assert main([*ANKLE, *OVER, *(word for name in outputs for word in ("-o", name))]) == 0
    shown = capsys.readouterr().out
    table = pj.transmission_table(
        pj.load("humanoid_ankle"), {"pitch": (-0.2, 0.2), "roll": (-0.1, 0.1)}
    )
    assert (tmp_path / "ankle.h").read_text() == table.c()
    with np.load(tmp_path / "ankle.npz") as saved:
        np.testing.assert_array_equal(saved["motor_values"], table.tabulated()["motor_values"])
    assert len((tmp_path / "ankle.csv").read_text().splitlines()) == 1 + 17 * 17
    assert (tmp_path / "ankle.png").read_bytes().startswith(b"\x89PNG")
    assert all(name in shown.split() for name in outputs)
    assert f"motor1 [rad]   {at_most(table.error[0])}" in shown
    assert "proof: all over pitch -0.2 to 0.2" in shown


def test_a_plugin_beside_its_header(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    words = [*ROCKER, "--points", "5", "--name", "bar", "-o", "plugin.cpp"]
    assert main(words) == 2
    assert "plugin.cpp includes a C header: add -o plugin.h" in capsys.readouterr().err
    assert main([*words, "-o", "rocker.h"]) == 0
    text = (tmp_path / "plugin.cpp").read_text()
    assert '#include "rocker.h"' in text
    assert "bar_at_joints(" in text
    assert "int bar_at_joints(" in (tmp_path / "rocker.h").read_text()


@pytest.mark.parametrize("machine", ["humanoid_ankle", "ankle"])
def test_where_nobody_says_it_the_rectangle_is_about_home(machine, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    command = ["transmission", machine, "--joints", "pitch,roll", "--no-proof", "-o", "ankle.h"]
    assert main(command) == 0
    shown = capsys.readouterr().out
    ends = re.search(r"pitch (\S+) to (\S+), roll (\S+) to (\S+); 17 by 17 points", shown)
    low, high, left, right = map(float, ends.groups())
    assert low < 0.0 < high
    assert left < -0.1
    assert right > 0.1
    assert "tolerance: an estimate" in " ".join(shown.split())
    assert (tmp_path / "ankle.h").read_text().count(f"{machine}_at_joints") == 2


def test_a_name_for_the_header_and_limits_of_the_motors(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert main([*ROCKER, "-o", "r.h", "--name", "rocker", "--limits", "2"]) == 0
    assert "int rocker_at_motors(" in (tmp_path / "r.h").read_text()
    first = capsys.readouterr().out
    assert main(ROCKER) == 0
    second = capsys.readouterr().out
    efforts = [
        float(re.search(r"effort of phi1 alone \[N m\]\s+(\S+)", shown)[1])
        for shown in (first, second)
    ]
    assert efforts[0] == pytest.approx(2.0 * efforts[1], rel=1e-2)


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--over", "pitch=-0.2:0.2"], "--over does not say where roll begins and ends"),
        (["--over", "pich=-0.2:0.2,roll=-0.1:0.1"], "did you mean 'pitch'"),
        (["--over", "pitch=-0.2,roll=-0.1:0.1"], "--over takes NAME=FROM:TO"),
        (["--over", "pitch=0.2:-0.2,roll=-0.1:0.1"], "the lower one first"),
        (["--over", "pitch=-1:1,roll=-0.1:0.1"], "the loops do not close.*it exists for pitch"),
        (["--joints", "pitch,rol"], "unknown joint 'rol'; did you mean 'roll'"),
        (["--joints", "pitch"], "as many joints as motors, 2, got 1"),
        (
            [*OVER, "-o", "ankle.txt"],
            r"ankle.txt: what is written ends in one of .h, .npz, .csv, .cpp, .png",
        ),
        ([*OVER, "-o", "nowhere/ankle.h"], "there is no folder"),
        ([*OVER, "-o", "mine.h"], "mine.h: exists already; --force replaces it"),
        ([*OVER, "-o", "mine.png"], "mine.png: exists already; --force replaces it"),
        ([*OVER, "-o", "a.h", "--name", "double"], "is a word of the language"),
        ([*OVER, "--limits", "1,a"], "--limits takes numbers"),
        ([*OVER, "--limits", "1,0"], "numbers above 0"),
        ([*OVER, "--limits", "1"], "2 numbers expected"),
        ([*OVER, "--points", "1"], "`points` is 2 to 200 along each joint"),
    ],
)
def test_what_is_wrong_is_told_in_one_line(words, message, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    for name in ("mine.h", "mine.png"):
        (tmp_path / name).write_text("mine")
    start = ANKLE[:2] if "--joints" in words else ANKLE
    assert main([*start, *words, "--no-proof"]) == 2
    told = capsys.readouterr()
    assert not told.out
    assert re.search(message, told.err)
    assert told.err.count("\n") == 1
    assert sorted(path.name for path in tmp_path.iterdir()) == ["mine.h", "mine.png"]
    assert (tmp_path / "mine.h").read_text() == "mine"


def test_files_are_replaced_where_that_is_asked_for(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for name in ("r.h", "r.png"):
        (tmp_path / name).write_text("old")
    assert main([*ROCKER, "-o", "r.h", "-o", "r.png", "--force"]) == 0
    assert (tmp_path / "r.h").read_text().startswith("/*")
    assert (tmp_path / "r.png").read_bytes().startswith(b"\x89PNG")


def test_a_figure_of_two_joints():
    table = table_of("humanoid_ankle")
    figure = pj.plot_transmission(table.map, [1.0, 2.0])
    titles = [axes.get_title() for axes in figure.axes if axes.get_title()]
    ratios = [f"{motor} by {joint}" for motor in table.motors for joint in table.joints]
    assert titles == ["Efforts within the limits", *ratios, "Condition"]
    line = figure.axes[0].get_lines()[table.map.status.size]
    corners = np.column_stack(line.get_data())[:-1]
    mesh = np.stack(np.meshgrid(*table.map.axes, indexing="ij"), axis=-1).reshape(-1, 2)
    nearest = mesh[np.linalg.norm(mesh, axis=1).argmin()]
    wanted = table.transmission.at_joints(nearest).effort_limits([1.0, 2.0]).vertices
    for corner in wanted:
        assert np.linalg.norm(corners - corner, axis=1).min() < 1e-9


def test_a_figure_of_one_joint():
    figure = pj.plot_transmission(table_of("four_bar").map, [1.0])
    assert [axes.get_title() for axes in figure.axes] == [
        "Gear ratio",
        "Largest effort",
        "Largest rate",
    ]


def test_a_figure_where_it_exists_in_part_and_nowhere():
    mechanism = pj.load("humanoid_ankle")
    part = pj.transmission_map(mechanism, {"pitch": (-0.8, 0.5), "roll": (-0.3, 0.3)}, 7)
    assert 0 < part.exists.sum() < part.exists.size
    assert len(pj.plot_transmission(part, [1.0, 1.0]).axes) == 11
    nowhere = pj.transmission_map(mechanism, {"pitch": (1.2, 1.3), "roll": (0.0, 0.1)}, 3)
    with pytest.raises(pj.ArgumentError, match="exists nowhere in the rectangle"):
        pj.plot_transmission(nowhere, [1.0, 1.0])


def test_bounds_are_rounded_away_from_what_they_bound(rng):
    for x in (*rng.normal(size=200) * 10.0 ** rng.uniform(-9, 9, 200), 0.0, 1.0, 9.99):
        assert float(at_least(x, 3)) <= x <= float(at_most(x, 3))
        assert float(at_most(x)) - float(at_least(x)) <= 0.11 * abs(x)
