"""Many poses at once are on the assembly modes that single calls keep to, beside folds, too.

`make targets` asks ten thousand targets of each mechanism and prints what became of them.
"""

from __future__ import annotations

import os
from collections import Counter
from dataclasses import dataclass

import numpy as np
import pytest
from humanoid import humanoid
from mechanisms import CATALOGUE, loaded
from recording import recorded, unrecorded

import pmjac_pin as pj
from pmjac_pin.values.arrays import Array

COUNT = int(os.environ.get("PMJAC_TARGETS", "0"))  # targets of each mechanism; 0: few
FEW, FEWER = 80, {"delta": 20, "stewart_gough": 40, "stewart_gough_dietmaier": 30}
SPREADS = (0.1, 0.5, 2.5)  # of the characteristic length, or rad: near home, far, across folds
BESIDE = [sign * 10.0**-k for k in range(2, 13) for sign in (1, -1)]  # of the way to a path's end
LIMITS = {False: slice(None), True: slice(0, None, 20), "all": slice(5, None, 20)}
#: Of a way, where K* is within 1e-6 of singular: at folds it grows as the way's root.
SHARE = 1e-8
#: Where it grows as the way itself: paths lead through what these are singular at.
CROSSED, CROSSED_SHARE = {"agile_eye", "delta_rods", "sarrus"}, 2e-5
WEAK = 2e-6  # of K*, relative: where paths end that come within 1e-6 of home's size
END = 1e-3  # of the characteristic length: ends of such paths, where K* hardly changes
BESIDE_A_FOLD = 1e-5  # of it: both modes that meet at a singular target, closed to tolerance
ROUNDING = 2e-14


def cases():
    """A quick one, and all the others."""
    for name in [*CATALOGUE, "humanoid"]:
        yield pytest.param(name, marks=[] if name == "five_bar" else [pytest.mark.slow])


def machine(name):
    return humanoid() if name == "humanoid" else loaded(name)


def around_home(mechanism, count, share, rng):
    """Random motor values: where a gear moves much, by as much less."""
    partition = mechanism.problem.partition
    size = share * partition.length * partition.column_scale[partition.actuated]
    return mechanism.home.actuated + size * rng.uniform(-1, 1, (count, size.size))


def beside_ends(many, count, rng):
    """Targets before and behind where paths end, on their ways; fewer where hardly any end."""
    home = many.mechanism.home.actuated
    far = around_home(many.mechanism, count, SPREADS[-1], rng)
    ways = many.close(far, enforce_limits=False)
    ends = np.flatnonzero(ways.status == pj.Status.STOPPED)
    chosen = rng.choice(ends, count) if ends.size else ends
    shares = (1.0 - rng.choice(BESIDE, chosen.size)) * ways.share[chosen]
    return home + shares[:, None] * (far[chosen] - home)


def all_targets(many, count, rng):
    """Half of them beside ends of paths where there are any."""
    beside = beside_ends(many, count // 2, rng)
    parts = np.array_split(np.arange(count - len(beside)), len(SPREADS))
    spread = [
        around_home(many.mechanism, part.size, share, rng)
        for part, share in zip(parts, SPREADS, strict=True)
    ]
    return rng.permutation(np.vstack([*spread, beside]))


@dataclass
class Path:
    """How a path ends by the single call."""

    status: pj.Status
    share: float
    q: Array


@dataclass
class Rates:
    """What single calls say of a pose, and how far its loops are open, of the length."""

    status: pj.Status
    jacobian: pj.EquivalentJacobian | None
    singularity: pj.Singularity
    gap: float


def path_alone(mechanism, values, limits):
    try:
        q = mechanism.close(values, enforce_limits=limits).q
    except pj.LimitError:
        return Path(pj.Status.LIMITS, np.nan, np.full(mechanism.nq, np.nan))
    except pj.ClosureError as error:
        reached = mechanism.home if error.reached is None else error.reached
        return Path(pj.Status.STOPPED, error.share, reached.q)
    return Path(pj.Status.CLOSED, 1.0, q)


def rates_alone(pose):
    known = pose.singularity(), pose.residual_norm / pose.mechanism.characteristic_length
    try:
        return Rates(pj.Status.CLOSED, pose.jacobian(), *known)
    except pj.SingularError:
        return Rates(pj.Status.SINGULAR, None, *known)
    except pj.NoJacobianError:
        return Rates(pj.Status.NO_JACOBIAN, None, *known)


def same(found, expected, bound):
    """Tell whether all numbers are equal, or as near as that."""
    with np.errstate(invalid="ignore"):
        return bool(np.all((found == expected) | (np.abs(found - expected) <= bound)))


def same_share(mechanism, found, expected):
    return same(found, expected, CROSSED_SHARE if mechanism.name in CROSSED else SHARE)


def same_end(mechanism, path, alone, rates):
    """Where K* is near singular, poses follow from motor values as badly as it is conditioned."""
    if path.status != alone.status or alone.status == pj.Status.LIMITS:
        return path.status == alone.status
    bound = END
    if alone.status == pj.Status.CLOSED:
        singular = rates.status == pj.Status.SINGULAR
        bound = BESIDE_A_FOLD if singular else ROUNDING / rates.singularity.smallest
    bound *= max(1.0, mechanism.characteristic_length)
    return same(path.q, alone.q, bound) and same_share(mechanism, path.share, alone.share)


def ends_on_its_way(mechanism, one, path, alone):
    """Tell whether a path ends where that of the single call leads, short before or behind its end.

    Where K* becomes small as the way itself, by a universal joint that is nearly stretched, say,
    steps decide where within what counts as singular it ends, and joints turn fast there.
    """
    if {path.status, alone.status} != {pj.Status.STOPPED}:
        return False
    home = mechanism.home.actuated
    there = path_alone(mechanism, home + path.share * (one - home), False)
    smallest = mechanism.configuration(path.q).singularity().smallest
    bound = ROUNDING / smallest * max(1.0, mechanism.characteristic_length)
    weak = smallest < WEAK and same(path.share, alone.share, CROSSED_SHARE)
    return weak and there.status == pj.Status.CLOSED and same(there.q, path.q, bound)


def same_rates(found, k, rates):
    """J_eq, radii and what tells how near singular a pose is: to rounding, as conditioned.

    Where loops are open by more, beside a fold, K* is one matrix or another by as much.
    """
    rounding = max(ROUNDING, rates.gap)
    singularity, jacobian = rates.singularity, rates.jacobian
    condition = singularity.condition if np.isfinite(singularity.condition) else 1.0
    pairs = [
        (found.smallest[k], singularity.smallest, singularity.smallest),
        (found.condition[k], singularity.condition, singularity.condition),
    ]
    if jacobian is not None:
        radii = [jacobian.velocity_ellipsoid().radii, jacobian.angular_ellipsoid().radii]
        pairs += [
            (found.J_eq[k], jacobian.J_eq, np.abs(jacobian.J_eq).max()),
            (found.velocity_radii[k], radii[0], jacobian.sizes[0]),
            (found.angular_radii[k], radii[1], jacobian.sizes[1]),
        ]
    near = (same(one, other, rounding * condition * size) for one, other, size in pairs)
    return found.status[k] == rates.status and all(near)


def comparisons(mechanism, many, values, limits):
    """Say of each target how its path ends by the single call, and what differs, if anything."""
    poses = many.close(values, enforce_limits=limits)
    found, jacobians = many.measures(poses.q), many.jacobian(poses.q)
    np.testing.assert_array_equal(jacobians.status, found.status)
    np.testing.assert_array_equal(jacobians.J_eq, found.J_eq)
    for k, one in enumerate(values):
        path = Path(pj.Status(int(poses.status[k])), poses.share[k], poses.q[k])
        alone = path_alone(mechanism, one, limits)
        rates = rates_alone(mechanism.configuration(path.q))
        ends = same_end(mechanism, path, alone, rates)
        if not ends and not ends_on_its_way(mechanism, one, path, alone):
            differs = f"at {one.tolist()} {path}, alone {alone}"
        else:
            differs = ""
        if not same_rates(found, k, rates):
            differs = f"measures at {path.q.tolist()}, alone {rates.singularity}"
        yield alone.status, path.status, differs


@pytest.mark.parametrize("name", list(cases()))
def test_many_at_once_are_what_single_calls_say(name, rng):
    mechanism, many = unrecorded(machine(name)), pj.batch(machine(name))
    values = all_targets(many, COUNT or FEWER.get(name, FEW), rng)
    counts, differing = Counter(), []
    for limits, part in LIMITS.items():
        for alone, status, differs in comparisons(mechanism, many, values[part], limits):
            counts[alone.name] += 1
            if status != alone:
                counts[f"{alone.name} alone and {status.name} at once"] += 1
            if differs:
                differing.append(differs)
    told = ", ".join(f"{count} {what}" for what, count in sorted(counts.items()))
    print(f"{name}: {told}; {len(differing)} differ")
    assert not differing, "\n".join(differing)


@pytest.mark.parametrize("name", ["agile_eye", "delta_rods", "sarrus"])
def test_what_is_arrived_at_right_behind_an_end_is_singular(name, rng):
    """Paths end where all of K* becomes small: behind, nothing is proven, and no J_eq told."""
    mechanism, many = loaded(name), pj.batch(loaded(name))
    home = mechanism.home.actuated
    far = around_home(mechanism, 200, SPREADS[-1], rng)
    ways = many.close(far, enforce_limits=False)
    ends = np.flatnonzero(ways.status == pj.Status.STOPPED)[:12]
    behind = 1.0 + 10.0 ** -np.arange(4.5, 7.0, 0.25)
    shares = (behind * ways.share[ends][:, None]).ravel()
    targets = home + shares[:, None] * np.repeat(far[ends] - home, behind.size, axis=0)
    poses, found = many.ellipsoids_at(targets, enforce_limits=False)
    assert (poses.status == pj.Status.CLOSED).any()
    assert not ((poses.status == pj.Status.CLOSED) & (found.status == pj.Status.CLOSED)).any()


@pytest.mark.parametrize("program", [recorded, unrecorded])
def test_a_singular_target_is_reached_wherever_the_step_before_has_ended(program):
    """Within 1e-6 of singular all along the last 1e-9 of the way, and 1e-4 m wide."""
    mechanism = program(loaded("planar_3rpr"))
    motors = [0.5796770734636645, 0.4308002843141029, 0.1488767894276454]
    pose = mechanism.close(motors, enforce_limits=False)
    assert rates_alone(pose).status == pj.Status.SINGULAR
    np.testing.assert_allclose(pose.actuated, motors, rtol=0, atol=1e-14)
    assert pose.residual_norm <= mechanism.tolerance

    def side(q):
        partition = mechanism.problem.partition
        K_star = partition.scaled(mechanism.problem.evaluate(q)[1])[:, partition.passive]
        in_plane = np.abs(K_star).max(axis=1) > 1e-9
        return np.linalg.slogdet(K_star[in_plane])[0]

    assert side(pose.q) == side(mechanism.home.q)  # has not gone through the fold
    behind = mechanism.home.actuated + (1.0 + 1e-7) * (motors - mechanism.home.actuated)
    with pytest.raises(pj.ClosureError, match="singularity"):
        mechanism.close(behind, enforce_limits=False)
