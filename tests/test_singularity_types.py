"""Singularities by the field's names: closed cases, and Zlatanov's definitions word for word."""

from __future__ import annotations

from math import pi

import hand_derived as hand
import hand_planar
import mechanisms
import numpy as np
import pinocchio as pin
import pytest
from hand_planar import unit
from mechanisms import loaded, with_motors
from scipy.optimize import fsolve
from transformed import moved, rebuilt

import pmjac_pin as pj
from pmjac_pin.rates.screw import principal_screws

Z = np.array([0.0, 0.0, 1.0])
MOVED = np.array([0.02, -0.03])


def posed(mechanism, **values):
    """The closed pose at these joint values, of revolute and planar joints."""
    coordinates = mechanism.coordinates
    return mechanism.configuration(coordinates.q(values, mechanism.home.q))


def five_bar_at(thetas, tip, lengths=(0.3, 0.3, 0.4, 0.4, 0.3)):
    names = dict(zip(("l0", "l1", "l2", "l3", "l4"), lengths, strict=True))
    l0, l1, _, _, l4 = lengths
    elbows = [l1 * unit(thetas[0]), np.array([l0, 0.0]) + l4 * unit(thetas[1])]
    angles = [np.arctan2(*(tip - elbow)[::-1]) for elbow in elbows]
    phi = [whole_turns_less(a - t) for a, t in zip(angles, thetas, strict=True)]
    machine = pj.load("five_bar", names)
    return posed(machine, theta1=thetas[0], theta2=thetas[1], phi1=phi[0], phi2=phi[1])


def five_bar_stretched():
    """The first arm in one line, at 1.3 rad."""
    tip = 0.7 * unit(1.3)
    elbow = hand_planar.meet(np.array([0.3, 0.0]), tip, 0.3, 0.4, 1)
    return five_bar_at((1.3, np.arctan2(elbow[1], elbow[0] - 0.3)), tip)


def five_bar_collinear():
    """Both distal links in one line, the tip between the elbows."""
    first = 0.3 * unit(2.4)
    second = hand_planar.meet(np.array([0.3, 0.0]), first, 0.3, 0.8, -1)
    theta2 = np.arctan2(second[1], second[0] - 0.3)
    return five_bar_at((2.4, theta2), 0.5 * (first + second))


def five_bar_both():
    """The first arm stretched, the second's distal link folded onto its distal one."""
    lengths = (0.3, 0.3, 0.4, 0.5, 0.3)
    angle = np.arccos(0.2**2 / (2 * 0.2 * 0.3))
    elbow, tip = 0.2 * unit(angle), 0.7 * unit(angle)
    return five_bar_at((angle, np.arctan2(elbow[1], elbow[0] - 0.3)), tip, lengths)


def four_bar_at_crank_limit():
    lengths = (4.0, 3.0, 2.5, 2.0)
    theta1, (phi1, phi2) = hand.four_bar_crank_limit(lengths)
    machine = pj.load("four_bar", dict(zip(("l0", "l1", "l2", "l3"), lengths, strict=True)))
    return posed(machine, theta1=theta1, phi1=phi1, phi2=phi2)


def rockers_dead_point(motor, tool):
    """The crank in line with the coupler."""
    l0, l1, l2, l3 = mechanisms.CRANK_ROCKER
    theta1 = np.arccos((l0**2 + (l1 + l2) ** 2 - l3**2) / (2 * l0 * (l1 + l2)))
    q = loaded("four_bar").close([theta1]).q
    return with_motors(loaded("four_bar"), [motor]).with_tool(tool).configuration(q)


def slider_crank_at_dead_centre(motor, tool):
    q = loaded("slider_crank").close([0.0]).q
    return with_motors(loaded("slider_crank"), [motor]).with_tool(tool).configuration(q)


def whole_turns_less(angle):
    return (angle + pi) % (2 * pi) - pi


def three_rrr_at(x, y, turn, elbows):
    """Plate at x, y, turn; elbows (3, 2)."""
    base, plate = (
        np.array([r * unit(2 * pi * k / 3 + by) for k in range(3)])
        for r, by in ((0.5, 0), (0.15, turn))
    )
    plate += np.array([x, y])
    values = {"platform": (x, y, turn)}
    for k in range(3):
        theta = np.arctan2(*(elbows[k] - base[k])[::-1])
        distal = np.arctan2(*(plate[k] - elbows[k])[::-1])
        values |= {
            f"theta{k + 1}": whole_turns_less(theta - pi - 2 * pi * k / 3),
            f"phi{k + 1}": distal - theta,
        }
    return values


def three_rrr_lines_in_a_point():
    """A pose with the distal links on three lines through a point, and this point."""
    base = np.array([0.5 * unit(2 * pi * k / 3) for k in range(3)])

    def elbows(unknown):
        point, turn = unknown[:2], unknown[2]
        plate = np.array([0.15 * unit(2 * pi * k / 3 + turn) for k in range(3)]) + MOVED
        away = plate - point
        return plate + 0.3 * away / np.linalg.norm(away, axis=1)[:, None]

    unknown = fsolve(
        lambda u: np.linalg.norm(elbows(u) - base, axis=1) - 0.25, [0, 0, 0.5], xtol=1e-13
    )
    values = three_rrr_at(*MOVED, unknown[2], elbows(unknown))
    return posed(loaded("planar_3rrr"), **values), unknown[:2]


def ring(degrees):
    turns = np.deg2rad(degrees)
    return np.column_stack([np.cos(turns), np.sin(turns), np.zeros(len(turns))])


IRREGULAR = ring([0.0, 40.0, 120.0, 160.0, 240.0, 280.0])
OCTAHEDRON = (ring([0, 0, 120, 120, 240, 240.0]), 0.5 * ring([300, 60, 60, 180, 180, 300.0]))


def octahedral_stewart(turn):
    """Plates parallel, the upper one turned about the vertical."""
    return pj.stewart(*OCTAHEDRON, pin.SE3(pin.utils.rotate("z", turn), Z)).home


def delta_with_vertical_rods(name):
    """All rods upright: with the motors locked the plate is free to move level.

    Rods with balls at both ends forbid it turns about level axes only; hinges forbid all turns.
    """
    machine = pj.load(name)
    size = machine.parameters
    theta = np.arccos((size["plate"] - size["base"]) / size["arm"])
    height = -size["arm"] * np.sin(theta) - size["rod"]
    values = {"platform": [0, 0, height, 0, 0, 0, 1]}
    for leg in (1, 2, 3):
        values[f"theta{leg}"] = theta
        if name == "delta":
            values[f"elbow{leg}"] = pi / 2 - theta
            values |= dict.fromkeys((f"sway{leg}a", f"sway{leg}b", f"level{leg}"), 0.0)
    return posed(machine, **values)


def rps_where(meeting):
    """A singular pose of the 3-RPS, or such a one where its operation modes meet."""
    machine = loaded("three_rps_ss")
    for lengths, theta in hand.rps_singular_poses(np.random.default_rng(5), 6):
        whole = np.hstack([hand.rps_K(lengths, theta), hand.rps_K_star(lengths, theta)])
        if (np.linalg.svd(whole)[1][-1] < 1e-6) == meeting:
            names = machine.actuated + machine.passive
            return posed(machine, **dict(zip(names, (*lengths, *theta), strict=True)))
    raise RuntimeError("no such pose among six")


def flat_parallelogram():
    return mechanisms.three_crank_parallelogram().configuration(np.zeros(4))


QUICK = ("agile_eye", "bennett", "five_bar", "serial_2r", "slider_crank", "three_rps_ss")
CASES = {
    "serial 2R, stretched": (lambda: loaded("serial_2r").close([0.3, 0.0]), "RI IO", "I"),
    "slider-crank, dead centre": (
        lambda: slider_crank_at_dead_centre("theta", "piston"),
        "RI IO",
        "I",
    ),
    "slider-crank, driven by its piston": (
        lambda: slider_crank_at_dead_centre("x", "rod_tip"),
        "RO II",
        "II",
    ),
    "slider-crank, driven by its tool": (
        lambda: slider_crank_at_dead_centre("x", "piston"),
        "RPM II IO",
        None,
    ),
    "four-bar, rocker's dead point": (
        lambda: rockers_dead_point("theta1", "rocker_tip"),
        "RI IO",
        "I",
    ),
    "four-bar, rocker's dead point, driven by it": (
        lambda: rockers_dead_point("phi1", "coupler_midpoint"),
        "RO II",
        "II",
    ),
    "four-bar, crank's limit": (four_bar_at_crank_limit, "RO II", "II"),
    "five-bar, arm stretched": (five_bar_stretched, "RI IO", "I"),
    "five-bar, distal links in line": (five_bar_collinear, "RO II", "II"),
    "five-bar, both": (five_bar_both, "RI RO II IO", "III"),
    "3-RRR, three lines in a point": (lambda: three_rrr_lines_in_a_point()[0], "RO II", "II"),
    "hinged Delta, rods upright": (lambda: delta_with_vertical_rods("delta"), "RO II", "II"),
    "3-RPS": (lambda: rps_where(meeting=False), "RO II", "II"),
    "Fichter, +90 degrees": (lambda: octahedral_stewart(pi / 2), "RO II", "II"),
    "Fichter, -90 degrees": (lambda: octahedral_stewart(-pi / 2), "RO II", "II"),
}


@pytest.mark.parametrize(("pose", "types", "kind"), CASES.values(), ids=CASES)
def test_closed_cases(pose, types, kind):
    found = pose().singularity()
    assert set(found.types.present) == set(types.split())
    assert found.types.gosselin_angeles == kind
    assert not found.types.constraint_singularity
    assert not found.types.architecture_singularity
    assert all(f"({name})" in found.in_words for name in types.split())
    assert bool(found.free_twists.size) == ("RO" in types)
    assert found.lost_wrenches.shape == (6, found.types.counts["IO"])


@pytest.mark.parametrize(
    "pose",
    [
        flat_parallelogram,
        lambda: delta_with_vertical_rods("delta_rods"),
        lambda: rps_where(meeting=True),
    ],
    ids=["flat parallelogram", "Delta", "3-RPS"],
)
def test_where_branches_meet_the_tool_gains_a_freedom(pose):
    found = pose().singularity()
    assert found.kind == "configuration space"
    assert "IIM" in found.types.present
    assert found.types.constraint_singularity
    assert found.types.here.twist == found.types.generic.twist + found.types.counts["IIM"]


def jacobian_of_all(configuration):
    """[K K* 0; J J* −1] on (θ̇, φ̇, t), t on the judged rows, without dimension."""
    machine = configuration.mechanism
    partition = machine.problem.partition
    split = configuration.split_jacobian(partition.tool_rows.axes)
    columns = [*partition.actuated, *partition.passive]
    rows = partition.tool_rows.linear + partition.tool_rows.angular
    C = partition.row_scale[:, None] * (split.constraint_jacobian * partition.column_scale)
    T = np.repeat([1.0, partition.length], 3)[:, None] * (
        split.tool_jacobian * partition.column_scale
    )
    C, T = C[:, columns], T[rows][:, columns]
    return np.block([[C, np.zeros((len(C), len(rows)))], [T, -np.eye(len(rows))]]), len(rows)


def rank(matrix):
    return int(np.linalg.matrix_rank(matrix, tol=1e-5)) if matrix.size else 0


def by_definition(configuration):
    """Dimensions of what Zlatanov's definitions speak of, each by its own intersection."""
    L, outputs = jacobian_of_all(configuration)
    n = len(configuration.mechanism.actuated)
    inputs, passive, out = L[:, :n], L[:, n : L.shape[1] - outputs], L[:, L.shape[1] - outputs :]

    def solutions(*blocks):  # dim of the null space
        matrix = np.hstack(blocks)
        return matrix.shape[1] - rank(matrix)

    def possible(block, *others):  # of the block's unknown, those for which the others exist
        return solutions(block, *others) - solutions(*others)

    return {
        "RI": possible(inputs, passive),
        "RO": possible(out, passive),
        "RPM": solutions(passive),
        "II": -possible(inputs, passive, out),
        "IO": -possible(out, inputs, passive),
        "IIM": solutions(L),
    }


@pytest.mark.parametrize("name", CASES)
def test_counts_are_those_of_the_definitions(name):
    """At the pose less those at a regular pose, by ranks of blocks of one matrix."""
    here = CASES[name][0]()
    regular = here.mechanism.home
    if regular.singularity().kind != "regular":  # of a machine made at the pose
        regular = octahedral_stewart(0.2)
    generic = by_definition(regular)
    expected = {kind: count - generic[kind] for kind, count in by_definition(here).items()}
    assert here.singularity().types.counts == expected


@pytest.mark.parametrize("name", mechanisms.mostly_slow(mechanisms.CATALOGUE, QUICK))
def test_no_type_at_regular_poses_and_what_is_impossible_is_redundant_elsewhere(name):
    """II needs RO or RPM, IO needs RI or RPM, IIM both: for each count, with its sign."""
    for here in mechanisms.random_poses(name, 3, 3):
        found = here.singularity()
        counts = found.types.counts
        assert found.kind != "regular" or not found.types.present
        assert counts["IIM"] + counts["II"] == counts["RO"] + counts["RPM"]
        assert counts["IIM"] + counts["IO"] == counts["RI"] + counts["RPM"]
        generic = by_definition(here)
        assert generic["RPM"] == found.types.generic.unfelt
        assert generic["IIM"] == found.types.generic.allowed


def test_similar_hexagons_are_singular_at_every_pose():
    """Ma and Angeles: a Stewart platform on similar hexagons moves with all legs locked."""
    rng = np.random.default_rng(2)
    for _ in range(3):
        turn = pin.exp3(0.4 * rng.normal(size=3))
        top = pin.SE3(turn, np.array([0.0, 0.0, 1.0]) + 0.2 * rng.normal(size=3))
        found = pj.stewart(IRREGULAR, 0.5 * IRREGULAR, top).home.singularity()
        assert found.kind == "regular"
        assert found.types.architecture_singularity
        assert found.in_words == "an architecture singularity, as at every pose"
        # The screw that comes free is reciprocal to the lines of all legs.
        (screw,) = found.free_screws
        lines = [(b, top.act(p)) for b, p in zip(IRREGULAR, 0.5 * IRREGULAR, strict=True)]
        work = [(p - b) @ screw.twist(b)[:3] for b, p in lines]
        np.testing.assert_allclose(work, 0.0, atol=1e-9)
    assert not octahedral_stewart(0.2).singularity().types.architecture_singularity


@pytest.mark.parametrize("side", [1, -1])
def test_fichters_screw_has_the_pitch_of_the_legs_moments(side):
    """About the vertical each leg has the moment b × n of the same share of its height."""
    (screw,) = octahedral_stewart(side * pi / 2).singularity().free_screws
    base, held = OCTAHEDRON
    upper = held @ pin.utils.rotate("z", side * pi / 2).T + Z
    moments = np.cross(base, upper - base)[:, 2]
    np.testing.assert_allclose(moments, moments[0], atol=1e-12)
    np.testing.assert_allclose(screw.direction, Z, atol=1e-9)
    np.testing.assert_allclose(screw.point[:2], 0.0, atol=1e-9)
    assert screw.pitch == pytest.approx(-moments[0] / 1.0, abs=1e-9)


def test_a_hinged_delta_with_upright_rods_is_free_to_move_level():
    screws = delta_with_vertical_rods("delta").singularity().free_screws
    assert [screw.pitch for screw in screws] == [np.inf, np.inf]
    np.testing.assert_allclose([screw.direction[2] for screw in screws], 0.0, atol=1e-9)


def test_three_rrr_turns_about_the_point_where_the_lines_meet():
    pose, point = three_rrr_lines_in_a_point()
    (screw,) = pose.singularity().free_screws
    assert (screw.pitch, screw.direction.tolist()) == (0.0, [0.0, 0.0, 1.0])
    np.testing.assert_allclose(screw.point[:2], point, atol=1e-8)


def test_the_force_that_needs_no_motor_is_along_the_stretched_arm():
    (screw,) = five_bar_stretched().singularity().lost_screws
    along = np.append(unit(1.3), 0.0)
    np.testing.assert_allclose(np.cross(screw.direction, along), 0.0, atol=1e-8)
    assert screw.pitch == 0.0
    np.testing.assert_allclose(np.cross(screw.point, along), 0.0, atol=1e-8)  # through the motor


def test_of_a_motion_that_is_lost_the_force_does_work_beside_the_pose():
    """A nearby motor rate moves the tool against it, and at the pose none does."""
    here = rockers_dead_point("theta1", "rocker_tip")
    (screw,) = here.singularity().lost_screws
    wrench = screw.wrench(here.tool_pose().translation)
    beside = here.mechanism.close(here.actuated + 1e-3, guess=here)
    works = [wrench @ pose.jacobian().J_eq[:, 0] for pose in (here, beside)]
    assert abs(works[0]) < 1e-8 < 1e-4 < abs(works[1])


def test_screws_do_not_depend_on_where_the_moment_is_taken(rng):
    resultants, moments, a, b = (
        rng.normal(size=(3, 2)),
        rng.normal(size=(3, 2)),
        *rng.normal(size=(2, 3)),
    )
    mixed = rng.normal(size=(2, 2))
    elsewhere = moments + np.cross((a - b), resultants.T).T
    one = principal_screws(resultants, moments, a, 1.0)
    other = principal_screws(resultants @ mixed, elsewhere @ mixed, b, 1.0)
    for x, y in zip(one, other, strict=True):
        np.testing.assert_allclose(x.direction, y.direction, atol=1e-9)
        assert x.pitch == pytest.approx(y.pitch, abs=1e-9)
        np.testing.assert_allclose(np.cross(x.point - y.point, x.direction), 0.0, atol=1e-9)
    assert one[0].direction @ one[1].direction == pytest.approx(0.0, abs=1e-12)
    # Together they span the same twists.
    span = np.vstack([moments, resultants])
    assert rank(np.column_stack([span, *(x.twist(a) for x in one)])) == 2


def wren_platform(home):
    """Six equal upright rods between two equal rings: it slides about, or it twists and sinks."""
    model, still, loops = pin.Model(), pin.SE3.Identity(), []
    body = 0
    for name, kind in (
        ("x", pin.JointModelPX()),
        ("y", pin.JointModelPY()),
        ("z", pin.JointModelPZ()),
    ):
        body = model.addJoint(body, kind, still, name)
    body = model.addJoint(body, pin.JointModelSpherical(), still, "turn")
    for k, point in enumerate(ring(60.0 * np.arange(6))):
        place = pin.SE3(np.eye(3), point)
        for name, joint in ((f"base{k}", 0), (f"top{k}", body)):
            model.addFrame(pin.Frame(name, joint, place, pin.FrameType.OP_FRAME))
        loops.append(pj.DistanceLoop(frames=(f"top{k}", f"base{k}"), length=1.5))
    return pj.Mechanism.from_pinocchio(model, loops, ["x", "y"], "top0", home=home)


WREN = {
    "upright": [0.0, 0.0, 1.5, 0.0, 0.0, 0.0, 1.0],
    "slid": [0.3, 0.4, np.sqrt(1.5**2 - 0.5**2), 0.0, 0.0, 0.0, 1.0],
    "twisted": [0, 0, np.sqrt(1.5**2 - (2 * np.sin(0.25)) ** 2), 0, 0, np.sin(0.25), np.cos(0.25)],
}


@pytest.mark.parametrize("home", mechanisms.mostly_slow(WREN, ("upright",)))
def test_the_wren_platform_is_shaky_on_each_branch_and_says_so(home):
    """Parallel rods, or those of a regulus, have rank 3: more motions are allowed than it has."""
    machine = wren_platform(WREN[home])
    assert machine.mobility is None
    for q in WREN.values():
        found = machine.configuration(q).singularity()
        assert found.types.here.allowed == 3
        assert (found.kind, found.is_singular) == ("isolated", True)
        assert found.in_words.startswith("not known")


def homed_at(configuration):
    """The same machine, whose home is this pose."""
    machine = configuration.mechanism
    own = machine.spec.tool
    return pj.Mechanism.from_pinocchio(
        machine.model,
        [loop.resolved(machine.parameters) for loop in machine.spec.loops],
        machine.actuated,
        own.names if len(own.names) > 1 else own.frame,
        home=configuration.q,
        tool_rows=own.judged.names,
        tool_axes=own.judged.axes,
        enforce_limits=False,
    )


@pytest.mark.parametrize("name", CASES)
def test_a_singular_home_says_the_same(name):
    """What is generic is looked for near home too, so that home may be singular itself."""
    here = CASES[name][0]()
    home = homed_at(here).home
    np.testing.assert_allclose(home.q, here.q, atol=1e-6)
    assert home.singularity().types == here.singularity().types


def test_a_sarrus_linkage_stretched_flat_is_a_mechanism_still():
    """Its panels upright: [K K*] drops there, at home too, and one freedom stays."""
    there = pj.nearest_singularity(loaded("sarrus").home, kind="gain", rng=0).configuration
    assert there.actuated[0] == pytest.approx(pi / 2, abs=1e-5)
    machine = homed_at(there)
    assert machine.mobility == 1
    found = machine.home.singularity()
    assert found.kind == "configuration space"
    assert "IIM" in found.types.present


def test_a_flat_parallelogram_opens_on_both_branches():
    lengths = {"l0": 2.0, "l1": 1.0, "l2": 2.0, "l3": 1.0}
    machine = pj.load("four_bar", lengths)
    flat = machine.configuration(np.zeros(3))
    assert flat.singularity().kind == "configuration space"
    assert {"RO", "IIM"} <= set(flat.singularity().types.present)
    modes = [mode.joint_values for mode in pj.assembly_modes(machine, [0.4], rng=0)]
    assert len(modes) == 2
    # Crank and rocker parallel, or crossed: sin of the rocker of the same sign or not.
    assert sorted(np.sign(np.sin(mode["phi1"])) for mode in modes) == [-1.0, 1.0]
    home = homed_at(flat)
    assert home.mobility == 1
    assert home.home.singularity().kind == "configuration space"


@pytest.mark.parametrize("joint", "ABCD")
def test_types_and_screws_do_not_depend_on_the_cut(joint):
    """A four-bar at the end of its crank's range: the rocker turns about its own pivot's line."""
    lengths = (4.0, 3.0, 2.5, 2.0)
    theta1, phi = hand.four_bar_crank_limit(lengths)
    found = mechanisms.four_bar_cut_at(joint, theta1, phi, lengths).home.singularity()
    reference = four_bar_at_crank_limit().singularity()
    assert found.types.counts == reference.types.counts
    (screw,), (expected,) = found.free_screws, reference.free_screws
    # The coupler turns about the crank's tip, which rests.
    tip = 3.0 * np.append(unit(theta1), 0.0)
    for one in (screw, expected):
        np.testing.assert_allclose(one.point, tip, atol=1e-5)
        np.testing.assert_allclose(one.direction, Z, atol=1e-9)


@pytest.mark.parametrize("name", ["five-bar, both", "3-RRR, three lines in a point"])
def test_types_and_screws_move_with_the_machine(name):
    here = CASES[name][0]()
    place = pin.SE3(pin.utils.rpyToMatrix(0.3, -0.8, 1.9), np.array([40.0, -7.0, 3.0]))
    machines = rebuilt(homed_at(here)), moved(homed_at(here), place)
    there, found = (machine.configuration(here.q).singularity() for machine in machines)
    assert found.types.counts == there.types.counts
    for kind in ("free_screws", "lost_screws"):
        screws, others = getattr(there, kind), getattr(found, kind)
        assert len(screws) == len(others)
        for one, other in zip(screws, others, strict=True):
            np.testing.assert_allclose(
                np.cross(place.rotation @ one.direction, other.direction), 0.0, atol=1e-8
            )
            np.testing.assert_allclose(place.act(one.point), other.point, atol=1e-6)
            assert one.pitch == pytest.approx(other.pitch, abs=1e-8)
