"""Poses and what is found there in one go: what two calls say, bit by bit."""

from __future__ import annotations

import sys
from dataclasses import fields

import numpy as np
import pytest
from interrupter import Interrupter
from mechanisms import mostly_slow
from test_batch import NAMES, machine, targets
from test_filled_again import equal
from test_generic_ranks import taut_four_bar

import pmjac_pin as pj
from pmjac_pin.batches import filled_again, gathering, judge
from pmjac_pin.batches.many_rates import ManyRates
from pmjac_pin.batches.pieces import PIECE, pieces_of
from pmjac_pin.batches.rates_in_lanes import rates_kernel

CALLS = ("ellipsoids", "measures")


@pytest.mark.parametrize("call", CALLS)
@pytest.mark.parametrize("name", list(mostly_slow(NAMES, ("five_bar", "four_bar", "delta"))))
def test_the_same_as_by_two_calls(name, call, rng):
    """Also where paths end early, or a pose is outside limits."""
    many = pj.batch(machine(name))
    values = targets(many.mechanism, 10, 0.5, rng)
    expected = many.close(values)
    poses, found = getattr(many, f"{call}_at")(values)
    equal(poses, expected)
    equal(found, getattr(many, call)(expected.q))


def some_stop(values):
    values[3] += (2.0, -2.0)


def some_are_none(values):
    values[5] = np.nan


def nothing_more(values):
    pass


@pytest.mark.skipif(rates_kernel() is None, reason="no kernel was built")
@pytest.mark.parametrize("asked", [0.0, 0.79, 2.0])
@pytest.mark.parametrize("more", [nothing_more, some_stop, some_are_none])
@pytest.mark.parametrize("compiled", [False, pytest.param(True, marks=pytest.mark.slow)])
def test_in_one_call_of_the_kernel_where_it_can(more, asked, compiled, rng, monkeypatch):
    """Where all arrive, and J_eq is certain of all, of some or of none."""
    mechanism = machine("five_bar")
    values, apart = targets(mechanism, 200, 0.2, rng), []
    usual = np.median(pj.batch(mechanism).measures_at(values)[1].smallest)
    monkeypatch.setattr(judge, "_BY_SINGLE_CALLS", asked * usual)
    more(values)
    many = pj.batch(mechanism, compiled=compiled)
    expected = many.close(values, enforce_limits=False)
    rates, fill = many.ellipsoids(expected.q), ManyRates.fill
    _, certain = many._at_poses.ellipsoids().rates.fill(expected.q, rates.J_eq.copy())
    known = np.delete(certain, [3, 5]).mean()  # which may stop, or be none
    assert {0.0: known == 1.0, 0.79: 0.0 < known < 1.0, 2.0: known == 0.0}[asked]
    monkeypatch.setattr(ManyRates, "fill", lambda *given: apart.append(1) or fill(*given))
    poses, found = many.ellipsoids_at(values, enforce_limits=False)
    equal(poses, expected)
    equal(found, rates)
    assert len(apart) == (more is not nothing_more)
    assert (poses.status == pj.Status.CLOSED).all() == (more is nothing_more)


@pytest.mark.parametrize("call", CALLS)
def test_by_pieces_threads_and_guesses(call, rng):
    many = pj.batch(machine("five_bar"))
    values = targets(many.mechanism, 2 * PIECE + 10, 0.2, rng)
    guesses, told = many.close(values + 0.01).q, []
    expected = many.close(values, guess=guesses)
    poses, found = getattr(many, f"{call}_at")(
        values, guesses, threads=2, progress=lambda *given: told.append(given)
    )
    assert told[-1] == (len(values), len(values))
    equal(poses, expected)
    equal(found, getattr(many, call)(expected.q))


@pytest.mark.parametrize("name", ["five_bar", "three_rps"])
def test_in_any_order_of_guesses_and_calls(name, rng):
    """What a kernel was told for one call it does not take for the next."""
    mechanism = machine(name)
    values = targets(mechanism, 30, 0.1, rng)
    many, near = pj.batch(mechanism), mechanism.close(values[0])
    guesses = ["home", near, many.close(values).q]
    calls = [(of, guess) for of in ("close", "ellipsoids_at") for guess in guesses]
    expected = [getattr(pj.batch(mechanism), of)(values, guess) for of, guess in calls]
    for k in np.concatenate([rng.permutation(len(calls)) for _ in range(5)]).tolist():
        of, guess = calls[k]
        found = getattr(many, of)(values, guess)
        pairs = zip(found, expected[k], strict=True) if of != "close" else [(found, expected[k])]
        for one, other in pairs:
            equal(one, other)


@pytest.mark.parametrize("call", CALLS)
def test_filled_again(call, rng):
    many = pj.batch(machine("three_rps"))
    first, then = (targets(many.mechanism, 50, 0.2, rng) for _ in range(2))
    of = getattr(many, f"{call}_at")
    out, expected = of(first), of(then)
    again = of(then, out=out)
    for one, other, same in zip(again, out, expected, strict=True):
        assert one is other
        equal(one, same)


def test_a_structure_has_no_jacobian_either_way():
    """K* has its rank of home there, and no pose beside it closes: of its J_eq nothing is known."""
    many = pj.batch(taut_four_bar(["a"]))
    poses, found = many.ellipsoids_at([[0.0]] * 3)
    assert (poses.status == pj.Status.CLOSED).all()
    assert (found.status == pj.Status.SINGULAR).all()
    equal(found, many.ellipsoids(poses.q))


def test_what_cannot_be_filled_is_refused_and_stays(rng):
    many = pj.batch(machine("five_bar"))
    values = targets(many.mechanism, 20, 0.2, rng)
    poses, found = many.ellipsoids_at(values)
    _, measures = many.measures_at(values)
    shorter = many.ellipsoids_at(values[:7])
    for out in (poses, [poses, found], (poses,), (found, poses), (poses, measures), shorter):
        with pytest.raises(pj.ArgumentError, match="`out`"):
            many.ellipsoids_at(values, out=out)
    assert many.ellipsoids_at(values, out=(poses, found))[0] is poses


def test_whoever_interrupts_leaves_what_is_to_be_filled(rng, monkeypatch):
    many = pj.batch(machine("five_bar"))
    values = targets(many.mechanism, 20, 0.2, rng)
    out = many.ellipsoids_at(values)

    def interrupt(*given):
        raise KeyboardInterrupt

    for place, name in ((filled_again, "_check_to_be_filled"), (gathering, "filling_of")):
        with monkeypatch.context() as context:
            context.setattr(place, name, interrupt)
            with pytest.raises(KeyboardInterrupt):
                many.ellipsoids_at(values, out=out)
        assert many.ellipsoids_at(values, out=out)[0] is out[0]


def test_interrupted_at_any_step_it_can_be_filled_again(rng):
    many = pj.batch(machine("five_bar"))
    values = targets(many.mechanism, 3, 0.2, rng)
    out, expected, points = many.ellipsoids_at(values[::-1]), many.ellipsoids_at(values), 0
    while True:
        points += 1
        interrupter, before = Interrupter(points), sys.gettrace()
        sys.settrace(interrupter)
        try:
            many.ellipsoids_at(values, out=out)
        except KeyboardInterrupt:
            pass
        finally:
            sys.settrace(before)
        again = many.ellipsoids_at(values, out=out)
        assert again[0] is out[0]
        assert again[1] is out[1]
        if interrupter.left > 0:
            break
    assert points > 50
    for one, other in zip(out, expected, strict=True):
        equal(one, other)


@pytest.mark.parametrize(
    "again", [0, 1, *(pytest.param(k, marks=pytest.mark.slow) for k in (2, 5))]
)
def test_interrupted_at_any_step_and_again_what_is_not_done_says_so(again, rng):
    """Unless nothing is done: then all is as before."""
    many = pj.batch(machine("five_bar"))
    values = targets(many.mechanism, PIECE // 2 + 1000, 0.2, rng)
    assert len(pieces_of(len(values))) == 3
    expected, out = many.ellipsoids_at(values), many.ellipsoids_at(values[::-1])
    first, points, some = out[0].q.copy(), 1, 0
    while True:
        interrupter, before = Interrupter(points, again=again), sys.gettrace()
        sys.settrace(interrupter)
        try:
            many.ellipsoids_at(values, threads=1, out=out)
        except KeyboardInterrupt:
            pass
        finally:
            sys.settrace(before)
        if interrupter.left > 0:
            break
        points += 1
        for found, right in zip(out, expected, strict=True):
            known = found.status == pj.Status.CLOSED
            some += not known.all()
            if not (known.all() and np.array_equal(out[0].q, first)):
                assert (known | (found.status == pj.Status.NOT_DONE)).all()
                for one in fields(found):
                    of_it = getattr(found, one.name)[known]
                    np.testing.assert_array_equal(of_it, getattr(right, one.name)[known])
        many.ellipsoids_at(values[::-1], out=out)
    assert some > 50


def test_an_interrupt_keeps_both(rng):
    many = pj.batch(machine("five_bar"))
    values = targets(many.mechanism, 3 * PIECE, 0.1, rng)

    def stop(done, count):
        raise KeyboardInterrupt

    with pytest.raises(pj.Interrupted) as raised:
        many.measures_at(values, threads=1, progress=stop)
    poses, found = raised.value.done
    done = poses.status != pj.Status.NOT_DONE
    assert 0 < done.sum() < len(values)
    np.testing.assert_array_equal(found.status != pj.Status.NOT_DONE, done)
    equal_there = many.measures(poses.q[done])
    np.testing.assert_array_equal(found.J_eq[done], equal_there.J_eq)
    assert np.isnan(found.smallest[~done]).all()


def test_a_refused_pair_stays_what_it_is(rng):
    """The first of it is of another machine, and the second cannot be filled."""
    one, other = pj.batch(machine("four_bar")), pj.batch(machine("slider_crank"))
    poses, _ = one.ellipsoids_at(targets(one.mechanism, 9, 0.1, rng))
    values = targets(other.mechanism, 9, 0.1, rng)
    _, measures = other.measures_at(values)
    before = poses.joint("phi1").copy()
    with pytest.raises(pj.ArgumentError, match="`out`"):
        other.ellipsoids_at(values, out=(poses, measures))
    np.testing.assert_array_equal(poses.joint("phi1"), before)
