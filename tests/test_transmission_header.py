"""A transmission as a C header: what it computes is what Python says, or it says that it is not."""

from __future__ import annotations

import ctypes
import itertools
import shutil
import subprocess

import numpy as np
import pytest
from test_transmission import motors_by_hand
from transmission_machines import CASES, drawn, table_of

import pmjac_pin as pj
from pmjac_pin.values.brief import at_most

OPTIONS = ("-std=c99", "-Wall", "-Wextra", "-Werror", "-pedantic", "-O2", "-shared", "-fPIC")
OK, OUTSIDE, NOT_CONVERGED, SINGULAR = range(4)
WRAPPED = """#include "t.h"
#include "t.h"
int at_joints(const double *x, t_pose *pose);
int at_motors(const double *theta, t_pose *pose);
void rates(const t_pose *pose, const double *from, double *motors, double *joints);
void efforts(const t_pose *pose, const double *from, double *motors, double *joints);
int at_joints(const double *x, t_pose *pose) { return t_at_joints(x, pose); }
int at_motors(const double *theta, t_pose *pose) { return t_at_motors(theta, pose); }
void rates(const t_pose *pose, const double *from, double *motors, double *joints)
{
    t_motor_rates(pose, from, motors);
    t_joint_rates(pose, from, joints);
}
void efforts(const t_pose *pose, const double *from, double *motors, double *joints)
{
    t_motor_efforts(pose, from, motors);
    t_joint_efforts(pose, from, joints);
}
"""
pytestmark = pytest.mark.skipif(shutil.which("cc") is None, reason="no C compiler here")


class Header:
    """A header, compiled."""

    def __init__(self, text, n, folder):
        (folder / "t.h").write_text(text)
        (folder / "t.c").write_text(WRAPPED)
        library = folder / "t.so"
        subprocess.run(["cc", *OPTIONS, str(folder / "t.c"), "-o", str(library), "-lm"], check=True)
        self._library, self._n = ctypes.CDLL(str(library)), n

    def at(self, way, values):
        """Return the status, and joints, motors, R and its inverse; the pose as C has it."""
        n, pose = self._n, np.zeros(2 * self._n + 2 * self._n**2)
        given = np.array(values, dtype=float)
        function = getattr(self._library, f"at_{way}")
        status = function(_address(given), _address(pose))
        joints, motors, ratio, inverse = np.split(pose, [n, 2 * n, 2 * n + n * n])
        return status, joints, motors, ratio.reshape(n, n), inverse.reshape(n, n), pose

    def both(self, what, pose, given):
        """Return what is made of rates or efforts: of the motors, and of the joints."""
        motors, joints = np.zeros(self._n), np.zeros(self._n)
        arrays = (pose, np.array(given, dtype=float), motors, joints)
        getattr(self._library, what)(*map(_address, arrays))
        return motors, joints


def _address(array):
    return array.ctypes.data_as(ctypes.c_void_p)


@pytest.fixture(scope="module")
def compiled(tmp_path_factory):
    found = {}

    def of(name):
        if name not in found:
            table = table_of(name)
            folder = tmp_path_factory.mktemp("header")
            found[name] = Header(table.c("t"), len(table.joints), folder)
        return found[name]

    return of


def corners(table):
    box = table.rectangle
    return list(itertools.product(*zip(box.lower.tolist(), box.upper.tolist(), strict=True)))


@pytest.mark.parametrize("name", CASES)
def test_from_joints_to_motors_it_is_what_python_says(name, compiled, rng):
    table, header = table_of(name), compiled(name)
    x = np.vstack([drawn(table, rng, 100), corners(table)])
    exact, ratio = table.exact(x)
    for k, row in enumerate(x):
        status, joints, motors, found, inverse, _ = header.at("joints", row)
        assert status == OK
        np.testing.assert_array_equal(joints, row)
        np.testing.assert_allclose(motors, exact[k], rtol=0, atol=1e-12)
        np.testing.assert_allclose(found, ratio[k], rtol=1e-12, atol=1e-12)
        np.testing.assert_allclose(inverse, np.linalg.inv(ratio[k]), rtol=1e-11, atol=1e-12)


@pytest.mark.parametrize("name", CASES)
def test_it_is_what_single_poses_say(name, compiled, rng):
    """By `close` and `jacobian`, which share no recorded step with it."""
    table, header = table_of(name), compiled(name)
    for row in drawn(table, rng, 5):
        geared = table.transmission.at_joints(row)
        _, _, motors, ratio, _, pose = header.at("joints", row)
        np.testing.assert_allclose(motors, geared.motors, rtol=0, atol=1e-11)
        np.testing.assert_allclose(ratio, geared.ratio, rtol=1e-9, atol=1e-9)
        given = rng.normal(size=len(row))
        motor_rates, joint_rates = header.both("rates", pose, given)
        np.testing.assert_allclose(motor_rates, geared.motor_rates(given), rtol=1e-9, atol=1e-9)
        np.testing.assert_allclose(joint_rates, geared.joint_rates(given), rtol=1e-9, atol=1e-9)
        motor_efforts, joint_efforts = header.both("efforts", pose, given)
        np.testing.assert_allclose(motor_efforts, geared.motor_efforts(given), rtol=1e-9, atol=1e-9)
        np.testing.assert_allclose(joint_efforts, geared.joint_efforts(given), rtol=1e-9, atol=1e-9)


def test_an_ankle_is_its_closed_formula(compiled, rng):
    header, table = compiled("humanoid_ankle"), table_of("humanoid_ankle")
    for row in drawn(table, rng, 100):
        by_hand = motors_by_hand(*row)
        np.testing.assert_allclose(header.at("joints", row)[2], by_hand, rtol=0, atol=1e-12)
        np.testing.assert_allclose(header.at("motors", by_hand)[1], row, rtol=0, atol=1e-12)


@pytest.mark.parametrize("name", CASES)
def test_from_motors_to_joints_it_leads_back(name, compiled, rng):
    table, header = table_of(name), compiled(name)
    x = np.vstack([drawn(table, rng, 200), corners(table)])
    exact, ratio = table.exact(x)
    for row, motors, rates in zip(x, exact, ratio, strict=True):
        status, joints, same, found, inverse, _ = header.at("motors", motors)
        assert status == OK
        np.testing.assert_allclose(joints, row, rtol=0, atol=2e-12)
        np.testing.assert_array_equal(same, motors)
        np.testing.assert_allclose(found, rates, rtol=1e-10, atol=1e-11)
        np.testing.assert_allclose(found @ inverse, np.eye(len(row)), atol=1e-12)


def is_nothing(told):
    return np.isnan(told[-1]).all()


@pytest.mark.parametrize("name", CASES)
def test_outside_the_rectangle_there_is_no_number(name, compiled, rng):
    table, header = table_of(name), compiled(name)
    box = table.rectangle
    width = box.upper - box.lower
    for row in drawn(table, rng, 30):
        axis = rng.integers(row.size)
        for away in (box.lower[axis] - 1e-9, box.upper[axis] + width[axis], np.nan, np.inf):
            row[axis] = away
            told = header.at("joints", row)
            assert told[0] == OUTSIDE
            assert is_nothing(told)


@pytest.mark.parametrize("name", CASES)
def test_motor_values_from_outside_lead_to_no_number(name, compiled):
    """Poses beside the rectangle exist, and are not of the table."""
    table, header = table_of(name), compiled(name)
    box = table.rectangle
    tried = 0
    for corner in corners(table):
        outwards = np.array(corner) + 0.02 * (np.array(corner) - 0.5 * (box.lower + box.upper))
        try:
            geared = table.transmission.at_joints(outwards)
        except pj.PmjacError:
            continue
        tried += 1
        told = header.at("motors", geared.motors)
        assert told[0] in (OUTSIDE, NOT_CONVERGED)
        assert is_nothing(told)
    assert tried


def test_any_motor_values_lead_to_a_pose_that_has_them_or_to_none(compiled, rng):
    header = compiled("humanoid_ankle")
    counts = np.zeros(4, dtype=int)
    for theta in rng.uniform(-3.0, 3.0, (2000, 2)):
        told = header.at("motors", theta)
        counts[told[0]] += 1
        if told[0] == OK:
            np.testing.assert_allclose(motors_by_hand(*told[1]), theta, rtol=0, atol=1e-11)
        else:
            assert is_nothing(told)
    assert counts[OK] > 20
    assert counts[OUTSIDE] > 400
    for theta in ([np.nan, 0.0], [0.0, np.inf], [1e300, 0.0], [2 * np.pi, 0.0]):
        told = header.at("motors", theta)
        assert told[0] != OK
        assert is_nothing(told)


def test_of_another_way_to_assemble_it_there_is_no_number(tmp_path):
    """A header whose table is off leads Newton's steps to the right pose, and refuses it."""
    table = table_of("four_bar")
    text = table.c("t")
    theta = table.exact(table.rectangle.lower)[0][0]
    wrong = Header(text.replace(repr(float(theta)), repr(float(theta) + 0.1)), 1, tmp_path)
    told = wrong.at("joints", table.rectangle.lower)
    assert told[0] == NOT_CONVERGED
    assert is_nothing(told)


@pytest.mark.parametrize("name", ["humanoid_ankle", "four_bar"])
def test_what_counts_as_singular_is_told(name, tmp_path):
    """With a tolerance that no pose keeps."""
    table = table_of(name)
    header = Header(table.c("t").replace("1e-06", "1.0"), len(table.joints), tmp_path)
    for way, values in (
        ("joints", table.rectangle.lower),
        ("motors", table.exact(table.rectangle.lower)[0]),
    ):
        told = header.at(way, values)
        assert told[0] == SINGULAR
        assert is_nothing(told)


def test_a_header_says_what_it_is_of():
    table = table_of("humanoid_ankle")
    text = table.c()
    comment = " ".join(text[: text.index("*/")].replace(" *", " ").split())
    assert "humanoid_ankle_at_joints(joints, &pose)" in comment
    assert "for pitch -0.4 to 0.25, roll -0.15 to 0.15" in comment
    assert str(table.evidence) in comment
    for motor, error in zip(table.motors, table.error, strict=True):
        assert f"{motor} {at_most(error)} rad" in comment


@pytest.mark.parametrize("name", ["1st", "a b", "", "double"])
def test_names_that_c_does_not_allow(name):
    with pytest.raises(pj.ArgumentError):
        table_of("four_bar").c(name)


def test_a_header_that_is_pasted_has_no_constant_that_nothing_uses(tmp_path):
    """Of one that is included a compiler does not say so."""
    table = pj.transmission_table(pj.load("four_bar"), {"phi1": (2.2, 2.4)}, points=5)
    (tmp_path / "t.c").write_text(f"{table.c()}\nint main(void) {{ return 0; }}\n")
    asked = ["cc", *OPTIONS[:5], "-o", str(tmp_path / "t"), str(tmp_path / "t.c"), "-lm"]
    subprocess.run(asked, check=True)
