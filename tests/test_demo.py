"""The demonstration: the lecture's pose B, told honestly."""

from __future__ import annotations

import contextlib
import io
import re

import hand_derived
import matplotlib.image
import numpy as np
import pytest

from pmjac_pin.cli import main
from pmjac_pin.pictures.demo import FIGURE, PRINTED_DIRECTIONS, PRINTED_VELOCITIES, run_demo
from pmjac_pin.words.numbers import matrix_numbers
from pmjac_pin.words.tables import TITLES


@pytest.fixture(scope="module")
def demo(tmp_path_factory):
    return run_demo(tmp_path_factory.mktemp("demo") / "figure.png")


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("told")


@pytest.fixture(scope="module")
def told(folder):
    out, err = io.StringIO(), io.StringIO()
    with (
        pytest.MonkeyPatch.context() as patch,
        contextlib.redirect_stdout(out),
        contextlib.redirect_stderr(err),
    ):
        patch.chdir(folder)
        patch.setenv("COLUMNS", "80")
        assert main(["demo"]) == 0
    assert err.getvalue() == ""
    return out.getvalue()


def test_where_its_figure_cannot_be_written_all_else_is_told(told, capsys, monkeypatch, tmp_path):
    (tmp_path / FIGURE).mkdir()
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "80")
    assert main(["demo"]) == 0
    tables, _, last = capsys.readouterr().out.rpartition("\n\n")
    assert tables == told.rpartition("\n\n")[0]
    assert sentence(last).startswith(f"{FIGURE} was not written (")
    assert main(["demo", "-o", str(FIGURE)]) == 2


def sentence(text):
    return " ".join(text.split())


def test_it_prints_every_matrix_of_the_lecture(told, demo):
    for key in ("K", "K_star", "Jv", "Jv_star", "Jw", "Jw_star", "Jv_eq", "Jw_eq"):
        matrix = demo.report.matrices[key]
        body = told.split(f"{TITLES[key]}\n")[1].split("\n\n")[0]
        rows = [line.split()[-len(matrix.columns) :] for line in body.splitlines()[3:]]
        assert rows == matrix_numbers(matrix.values)


def test_both_triples_stand_side_by_side(told):
    assert (
        "The printed 0.3724, 0.3162, 0.2031 m/s do not follow from the lecture's own equations, "
        "which give 2.3429, 0.5645, 0.2980 m/s at this pose"
    ) in sentence(told)
    assert re.search(r"\[J_v\]eq \[m/s\] +2\.3429 +0\.5645 +0\.2980$", told, re.MULTILINE)
    for radius, direction in zip(PRINTED_VELOCITIES, PRINTED_DIRECTIONS, strict=True):
        row = " +".join(f"{x:.4f}" for x in (radius, *direction))
        assert re.search(rf"^\d +{row}$", told, re.MULTILINE)


def test_the_angles_are_the_lectures(told):
    for joint, angle in (("theta1", "0.4000"), ("theta2", "0.7535"), ("theta3", "0.2402")):
        assert re.search(rf"^{joint} +{angle} +{angle}$", told, re.MULTILINE)


def test_the_other_cut_gives_the_same_jacobian(told, demo):
    assert demo.linear_difference < 1e-10
    assert demo.angular_difference < 1e-10
    printed = re.search(r"above: (\S+) in \[J_v\]eq, (\S+) rad/m in \[J_ω\]eq", sentence(told))
    assert max(map(float, printed.groups())) < 1e-10
    assert re.search(r"^three_rps_ss +3 × 3 +3 × 3 +0\.5304 m⁶/rad³$", told, re.MULTILINE)
    assert re.search(r"^three_rps +9 × 3 +9 × 9 ", told, re.MULTILINE)


def test_the_figure_is_in_the_current_folder_and_not_blank(told, folder):
    assert told.splitlines()[-1] == str(FIGURE) == "three_rps_lecture_b.png"
    pixels = matplotlib.image.imread(folder / FIGURE)[..., :3]
    assert min(pixels.shape[:2]) >= 1000
    colored = np.ptp(pixels, axis=2) > 0.2
    quarters = [half for part in np.array_split(colored, 2) for half in np.array_split(part, 2, 1)]
    assert all(quarter.mean() > 0.002 for quarter in quarters)


def test_no_line_is_too_long(told):
    assert max(map(len, told.splitlines())) <= 80


def test_the_figure_may_have_another_name(capsys, tmp_path):
    path = tmp_path / "other.svg"
    assert main(["demo", "-o", str(path)]) == 0
    assert capsys.readouterr().out.splitlines()[-1] == str(path)
    assert "three_rps_ss, pose lecture_b" in path.read_text(encoding="utf-8")


def test_its_printed_numbers_are_the_lectures_and_its_own_the_formulas(demo):
    assert hand_derived.POSE_B_PRINTED_VELOCITIES == PRINTED_VELOCITIES
    assert hand_derived.POSE_B_PRINTED_DIRECTIONS == PRINTED_DIRECTIONS
    matrices, lengths = demo.report.matrices, hand_derived.POSE_B_L
    angles = [joint.value for joint in demo.report.joints if joint.role == "passive"]
    K = hand_derived.rps_K(lengths, angles)
    np.testing.assert_allclose(matrices["K"].values, K, atol=1e-10)
    np.testing.assert_allclose(
        matrices["K_star"].values, hand_derived.rps_K_star(lengths, angles), atol=1e-10
    )
    radii = demo.report.ellipsoids["velocity"].radii
    np.testing.assert_allclose(radii, hand_derived.POSE_B_VELOCITIES[0], atol=1e-4)
