"""Planar mechanisms, of the catalogue and published: against formulas and printed figures."""

from __future__ import annotations

from math import atan2, cos, pi, sin, sqrt

import hand_planar as planar
import mechanisms
import numpy as np
import pinocchio as pin
import pytest
from mechanisms import loaded

import pmjac_pin as pj
from pmjac_pin.viewer.scene import SceneMaker

EXACT = 1e-11
Z = (0, 0, 1)


def in_plane(configuration):
    """The rows v_x, v_y, ω_z of J_eq, after a look at the others."""
    J_eq = configuration.jacobian().J_eq
    assert np.abs(J_eq[2:5]).max() <= EXACT
    return J_eq[[0, 1, 5]]


def platform_pose(configuration):
    x, y, _ = configuration.tool_pose().translation
    return np.array([x, y, pin.log3(configuration.tool_pose().rotation)[2]])


# --- Slider-crank --------------------------------------------------------------------------------


@pytest.mark.parametrize("sizes", [(0.3, 0.9, 0.0), (0.4, 0.7, 0.1), (0.25, 1.2, -0.3)])
@pytest.mark.parametrize("theta", [-2.5, -0.4, 0.7, 1.6, 3.0])
def test_slider_crank_is_its_closed_form(theta, sizes):
    mechanism = pj.load("slider_crank", dict(zip("rle", sizes, strict=True)))
    configuration = mechanism.close([theta])
    x, slope = planar.slider_crank(theta, *sizes)
    assert configuration.joint_values["x"] == pytest.approx(x, abs=EXACT)
    np.testing.assert_allclose(in_plane(configuration)[:, 0], [slope, 0, 0], atol=EXACT)


def test_slider_crank_behind_the_crank():
    """The other assembly mode is the mirror image: x(θ) → −x(π − θ), in line."""
    behind = loaded("slider_crank").close([0.9], guess={"theta": 0.9, "beta": 2.5, "x": -0.7})
    x, slope = planar.slider_crank(pi - 0.9, 0.3, 0.9, 0.0)
    assert behind.joint_values["x"] == pytest.approx(-x, abs=EXACT)
    assert in_plane(behind)[0, 0] == pytest.approx(slope, abs=EXACT)


@pytest.mark.parametrize("theta", [0.0, pi])
def test_slider_crank_at_its_dead_centres(theta):
    """The piston stands still; driven by the piston, the same pose has no J_eq."""
    by_crank = loaded("slider_crank").close([theta])
    assert np.abs(by_crank.jacobian().J_eq).max() <= EXACT
    assert by_crank.singularity().kind == "loss"
    by_piston = pj.Mechanism.from_pinocchio(
        by_crank.mechanism.model,
        by_crank.mechanism.spec.loops,
        ["x"],
        "crank",
        home={"theta": 0.9, "beta": -1.16, "x": 1.06},
    )
    assert by_piston.home.jacobian().Jw_eq[2, 0] == pytest.approx(
        1 / planar.slider_crank(by_piston.home.joint_values["theta"], 0.3, 0.9, 0.0)[1]
    )
    dead = by_piston.configuration(by_crank.q)
    with pytest.raises(pj.SingularError):
        dead.jacobian()


# --- Five-bar ------------------------------------------------------------------------------------


@pytest.mark.parametrize("pose", ["home", "right", "elbows_left", "below"])
def test_five_bar_is_its_closed_form(pose, rng):
    mechanism = loaded("five_bar")
    side = -1 if pose == "below" else 1  # of the line from the first elbow to the second
    for configuration in mechanisms.random_closed(mechanism, rng, 10, 0.2, start=pose):
        lengths = tuple(mechanism.parameters.values())
        tip, J = planar.five_bar(configuration.actuated, lengths, side)
        np.testing.assert_allclose(configuration.tool_pose().translation, [*tip, 0], atol=EXACT)
        np.testing.assert_allclose(in_plane(configuration), J, atol=EXACT * np.abs(J).max())


@pytest.mark.parametrize("lengths", [(0.5, 0.25, 0.6, 0.45, 0.35), (0.001, 0.3, 0.5, 0.4, 0.2)])
def test_five_bar_of_other_lengths(lengths):
    given = dict(zip(("l0", "l1", "l2", "l3", "l4"), lengths, strict=True))
    configuration = pj.load("five_bar", given).home
    tip, J = planar.five_bar(configuration.actuated, lengths, 1)
    np.testing.assert_allclose(configuration.tool_pose().translation, [*tip, 0], atol=EXACT)
    np.testing.assert_allclose(in_plane(configuration), J, atol=EXACT)


# --- Watt six-bar --------------------------------------------------------------------------------

SIZES = ("AG", "AB", "BC", "CD", "GC", "CF", "DE", "EF")


@pytest.mark.parametrize("crank", np.linspace(-3.0, 3.0, 7))
@pytest.mark.parametrize(
    ("pose", "sides"), [("home", (1, 1)), ("folded", (1, -1)), ("below", (-1, 1))]
)
def test_watt_six_bar_is_its_closed_form(pose, sides, crank):
    mechanism = loaded("watt_six_bar")
    given = mechanism.parameters
    angles = (given["beta"], given["gamma"])
    points = planar.watt_six_bar_points(crank, [given[name] for name in SIZES], angles, sides)
    velocities, turning = planar.watt_six_bar(points)
    configuration = mechanism.close([crank], guess=pose)
    np.testing.assert_allclose(configuration.tool_pose().translation, [*points["E"], 0], atol=1e-9)
    expected = [*velocities["E"], turning]
    np.testing.assert_allclose(in_plane(configuration)[:, 0], expected, atol=1e-9)


# PMKS+ (github.com/PMKS-Web), the six-bar of its tests, verified there in MATLAB; rad/s.
PMKS_POINTS = {
    "A": (-3.74, -2.41),
    "B": (-2.72, 0.91),
    "C": (1.58, 0.43),
    "D": (-0.24, 4.01),
    "E": (5.08, 5.31),
    "F": (8.14, 3.35),
    "G": (7.32, -3.51),
}
PMKS_CRANK = 10.0
PMKS_VELOCITIES = {
    "B": (-33.2, 10.2),
    "C": (-41.00746046, -59.74183325),
    "D": (17.22318211, -30.13854569),
    "E": (-14.09031526, 98.00592049),
    "F": (-71.39877633, 8.534547608),
}


def watt_six_bar_at(points, tool):
    """A six-bar whose links are all parallel to the world where its joints are at zero."""

    def arm(tail, head):
        return (*np.subtract(points[head], points[tail]).tolist(), 0.0)

    joints = [
        ("A", "revolute", "ground", "AB", (*points["A"], 0.0), Z),
        ("B", "revolute", "AB", "BCD", arm("A", "B"), Z),
        ("D", "revolute", "BCD", "DE", arm("B", "D"), Z),
        ("G", "revolute", "ground", "GCF", (*points["G"], 0.0), Z),
        ("F", "revolute", "GCF", "EF", arm("G", "F"), Z),
        ("C1", "fixed", "BCD", "C_of_BCD", arm("B", "C")),
        ("C2", "fixed", "GCF", "C_of_GCF", arm("G", "C")),
        ("E1", "fixed", "DE", "E_of_DE", arm("D", "E")),
        ("E2", "fixed", "EF", "E_of_EF", arm("F", "E")),
    ]
    loops = [("C_of_BCD", "C_of_GCF"), ("E_of_DE", "E_of_EF")]
    return mechanisms.build(joints, loops, ["A"], tool, dict.fromkeys("ABDGF", 0.0))


@pytest.mark.parametrize(
    ("point", "frame"),
    [
        ("B", "BCD"),
        ("C", "C_of_BCD"),
        ("C", "C_of_GCF"),
        ("D", "DE"),
        ("E", "E_of_DE"),
        ("E", "E_of_EF"),
        ("F", "EF"),
    ],
)
def test_six_bar_of_pmks(point, frame):
    """Ternary links BCD and GCF share C, on a binary ground: it is a Watt six-bar."""
    mechanism = watt_six_bar_at(PMKS_POINTS, frame)
    assert mechanism.mobility == 1
    velocity = PMKS_CRANK * in_plane(mechanism.home)[:2, 0]
    np.testing.assert_allclose(velocity, PMKS_VELOCITIES[point], rtol=1e-9)
    by_hand = PMKS_CRANK * planar.watt_six_bar(PMKS_POINTS)[0][point]
    np.testing.assert_allclose(by_hand, PMKS_VELOCITIES[point], rtol=1e-9)


# --- 3-RRR and 3-RPR -----------------------------------------------------------------------------


@pytest.mark.parametrize("pose", ["home", "turned", "elbow_right"])
def test_3rrr_inverts_its_textbook_jacobian(pose, rng):
    mechanism = loaded("planar_3rrr")
    a, b, l1, l2 = mechanism.parameters.values()
    for configuration in mechanisms.random_closed(mechanism, rng, 10, 0.1, start=pose):
        platform = platform_pose(configuration)
        inverse, lengths = planar.inverse_3rrr(platform, configuration.actuated, a, b, l1)
        np.testing.assert_allclose(lengths, l2, atol=EXACT)
        J = in_plane(configuration)
        np.testing.assert_allclose(J @ inverse, np.eye(3), atol=EXACT * np.abs(J).max())


@pytest.mark.parametrize("pose", ["home", "mirrored", "shifted"])
def test_3rpr_inverts_its_textbook_jacobian(pose, rng):
    mechanism = loaded("planar_3rpr")
    for configuration in mechanisms.random_closed(mechanism, rng, 10, 0.03, start=pose):
        platform = platform_pose(configuration)
        inverse, lengths = planar.inverse_3rpr(platform, **mechanism.parameters)
        np.testing.assert_allclose(lengths, configuration.actuated, atol=EXACT)
        J = in_plane(configuration)
        np.testing.assert_allclose(J @ inverse, np.eye(3), atol=EXACT * np.abs(J).max())


def test_3rpr_modes_meet_where_the_legs_meet():
    """At equal legs l the angle is ±φ with l² = a² + b² − 2ab cos φ: both vanish at l = b − a."""
    mechanism = loaded("planar_3rpr")
    a, b = mechanism.parameters.values()
    home, mirrored = mechanism.pose("home"), mechanism.pose("mirrored")
    np.testing.assert_allclose(home.actuated, mirrored.actuated, atol=1e-9)
    for start, sign in ((home, 1), (mirrored, -1)):
        near = mechanism.close([b - a + 1e-4] * 3, guess=start)
        angle = np.arccos((a**2 + b**2 - (b - a + 1e-4) ** 2) / (2 * a * b))
        np.testing.assert_allclose(platform_pose(near), [0, 0, sign * angle], atol=1e-9)
        with pytest.raises(pj.ClosureError) as caught:
            mechanism.close([b - a - 1e-4] * 3, guess=start)
        assert np.abs(caught.value.reached.actuated - (b - a)).max() < 1e-5
    model = mechanism.model
    q = pin.neutral(model)
    for leg in ("l1", "l2", "l3"):
        q[model.joints[model.getJointId(leg)].idx_q] = b - a
    concurrent = mechanism.configuration(q).singularity()
    assert concurrent.kind == "gain"
    [free] = concurrent.free_motions.T  # the platform turns about its middle
    x, y, angle = (free[concurrent.passive_names.index(f"platform.{c}")] for c in ("x", "y", "rz"))
    assert max(abs(x), abs(y)) < 1e-9 < 0.1 < abs(angle)


# --- Published mechanisms ------------------------------------------------------------------------


def test_four_bar_of_drake():
    """Drake, examples/multibody/four_bar: ground 2 m, links 4 m, all turning about y.

    Its starting configuration is an isosceles trapezoid: q_A = atan √15 (75.52°), q_B = q_C =
    π − q_A (104.48°). It needs a stiff bushing where the loop is cut.
    """
    y = (0, 1, 0)
    joints = [
        ("A", "revolute", "world", "crank", (0, 0, 0), y),
        ("B", "revolute", "crank", "coupler", (4, 0, 0), y),
        ("C", "revolute", "world", "rocker", (-2, 0, 0), y),
        ("Bc", "fixed", "coupler", "Bc_bushing", (4, 0, 0)),
        ("Cb", "fixed", "rocker", "Cb_bushing", (4, 0, 0)),
    ]
    home = {"A": 1.3, "B": 1.8, "C": 1.8}
    loops = [("Bc_bushing", "Cb_bushing")]
    mechanism = mechanisms.build(joints, loops, ["A"], "coupler", home, ["B", "C"])
    assert mechanism.mobility == 1
    q_A = atan2(sqrt(15), 1)
    assert np.rad2deg(q_A) == pytest.approx(75.52, abs=5e-3)
    configuration = mechanism.close([q_A])
    np.testing.assert_allclose(configuration.passive, [pi - q_A, pi - q_A], atol=EXACT)
    rates = configuration.jacobian().passive_rates[:, 0]
    np.testing.assert_allclose(rates, trapezoid_rates(q_A), atol=EXACT)


def trapezoid_rates(q_A):
    """(dq_B, dq_C)/dq_A by the two closure equations of the trapezoid, in the plane x, −z."""
    along = np.array([cos(pi), sin(pi)])  # the coupler's direction at q_A + q_B = π
    crank, rocker = planar.unit(q_A), planar.unit(pi - q_A)
    columns = np.column_stack([planar.quarter(along), -planar.quarter(rocker)])
    # crank' + coupler' (1 + dq_B) = rocker' dq_C, all links of one length
    return np.linalg.solve(columns, -planar.quarter(crank) - planar.quarter(along))


def test_4r4p_of_acrod():
    """ACRoD (the package `acrod`), its example of a planar 4R-4P serial-parallel robot.

    Links 1 (base) to 7 (tool). d₁₂ and d₁₃ slide links 2 and 3 on the base, d₂₄ and d₃₄ slide
    link 4 on these; φ is a slide's angle from x. θ₄₅ turns link 5 on link 4, r a hinge's place;
    links 5 and 6 carry link 7. Motors d₁₂, d₁₃, θ₄₅; the tool's point is a = (1, 2).
    """
    phi = {"d12": 2 * pi / 3, "d13": pi / 3, "d24": pi / 3, "d34": 2 * pi / 3}
    a, r45, r46, r57, r67 = map(np.array, ((1, 2), (2, 8), (6, 8), (3, 10), (5, 10)))

    def place(point):
        return (*map(float, point), 0.0)

    slide = {name: (cos(angle), sin(angle), 0) for name, angle in phi.items()}
    joints = [
        ("d12", "prismatic", "link1", "link2", (0, 0, 0), slide["d12"]),
        ("d24", "prismatic", "link2", "link4", (0, 0, 0), slide["d24"]),
        ("d13", "prismatic", "link1", "link3", (0, 0, 0), slide["d13"]),
        ("theta45", "revolute", "link4", "link5", place(r45), Z),
        ("theta46", "revolute", "link4", "link6", place(r46), Z),
        ("theta57", "revolute", "link5", "link7", place(r57 - r45), Z),
        ("r67_6", "fixed", "link6", "r67_of_6", place(r67 - r46)),
        ("r67_7", "fixed", "link7", "r67_of_7", place(r67 - r57)),
        ("a", "fixed", "link7", "tool", place(a - r57)),
    ]
    loops = [
        pj.PrismaticLoop(frames=("link3", "link4"), axis=slide["d34"]),
        pj.RevoluteLoop(frames=("r67_of_6", "r67_of_7")),
    ]
    model = pin.buildModelFromXML(mechanisms.tree(*joints))
    mechanism = pj.Mechanism.from_pinocchio(model, loops, ["d12", "d13", "theta45"], "tool")
    assert mechanism.mobility == 3
    printed = [[-0.5, 0.5, -10.0], [0.8660254, 0.8660254, 3.0], [0.0, 0.0, -1.0]]
    np.testing.assert_allclose(in_plane(mechanism.home), printed, atol=5e-8)


# --- The drawings --------------------------------------------------------------------------------

PLANAR = ("slider_crank", "five_bar", "watt_six_bar", "planar_3rrr", "planar_3rpr")


@pytest.mark.parametrize("growth", [0.0, 0.07])
@pytest.mark.parametrize("name", PLANAR)
def test_bars_end_at_joints_whatever_the_parameters(name, growth):
    """Every eye of a link is on the axis of a joint or at an anchor of a loop."""
    given = {key: item.default + growth for key, item in loaded(name).spec.parameters.items()}
    home = pj.load(name, given).home
    model = home.mechanism.model
    data = model.createData()
    pin.framesForwardKinematics(model, data, home.q)
    frames = np.array([placement.translation[:2] for placement in data.oMf])
    eyes = [item for item in SceneMaker(home.mechanism).scene(home).items if "_eye" in item.name]
    assert len(eyes) >= 3
    for item in eyes:
        distance = np.linalg.norm(frames - item.transform[:2, 3], axis=1).min()
        assert distance < 1e-9, item.name
