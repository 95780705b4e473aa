"""The report: the Python interface's own numbers, with names and units, complete everywhere."""

from __future__ import annotations

import json
import math

import mechanisms
import numpy as np
import pytest
from mechanisms import loaded

import pmjac_pin as pj
from pmjac_pin.words.labelled import common_unit, metric_unit, powers_of, quotient, unit
from pmjac_pin.words.plain import to_json

MATRICES = ("K", "K_star", "Jv", "Jv_star", "Jw", "Jw_star")
EQUIVALENT = ("passive_rates", "Jv_eq", "Jw_eq", "gv_eq", "gw_eq")
FRAMES = ("LOCAL", "WORLD", "LOCAL_WORLD_ALIGNED")


def refuse(token):
    raise AssertionError(f"{token} is no JSON")


def strict(text):
    return json.loads(text, parse_constant=refuse)


def fold():
    """A four-bar where coupler and rocker align: the end of its crank's range."""
    l0, l1, l2, l3 = mechanisms.NON_GRASHOF
    end = math.acos((l0**2 + l1**2 - (l2 + l3) ** 2) / (2 * l0 * l1))
    return mechanisms.rocker_rocker().close([end])


@pytest.fixture(scope="module")
def homes():
    return {name: loaded(name).home for name in mechanisms.CATALOGUE}


@pytest.mark.parametrize("frame", FRAMES)
@pytest.mark.parametrize("name", mechanisms.CATALOGUE)
def test_json_gives_the_python_interface_back_bit_by_bit(homes, name, frame):
    configuration = homes[name]
    mechanism, jacobian = configuration.mechanism, configuration.jacobian(frame)
    report = strict(to_json(pj.report(configuration, frame, pose="home").told()))
    for key in MATRICES + EQUIVALENT:
        found, expected = report["matrices"][key], getattr(jacobian, key)
        shape = (len(found["rows"]), len(found["columns"]))
        assert shape == expected.shape
        np.testing.assert_array_equal(np.reshape(found["values"], shape), expected)
    assert (report["frame"], report["pose"], report["start"]) == (frame, "home", None)
    assert report["mechanism"] == name
    assert report["description"] == mechanism.spec.description
    values = {joint["name"]: joint["value"] for joint in report["joints"]}
    names = configuration.mechanism.actuated + configuration.mechanism.passive
    numbers = [*configuration.actuated, *configuration.passive]
    assert values == dict(zip(names, numbers, strict=True))
    assert tuple(row["name"] for row in report["residual"]) == mechanism.rows
    assert [row["value"] for row in report["residual"]] == configuration.residual.tolist()
    assert report["residual_norm"] == configuration.residual_norm
    assert report["iterations"] == configuration.iterations
    np.testing.assert_array_equal(report["tool"]["position"], configuration.tool_pose().translation)
    np.testing.assert_array_equal(report["tool"]["rotation"], configuration.tool_pose().rotation)
    assert report["refusal"] is None


@pytest.mark.parametrize("name", mechanisms.CATALOGUE)
def test_sizes_determinant_and_parameters(homes, name):
    configuration = homes[name]
    mechanism = configuration.mechanism
    report = strict(to_json(pj.report(configuration).told()))
    m = configuration.split_jacobian().rows.size
    assert report["dimensions"] == {
        "n": len(mechanism.actuated),
        "m_p": len(mechanism.passive),
        "p": len(mechanism.rows),
        "m": m,
        "mobility": mechanism.mobility,
        "nq": mechanism.nq,
        "nv": mechanism.nv,
    }
    assert report["det_K_star"]["value"] == configuration.split_jacobian().det_K_star
    parameters = {entry["name"]: entry["value"] for entry in report["parameters"]}
    assert parameters == dict(mechanism.parameters)
    for entry in report["parameters"]:
        declared = mechanism.spec.parameters[entry["name"]]
        assert entry["unit"] == declared.unit
        assert entry["meaning"] == declared.meaning
        assert entry["default"] == declared.default


def assert_margins_told(told, margins):
    """Numbers are those of the margins, what is infinite or not a number is null."""
    for kind in ("gain", "loss"):
        by_name = getattr(margins, kind)
        assert [one.pop("joint") for one in told[kind]] == list(by_name)
        for one, margin in zip(told[kind], by_name.values(), strict=True):
            numbers = {name: getattr(margin, name) for name in ("arm", "angle", "transmission")}
            assert one == {n: x if math.isfinite(x) else None for n, x in numbers.items()}
    assert told["tool"] == [
        {"motor": name, "value": one.value, "unit": one.unit} for name, one in margins.tool.items()
    ]


@pytest.mark.parametrize("name", mechanisms.CATALOGUE)
def test_singularity_and_singular_values(homes, name):
    configuration = homes[name]
    singularity, jacobian = configuration.singularity(), configuration.jacobian()
    report = strict(to_json(pj.report(configuration).told()))
    found = report["singularity"]
    for key, value in found.items():
        match key:
            case "characteristic_length":
                assert value == configuration.mechanism.characteristic_length
            case "singular_values":
                assert value == singularity.singular_values.tolist()
            case "tool_rows":
                assert value == list(configuration.mechanism.spec.tool.judged.names)
            case "tool_axes":
                assert value == configuration.mechanism.spec.tool.axes
            case "free_motions" | "idle_motions" | "forbidden_rates" | "types":
                assert value == []
            case "free_screws" | "lost_screws":
                assert value == []
            case "margins":
                assert_margins_told(value, singularity.margins)
            case "gosselin_angeles" | "constraint_singularity" | "architecture_singularity":
                assert value == getattr(singularity.types, key)
            case _:
                expected = getattr(singularity, key)
                assert value == (None if expected == math.inf else expected)
    values = {key: found["values"] for key, found in report["singular_values"].items()}
    for key in ("K_star", "Jv_eq", "Jw_eq"):
        matrix = getattr(jacobian, key)
        expected = np.linalg.svd(matrix, compute_uv=False) if matrix.size else []
        np.testing.assert_allclose(values[key], expected, rtol=1e-12, atol=1e-14)
    assert np.count_nonzero(values["Jv_eq"]) == jacobian.tool_ranks.linear
    assert np.count_nonzero(values["Jw_eq"]) == jacobian.tool_ranks.angular


@pytest.mark.parametrize("name", mechanisms.CATALOGUE)
def test_ellipsoids(homes, name):
    jacobian = homes[name].jacobian()
    report = strict(to_json(pj.report(homes[name]).told()))
    for key in ("velocity", "angular", "force"):
        expected = getattr(jacobian, f"{key}_ellipsoid")()
        found = report["ellipsoids"][key]
        radii = [math.inf if radius is None else radius for radius in found["radii"]]
        assert radii == expected.radii.tolist()
        assert found["directions"] == expected.axes.T.tolist()
        assert (found["unit"], found["rank"]) == (expected.unit, expected.rank)


def test_infinite_radii_are_null(homes):
    report = strict(to_json(pj.report(homes["four_bar"]).told()))
    assert report["ellipsoids"]["force"]["radii"][:2] == [None, None]


def test_json_is_ascii_and_keeps_its_keys(homes):
    text = to_json(pj.report(homes["three_rps_ss"]).told())
    assert text.isascii()
    assert list(strict(text)) == [
        "mechanism",
        "description",
        "notes",
        "parameters",
        "dimensions",
        "pose",
        "start",
        "frame",
        "joints",
        "limits_violated",
        "iterations",
        "residual",
        "residual_norm",
        "tool",
        "matrices",
        "det_K_star",
        "singular_values",
        "singularity",
        "ellipsoids",
        "refusal",
        "motion",
        "statics",
        "dynamics",
    ]
    assert strict(text)["residual"][0]["name"] == "S1-S2 distance²"


def test_a_singular_pose_is_reported_but_for_what_does_not_exist():
    configuration = fold()
    singularity, split = configuration.singularity(), configuration.split_jacobian()
    report = strict(to_json(pj.report(configuration).told()))
    for key in MATRICES:
        np.testing.assert_array_equal(report["matrices"][key]["values"], getattr(split, key))
    assert [report["matrices"][key] for key in EQUIVALENT] == [None] * 5
    assert report["ellipsoids"] == {"velocity": None, "angular": None, "force": None}
    assert report["singular_values"]["Jv_eq"] is report["singular_values"]["Jw_eq"] is None
    assert report["singular_values"]["K_star"]["values"][1] < 1e-6
    with pytest.raises(pj.SingularError) as caught:
        configuration.jacobian()
    assert report["refusal"] == str(caught.value)
    found = report["singularity"]
    assert (found["kind"], found["rank"], found["generic_rank"]) == ("gain", 1, 2)
    assert (found["gained"], found["idle"]) == (1, 0)
    [motion] = found["free_motions"]
    assert list(motion) == ["phi1", "phi2"]
    assert list(motion.values()) == singularity.free_motions[:, 0].tolist()
    [forbidden] = found["forbidden_rates"]
    assert forbidden == {"theta1": pytest.approx(1.0)}


def test_an_idle_motion_is_named():
    report = pj.report(mechanisms.rssr().home)
    assert report.refusal is None
    assert report.singularity.idle == 1
    found = report.told()["singularity"]
    assert found["free_motions"] == []
    [motion] = found["idle_motions"]
    assert set(motion) == {"psi", "rx", "ry", "rz"}
    assert report.det_K_star is None  # K* is 3 x 4


@pytest.mark.parametrize(
    ("mechanism", "error"),
    [
        (lambda: mechanisms.rssr("rod_side"), pj.IdleMotionError),
        (mechanisms.over_actuated_four_bar, pj.ForbiddenRatesError),
    ],
)
def test_other_refusals_are_reported_too(mechanism, error):
    configuration = mechanism().home
    with pytest.raises(error) as caught:
        configuration.jacobian()
    report = pj.report(configuration)
    assert report.refusal == str(caught.value)
    assert report.matrices["Jv_eq"] is None
    strict(to_json(report.told()))


def test_an_unknown_frame_is_refused(homes):
    with pytest.raises(pj.ArgumentError, match="LOCAL, WORLD or LOCAL_WORLD_ALIGNED"):
        pj.report(homes["four_bar"], "BASE")


def test_joint_units_roles_and_order(homes):
    joints = pj.report(homes["three_rps"]).joints
    assert [joint.role for joint in joints] == ["actuated"] * 3 + ["passive"] * 9
    assert [joint.unit for joint in joints] == ["m"] * 3 + ["rad"] * 3 + ["m"] * 3 + ["rad"] * 3


def test_units_do_not_depend_on_the_order_of_the_file(homes):
    # In the model file phi1 stands before phi2, in the tree behind it; yaw is no passive joint.
    joints = pj.report(mechanisms.yawing_four_bar().home).joints
    assert [(joint.name, joint.unit) for joint in joints] == [
        (name, "rad") for name in ("yaw", "theta1", "phi1", "phi2")
    ]


@pytest.mark.parametrize(
    ("name", "key", "row_units", "column_units"),
    [
        ("three_rps_ss", "K", {"m²"}, {"m"}),
        ("three_rps_ss", "K_star", {"m²"}, {"rad"}),
        ("three_rps_ss", "Jv", {"m/s"}, {"m/s"}),
        ("three_rps_ss", "Jw_star", {"rad/s"}, {"rad/s"}),
        ("three_rps_ss", "passive_rates", {"rad/s"}, {"m/s"}),
        ("three_rps_ss", "gv_eq", {"m/s"}, {"m/s"}),
        ("three_rps_ss", "gw_eq", {"rad²/(m s)"}, {"m/s"}),
        ("three_rps", "K_star", {"m"}, {"m", "rad"}),
        ("four_bar", "K", {"m"}, {"rad"}),
        ("four_bar", "gv_eq", {"m²/(rad s)"}, {"rad/s"}),
    ],
)
def test_matrix_units(homes, name, key, row_units, column_units):
    matrix = pj.report(homes[name]).matrices[key]
    assert (set(matrix.row_units), set(matrix.column_units)) == (row_units, column_units)


def test_units_of_determinants_and_singular_values(homes):
    units = {}
    for name in ("three_rps_ss", "three_rps", "four_bar"):
        report = pj.report(homes[name])
        units[name] = (report.det_K_star.unit, report.singular_values["K_star"].unit)
    assert units == {
        "three_rps_ss": ("m⁶/rad³", "m²/rad"),
        "three_rps": ("m⁶/rad⁶", None),
        "four_bar": ("m²/rad²", "m/rad"),
    }


def test_scaling_all_lengths_scales_each_entry_as_its_unit_says():
    """Twice as large a four-bar at the same angles: an entry in mᵏ grows by 2ᵏ."""
    lengths = dict(zip(("l0", "l1", "l2", "l3"), mechanisms.CRANK_ROCKER, strict=True))
    small = pj.report(pj.load("four_bar", lengths).close([1.0]))
    double = {name: 2 * value for name, value in lengths.items()}
    large = pj.report(pj.load("four_bar", double).close([1.0]))
    for key, factor in {"K": 2, "K_star": 2, "passive_rates": 1, "Jv_eq": 2, "gv_eq": 4}.items():
        before, after = small.matrices[key], large.matrices[key]
        np.testing.assert_allclose(after.values, factor * np.array(before.values), rtol=1e-9)
    assert large.det_K_star.value == pytest.approx(4 * small.det_K_star.value)


def test_writing_units():
    assert unit((2, -1)) == "m²/rad"
    assert unit((-2, 12)) == "rad¹²/m²"
    assert unit((-1, -1)) == "1/(m rad)"
    assert quotient([(2, 0), (1, 0)], [(0, 1), (0, 1)]) == (3, -2)
    assert common_unit([], []) is None
    assert common_unit([(1, 0)], [(1, 0), (0, 1)]) is None
    assert metric_unit((1, 0), (1, 0)) == "m/s"
    assert powers_of(loaded("four_bar").row_units) == ((1, 0), (1, 0), (1, 0))
    assert powers_of(loaded("three_rps_ss").row_units) == ((2, 0), (2, 0), (2, 0))
