"""The table of mechanisms: its numbers, and the README in step with it."""

from __future__ import annotations

import re
import shutil
from pathlib import Path

import mechanisms
import numpy as np
import pytest

import pmjac_pin as pj
from pmjac_pin.files import catalog, catalogue_numbers
from pmjac_pin.files.catalogue_numbers import kept_numbers
from pmjac_pin.words.catalogue_table import catalogue_table, numbers_of, poses_table
from pmjac_pin.words.markdown import markdown_table

README = Path(__file__).parent.parent / "README.md"


def test_one_row_a_mechanism():
    table = catalogue_table([numbers_of(pj.load("planar_3rpr")), numbers_of(pj.load("serial_2r"))])
    header = [" ".join(cell.split()) for cell in table.header]
    assert header == ["name", "degrees of freedom", "motors", "loops (rows)", "rank", "what it is"]
    assert [row[:5] for row in table.rows] == [
        ("planar_3rpr", "3", "3", "3 (15)", "6"),
        ("serial_2r", "2", "2", "0", "0"),
    ]
    assert len(table.align) == len(table.header)


@pytest.mark.parametrize("name", mechanisms.CATALOGUE)
def test_the_rank_is_that_of_the_constraint_jacobian(name):
    mechanism = pj.load(name)
    [row] = catalogue_table([numbers_of(mechanism)]).rows
    constraint = mechanism.home.jacobian().constraint_jacobian
    assert int(row[4]) == (np.linalg.matrix_rank(constraint, tol=1e-9) if constraint.size else 0)
    assert int(row[1]) + int(row[4]) == mechanism.nv
    assert row[5] == mechanism.spec.description


def test_poses_by_name():
    rows = poses_table([numbers_of(pj.load("three_rps"))]).rows
    assert rows == (("three_rps", "home, lecture_a, lecture_b, view"),)


def test_what_is_kept_is_what_is_computed():
    """After a change of the catalogue: `make readme`."""
    computed = {name: numbers_of(pj.load(name)) for name in pj.list_mechanisms()}
    assert kept_numbers() == computed


def test_what_does_not_fit_its_files_is_not_used(tmp_path, monkeypatch):
    for folder in ("models", "urdf"):
        shutil.copytree(README.parent / folder, tmp_path / folder)
    monkeypatch.setattr(catalogue_numbers, "data_folder", lambda: tmp_path)
    monkeypatch.setattr(catalog, "data_folder", lambda: tmp_path)
    everything = set(kept_numbers())
    model, urdf = tmp_path / "models" / "five_bar.toml", tmp_path / "urdf" / "four_bar.urdf"
    model.write_text(model.read_text() + "\n# changed\n")
    urdf.write_text(urdf.read_text() + "\n")
    assert everything - set(kept_numbers()) == {"five_bar", "four_bar"}
    (tmp_path / "models" / "catalogue.json").write_text("{")
    assert kept_numbers() == {}


def test_the_readme_is_in_step():
    """After a change of the catalogue: `make readme`."""
    table = markdown_table(catalogue_table(kept_numbers().values()))
    found = re.findall(
        r"<!-- mechanisms -->\n\n(.*?)\n\n<!-- end of mechanisms -->", README.read_text(), re.DOTALL
    )
    assert found == [table]
