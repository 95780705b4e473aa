"""Sweeps over parameters: of all designs at once what each design's own mechanism says."""

from __future__ import annotations

import mechanisms
import numpy as np
import pytest
from mechanisms import loaded

import pmjac_pin as pj
from pmjac_pin.batches import designs
from pmjac_pin.studies.sweep import work

MEASURES = ("q", "share", "J_eq", "velocity_radii", "smallest", "position", "rotation")
QUICK = ("ankle", "five_bar", "slider_crank", "three_rps_ss")
SERVED = tuple(name for name in mechanisms.PARAMETRISED if name not in {"bennett", "serial_2r"})


def samples(mechanism, rng, *, count, poses, size, share):
    """Values of all parameters around the defaults, and of motors around home."""
    lengths = np.array(list(mechanism.parameters.values()))
    sizes = share * np.where(lengths, np.abs(lengths), 0.1 * mechanism.characteristic_length)
    table = lengths + sizes * rng.uniform(-1.0, 1.0, (count, lengths.size))
    slides = [mechanism.units[motor] == "m" for motor in mechanism.actuated]
    strokes = size * np.where(slides, mechanism.characteristic_length, 1.0)
    motors = mechanism.home.actuated + strokes * rng.uniform(
        -1.0, 1.0, (count * poses, strokes.size)
    )
    columns = zip(mechanism.parameters, np.repeat(table, poses, axis=0).T, strict=True)
    return dict(columns) | dict(zip(mechanism.actuated, motors.T, strict=True))


def swept(mechanism, given, monkeypatch, *, together):
    """The sweep, of all designs at once or each by its own; how many were built for it."""
    built = []

    def machine_at(machine, parameters, made=work._machine_at):
        built.append(parameters)
        return made(machine, parameters)

    with monkeypatch.context() as context:
        context.setattr(work, "_enough_designs", lambda _: 2 if together else np.inf)
        context.setattr(work, "_machine_at", machine_at)
        found = pj.sweep(
            mechanism, samples=given, measures=MEASURES, enforce_limits=False, workers=1
        )
    return found, len(built)


def assert_same(found, expected, tolerance):
    np.testing.assert_array_equal(found.status, expected.status)
    ended = found.status == pj.Status.STOPPED  # where poses and modes meet: hardly determined
    np.testing.assert_allclose(found.share, expected.share, rtol=0, atol=1e-6)
    for name in MEASURES:
        mine, theirs = found[name][~ended].to_numpy(), expected[name][~ended].to_numpy()
        scale = max(1.0, np.nanmax(np.abs(theirs), initial=0.0))
        np.testing.assert_allclose(mine, theirs, rtol=0, atol=tolerance * scale, err_msg=name)


@pytest.mark.parametrize("name", mechanisms.mostly_slow(mechanisms.PARAMETRISED, QUICK))
def test_of_every_mechanism(name, rng, monkeypatch):
    mechanism = loaded(name)
    given = samples(mechanism, rng, count=12, poses=2, size=0.05, share=0.04)
    found, built = swept(mechanism, given, monkeypatch, together=True)
    expected, _ = swept(mechanism, given, monkeypatch, together=False)
    assert_same(found, expected, 1e-12)
    assert built <= (2 if name in SERVED else 12)


@pytest.mark.slow
@pytest.mark.parametrize("name", SERVED)
def test_far_away_and_over_folds(name, rng, monkeypatch):
    mechanism = loaded(name)
    given = samples(mechanism, rng, count=40, poses=3, size=0.6, share=0.25)
    found, built = swept(mechanism, given, monkeypatch, together=True)
    expected, _ = swept(mechanism, given, monkeypatch, together=False)
    assert built < 40
    assert_same(found, expected, 1e-7)  # beside folds, J_eq and the share are as near as that


def test_a_four_bar_by_hand(monkeypatch, rng):
    """Where two circles meet, and the crank's velocity by Freudenstein's angles."""
    mechanism = loaded("four_bar")
    given = samples(mechanism, rng, count=30, poses=4, size=0.4, share=0.1)
    found, built = swept(mechanism, given, monkeypatch, together=True)
    assert built == 0
    assert (found.status == pj.Status.CLOSED).all()
    l0, l1, l2, l3, theta = (given[name] for name in ("l0", "l1", "l2", "l3", "theta1"))
    crank = l1 * np.exp(1j * theta)
    across = l0 - crank  # from the crank's tip to the rocker's pivot
    size = np.abs(across)
    inside = np.arccos((l2**2 + size**2 - l3**2) / (2 * l2 * size))
    coupler = np.angle(across) + inside
    rocker = np.angle(crank + l2 * np.exp(1j * coupler) - l0)
    phi1, phi2 = found.q.sel(entry="phi1"), found.q.sel(entry="phi2")
    np.testing.assert_allclose(np.exp(1j * phi1), np.exp(1j * rocker), atol=1e-12)
    np.testing.assert_allclose(np.exp(1j * phi2), np.exp(1j * (coupler - theta)), atol=1e-12)
    turning = l1 * np.sin(rocker - theta) / (l2 * np.sin(coupler - rocker))  # of the coupler
    middle = 1j * crank + 0.5j * l2 * np.exp(1j * coupler) * turning
    column = found.J_eq.sel(motor="theta1")
    np.testing.assert_allclose(column.sel(row="vx"), middle.real, atol=1e-11)
    np.testing.assert_allclose(column.sel(row="vy"), middle.imag, atol=1e-11)
    np.testing.assert_allclose(column.sel(row="wz"), turning, atol=1e-11)


@pytest.mark.parametrize("name", ["three_rps", "humanoid_ankle"])
def test_without_a_kernel(name, rng, monkeypatch):
    mechanism = loaded(name)
    given = samples(mechanism, rng, count=10, poses=2, size=0.2, share=0.05)
    expected, _ = swept(mechanism, given, monkeypatch, together=True)
    monkeypatch.setattr(designs, "many_paths_kernel", lambda: None)
    found, _ = swept(mechanism, given, monkeypatch, together=True)
    assert_same(found, expected, 1e-9)


def test_designs_that_files_do_not_allow(monkeypatch):
    """They are what their own mechanism says: an error, or no home."""
    mechanism, rest = loaded("four_bar"), np.linspace(0.9, 1.1, 5)
    far = {"l2": [*(3.0 * rest), 9.5], "theta1": np.full(6, 0.9)}
    found, built = swept(mechanism, far, monkeypatch, together=True)
    assert built == 1
    assert found.status[-1] == pj.Status.NOT_ASSEMBLED
    assert (found.status[:-1] == pj.Status.CLOSED).all()
    with pytest.raises(pj.ArgumentError, match="'l1' = -1 m is not within"):
        swept(mechanism, {"l1": [*rest, -1.0]}, monkeypatch, together=True)


def test_from_another_design(rng, monkeypatch):
    """Parameters that are not swept stay as the mechanism has them."""
    mechanism = loaded("five_bar").with_parameters(l2=0.42)
    given = {"l1": rng.uniform(0.28, 0.32, 8), "theta1": np.full(8, mechanism.home.actuated[0])}
    found, built = swept(mechanism, given, monkeypatch, together=True)
    expected, _ = swept(mechanism, given, monkeypatch, together=False)
    assert built == 0
    assert_same(found, expected, 1e-12)


def test_special_lengths(monkeypatch):
    """A loop of four hinges in space moves with special lengths alone: ranks are each design's."""
    mechanism = loaded("bennett")
    own = dict(mechanism.parameters)
    name = next(iter(own))
    values = own[name] * np.array([1.0, 1.0 + 1e-13, 1.01, 1.02, 0.98])
    found, _ = swept(mechanism, {name: values}, monkeypatch, together=True)
    expected, _ = swept(mechanism, {name: values}, monkeypatch, together=False)
    np.testing.assert_array_equal(found.status, expected.status)
    assert found.status[0] == pj.Status.CLOSED
    assert (found.status[2:] != pj.Status.CLOSED).all()


def test_limits_and_named_poses(monkeypatch):
    mechanism, count = loaded("three_rps"), 6
    lengths = np.linspace(0.95, 1.05, count)
    given = {"b": lengths, "l1": np.linspace(0.9, 9.0, count)}
    both = []
    for together in (True, False):
        monkeypatch.setattr(work, "_enough_designs", lambda _, on=together: 2 if on else np.inf)
        both.append(pj.sweep(mechanism, samples=given, measures=["q"], workers=1))
    found, expected = both
    np.testing.assert_array_equal(found.status, expected.status)
    assert (found.status == pj.Status.LIMITS).any()
    assert (found.status == pj.Status.CLOSED).any()
    closed = found.status == pj.Status.CLOSED
    np.testing.assert_allclose(found.q[closed], expected.q[closed], atol=1e-9)
