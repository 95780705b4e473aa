"""Over-actuation beside folds: led motors arrive on the side that the leading ones come from.

Of two motors on one freedom one leads, straight, and turns back at a fold of its path; the other
one's values are on either side of it. By hand, with fifty digits, each machine is one equation
between the two: the length of the rod between what they turn.
"""

from __future__ import annotations

import contextlib
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache

import mpmath as mp
import numpy as np
import pytest
from idling_rods import FOLDING_RSSR, rod_of_an_rssr
from mechanisms import NON_GRASHOF, with_motors

import pmjac_pin as pj
from pmjac_pin.closing.over_actuation import lead

#: How far the loops are open with the led motor where the fold is, of the characteristic length:
#: sides are told apart, and so near that they need not be.
TOLD = [10.0**-k for k in range(4, 12)]
NEARER = [1e-12, 1e-13, 1e-14, 1e-15]


@dataclass(frozen=True, eq=False)
class Tied:
    """A machine whose first motor leads, the equation between both, and where that one turns back.

    The equation is that of a length, m: how far the loops are open. `fold` are the values of both.
    """

    machine: pj.Mechanism
    equation: Callable
    fold: tuple

    def slope(self, leading, led):
        """Return the derivative by the led one, which has a sign on each side of the fold."""
        return mp.diff(lambda value: self.equation(leading, value), led)

    def beside(self, gap, far=False):
        """Return values that fit beside the fold, on the side of home or on the far one."""
        leading, led = self.fold
        curved = mp.diff(lambda value: self.equation(leading, value), led, 2)
        along = mp.diff(lambda value: self.equation(value, led), leading)
        at_home = self.slope(*map(mp.mpf, self.machine.home.actuated.tolist()))
        opened = mp.sign(curved) * gap * self.machine.characteristic_length
        there = mp.mpf(float(leading - opened / along))
        off = mp.sign(at_home * curved) * mp.sqrt(2 * (leading - there) * along / curved)
        off = -off if far else off
        own = mp.findroot(lambda value: self.equation(there, value), (led + off, led + 0.9 * off))
        assert mp.sign(self.slope(there, own)) == (-1 if far else 1) * mp.sign(at_home)
        return np.array([float(there), float(own)])


def four_bar(lengths, away=None):
    """Its rocker leads, and turns back where crank and coupler are in line.

    With the catalogue's home, or one where the crank is so far away from there.
    """
    base, crank, coupler, rocker = map(mp.mpf, lengths)

    def equation(phi, theta):
        x = base + rocker * mp.cos(phi) - crank * mp.cos(theta)
        y = rocker * mp.sin(phi) - crank * mp.sin(theta)
        return mp.hypot(x, y) - coupler

    reach = (crank + coupler) ** 2
    phi = mp.acos((reach - base**2 - rocker**2) / (2 * base * rocker))
    theta = mp.atan2(rocker * mp.sin(phi), base + rocker * mp.cos(phi))
    machine = pj.load("four_bar", dict(zip(("l0", "l1", "l2", "l3"), lengths, strict=True)))
    home = machine.home.q
    if away is not None:
        there = crank * mp.expjpi((theta + away) / mp.pi) - base
        inner = mp.acos((abs(there) ** 2 + rocker**2 - coupler**2) / (2 * rocker * abs(there)))
        angles = mp.arg(there) + inner, mp.arg(there) - inner
        near = min(angles, key=lambda angle: abs(mp.sin((angle - phi) / 2)))
        home = {"phi1": float(near), "theta1": float(theta + away), "phi2": 0.0}
    return Tied(with_motors(machine, ["phi1", "theta1"], home=home), equation, (phi, theta))


def random_four_bars(rng, count):
    """Such whose rocker turns back there, and leads from home."""
    found = []
    while len(found) < count:
        lengths = rng.uniform(0.5, 4.0, 4).round(3)
        base, crank, coupler, rocker = lengths.tolist()
        turns = abs(base - rocker) + 0.05 < crank + coupler < base + rocker - 0.05
        if not turns or 2.0 * lengths.max() > lengths.sum() - 0.05:
            continue
        away = rng.choice([-1, 1]) * rng.uniform(0.3, 0.8)
        with contextlib.suppress(pj.ClosureError, TypeError):  # a crank that reaches not so far
            one = four_bar(lengths.tolist(), away)
            if lead(one.machine.problem, one.machine.home._point).leading.tolist() == [0]:
                found.append(one)
    return found


def rssr(body):
    """Its crank leads; as a body, its rod spins about itself."""
    crank, rod = mp.mpf(FOLDING_RSSR["crank"]), mp.mpf(FOLDING_RSSR["rod"])
    foot, tip, axis = (mp.matrix(FOLDING_RSSR[name]) for name in ("foot", "rocker", "axis"))
    axis /= mp.norm(axis)
    across = mp.matrix([[0, -axis[2], axis[1]], [axis[2], 0, -axis[0]], [-axis[1], axis[0], 0]])

    def equation(theta, psi):
        turn = mp.eye(3) + mp.sin(psi) * across + (1 - mp.cos(psi)) * across**2
        apart = foot + turn * tip - crank * mp.matrix([mp.cos(theta), mp.sin(theta), 0])
        return mp.norm(apart) - rod

    def turns_back(theta, psi):
        return equation(theta, psi), mp.diff(lambda value: equation(theta, value), psi)

    fold = mp.findroot(turns_back, (-2.06465, 3.61896))
    return Tied(rod_of_an_rssr(body, ["theta", "psi"]), equation, tuple(fold))


MACHINES = {
    "four-bar": lambda: four_bar(NON_GRASHOF),
    "rssr, a distance": lambda: rssr(body=False),
    "rssr, a rod": lambda: rssr(body=True),
}


@cache
def tied(name):
    with mp.workdps(50):
        return MACHINES[name]()


@pytest.fixture(params=MACHINES)
def one(request):
    with mp.workdps(50):
        yield tied(request.param)


def test_the_first_motor_leads_from_home(one):
    assert lead(one.machine.problem, one.machine.home._point).leading.tolist() == [0]
    assert abs(one.equation(*one.fold)) < 1e-40
    assert abs(one.slope(*one.fold)) < 1e-20


def arrives(one, values, guess="home"):
    pose = one.machine.close(values, guess, enforce_limits=False)
    np.testing.assert_allclose(pose.actuated, values, rtol=0, atol=1e-15)
    assert pose.residual_norm <= one.machine.tolerance


@pytest.mark.parametrize("gap", TOLD)
def test_on_the_side_of_home_it_arrives(one, gap):
    arrives(one, one.beside(gap))


@pytest.mark.parametrize("gap", TOLD + NEARER)
def test_on_the_far_side_it_is_refused_and_said_why(one, gap):
    with pytest.raises(pj.ClosureError) as caught:
        one.machine.close(one.beside(gap, far=True), enforce_limits=False)
    error, led = caught.value, one.machine.actuated[1]
    assert error.residual_norm <= one.machine.tolerance
    assert "go there by motor values in between" in str(error)
    assert error.ties in str(error)
    if gap in TOLD:
        assert "The loops close at these values, but no straight path" in str(error)
        assert f"leads there: on it {led} goes to" in str(error)
        np.testing.assert_array_equal(error.reached.q, one.machine.home.q)
        assert error.share == 0.0


@pytest.mark.parametrize("gap", NEARER)
def test_nearer_than_sides_are_told_apart_it_arrives_or_is_refused(one, gap):
    try:
        arrives(one, one.beside(gap))
    except pj.ClosureError as error:
        assert "go there by motor values in between" in str(error)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(2))
def test_of_any_four_bar(seed):
    """Where its rocker alone comes near the fold, both together come there on its side of it."""
    near = 0
    with mp.workdps(50):
        for one in random_four_bars(np.random.default_rng(seed), 6):
            alone = with_motors(one.machine, ["phi1"])
            for gap in TOLD[1::2] + NEARER:
                with pytest.raises(pj.ClosureError):
                    one.machine.close(one.beside(gap, far=True), enforce_limits=False)
            for gap in TOLD[1::2]:
                values = one.beside(gap)
                try:
                    alone.close(values[:1], enforce_limits=False)
                except pj.ClosureError:
                    continue
                arrives(one, values)
                near += 1
    assert near > 4  # of 24


def test_at_the_fold_itself_both_sides_are_one(one):
    """There it arrives where the first motor alone does."""
    values = [float(value) for value in one.fold]
    alone = with_motors(one.machine, one.machine.actuated[:1])
    try:
        alone.close(values[:1], enforce_limits=False)
    except pj.ClosureError:
        with pytest.raises(pj.ClosureError, match="go there by motor values in between"):
            arrives(one, values)
    else:
        arrives(one, values)


def test_by_values_in_between_it_goes_to_the_far_side(one):
    """Beside the fold the other motor leads: from there it is no fold."""
    near = one.machine.close(one.beside(1e-3), enforce_limits=False)
    assert lead(near.problem, near._point).leading.tolist() == [1]
    for gap in (1e-6, 1e-9, 1e-12, 1e-15):
        arrives(one, one.beside(gap, far=True), near)


def test_where_the_motors_are_already_nothing_moves(one):
    """Also beside the fold, where no path of the first motor would say on which side that is."""
    near = one.machine.close(one.beside(1e-3), enforce_limits=False)
    there = one.machine.close(one.beside(1e-14), near, enforce_limits=False)
    np.testing.assert_array_equal(one.machine.close(there.actuated, there).q, there.q)


def test_many_at_once_say_the_same(one):
    gaps = [1e-6, 1e-11, 1e-13]
    sides = np.array([one.beside(gap, far) for gap in gaps for far in (False, True)])
    poses = pj.batch(one.machine).close(sides, enforce_limits=False)
    for values, status, q in zip(sides, poses.status, poses.q, strict=True):
        try:
            alone = one.machine.close(values, enforce_limits=False).q
        except pj.ClosureError as error:
            assert status == pj.Status.STOPPED
            alone = error.reached.q
        else:
            assert status == pj.Status.CLOSED
        np.testing.assert_array_equal(q, alone)
