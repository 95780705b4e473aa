"""What comes free at a singular pose, told modulo what is free at every pose."""

from __future__ import annotations

import re

import hand_derived as hand
import mechanisms
import numpy as np
import pinocchio as pin
import pytest
from mechanisms import loaded
from test_tables import drawn

import pmjac_pin as pj
from pmjac_pin.closing import idle_motions
from pmjac_pin.rates.singularity import analyse_singularity
from pmjac_pin.values.arrays import norm
from pmjac_pin.viewer.free_motion import easiest_motions
from pmjac_pin.words.tables import report_blocks

X, Y, Z = (1, 0, 0), (0, 1, 0), (0, 0, 1)
TURNS = {"x": X, "y": Y, "z": Z}


def distances(plain):
    """The frames and the length of each distance loop."""
    return [(*loop.frames, loop.resolved_length(plain.parameters)) for loop in plain.spec.loops]


def rod_values(plain, q):
    """Joint values of rods between two ball joints in place of the distances at this pose."""
    model, values = plain.model, {}
    data = model.createData()
    pin.framesForwardKinematics(model, data, q)
    for number, (first, second, length) in enumerate(distances(plain)):
        start, end = (data.oMf[model.getFrameId(name)] for name in (first, second))
        x, y, z = start.rotation.T @ (end.translation - start.translation) / length
        turns = {"x": 0.3, "y": 0.0, "z": 0.0}  # spun by 0.3 before it is turned
        # Rx Ry Rz e_x = (x, y, z), with any first angle.
        c, s = np.cos(turns["x"]), np.sin(turns["x"])
        y, z = c * y + s * z, c * z - s * y
        turns |= {"y": np.arctan2(-z, x), "z": np.arctan2(y, np.hypot(x, z))}
        values |= {f"rod{number}_{axis}": float(angle) for axis, angle in turns.items()}
    return values


def with_rods(plain, urdf):
    """The machine with each distance a rod between two ball joints, which spins idly."""
    joints = []
    for number, (first, _, length) in enumerate(distances(plain)):
        parent = first
        for axis, vector in TURNS.items():
            link = f"rod{number}_{axis}_link"
            joints.append((f"rod{number}_{axis}", "continuous", parent, link, (0, 0, 0), vector))
            parent = link
        joints.append((f"rod{number}_end", "fixed", parent, f"rod{number}_tip", (length, 0, 0)))
    inside = mechanisms.tree(*joints).split("\n", 1)[1].removesuffix("</robot>")
    for first, _, _ in distances(plain):
        inside = inside.replace(f'<link name="{first}"/>', "")
    return pj.Mechanism.from_pinocchio(
        pin.buildModelFromXML(urdf.replace("</robot>", f"{inside}</robot>")),
        [
            pj.PointLoop(frames=(f"rod{number}_tip", second))
            for number, (_, second, _) in enumerate(distances(plain))
        ],
        plain.actuated,
        plain.spec.tool.frame,
        home=dict(plain.home.joint_values) | rod_values(plain, np.array(plain.home.q)),
        name="rods",
    )


def at(mechanism, values):
    """The configuration at these joint values, closed as they are."""
    q, model = pin.neutral(mechanism.model), mechanism.model
    for name, value in values.items():
        joint = model.joints[model.getJointId(name)]
        entries = [value] if np.isscalar(value) else value
        if joint.nq == 2:
            entries = [np.cos(value), np.sin(value)]
        q[joint.idx_q : joint.idx_q + joint.nq] = entries
    return mechanism.configuration(q)


class Rssr:
    """Crank and rocker about any two axes, and the rod between their tips."""

    def __init__(self, crank, rocker, rod, place, tilt):
        self.rod = rod
        self.joints = [
            ("theta", "revolute", "ground", "crank", (0, 0, 0), Z),
            ("psi", "revolute", "ground", "rocker", place, Z, (tilt, 0.0, 0.0)),
            ("ke", "fixed", "crank", "crank_tip", (crank, 0, 0)),
            ("re", "fixed", "rocker", "rocker_tip", (rocker, 0, 0)),
        ]

    def plain(self, home):
        """The rod as a distance."""
        loop = pj.DistanceLoop(frames=("crank_tip", "rocker_tip"), length=self.rod)
        model = pin.buildModelFromXML(mechanisms.tree(*self.joints))
        return pj.Mechanism.from_pinocchio(model, [loop], ["theta"], "rocker_tip", home=home)

    def rods(self, plain):
        """The rod as a body."""
        return with_rods(plain, mechanisms.tree(*self.joints))


def random_fold(seed):
    """An RSSR, its rod a distance and a body, at a fold that is exact to the last digit.

    The rod is set at right angles to the rocker tip's way, and the rocker where it then belongs.
    """
    rng = np.random.default_rng(seed)
    (crank, rocker), (theta, psi, tilt) = rng.uniform(0.4, 1.5, 2), rng.uniform(-2, 2, 3)
    turn = np.array([[1, 0, 0], [0, np.cos(tilt), -np.sin(tilt)], [0, np.sin(tilt), np.cos(tilt)]])
    arm = turn @ [rocker * np.cos(psi), rocker * np.sin(psi), 0.0]
    rate = turn @ [-np.sin(psi), np.cos(psi), 0.0]
    rod = np.cross(rate, rng.normal(size=3))
    place = rod - arm + np.array([crank * np.cos(theta), crank * np.sin(theta), 0.0])
    linkage = Rssr(
        float(crank), float(rocker), float(np.linalg.norm(rod)), tuple(place.tolist()), float(tilt)
    )
    for way in (0.2, -0.2):
        plain = linkage.plain({"theta": theta + way, "psi": psi + 0.4})
        if plain.home.actuated[0] == theta + way:
            break
    rods = linkage.rods(plain)
    return at(plain, {"theta": theta, "psi": psi}), rods


def same_with_rods(fold, rods):
    return at(rods, dict(fold.joint_values) | rod_values(fold.mechanism, np.array(fold.q)))


def spins(pose, rods):
    """The spin of each rod about itself by hand, shape (m_p, rods)."""
    mechanism = pose.mechanism
    model, names = mechanism.model, list(mechanism.passive)
    data = model.createData()
    pin.computeJointJacobians(model, data, np.array(pose.q))
    pin.updateFramePlacements(model, data)
    columns = []
    for number in range(rods):
        tip = model.getFrameId(f"rod{number}_tip")
        jacobian = pin.getFrameJacobian(model, data, tip, pin.LOCAL_WORLD_ALIGNED)[3:]
        turns = [f"rod{number}_{axis}" for axis in TURNS]
        axes = jacobian[:, [model.joints[model.getJointId(name)].idx_v for name in turns]]
        rates = np.linalg.solve(axes, data.oMf[tip].rotation[:, 0])
        column = np.zeros(len(names))
        column[[names.index(name) for name in turns]] = rates / np.linalg.norm(rates)
        columns.append(column)
    return np.array(columns).T


def dimensionless(pose, motions):
    units = [pose.mechanism.units[name] for name in pose.mechanism.passive]
    length = pose.mechanism.characteristic_length
    return motions / np.array([1 / length if unit == "rad" else 1.0 for unit in units])[:, None]


def distance_between(one, other):
    """The sine of the largest angle between the spans of two sets of columns."""
    a, b = np.linalg.qr(one)[0], np.linalg.qr(other)[0]
    return np.linalg.norm(a - b @ (b.T @ a), 2)


def check_modulo_idle(pose, rods, exact):
    """Idle is what spins; what is gained is free, too, and has no part of it."""
    singularity, passive = pose.singularity(), pose.split_jacobian().partition.passive
    assert singularity.gained == 1
    assert singularity.idle == singularity.idle_motions.shape[1] == rods
    assert singularity.free_motions.shape[1] == 1
    idle, gained = (
        dimensionless(pose, motions)
        for motions in (singularity.idle_motions, singularity.free_motions)
    )
    by_hand = dimensionless(pose, spins(pose, rods))
    assert distance_between(idle, by_hand) < exact
    assert np.abs(np.linalg.qr(by_hand)[0].T @ gained).max() < exact * norm(gained)
    constraint = pose.split_jacobian().constraint_jacobian[:, passive]
    assert norm(constraint @ singularity.free_motions) < 1e-5 * norm(constraint)
    assert norm(constraint @ singularity.idle_motions) < exact * norm(constraint)


def check_like_without_rods(pose, plain_pose):
    """Bodies that are in both machines move as they do where the rods are distances."""
    free, [expected] = pose.singularity().free_motion(), easiest_motions(plain_pose).T
    shared = np.array([free[name] for name in plain_pose.mechanism.passive])
    pivot = np.argmax(np.abs(expected))
    np.testing.assert_allclose(shared / shared[pivot], expected / expected[pivot], atol=1e-4)


@pytest.mark.parametrize("seed", range(12))
def test_a_fold_of_an_rssr_to_the_last_digit(seed):
    """There one null space holds both, and nothing in K* tells them apart."""
    pose = same_with_rods(*random_fold(seed))
    assert pose.singularity().smallest < 1e-12
    check_modulo_idle(pose, 1, 1e-10)
    free = pose.singularity().free_motion()
    assert free["psi"] != 0.0
    with pytest.raises(pj.SingularError) as caught:
        pose.jacobian()
    assert caught.value.free_motion == free
    assert f"psi {free['psi']:+.3g}" in str(caught.value)


@pytest.mark.parametrize("seed", range(12))
def test_the_fold_of_an_rssr_where_close_ends(seed):
    fold, rods = random_fold(seed)
    theta = fold.actuated[0]
    with pytest.raises(pj.ClosureError) as caught:
        rods.close([2 * theta - rods.home.actuated[0]])
    reached = caught.value.reached
    assert reached.actuated[0] == pytest.approx(theta, abs=1e-6)
    if reached.singularity().gained:
        check_modulo_idle(reached, 1, 1e-7)
    else:  # a hair before: its null space is idle, all of it
        assert reached.singularity().free_motions.shape[1] == 0
    easiest, spin = easiest_motions(reached), spins(reached, 1)  # all in rad/s
    assert abs(easiest[:, 0] @ spin[:, 0]) < 1e-5 * norm(easiest) * norm(spin)


@pytest.mark.parametrize("lengths", [(4.0, 3.0, 2.5, 2.0), (2.0, 1.5, 2.6, 1.0)])
def test_a_planar_four_bar_whose_coupler_spins(lengths):
    l0, l1, l2, l3 = lengths
    theta, (psi, _) = hand.four_bar_crank_limit(lengths)
    linkage = Rssr(l1, l3, l2, (l0, 0, 0), 0.0)
    plain = linkage.plain({"theta": 0.9, "psi": 2.0})
    fold = at(plain, {"theta": theta, "psi": psi})
    check_modulo_idle(same_with_rods(fold, linkage.rods(plain)), 1, 1e-10)


@pytest.mark.parametrize("seed", [0, 1])
def test_a_delta_whose_six_rods_spin(seed):
    """Wherever close meets a singularity, the plate moves as it does without spinning rods."""
    plain = loaded("delta_rods")
    rods = with_rods(plain, plain.urdf.text)
    assert rods.home.singularity().idle == 6
    rng, met = np.random.default_rng(seed), 0
    while met < 2:
        target = rods.home.actuated + rng.normal(size=3) * 3
        try:
            rods.close(target, enforce_limits=False)
        except pj.ClosureError as error:
            pose = error.reached
            if not pose.singularity().gained:
                continue
            check_modulo_idle(pose, 6, 1e-7)
            model = rods.model
            joint = model.joints[model.getJointId("platform")]
            q = np.array([*pose.q[joint.idx_q : joint.idx_q + 7]])
            values = {name: pose.joint_values[name] for name in plain.actuated} | {"platform": q}
            check_like_without_rods(pose, at(plain, values))
            met += 1


def test_where_branches_meet():
    """The flat parallelogram with a spinning coupler: the coupler's spin is idle on each branch."""
    linkage = Rssr(0.7, 0.7, 2.0, (2, 0, 0), 0.0)
    plain = linkage.plain({"theta": 1.0, "psi": 1.0})
    pose = same_with_rods(at(plain, {"theta": 0.0, "psi": 0.0}), linkage.rods(plain))
    assert pose.singularity().kind == "configuration space"
    check_modulo_idle(pose, 1, 1e-7)


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_regular_poses_nearby_tell_the_same(seed):
    """The other way to find it, where K* changes to second order only."""
    fold, rods = random_fold(seed)
    pose, problem = same_with_rods(fold, rods), rods.problem
    partition, q = problem.partition, np.array(pose.q)
    scaled = partition.scaled(problem.evaluate(q)[1])
    passive = partition.factorise(scaled[:, partition.passive], norm(scaled))
    free = passive.right[passive.rank :].T
    nearby = free @ idle_motions._by_neighbours(problem, q, scaled, free)[:, 1:]
    assert distance_between(nearby, dimensionless(pose, spins(pose, 1))) < 1e-4


def test_regular_poses_gain_nothing_and_keep_their_idle_motions():
    plain = loaded("delta_rods")
    home = with_rods(plain, plain.urdf.text).home
    singularity = home.singularity()
    assert singularity.free_motions.shape == (24, 0)
    assert singularity.free_motion() == {}
    by_hand = dimensionless(home, spins(home, 6))
    assert distance_between(dimensionless(home, singularity.idle_motions), by_hand) < 1e-12
    assert loaded("four_bar").home.singularity().idle_motions.shape == (2, 0)


def test_a_report_tells_them_apart():
    pose = same_with_rods(*random_fold(0))
    report, singularity = pj.report(pose), pose.singularity()
    found = report.told()["singularity"]
    [free], [idle] = found["free_motions"], found["idle_motions"]
    assert list(free.values()) == singularity.free_motions[:, 0].tolist()
    assert list(idle.values()) == singularity.idle_motions[:, 0].tolist()
    text = drawn(report_blocks(report))
    tables = re.split(r"Passive motions that come free here|Idle passive motions, free", text)
    assert len(tables) == 3
    assert re.search(r"^psi \[rad/s\] +0(\.0+)?$", tables[2], re.MULTILINE)


def test_where_nothing_tells_them_apart_nothing_is_called_idle():
    """The crank's tip on the rocker's axis: with it there the rocker turns for ever."""
    linkage = Rssr(1.0, 0.7, 0.7, (1, 0, 0), 0.0)
    plain = linkage.plain({"theta": 0.4, "psi": 2.0})
    pose = same_with_rods(at(plain, {"theta": 0.0, "psi": 0.5}), linkage.rods(plain))
    singularity = pose.singularity()
    assert (singularity.gained, singularity.idle) == (1, 1)
    assert singularity.free_motions.shape == (4, 2)
    assert singularity.idle_motions.shape == (4, 0)


def test_matrices_alone_tell_only_where_singular_values_do():
    """η̇ = θ̇ + a φ̇₁ at a pose where a is small, or zero, and φ̇₂ idle."""
    regular = np.array([[1.0, 1.0, 0.0]])
    partition = pj.Partition.from_matrices(regular, np.eye(6, 3), [0], [1, 2])
    for a, gained, idle in ((1.0, 0, 1), (1e-7, 1, 1), (0.0, 2, 0)):
        C = np.array([[1.0, a, 0.0]])
        singularity = analyse_singularity(C, np.eye(6, 3), partition)
        found = (singularity.free_motions.shape[1], singularity.idle_motions.shape[1])
        assert found == (gained, idle)
        if gained == 1:
            assert singularity.free_motion() == {"phi0": 1.0, "phi1": 0.0}
