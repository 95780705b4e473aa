"""Values that show themselves: as text where they are printed, as HTML in notebooks."""

from __future__ import annotations

import pickle
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
    jacobian = home.jacobian()
    for value in (
        home,
        report,
        report.table("K_star"),
        pj.check(home.mechanism),
        home.mechanism,
        jacobian,
        home.split_jacobian(),
        home.allowed_jacobian(),
        jacobian.velocity_ellipsoid(),
        home.singularity(),
    ):
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


@pytest.mark.parametrize("name", ONES)
def test_a_jacobian_has_its_tables_itself(name):
    """The same as the report's: names and units are the mechanism's."""
    home = loaded(name).home
    report, jacobian = pj.report(home), home.jacobian()
    for which in ("J_eq", *report.matrices):
        assert jacobian.table(which) == report.table(which)
    for which in ("K", "K_star", "Jv", "Jv_star", "Jw", "Jw_star"):
        assert home.split_jacobian().table(which) == report.table(which)


@pytest.mark.parametrize("frame", ["LOCAL", "WORLD"])
def test_a_table_is_of_its_own_frame_and_tool(frame):
    jacobian = loaded("three_rps").pose("lecture_b").jacobian(frame, tool="leg1_rod")
    table = pickle.loads(pickle.dumps(jacobian)).table("J_eq")
    np.testing.assert_array_equal(np.array(table.values), jacobian.J_eq)
    assert table.row_units == ("m/s",) * 3 + ("rad/s",) * 3


def test_a_table_of_motors_that_are_tied():
    tied = pj.load("four_bar", actuated=["theta1", "phi1"]).home.allowed_jacobian()
    table = tied.table("J_eq")
    assert table.columns == tied.leading
    np.testing.assert_array_equal(np.array(table.values), tied.J_eq)
    rates = tied.table("motor_rates")
    assert rates.rows == ("theta1", "phi1")
    np.testing.assert_array_equal(np.array(rates.values), tied.motor_rates)
    assert "rates of all motors by those that lead" in tied._repr_html_()


def test_a_report_of_motors_that_are_tied_has_the_rates_that_fit():
    tied = pj.load("four_bar", actuated=["theta1", "phi1"])
    report = pj.report(tied.home)
    assert report.allowed.leading == ("theta1",)
    np.testing.assert_array_equal(report.allowed.J_eq, tied.home.allowed_jacobian().J_eq)
    assert "led by theta1" in str(report)
    assert "rates of all motors by those that lead" in str(report)


@pytest.mark.parametrize("name", ["four_bar", "three_rps"])
def test_a_report_of_free_motors_has_no_rates_that_fit(name):
    report = pj.report(loaded(name).home)
    assert report.allowed is None
    assert "led by" not in str(report)


def test_matrices_from_elsewhere_have_no_tables_and_say_so():
    C, J = np.array([[-2.0, 1.0, -1.0], [1.0, 0.5, 2.0]]), np.ones((6, 3))
    partition = pj.Partition.from_matrices(C, J, [0], [1, 2])
    split = pj.SplitJacobian(C, J, "LOCAL_WORLD_ALIGNED", partition)
    with pytest.raises(pj.ArgumentError, match="no names and units"):
        pj.equivalent_jacobian(split).table("J_eq")
    assert "matrices from elsewhere" in parsed(split._repr_html_()).find("p").text


@pytest.mark.parametrize("name", ["J_eg", "j_eq", "", "Jv_eqq"])
def test_a_matrix_that_a_jacobian_does_not_have(name):
    home = loaded("five_bar").home
    with pytest.raises(pj.UnknownNameError, match=r"did you mean 'J|there are: J_eq, K,"):
        home.jacobian().table(name)
    with pytest.raises(pj.UnknownNameError, match="no matrix 'J_eq'"):
        home.split_jacobian().table("J_eq")


def cells(value):
    return [cell.text for cell in parsed(value._repr_html_()).iter("td")]


def test_a_mechanism_shows_its_joints_parameters_and_loops():
    shown = cells(loaded("three_rps"))
    assert shown[:6] == ["l1", "actuated", "0.1000", "3.0000", "1.0000", "m"]
    assert {"platform.rx", "platform circumradius, from its middle to the spherical joints"} <= {
        *shown
    }
    assert shown[-3:] == ["S3 – leg3_rod", "point", "3"]


def test_an_ellipsoid_shows_its_axes():
    ellipsoid = loaded("five_bar").home.jacobian().velocity_ellipsoid()
    shown = cells(ellipsoid)
    assert [float(radius) for radius in shown[1::5]] == pytest.approx(ellipsoid.radii, abs=5e-5)
    assert [float(x) for x in shown[2:5]] == pytest.approx(ellipsoid.axes[:, 0], abs=5e-5)


def test_a_singularity_shows_what_comes_free_with_its_units():
    """The slider-crank stretched, the piston held: r θ̇ + l (θ̇ + β̇) = 0."""
    machine = loaded("slider_crank")
    stretched = machine.driven_by(["x"]).configuration(machine.close([0.0]).q).singularity()
    assert stretched.passive_units == ("rad", "rad")
    shown = cells(stretched)
    assert shown[:2] == ["kind", "gain and loss"]  # the held piston is the tool
    crank, rod = (shown[shown.index(f"{name} [rad/s]") + 1] for name in ("theta", "beta"))
    assert float(rod) == 1.0
    assert float(crank) == pytest.approx(-0.9 / (0.3 + 0.9), abs=5e-5)


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


def test_working_modes_and_where_reach_came_to_show_their_motor_values():
    chain = loaded("serial_2r")
    target = chain.home.tool_pose().translation
    modes, reached = pj.working_modes(chain, target), pj.reach(chain, target)
    for value, poses in ((modes, list(modes)), (reached, [reached.configuration])):
        numbers = [pytest.approx(pose.actuated, abs=5e-5) for pose in poses]
        shown = cells(value)
        assert [
            list(map(float, shown[3 * k + 1 : 3 * k + 3])) for k in range(len(poses))
        ] == numbers
    far = pj.working_modes(chain, [10.0, 0.0, 0.0])
    assert parsed(far._repr_html_()).find("h3").text == "0 working modes"
