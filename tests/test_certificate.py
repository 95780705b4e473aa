"""Certificates: what is proven is true, and nothing is proven where nothing is."""

from __future__ import annotations

import math
from concurrent.futures import ThreadPoolExecutor

import flint
import mechanisms
import mpmath
import numpy as np
import pinocchio as pin
import pytest
import transformed
from mechanisms import loaded

import pmjac_pin as pj
from pmjac_pin.algebra.balls import precise
from pmjac_pin.studies.certificates.certificate import _certified, _equations

LEGS = ((0, 1), (1, 2), (2, 0))
OTHERS = {
    "yawing four-bar": mechanisms.yawing_four_bar,
    "rssr": mechanisms.rssr,
    "rssr as a distance": lambda: mechanisms.rssr(rod=False),
    "three cranks": mechanisms.three_crank_parallelogram,
    "two motors": mechanisms.over_actuated_four_bar,
}


def lecture_equations(lengths):
    """The 3-RPS's three distances in exact numbers, a = 1/2."""
    quarter = mpmath.mpf(1) / 4

    def equations(*angles):
        c, s = ([f(angle) for angle in angles] for f in (mpmath.cos, mpmath.sin))
        return [
            3
            - 3 * quarter
            + lengths[i] ** 2
            + lengths[j] ** 2
            + lengths[i] * lengths[j] * c[i] * c[j]
            - 2 * lengths[i] * lengths[j] * s[i] * s[j]
            - 3 * lengths[i] * c[i]
            - 3 * lengths[j] * c[j]
            for i, j in LEGS
        ]

    return equations


def exact_angles(configuration, start):
    with mpmath.workdps(40):
        lengths = [mpmath.mpf(float(length)) for length in configuration.actuated]
        root = mpmath.findroot(lecture_equations(lengths), [float(angle) for angle in start])
        return [mpmath.mpf(angle) for angle in root]


def distance(configuration, angles):
    passive = configuration.passive[: len(angles)].tolist()
    with mpmath.workdps(40):
        return float(
            max(abs(mpmath.mpf(one) - other) for one, other in zip(passive, angles, strict=True))
        )


def certified(name, seed, count):
    poses = mechanisms.random_poses(name, seed, count)
    return [(pose, pj.certify(pose)) for pose in poses]


@pytest.mark.parametrize("name", [*mechanisms.CATALOGUE, *OTHERS])
def test_every_named_pose_is_certified(name):
    mechanism = OTHERS[name]() if name in OTHERS else loaded(name)
    for pose in mechanism.poses:
        certificate = pj.certify(mechanism.pose(pose))
        assert certificate, certificate.failed
        assert certificate.existence_radius < 1e-12
        assert certificate.uniqueness_radius > 0.01
        assert certificate.left_out_gap < 1e-12
        partition = mechanism.problem.partition
        assert len(mechanism.rows) - len(certificate.left_out) == partition.passive_rank
        assert len(mechanism.passive) - len(certificate.held) == partition.passive_rank


@pytest.mark.slow
@pytest.mark.parametrize("name", ["three_rps", "three_rps_ss"])
def test_the_exact_root_is_within_the_existence_radius(name):
    """In 40 digits, by the lecture's formulas, which share nothing with the library."""
    for pose, certificate in certified(name, 5, 30):
        assert certificate
        off = distance(pose, exact_angles(pose, pose.passive[:3]))
        assert off <= certificate.existence_radius


def test_a_pose_moved_off_its_root_gets_a_larger_radius_that_reaches_it(rng):
    mechanism = loaded("three_rps_ss")
    pose = mechanism.pose("lecture_a")
    before, root = pj.certify(pose), exact_angles(pose, pose.passive)
    for size in (1.5, 0.3, 2.0):
        step = size * before.existence_radius * rng.choice([-1.0, 1.0], size=3)
        moved = mechanism.configuration(pose.q + with_passive(mechanism, step))
        after, off = pj.certify(moved), distance(moved, root)
        assert off <= after.existence_radius
        if size > 1.0:
            assert off > before.existence_radius
            assert after.existence_radius > before.existence_radius


def with_passive(mechanism, step):
    q = np.zeros(mechanism.nq)
    model = mechanism.model
    q[[model.joints[model.getJointId(name)].idx_q for name in mechanism.passive]] = step
    return q


@pytest.mark.parametrize("lengths", [(2 / 3, 3 / 5, 3 / 4), (0.5, 1.0, 2.0)])
def test_no_two_assembly_modes_lie_in_one_uniqueness_ball(lengths):
    modes = {
        (2 / 3, 3 / 5, 3 / 4): [
            (0.75931201, 0.28510144, 0.80278893),
            (0.74709682, 0.48093603, 0.81110182),
            (0.66831139, 0.64666409, -0.21037810),
            (0.03951542, -0.69420756, -0.74615223),
        ],
        (0.5, 1.0, 2.0): [(0.4000, 0.7535, 0.2402), (1.0907, 0.5736, 0.2572)],
    }[lengths]
    mechanism = loaded("three_rps_ss")
    roots, radii = [], []
    for mode in (tuple(sign * angle for angle in mode) for mode in modes for sign in (1, -1)):
        lines = lecture_equations([mpmath.mpf(length) for length in lengths])
        with mpmath.workdps(25):
            angles = [float(angle) for angle in mpmath.findroot(lines, mode)]
        q = mechanism.home.q.copy()
        model = mechanism.model
        for name, value in zip(
            [*mechanism.actuated, *mechanism.passive], [*lengths, *angles], strict=True
        ):
            q[model.joints[model.getJointId(name)].idx_q] = value
        certificate = pj.certify(mechanism.configuration(q))
        assert certificate
        roots.append(angles)
        radii.append(certificate.uniqueness_radius)
    apart = np.abs(np.array(roots)[:, None] - np.array(roots)[None]).max(axis=2)
    np.fill_diagonal(apart, np.inf)
    assert np.all(apart.min(axis=1) > radii)
    # A bound of no use would be far from the nearest other mode.
    assert np.min(apart.min(axis=1) / radii) < 40.0


def fold(mechanism, offset):
    """A rocker-rocker four-bar of which the crank is `offset` beyond the end of its range."""
    l0, l1, l2, l3 = mechanisms.NON_GRASHOF
    theta = math.acos((l0**2 + l1**2 - (l2 + l3) ** 2) / (2 * l0 * l1)) + offset
    crank = l1 * np.array([math.cos(theta), math.sin(theta)])
    gap = np.array([l0, 0.0]) - crank
    reach = math.hypot(*gap)
    bend = math.acos(min(1.0, (l2**2 + reach**2 - l3**2) / (2 * l2 * reach)))
    coupler = math.atan2(gap[1], gap[0]) + bend
    tip = crank + l2 * np.array([math.cos(coupler), math.sin(coupler)])
    phi1 = math.atan2(tip[1], tip[0] - l0)
    return {"theta1": theta, "phi1": phi1, "phi2": coupler - theta}


def tolerant(tolerance):
    rocker = mechanisms.rocker_rocker()
    return mechanisms.with_motors(rocker, rocker.actuated, tolerance=tolerance)


@pytest.mark.parametrize("offset", [1e-9, 1e-7, 1e-5, 1e-3])
def test_nothing_is_certified_where_the_loops_cannot_close(offset):
    mechanism = tolerant(0.01)
    values = fold(mechanism, offset)
    q = mechanism.coordinates.q(values, mechanism.home.q)
    certificate = pj.certify(mechanism.configuration(q))
    assert not certificate
    assert certificate.existence_radius == math.inf
    assert certificate.uniqueness_radius == 0.0
    assert "does not hold" in certificate.failed or "determinant" in certificate.failed
    assert certificate.evidence.kind == "nothing"


def test_towards_a_singularity_the_radii_close_in_and_the_inequality_is_named():
    mechanism = tolerant(1e-9)
    unique = []
    for offset in (1e-2, 1e-4, 1e-6, 1e-8, 1e-10, 1e-14):
        q = mechanism.coordinates.q(fold(mechanism, -offset), mechanism.home.q)
        certificate = pj.certify(mechanism.configuration(q))
        if not certificate:
            break
        unique.append(certificate.uniqueness_radius)
        # The other mode is the coupler's mirror image.
        other = 2.0 * bend_of(mechanism, offset)
        assert certificate.uniqueness_radius < other
        assert certificate.uniqueness_radius > other / 20.0
    assert len(unique) >= 3
    assert unique == sorted(unique, reverse=True)
    assert certificate.failed.startswith("Y + M r < r does not hold for any r: Newton's step is Y")


def bend_of(mechanism, offset):
    """How far the relative angles are from where coupler and rocker are in line."""
    here = fold(mechanism, -offset)
    end = fold(mechanism, 0.0)
    return max(abs(here[name] - end[name]) for name in ("phi1", "phi2")) + offset


def test_threads_agree_and_leave_the_precision_alone():
    poses = mechanisms.random_poses("three_rps_ss", 3, 8)
    alone = [pj.certify(pose) for pose in poses]
    flint.ctx.prec = 60
    try:
        with ThreadPoolExecutor(4) as threads:
            together = list(threads.map(pj.certify, poses))
        assert flint.ctx.prec == 60
    finally:
        flint.ctx.prec = 53
    assert [one.existence_radius for one in together] == [one.existence_radius for one in alone]


@pytest.mark.parametrize("joint", ["phi1", "theta1", "phi2"])
def test_every_cut_is_certified(joint):
    assert pj.certify(pj.recut(loaded("four_bar"), joint).home)


def test_joints_of_other_kinds_are_refused():
    model = pin.Model()
    joint = model.addJoint(0, pin.JointModelUniversal(*np.eye(3)[:2]), pin.SE3.Identity(), "cross")
    model.addFrame(pin.Frame("tool", joint, pin.SE3.Identity(), pin.FrameType.OP_FRAME))
    motor = model.addJoint(0, pin.JointModelRZ(), pin.SE3.Identity(), "motor")
    model.addFrame(pin.Frame("tip", motor, pin.SE3.Identity(), pin.FrameType.OP_FRAME))
    loops = [pj.PointLoop(frames=("tool", "tip"))]
    mechanism = pj.Mechanism.from_pinocchio(model, loops, ["motor"], "tool", name="test")
    certificate = pj.certify(mechanism.home)
    assert not certificate
    assert "cannot be taken apart; known kinds are: revolute, " in certificate.failed


def test_held_and_left_out_are_named():
    spin = pj.certify(mechanisms.rssr().home)
    assert len(spin.held) == 1
    assert set(spin.held) <= {"rx", "ry", "rz"}
    assert f"with {spin.held[0]} held" in spin.evidence.statement
    planar = pj.certify(loaded("four_bar").home)
    assert planar.left_out == ("coupler_tip-rocker_tip z",)
    assert "1 dependent row" in planar.evidence.statement


def test_the_unit_of_length_changes_no_radius():
    """All lengths a thousand times as large: angles and their radii are as before."""
    lengths = dict(zip(("l0", "l1", "l2", "l3"), mechanisms.CRANK_ROCKER, strict=True))
    one, other = (
        pj.load("four_bar", {name: size * value for name, value in lengths.items()}).home
        for size in (1.0, 1000.0)
    )
    radii = [pj.certify(pose).uniqueness_radius for pose in (one, other)]
    assert radii[0] == pytest.approx(radii[1], rel=1e-6)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["three_rps", "three_rps_ss"])
def test_two_hundred_random_poses(name):
    found = [certificate for _, certificate in certified(name, 11, 200)]
    assert sum(map(bool, found)) == 200
    assert np.median([one.existence_radius for one in found]) < 2e-13
    assert min(one.uniqueness_radius for one in found) > 1e-4


@pytest.mark.parametrize(
    "loop",
    [
        pj.FrameLoop(frames=("hand", "tip")),
        pj.RevoluteLoop(frames=("hand", "tip"), axis=(1, 0, 0)),
    ],
)
def test_axes_half_a_turn_apart_are_not_taken_for_parallel(loop):
    """There the rows without roots vanish, and their derivative is regular."""
    model = pin.Model()
    motor = model.addJoint(0, pin.JointModelRZ(), pin.SE3.Identity(), "motor")
    model.addFrame(pin.Frame("tip", motor, pin.SE3.Identity(), pin.FrameType.OP_FRAME))
    ball = model.addJoint(0, pin.JointModelFreeFlyer(), pin.SE3.Identity(), "body")
    model.addFrame(pin.Frame("hand", ball, pin.SE3.Identity(), pin.FrameType.OP_FRAME))
    mechanism = pj.Mechanism.from_pinocchio(model, [loop], ["motor"], "tip")
    assert pj.certify(mechanism.home)
    for over in ([0, 0, 1, 0], [0, 1, 0, 0]):
        q = np.array([0, 0, 0, 0, *over], dtype=float)
        certificate = certified_at(mechanism, q)
        assert not certificate
        # All three turns of a frame have a singular derivative there.
        assert "half a turn" in certificate.failed or isinstance(loop, pj.FrameLoop)


def certified_at(mechanism, q):
    """What is proven at q where no configuration says that the loops are closed."""
    partition = mechanism.problem.partition
    with precise(), np.errstate(over="ignore", invalid="ignore"):
        return _certified(_equations(mechanism), q, partition, mechanism.rows)


@pytest.mark.parametrize("name", ["four_bar", "three_rps", "delta_rods"])
def test_a_machine_far_from_the_origin_is_certified_with_what_its_numbers_allow(name):
    near = loaded(name)
    far = transformed.moved(near, pin.SE3(np.eye(3), np.array([1e5, -3e4, 7.0])))
    one, other = (pj.certify(mechanism.home) for mechanism in (near, far))
    assert one.existence_radius < other.existence_radius < 1e-8
    assert other.uniqueness_radius == pytest.approx(one.uniqueness_radius, rel=1e-3)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["four_bar", "five_bar", "slider_crank", "three_rps_ss"])
def test_no_other_mode_is_within_the_uniqueness_radius(name, rng):
    mechanism = loaded(name)
    length = mechanism.problem.partition.length
    turns = np.array([kind != "JointModelPX" for kind in kinds_of(mechanism, mechanism.passive)])
    for _ in range(3):
        theta = mechanism.home.actuated + 0.2 * rng.normal(size=len(mechanism.actuated))
        modes = list(pj.assembly_modes(mechanism, theta, rng=0))
        for mode in modes:
            certificate = pj.certify(mode)
            assert certificate
            for other in modes:
                change = mode.passive - other.passive
                apart = np.where(turns, np.abs(np.angle(np.exp(1j * change))), change / length)
                assert other is mode or np.abs(apart).max() > certificate.uniqueness_radius


def kinds_of(mechanism, names):
    model = mechanism.model
    return [model.joints[model.getJointId(name)].shortname() for name in names]


def test_what_is_proven_does_not_depend_on_the_precision_of_the_process():
    found = []
    for precision in (53, 30, 200):
        flint.ctx.prec = precision
        try:
            found.append(pj.certify(loaded("three_rps_ss").home).existence_radius)
        finally:
            flint.ctx.prec = 53
    assert found == [found[0]] * 3
