"""What is unpickled is what was pickled, and once; or it is refused."""

from __future__ import annotations

import concurrent.futures
import gc
import multiprocessing
import pickle
import weakref

import numpy as np
import pinocchio as pin
import pytest
from mechanisms import CATALOGUE, SAMPLE, mostly_slow
from test_dynamics import heavy
from transformed import moved

import pmjac_pin as pj
from pmjac_pin.mechanism_value import _MECHANISMS
from pmjac_pin.model.loop_spec import LOOP_KINDS, PointLoop
from pmjac_pin.values.made_lately import MadeLately

PROTOCOLS = range(2, pickle.HIGHEST_PROTOCOL + 1)
STEP = 0.01  # m or rad, from home


def regular(name):
    """Return a configuration off home, its mechanism read for itself: no other call counts."""
    mechanism = pj.load(name)
    return mechanism.close(mechanism.home.actuated + STEP, enforce_limits=False)


def answers(configuration):
    """What a configuration says, and one that is closed from it; what it refuses, in words."""
    mechanism = configuration.mechanism
    towards = configuration.actuated + 0.5 * STEP
    rates = np.linspace(0.1, 0.2, len(towards))
    asked = {
        "q": lambda: configuration.q,
        "gap": lambda: configuration.residual_norm,
        "J_eq": lambda: configuration.jacobian().J_eq,
        "split": lambda: configuration.split_jacobian().constraint_jacobian,
        "singularity": lambda: configuration.singularity().singular_values,
        "tool": lambda: configuration.tool_pose().homogeneous,
        "onward": lambda: mechanism.close(towards, guess=configuration, enforce_limits=False).q,
        "efforts": lambda: configuration.statics([1.0, 2.0, 3.0, 4.0, 5.0, 6.0]).efforts,
        "masses": lambda: configuration.dynamics().mass_matrix,
        "motion": lambda: configuration.motion(rates).bias,
        "home": lambda: mechanism.home.q,
        "place": lambda: mechanism.place,
    }
    return {name: answer(of) for name, of in asked.items()}


def answer(of):
    try:
        return np.asarray(of())
    except pj.PmjacError as error:
        return np.asarray(str(error))


def assert_the_same(found, expected):
    """The q to the last bit; sums of products may depend on where in memory vectors lie."""
    np.testing.assert_array_equal(found["q"], expected["q"])
    for name, value in expected.items():
        if value.dtype.kind == "U":
            assert found[name] == value, name
            continue
        close = 1e-12 * np.abs(value).max(initial=0.0)
        np.testing.assert_allclose(found[name], value, rtol=0, atol=close, err_msg=name)


@pytest.mark.parametrize("name", mostly_slow(CATALOGUE))
def test_an_unpickled_configuration_answers_the_same(name):
    """After the original is gone, too."""
    configuration = regular(name)
    sent, expected = pickle.dumps(configuration), answers(configuration)
    spec, urdf, model = (getattr(configuration.mechanism, of) for of in ("spec", "urdf", "model"))
    gone = weakref.ref(configuration.mechanism)
    del configuration
    gc.collect()
    assert gone() is None
    again = pickle.loads(sent)
    assert_the_same(answers(again), expected)
    assert again.mechanism.spec == spec
    assert again.mechanism.urdf == urdf
    assert again.mechanism.model == model


@pytest.mark.parametrize("protocol", PROTOCOLS)
@pytest.mark.parametrize("name", ["serial_2r", "three_rps"])
def test_every_protocol_says_the_same(name, protocol):
    configuration = regular(name)
    again = pickle.loads(pickle.dumps(configuration, protocol))
    assert_the_same(answers(again), answers(configuration))


@pytest.mark.slow
def test_a_fresh_process_answers_the_same():
    context = multiprocessing.get_context("spawn")
    configurations = [regular(name) for name in SAMPLE]
    with concurrent.futures.ProcessPoolExecutor(1, mp_context=context) as pool:
        for configuration, found in zip(
            configurations, pool.map(answers, configurations), strict=True
        ):
            assert_the_same(found, answers(configuration))


def test_machines_that_have_masses(rng):
    mechanism = heavy("three_rps", rng)
    again = pickle.loads(pickle.dumps(mechanism.home))
    assert_the_same(answers(again), answers(mechanism.home))
    np.testing.assert_array_equal(
        again.dynamics().mass_matrix, mechanism.home.dynamics().mass_matrix
    )


def test_far_from_the_origin_and_at_other_parameters():
    place = pin.SE3(np.eye(3), np.array([5e5, 0.0, 0.0]))
    for mechanism in (
        moved(pj.load("three_rps"), place),
        pj.load("four_bar", {"l1": 1.2}),
    ):
        again = pickle.loads(pickle.dumps(mechanism))
        assert again == mechanism
        assert again.parameters == mechanism.parameters
        assert again.urdf == mechanism.urdf
        np.testing.assert_array_equal(again.place, mechanism.place)
        assert_the_same(answers(again.home), answers(mechanism.home))
    longer, expected = (one.with_parameters({"l1": 1.3}) for one in (again, mechanism))
    assert longer == expected
    assert longer.urdf == expected.urdf


def test_poses_of_one_machine_have_it_once():
    """In one pickle, in pickles of their own, and sent on from where they arrived."""
    home, other = pj.load("four_bar").home, regular("four_bar").mechanism.home
    together = pickle.loads(pickle.dumps([home, {"there": home.mechanism.close([0.9])}]))
    apart = pickle.loads(pickle.dumps(home))
    mechanism = apart.mechanism
    assert together[0].mechanism is together[1]["there"].mechanism is mechanism
    assert pickle.loads(pickle.dumps(other)).mechanism is mechanism
    assert mechanism is not home.mechanism
    assert len(pickle.dumps([home] * 2 + [home.mechanism.close([0.9])])) < 1.1 * len(
        pickle.dumps(home)
    )
    assert_the_same(answers(pickle.loads(pickle.dumps(apart))), answers(home))


def test_siblings_have_their_blueprint_once():
    mechanism = pj.load("four_bar")
    longer = mechanism.with_parameters({"l1": 1.2})
    first, second = (pickle.loads(pickle.dumps(one)) for one in (mechanism, longer))
    assert first != second == longer
    assert first.blueprint is second.blueprint


def test_machines_that_differ_are_not_taken_for_each_other(rng):
    four_bar = pj.load("four_bar")
    lengths = [1.0, 1.0 + 2.0**-52, *rng.uniform(1.0, 1.2, 5)]
    machines = [four_bar.with_parameters({"l1": length}) for length in lengths]
    machines += [four_bar.with_tool(tool) for tool in ("rocker", "ground")]
    machines += [pj.load("four_bar", tool_rows=[row]) for row in ("vx", "vy")]
    sent = [pickle.dumps(machine) for machine in machines]
    assert len(set(map(len, sent))) < len(sent)  # some are as long as others
    for machine, pickled in zip(machines * 2, sent * 2, strict=True):
        again = pickle.loads(pickled)
        assert again == machine
        assert again.parameters == machine.parameters
        assert again.urdf == machine.urdf


def test_what_is_kept_of_mechanisms_is_bounded():
    mechanism = pj.load("four_bar")
    sent = [
        pickle.dumps(mechanism.with_parameters({"l1": length}))
        for length in np.linspace(1.0, 1.2, 9)
    ]
    first = weakref.ref(pickle.loads(sent[0]))
    assert first() is not None
    for one in sent[1:]:
        pickle.loads(one)
    gc.collect()
    assert first() is None


def test_the_latest_are_kept_and_no_more_than_their_bytes_allow():
    lately, made = MadeLately(most=3, most_bytes=10), []

    def of(said):
        return lately.of(said, (), lambda: made.append(said) or said)

    for said in (b"one", b"two", b"one", b"three", b"one", b"two"):
        of(said)
    assert made == [b"one", b"two", b"three", b"two"]  # "three" and "one" fill 8 of 10
    made.clear()
    for said in (b"a longer one", b"a longer one", b"two"):
        of(said)
    assert made == [b"a longer one", b"a longer one"]


def test_what_could_not_be_made_is_tried_again():
    lately = MadeLately(most=3, most_bytes=10)
    with pytest.raises(ZeroDivisionError):
        lately.of(b"one", (), lambda: 1 / 0)
    assert lately.of(b"one", (), lambda: 1) == 1


def test_a_kind_of_loop_that_means_something_else_now(monkeypatch):
    class OtherPointLoop(PointLoop, frozen=True, tag="point"):
        pass

    sent = pickle.dumps(pj.load("four_bar"))
    before = pickle.loads(sent)
    monkeypatch.setitem(LOOP_KINDS, "point", OtherPointLoop)
    assert isinstance(pickle.loads(sent).spec.loops[0], OtherPointLoop)
    monkeypatch.undo()
    assert pickle.loads(sent) is before


def test_threads_that_unpickle_at_once():
    homes = [pj.load(name).home for name in ("four_bar", "five_bar", "slider_crank")]
    sent = [pickle.dumps(home) for home in homes]

    def unpickled(k):
        if k % 7 == 0:
            _MECHANISMS.clear()
        return pickle.loads(sent[k % 3])

    with concurrent.futures.ThreadPoolExecutor(8) as pool:
        for k, again in enumerate(pool.map(unpickled, range(120))):
            assert again.mechanism == homes[k % 3].mechanism
            np.testing.assert_array_equal(again.q, homes[k % 3].q)


def test_one_changed_bit_gives_no_other_machine(rng):
    """Every byte around what is sealed, and some of those within."""
    configuration = regular("four_bar")
    sent = pickle.dumps(configuration)
    inside = sent.index(configuration.mechanism._sealed)
    around = set(range(len(sent))) - set(
        range(inside, inside + len(configuration.mechanism._sealed))
    )
    refused = 0
    for at in [*around, *rng.integers(inside, len(sent), 100)]:
        changed = bytearray(sent)
        changed[at] ^= 1 << int(rng.integers(8))
        try:
            again = pickle.loads(bytes(changed))
            again = again if isinstance(again, pj.Configuration) else None
        except Exception:
            again = None
        if again is None:
            refused += 1
            continue
        assert again.mechanism == configuration.mechanism
        np.testing.assert_allclose(again.q, configuration.q, atol=1e-11)
    assert refused > 150


def test_a_damaged_pickle_is_refused_in_words():
    """A digit of a length is as good a digit as any other: nothing else would tell."""
    mechanism = pj.load("serial_2r")
    sent = pickle.dumps(mechanism)
    sealed = mechanism._sealed
    digit = sealed.index(b"1.0", 100)
    damaged = sent.replace(sealed, sealed[:digit] + b"3" + sealed[digit + 1 :])
    assert damaged != sent
    with pytest.raises(pj.ArgumentError, match="do not have the digest"):
        pickle.loads(damaged)
    make, (kind, _) = mechanism.__reduce__()
    with pytest.raises(pj.ArgumentError, match="holds bytes, got"):
        make(kind, "text")


def test_a_urdf_is_opened_when_it_is_looked_at():
    urdf = pj.load("four_bar").urdf
    again = pickle.loads(pickle.dumps(pickle.loads(pickle.dumps(urdf))))
    assert "joints" not in vars(again)
    assert again == urdf
    assert again.joints == urdf.joints
    assert again.kinematic_xml() == urdf.kinematic_xml()
    assert pickle.loads(pickle.dumps(again)) == urdf
    with pytest.raises(AttributeError, match="jointz"):
        _ = pickle.loads(pickle.dumps(urdf)).jointz
