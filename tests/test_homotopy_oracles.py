"""Our counts against other people's homotopies, on polynomials written by hand."""

from __future__ import annotations

from importlib import util

import hand_spatial
import numpy as np
import pytest
from mechanisms import loaded
from test_modes import same_sets

import pmjac_pin as pj

pytest.importorskip("sympy", reason="the polynomials are written in SymPy")

from homotopy_oracles import ORACLES
from polynomials_by_hand import SYSTEMS, stewart_gough

pytestmark = pytest.mark.slow  # the peers are installed with the slow tests only

LECTURE_A, LECTURE_B = (2 / 3, 3 / 5, 3 / 4), (0.5, 1.0, 2.0)
SHIFTED = (0.32461369, 0.36873712, 0.49813137)
SMALL = [
    ("four_bar", (0.9,)),
    ("planar_3rpr", SHIFTED),
    ("three_rps_ss", LECTURE_A),
    ("three_rps_ss", LECTURE_B),
]


@pytest.fixture(params=ORACLES)
def oracle(request):
    pytest.importorskip(request.param, reason="a peer, of the extra `peers`")
    return ORACLES[request.param]


def by_hand(name, mode):
    """The unknowns of the hand-written polynomials at a closed pose."""
    values = mode.joint_values
    if name == "planar_3rpr":
        x, y, angle = values["platform"]
        return [x, y, np.cos(angle), np.sin(angle)]
    names = ["phi1", "phi2"] if name == "four_bar" else ["theta1", "theta2", "theta3"]
    angles = np.array([values[joint] for joint in names])
    return np.column_stack([np.cos(angles), np.sin(angles)]).ravel()


def places(study):
    """The platform's place p = g e* / |e|^2 by rows of Study's coordinates, real part first."""
    e, g = study[:, :4], study[:, 4:]
    vector = g[:, 1:] * e[:, :1] - g[:, :1] * e[:, 1:] - np.cross(g[:, 1:], e[:, 1:])
    return vector / (e**2).sum(axis=1, keepdims=True)


@pytest.mark.parametrize(("name", "motors"), SMALL)
def test_real_solutions_are_the_assembly_modes(oracle, name, motors):
    found = oracle(SYSTEMS[name](motors))
    modes = [by_hand(name, mode) for mode in pj.assembly_modes(loaded(name), motors, rng=0)]
    if not found.lost:
        same_sets(found.real, modes, 1e-8)
    for point in found.real:
        assert np.abs(np.array(modes) - point).max(axis=1).min() <= 1e-8


@pytest.mark.parametrize("lengths", [LECTURE_A, LECTURE_B])
def test_sixteen_of_the_3_rps(oracle, lengths):
    """A path that was lost may have led to a solution, and not to more than one."""
    found = oracle(SYSTEMS["three_rps_ss"](lengths))
    assert len(found.points) <= 16 <= len(found.points) + found.lost


@pytest.mark.parametrize(("name", "motors"), SMALL[:3])
def test_counts_of_complex_solutions_agree(name, motors):
    installed = [oracle for module, oracle in ORACLES.items() if util.find_spec(module)]
    if not installed:
        pytest.skip("no peer is installed")
    ours = pj.parameter_homotopy(loaded(name), rng=0).at(motors)
    for oracle in installed:
        found = oracle(SYSTEMS[name](motors))
        assert (len(found.points), len(found.real), found.lost) == (ours.count, len(ours.real), 0)


def test_dietmaiers_forty_are_all_there_are(oracle):
    """The 40 that the search finds are the 40 of all complex solutions."""
    lengths = hand_spatial.DIETMAIER_LENGTHS
    found = oracle(SYSTEMS["stewart_gough_dietmaier"](lengths))
    modes = pj.assembly_modes(loaded("stewart_gough_dietmaier"), lengths, rng=0, limits=False)
    expected = np.array([mode.joint_values["platform"][:3] for mode in modes])
    assert len(found.points) <= 40 <= len(found.points) + found.lost
    if not found.lost:
        same_sets(places(found.real), expected, 1e-6)
    for place in places(found.real):
        assert np.abs(expected - place).max(axis=1).min() <= 1e-6


def test_a_gough_platform_with_flat_base_and_platform():
    """Twenty-eight; further eight of the polynomials have |e|² = 0 and are no poses."""
    pytest.importorskip("bertini", reason="a peer, of the extra `peers`")
    mechanism = loaded("stewart_gough")
    values = mechanism.parameters
    names = [f"{letter}{leg}" for letter in "bp" for leg in range(1, 7)]
    points = [tuple(values.get(f"{name}{axis}", 0.0) for axis in "xyz") for name in names]
    lengths = mechanism.home.actuated * np.linspace(0.9, 1.1, 6)
    system = stewart_gough(lengths.tolist(), points[:6], points[6:])
    found = ORACLES["bertini"](system).points
    poses = found[np.abs((found[:, :4] ** 2).sum(axis=1)) > 1e-3]
    ours = pj.parameter_homotopy(mechanism, rng=0).at(lengths)
    assert (len(poses), ours.count, ours.certified, ours.evidence.kind) == (28, 28, 28, "tolerance")
    assert len(ours.real) == int((np.abs(poses.imag).max(axis=1) < 1e-7).sum())
