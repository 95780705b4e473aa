"""`pmjac workspace` and `pmjac locus`, and the figures that they draw."""

import json

import numpy as np
import pytest
from annuli import shared_area
from mechanisms import loaded

import pmjac_pin as pj
from pmjac_pin.cli import main

MAP = ["workspace", "five_bar", "--plane", "x,y", "--cells", "15"]
LOCUS = ["locus", "five_bar", "--plane", "theta1,theta2", "--cells", "15", "--kinds", "gain"]


@pytest.fixture(autouse=True)
def plain(monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "100")


def test_a_workspace_with_its_figure(tmp_path, capsys):
    assert main([*MAP, "--measure", "dexterity", "-o", "map.pdf"]) == 0
    shown = capsys.readouterr().out
    assert "Workspace of five_bar" in shown
    assert "dexterity, largest" in shown
    assert "map.pdf" in shown.split()
    assert (tmp_path / "map.pdf").read_bytes().startswith(b"%PDF")


def test_a_workspace_as_json(capsys):
    assert main([*MAP, "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    annuli = [((0.0, 0.0), 0.1, 0.7), ((0.3, 0.0), 0.1, 0.7)]
    assert told["area"] == pytest.approx(shared_area(annuli), rel=1e-7)
    assert told["plane"] == ["x", "y"]


def test_a_locus_with_its_figure(tmp_path, capsys):
    assert main([*LOCUS, "-o", "locus.svg"]) == 0
    shown = capsys.readouterr().out
    assert "gain (type II)" in shown
    assert "isolated point" in shown
    assert b"<svg" in (tmp_path / "locus.svg").read_bytes()


def test_a_locus_as_json_in_a_window(capsys):
    assert main([*LOCUS, "--json", "--window", "theta1=0:3,theta2=-3:3"]) == 0
    told = json.loads(capsys.readouterr().out)
    places = np.vstack([curve["places"] for curve in told["curves"]])
    assert (places >= [-1e-9, -3.0 - 1e-9]).all()
    assert (places <= 3.0 + 1e-9).all()


@pytest.mark.parametrize(
    ("words", "message"),
    [
        ([*MAP, "--window", "x=1"], "NAME=FROM:TO"),
        ([*MAP, "--window", "x=0:1,x=1:2"], "gives 'x' twice"),
        ([*MAP, "--measure", "beauty"], "beauty"),
        ([*MAP, "-o", "map.docx"], "suffix"),
        ([*LOCUS[:-2], "--kinds", "lost"], "kinds"),
        (["locus", "five_bar", "--plane", "theta1"], "two motors"),
        (["locus", "five_bar", "--plane", "theta1,theta9"], "theta9"),
        (["locus", "serial_2r", "--plane", "x,theta1"], "one of each"),
        (["workspace", "four_bar", "--plane", "x,y"], "mobility 1"),
    ],
)
def test_what_is_wrong_is_told_in_one_line(words, message, capsys):
    assert main(words) == 2
    shown = capsys.readouterr()
    assert not shown.out
    assert message in shown.err
    assert len(shown.err.splitlines()) == 1


def test_a_file_is_replaced_only_where_that_is_asked_for(tmp_path, capsys):
    (tmp_path / "map.svg").write_text("mine")
    assert main([*MAP, "-o", "map.svg"]) == 2
    assert "--force" in capsys.readouterr().err
    assert (tmp_path / "map.svg").read_text() == "mine"


def test_a_locus_is_drawn_on_the_workspace_of_its_plane():
    bar = loaded("five_bar")
    found = pj.workspace(bar, ("theta1", "theta2"), cells=15, measure="speed", trace=False)
    locus = pj.singularity_locus(bar, ("theta1", "theta2"), kinds=["gain"], cells=15)
    labels = pj.plot_workspace(found, locus).axes[0].get_legend_handles_labels()[1]
    assert "Type 2 (parallel) singularity" in labels
    with pytest.raises(pj.ArgumentError, match="the workspace of"):
        pj.plot_workspace(pj.workspace(bar, ("x", "y"), cells=15, trace=False), locus)
