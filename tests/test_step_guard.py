"""No singularity passes unseen between two poses of a path: machines made to mislead."""

from __future__ import annotations

import contextlib
import math

import mechanisms
import numpy as np
import pinocchio as pin
import pytest
from ladder import ladder
from mechanisms import loaded

import pmjac_pin as pj
from pmjac_pin.closing.arms import without_arms
from pmjac_pin.closing.closed import closed_point, is_invertible
from pmjac_pin.closing.step_guard import StepGuard

NOTHING = np.full(1, 1e9)
RESOLVED = 1e-6  # the relative singular value that counts as zero


class FourBar:
    """Ground l0 at the angle beta, crank 1 m, coupler l2, rocker l3; one of two branches.

    It closes where |l2 − l3| ≤ d(θ) ≤ l2 + l3, d the diagonal from the crank's tip to the rocker's
    foot, and is singular where one of them is equal: at a fold, or where branches cross.
    """

    def __init__(self, beta, l0, l2, l3, branch):
        self.beta, self.l0, self.l2, self.l3, self.branch = beta, l0, l2, l3, branch

    def diagonal(self, theta):
        return math.sqrt(self.l0**2 + 1.0 - 2.0 * self.l0 * math.cos(theta - self.beta))

    def closure(self, theta):
        """Angles of coupler and rocker in the plane."""
        tip = np.array([math.cos(theta), math.sin(theta)])
        foot = self.l0 * np.array([math.cos(self.beta), math.sin(self.beta)])
        d, along = np.linalg.norm(foot - tip), math.atan2(*(foot - tip)[::-1])
        cosine = (self.l2**2 + d**2 - self.l3**2) / (2.0 * self.l2 * d)
        coupler = along + self.branch * math.acos(np.clip(cosine, -1.0, 1.0))
        joint = tip + self.l2 * np.array([math.cos(coupler), math.sin(coupler)])
        return coupler, math.atan2(*(joint - foot)[::-1])

    def margin(self, theta):
        """How far from singular, m: by which the diagonal is short or long of its bounds."""
        d = self.diagonal(theta)
        return min(self.l2 + self.l3 - d, d - abs(self.l2 - self.l3))

    def singular_angles(self):
        """Where the diagonal is at a bound, exactly or nearly: within rounding of it."""
        for bound in (self.l2 + self.l3, abs(self.l2 - self.l3)):
            cosine = (self.l0**2 + 1.0 - bound**2) / (2.0 * self.l0)
            if abs(cosine) <= 1.0 + 1e-15:
                aside = math.acos(np.clip(cosine, -1.0, 1.0))
                yield from (self.beta + aside, self.beta - aside)


def on_one_crank(bars, theta):
    """One crank that drives them all, closed at theta."""
    model, loops, q = pin.Model(), [], {"crank": theta}

    def add(parent, name, x, y=0.0):
        at = pin.SE3(np.eye(3), np.array([x, y, 0.0]))
        return model.addJoint(
            parent, pin.JointModelRZ(), at, name, NOTHING, NOTHING, -NOTHING, NOTHING
        )

    crank = add(0, "crank", 0.0)
    for n, bar in enumerate(bars):
        foot = bar.l0 * math.cos(bar.beta), bar.l0 * math.sin(bar.beta)
        links = (add(crank, f"c{n}", 1.0), bar.l2), (add(0, f"r{n}", *foot), bar.l3)
        for (joint, length), end in zip(links, "cr", strict=True):
            place = pin.SE3(np.eye(3), np.array([length, 0.0, 0.0]))
            frame = pin.Frame(f"{end}{n} end", joint, place, pin.FrameType.OP_FRAME)
            model.addFrame(frame, False)
        loops.append(pj.PointLoop(frames=(f"c{n} end", f"r{n} end")))
        coupler, rocker = bar.closure(theta)
        q |= {f"c{n}": coupler - theta, f"r{n}": rocker}
    return pj.Mechanism.from_pinocchio(model, loops, ["crank"], "c0 end", home=q)


def misleading(rng, count):
    """Bars with two folds a stated way apart, crossings, and narrow passages among plain ones."""
    bars, special = [], int(rng.integers(count))
    for n in range(count):
        beta, branch = rng.uniform(-np.pi, np.pi), int(rng.choice([-1, 1]))
        if n == special:
            # Flat at beta but for the excess: closed on both sides of it and open between
            # (two folds), branches that cross, or a passage.
            l0, excess = rng.uniform(1.5, 3.0), 10.0 ** rng.uniform(-17, -4)
            excess *= rng.choice([-1.0, 0.0, 1.0])
            bars.append(FourBar(0.0, l0, l0 + excess, 1.0, branch))
        else:  # a crank-rocker: never singular
            l0 = rng.uniform(2.5, 4.0)
            l2, l3 = l0 * rng.uniform(0.8, 1.1, 2)
            bars.append(FourBar(beta, l0, l2, l3, branch))
    return bars, special


def check(bars, theta, target):
    """Close at the target from theta: at the first singularity or, without one, at the target."""
    start = on_one_crank(bars, theta).home
    way = target - theta
    shares = [
        math.remainder(angle - theta, math.tau) / way
        for bar in bars
        for angle in bar.singular_angles()
    ]
    first = min((share for share in shares if 0.0 < share < 1.0), default=None)
    try:
        reached = start.mechanism.close([target], guess=start)
    except pj.ClosureError as error:
        reached = error.reached
        assert "meets a singularity" in str(error)
        if first is None:  # as near to singular as what counts as singular
            assert error.singular_value < 3 * RESOLVED
        else:
            away = abs(float(reached.actuated[0]) - (theta + first * way))
            assert away < 1e-4, (away, str(error))
        outcome = "stopped"
    else:
        assert first is None, (first, reached.singularity())
        outcome = "closed"
    at = float(reached.actuated[0])
    for n, bar in enumerate(bars):
        coupler, rocker = bar.closure(at)
        for name, value in ((f"c{n}", coupler - at), (f"r{n}", rocker)):
            off = math.remainder(reached.joint_values[name] - value, math.tau)
            assert abs(off) < 1e-9 + 1e-5 / math.sqrt(max(bar.margin(at), 1e-12))
    return outcome


def trial(rng):
    bars, special = misleading(rng, int(rng.choice([1, 2, 3, 8])))
    beta, half = bars[special].beta, 10.0 ** rng.uniform(-2.5, -0.3)
    start = beta - half
    if bars[special].margin(start) < 1e-8:
        return "no start"
    # Symmetric about the flat pose, or not; and never so far that others would matter.
    return check(bars, start, beta + rng.choice([1.0, 0.5, 2.0, rng.uniform(0.01, 2.0)]) * half)


class Crank:
    """A crank under a sliding platform, joined to it by a rod: singular at d = |L ± r|.

    Its K* is the same on both sides of a fold, or of a crossing, at slide 0: what a step's ends
    show is no change at all.
    """

    def __init__(self, crank, rod, height, branch):
        self.crank, self.rod, self.height, self.branch = crank, rod, height, branch

    def angle(self, slide):
        d = math.hypot(slide, self.height)
        cosine = (self.crank**2 + d * d - self.rod**2) / (2.0 * self.crank * d)
        aside = self.branch * math.acos(np.clip(cosine, -1.0, 1.0))
        return math.atan2(self.height, slide) + aside

    def margin(self, slide):
        d = math.hypot(slide, self.height)
        return min(self.rod + self.crank - d, d - abs(self.rod - self.crank))


def under_a_platform(crank, slide):
    model = pin.Model()
    motor, joint = (
        model.addJoint(0, kind, pin.SE3.Identity(), name, NOTHING, NOTHING, -NOTHING, NOTHING)
        for kind, name in ((pin.JointModelPX(), "slide"), (pin.JointModelRZ(), "crank"))
    )
    for name, body, at in (
        ("tip", joint, (crank.crank, 0.0, 0.0)),
        ("top", motor, (0.0, crank.height, 0.0)),
    ):
        place = pin.SE3(np.eye(3), np.array(at))
        model.addFrame(pin.Frame(name, body, place, pin.FrameType.OP_FRAME), False)
    home = {"slide": slide, "crank": crank.angle(slide)}
    loop = pj.DistanceLoop(frames=("tip", "top"), length=crank.rod)
    return pj.Mechanism.from_pinocchio(model, [loop], ["slide"], "top", home=home)


def under_a_platform_trial(rng):
    """Folds a way apart, a crossing, or a narrow passage, at slide 0 and from both sides."""
    rod, crank = 10.0 ** rng.uniform(-0.5, 0.5, 2)
    excess = 10.0 ** rng.uniform(-16, -3) * rng.choice([-1.0, 0.0, 1.0])
    half = 10.0 ** rng.uniform(-3, -0.3)
    machine = Crank(crank, rod, abs(rod - crank) - excess, int(rng.choice([-1, 1])))
    if machine.height < 0.05 or machine.margin(-half) < 1e-7:
        return "no start"
    start = under_a_platform(machine, -half).home
    try:
        reached = start.mechanism.close([half * rng.choice([0.1, 1.0, 2.0])], guess=start)
    except pj.ClosureError as error:
        if excess < -1e-9:  # a passage, unless it ends where the rod is stretched
            assert machine.margin(float(error.reached.actuated[0])) < 1e-9
        return "stopped"
    assert excess < -1e-15
    at = float(reached.actuated[0])
    off = math.remainder(reached.joint_values["crank"] - machine.angle(at), math.tau)
    assert abs(off) < 1e-8
    return "closed"


@pytest.mark.slow
def test_what_is_alike_at_both_ends_of_a_step_does_not_pass_unseen(rng):
    outcomes = [under_a_platform_trial(rng) for _ in range(60)]
    assert outcomes.count("stopped") > 10
    assert outcomes.count("closed") > 3


@pytest.mark.slow
@pytest.mark.parametrize("one", [trial, under_a_platform_trial])
def test_many_machines_made_to_mislead(one, rng):
    outcomes = [one(rng) for _ in range(250)]
    assert min(map(outcomes.count, ("stopped", "closed"))) > 12


@pytest.mark.parametrize("target", [0.0999, 0.1])
def test_a_singular_target_does_not_excuse_what_lies_before_it(target):
    """Two parallelograms on one crank: one is flat at 0, the other at 0.1 rad."""
    bars = [FourBar(0.0, 2.0, 2.0, 1.0, 1), FourBar(0.1, 2.0, 2.0, 1.0, 1)]
    mechanism = on_one_crank(bars, -0.005)
    with pytest.raises(pj.ClosureError, match="meets a singularity") as caught:
        mechanism.close([target])
    assert caught.value.reached.actuated[0] == pytest.approx(0.0, abs=1e-4)


def test_a_singular_target_is_reached():
    """The end of a path may be singular, and says so."""
    mechanism = on_one_crank([FourBar(0.0, 2.0, 2.0, 1.0, 1)], -0.3)
    reached = mechanism.close([0.0])
    assert reached.singularity().is_singular
    assert reached.actuated[0] == 0.0


def keeps_the_sign(mechanism, displacement):
    """Tell whether the determinant of K* is of one sign at both ends of a path.

    It is square, less the rows in which a planar machine moves nothing. True where the path ends,
    or leads to a singular pose.
    """
    partition, home = mechanism.problem.partition, mechanism.home
    try:
        pose = mechanism.close(home.actuated + displacement, enforce_limits=False)
    except pj.ClosureError:
        return True
    first, last = (
        partition.scaled(mechanism.problem.evaluate(q)[1])[:, partition.passive]
        for q in (home.q, pose.q)
    )
    moves = np.abs(first).max(axis=1) > 1e-9
    first, last = (np.linalg.slogdet(one[moves])[0] for one in (first, last))
    return first == last or pose.singularity().is_singular


@pytest.mark.parametrize("name", ["three_rps_ss", "planar_3rpr", "planar_3rrr", "five_bar"])
def test_no_path_leads_to_where_the_determinant_has_another_sign(name, rng):
    mechanism = loaded(name)
    partition = mechanism.problem.partition
    size = partition.length * partition.column_scale[partition.actuated]
    ways = size * rng.uniform(-2.5, 2.5, (60, size.size))
    assert all(keeps_the_sign(mechanism, way) for way in ways)


def test_branches_that_nearly_meet_are_not_taken_for_each_other(rng):
    """Two legs are hardly different, and so the modes on which the platform tilts either way."""
    mechanism = loaded("three_rps_ss")
    shares, aside = rng.uniform(0.15, 0.45, 60), 1e-3 * rng.normal(size=(60, 3))
    ways = shares[:, None] * [2.4, -1.05, -1.05] + aside
    assert all(keeps_the_sign(mechanism, way) for way in ways)


@pytest.mark.parametrize("name", mechanisms.SAMPLE)
def test_on_covered_steps_nothing_turns_into_its_opposite(name, rng, monkeypatch):
    """All of I + A⁺ (K*(q₁) − A) is regular between, whatever is measured there: ρ < 1."""
    mechanism = loaded(name)
    partition, sizes = mechanism.problem.partition, []

    def watched(covers):
        def told(guard, problem, start, end, *rates, **more):
            covered = covers(guard, problem, start, end, *rates, **more)
            if covered and partition.passive_rank:
                change = (end.scaled - start.scaled)[:, partition.passive]
                turned = start.factors.inverse(partition.passive_rank) @ change
                sizes.append(np.abs(np.linalg.eigvals(turned)).max())
            return covered

        return told

    for method in ("covers", "covers_straight"):
        monkeypatch.setattr(StepGuard, method, watched(getattr(StepGuard, method)))
    size = partition.length * partition.column_scale[partition.actuated]
    for way in size * rng.uniform(-2.5, 2.5, (12, size.size)):
        with contextlib.suppress(pj.ClosureError):
            mechanism.close(mechanism.home.actuated + way, enforce_limits=False)
    assert max(sizes, default=0.0) < 1.0
    assert bool(sizes) == bool(partition.passive_rank)


def test_loops_that_follow_one_another_take_no_shorter_steps():
    mechanism = ladder(24)
    assert mechanism.close(mechanism.home.actuated + 0.03).iterations <= 40


def test_machines_made_to_mislead(rng):
    outcomes = [trial(rng) for _ in range(50)]
    assert outcomes.count("stopped") > 10
    assert outcomes.count("closed") > 3


def judged(mechanism, target, monkeypatch):
    """The first step of a path, and what the guard knows of it: by its ends, and by more."""
    ends, known = [], []
    contracts, covers = StepGuard._contracts, StepGuard.covers
    guard, problem = mechanism.step_guard, mechanism.problem

    def recorded(guard, step, basis):
        known.append(step)
        return contracts(guard, step, basis)

    def told(guard, problem, start, end, leaving, arriving):
        ends.append((start, end, leaving, arriving))
        return covers(guard, problem, start, end, leaving, arriving)

    with monkeypatch.context() as context:
        context.setattr(StepGuard, "covers", told)
        context.setattr(StepGuard, "covers_straight", lambda *_: False)
        mechanism.close(target, enforce_limits=False)
    with monkeypatch.context() as context:
        context.setattr(StepGuard, "_contracts", recorded)
        guard.covers_straight(problem, *ends[0][:2])
        guard.covers(problem, *ends[0])
    return ends[0], known[0], known[1]


def test_where_ends_alone_cover_a_step_it_ends_at_an_invertible_pose(rng, monkeypatch):
    """So that nobody has to look: on steps into folds and out of them, too."""
    seen, covers = [], StepGuard.covers_straight

    def watched(guard, problem, start, end):
        covered = covers(guard, problem, start, end)
        if covered:
            weakest = end.factors.singular_values[problem.partition.passive_rank - 1]
            assert is_invertible(end, problem.partition)
            seen.append(weakest / end.factors.size)
        return covered

    monkeypatch.setattr(StepGuard, "covers_straight", watched)
    mechanism = pj.load("planar_3rrr")
    for _ in range(6):
        with pytest.raises(pj.ClosureError) as caught:
            mechanism.close(
                mechanism.home.actuated + 10.0 * rng.normal(size=3), enforce_limits=False
            )
        pose, fold = mechanism.home, caught.value.reached.actuated
        for left in 10.0 ** np.arange(-1.0, -9.0, -1.0):
            for share in (left, 0.9 * left):
                target = fold + share * (mechanism.home.actuated - fold)
                with contextlib.suppress(pj.ClosureError):
                    pose = mechanism.close(target, guess=pose, enforce_limits=False)
    assert len(seen) > 30
    assert min(seen) < 1e-3


def test_ends_alone_prove_nothing_of_joints_that_are_not_known():
    mechanism = loaded("four_bar")
    problem, model = mechanism.problem, mechanism.kinematics.model
    near = mechanism.close(mechanism.home.actuated + 1e-3)
    ends = [closed_point(problem, pose.q.copy()) for pose in (mechanism.home, near)]
    assert mechanism.step_guard.covers_straight(problem, *ends)
    unknown = StepGuard(model, without_arms(model, len(mechanism.rows)))
    assert not unknown.covers_straight(problem, *ends)


@pytest.mark.parametrize(
    "name",
    ["four_bar", "five_bar", "watt_six_bar", "three_rps", "delta", "stewart_gough", "bennett"],
)
def test_what_lies_between_measured_poses_is_bounded(name, monkeypatch, rng):
    """K* beside the parabola through three of them, η beside zero: by what the guard adds.

    Neither may be left out: the bounds are within a few powers of ten of what there is.
    """
    mechanism = loaded(name)
    problem, model = mechanism.problem, mechanism.kinematics.model
    slides = np.array([mechanism.units[motor] == "m" for motor in mechanism.actuated])
    size = 0.2 * np.where(slides, mechanism.characteristic_length, 1.0)
    target = mechanism.home.actuated + size * rng.choice([-1.0, 1.0], size.size)
    (start, end, leaving, arriving), chord, step = judged(mechanism, target, monkeypatch)
    way = pin.difference(model, start.q, end.q)
    arriving = pin.dDifference(model, start.q, end.q, pin.ArgumentPosition.ARG1) @ arriving
    passive = problem.partition.passive

    def curve(s):
        return leaving * s * (1 - s) ** 2 + way * s**2 * (3 - 2 * s) + arriving * s**2 * (s - 1)

    def at(x):
        residual, jacobian = problem.evaluate(pin.integrate(model, start.q, x))
        scaled = problem.partition.scaled(jacobian)[:, passive]
        return residual * problem.partition.row_scale, scaled

    (_, first), (_, middle), (_, last) = (at(curve(s)) for s in (0.0, 0.5, 1.0))
    aside, opened = [], []
    for s in np.linspace(0.05, 0.95, 19):
        residual, scaled = at(curve(s))
        parabola = first * (1 - s) * (1 - 2 * s) + middle * 4 * s * (1 - s) + last * s * (2 * s - 1)
        assert (np.abs(scaled - parabola) <= step.left_out + 1e-14).all()
        assert (np.abs(residual) <= step.open_by + 1e-15).all()
        aside.append(np.abs(scaled - parabola).max())
        opened.append(np.abs(residual).max())
    assert step.left_out.max() / 1e4 < max(aside) > 1e-9
    assert step.open_by.max() / 1e4 < max(opened) > 1e-10
    # What is seen off closure turns with the second frame: by as much as the loops are open there.
    per_gap = problem.partition.column_scale[passive]
    bent, opened = [], []
    for s in np.linspace(0.05, 0.95, 19):
        residual, scaled = at(s * way)
        off = np.linalg.norm(residual) * per_gap
        bent.append(np.abs(scaled - first * (1 - s) - last * s))
        assert (bent[-1] <= chord.left_out + off + 1e-14).all()
        assert (np.abs(residual) <= chord.open_by + 1e-15).all()
        opened.append(np.abs(residual).max())
    assert chord.left_out.max() / 1e3 < np.max(bent) > 1e-7
    assert chord.open_by.max() / 1e3 < max(opened) > 1e-8
