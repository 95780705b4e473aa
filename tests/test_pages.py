"""Values that show themselves: as text where they are printed, as HTML in notebooks."""

from __future__ import annotations

import xml.etree.ElementTree as ET

import numpy as np
import pytest
from mechanisms import CATALOGUE, loaded

import pmjac_pin as pj

ONES = [name for name in CATALOGUE if name not in {"stewart_gough_dietmaier", "delta", "ur5"}]


def parsed(html):
    """Return the page as a tree: each tag is closed."""
    return ET.fromstring(f"<page>{html.replace('<br>', '<br/>')}</page>")


@pytest.mark.parametrize("name", ONES)
def test_every_page_is_html(name):
    home = loaded(name).home
    report = pj.report(home)
    for value in (home, report, report.table("K_star"), pj.check(home.mechanism)):
        page = parsed(value._repr_html_())
        assert page.findall(".//table") or page.findall(".//p")
        for table in page.iter("table"):
            assert len({len(row) for row in table.iter("tr")}) <= 1


@pytest.mark.parametrize("name", ONES)
def test_a_table_has_the_numbers_of_the_jacobian(name):
    home = loaded(name).home
    report, jacobian = pj.report(home), home.jacobian()
    for which, expected in (("J_eq", jacobian.J_eq), ("K", jacobian.K), ("Jv", jacobian.Jv)):
        table = report.table(which)
        np.testing.assert_array_equal(np.array(table.values).reshape(expected.shape), expected)
        assert table.columns == home.mechanism.actuated
    assert len(report.table("J_eq").latex().splitlines()) == 9  # a head, six rows, and two ends


def test_a_table_as_data_frame():
    pytest.importorskip("pandas")
    home = loaded("three_rps").pose("lecture_b")
    frame = pj.report(home).table("Jv_eq").dataframe()
    assert list(frame.columns) == ["l1 [m/s]", "l2 [m/s]", "l3 [m/s]"]
    assert list(frame.index) == ["v_x [m/s]", "v_y [m/s]", "v_z [m/s]"]
    np.testing.assert_array_equal(frame.to_numpy(), home.jacobian().Jv_eq)


def test_names_in_latex_are_text():
    home = loaded("four_bar").home
    lines = pj.report(home).table("K").latex().splitlines()
    assert r"\text{theta1}" in lines[1]
    assert lines[2].startswith(r"\text{coupler\_tip-rocker\_tip x} & ")


def test_what_is_no_table_is_told():
    report = pj.report(loaded("five_bar").home)
    with pytest.raises(pj.UnknownNameError, match="no matrix 'J_eg'; did you mean 'J_eq'"):
        report.table("J_eg")


def test_a_table_that_does_not_exist_at_a_singularity():
    with pytest.raises(pj.ClosureError) as found:
        pj.load("four_bar", {"l0": 4.0, "l1": 3.0, "l2": 2.5, "l3": 2.0}).close([1.5])
    report = pj.report(found.value.reached)
    assert report.refusal
    with pytest.raises(pj.NoJacobianError, match="J_eq does not exist here"):
        report.table("J_eq")
    assert "J_eq does not exist here" in found.value.reached._repr_html_()


def test_a_diagnosis_and_a_report_print_as_their_pages():
    five_bar = loaded("five_bar")
    page = str(pj.check(five_bar))
    assert page.startswith("five_bar: 3 notes\n")
    assert "Degrees of freedom\n" in page
    assert repr(pj.check(five_bar)) == page
    assert "Equivalent Jacobian\n" in str(pj.report(five_bar.home))
    assert all(len(line) <= 100 and line == line.rstrip() for line in page.splitlines())


def test_assembly_modes_show_what_they_rest_on():
    five_bar = loaded("five_bar")
    modes = pj.assembly_modes(five_bar, five_bar.home.actuated, rng=0)
    page = parsed(modes._repr_html_())
    assert page.find("h3").text == "2 assembly modes"
    assert "rests on" in page.find("p").text
    none = pj.assembly_modes(loaded("three_rps"), [0.1, 3.0, 0.1], rng=0)
    assert parsed(none._repr_html_()).find("h3").text == "0 assembly modes"


def test_markup_in_names_is_text():
    model = loaded("five_bar").model.copy()
    loops = [pj.PointLoop(frames=("tip", "tip2"))]
    made = pj.Mechanism.from_pinocchio(
        model, loops, ["theta1", "theta2"], "tip", home=loaded("five_bar").home.q, name="<b>&"
    )
    assert "&lt;b&gt;&amp;" in pj.report(made.home)._repr_html_()
    parsed(pj.report(made.home)._repr_html_())


def test_dir_has_the_public_names_only():
    assert [name for name in dir(pj) if name.startswith("_")] == [
        "__doc__", "__file__", "__name__", "__path__",
    ]  # fmt: skip
    assert {"load", "report", "plot", "stewart", "delta"} <= set(dir(pj))
