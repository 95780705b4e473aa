"""The report on assembly modes: the Python interface's own numbers, with names and units."""

from __future__ import annotations

import json

import mechanisms
import numpy as np
import pytest
from mechanisms import loaded

import pmjac_pin as pj
from pmjac_pin.words.modes_report import make_modes_report
from pmjac_pin.words.plain import to_json


def refuse(token):
    raise AssertionError(f"{token} is no JSON")


@pytest.fixture(scope="module")
def lecture():
    mechanism = loaded("three_rps_ss")
    theta = mechanism.pose("lecture_a").actuated
    modes = pj.assembly_modes(mechanism, theta, rng=0)
    return modes, make_modes_report(mechanism, theta, modes)


def test_the_numbers_are_those_of_the_configurations(lecture):
    modes, report = lecture
    told = json.loads(to_json(report.told()), parse_constant=refuse)
    for mode, found in zip(modes, told["modes"], strict=True):
        assert found["residual_norm"] == mode.residual_norm
        assert found["smallest"] == mode.singularity().smallest
        assert found["det_K_star"]["value"] == mode.split_jacobian().det_K_star
        assert found["sign"] == np.sign(found["det_K_star"]["value"])
        np.testing.assert_array_equal(found["tool"]["position"], mode.tool_pose().translation)
        np.testing.assert_array_equal(found["tool"]["rotation"], mode.tool_pose().rotation)
        np.testing.assert_array_equal(found["q"], mode.q)
        values = {joint["name"]: joint["value"] for joint in found["joints"]}
        assert values == dict(mode.joint_values)
    assert [mode.share for mode in report.modes] == list(modes.shares)
    assert (told["starts"], told["evidence"]["statement"]) == (
        modes.starts,
        modes.evidence.statement,
    )


def test_the_certificates_are_those_of_the_configurations(lecture):
    modes, report = lecture
    for mode, found in zip(modes, report.told()["modes"], strict=True):
        certificate = pj.certify(mode)
        assert found["certificate"]["certified"] is bool(certificate) is True
        assert found["certificate"]["existence_radius"] == certificate.existence_radius
        assert found["certificate"]["uniqueness_radius"] == certificate.uniqueness_radius
        assert found["certificate"]["evidence"] == certificate.evidence


def test_a_mode_can_be_made_again_of_its_q(lecture):
    modes, report = lecture
    again = modes[0].mechanism.configuration(report.told()["modes"][0]["q"])
    assert again.residual_norm == modes[0].residual_norm


def test_mirror_images_have_opposite_signs_and_name_each_other(lecture):
    _, report = lecture
    assert len(report.modes) == 8
    for mode in report.modes:
        image = report.modes[mode.mirror_image - 1]
        assert image.mirror_image == mode.number
        assert image.sign == -mode.sign
    assert [mode.number for mode in report.modes] == list(range(1, 9))


def test_the_named_pose_is_found_once(lecture):
    modes, report = lecture
    [named] = [index for index, mode in enumerate(report.modes) if mode.poses]
    assert report.modes[named].poses == ("lecture_a",)
    pose = modes[0].mechanism.pose("lecture_a")
    np.testing.assert_allclose(modes[named].passive, pose.passive, atol=1e-9)


def test_other_motor_values_have_no_names():
    mechanism = loaded("three_rps_ss")
    theta = mechanism.pose("lecture_a").actuated + np.array([0.0, 1e-6, 0.0])
    report = make_modes_report(mechanism, theta, pj.assembly_modes(mechanism, theta, rng=0))
    assert {mode.poses for mode in report.modes} == {()}


def test_a_pose_is_known_by_its_bodies_though_a_rod_spins():
    mechanism = mechanisms.rssr()
    theta = mechanism.home.actuated
    report = make_modes_report(mechanism, theta, pj.assembly_modes(mechanism, theta, rng=3))
    assert sum(mode.poses == ("home",) for mode in report.modes) == 1


def test_a_pose_that_does_not_close_names_nothing():
    mechanism = mechanisms.rocker_rocker()
    report = make_modes_report(mechanism, [2.5], pj.assembly_modes(mechanism, [2.5], rng=0))
    assert report.modes == ()
    assert [(motor.name, motor.value, motor.unit) for motor in report.motors] == [
        ("theta1", 2.5, "rad")
    ]


def test_a_singular_mode_has_no_sign():
    """Coupler and rocker of the four-bar in one line: two modes have become one."""
    mechanism = mechanisms.rocker_rocker()
    l0, l1, l2, l3 = mechanisms.NON_GRASHOF
    end = np.arccos((l0**2 + l1**2 - (l2 + l3) ** 2) / (2 * l0 * l1))
    pose = mechanism.close([end])
    assert pose.singularity().is_singular
    modes = pj.AssemblyModes(
        (pose,), 1, pj.Evidence("nothing", "by hand", 1.0, 0.5), (1.0,), (None,)
    )
    [mode] = make_modes_report(mechanism, [end], modes).modes
    assert (mode.singularity.kind, mode.sign) == ("gain", 0)
    assert not mode.certificate


def test_without_loops_there_is_one_mode_and_no_smallest_singular_value():
    mechanism = loaded("serial_2r")
    report = make_modes_report(
        mechanism, [0.1, 0.2], pj.assembly_modes(mechanism, [0.1, 0.2], rng=0)
    )
    [mode] = json.loads(to_json(report.told()), parse_constant=refuse)["modes"]
    assert mode["smallest"] is None


def test_json_gives_every_attribute_back(lecture):
    _, report = lecture
    found = json.loads(to_json(report.told()), parse_constant=refuse)
    assert list(found) == list(report.told())
    assert found["modes"][3]["q"] == report.modes[3].configuration.q.tolist()
    assert found["evidence"]["kind"] == "proof"
