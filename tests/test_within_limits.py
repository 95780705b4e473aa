"""More motors than freedoms: the efforts of least norm within the limits of each motor."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import linprog, nnls
from test_dynamics import heavy
from test_statics import left_over
from transformed import rebuilt

import pmjac_pin as pj

#: Machines, and how many further motors they get.
TIED = {"five_bar": 1, "four_bar": 2, "planar_3rrr": 2, "three_rps": 2, "watt_six_bar": 1}


def tied(name, rng):
    whole = heavy(name, rng)
    spec = whole.spec
    single = {name for name, value in whole.home.joint_values.items() if np.isscalar(value)}
    more = [joint for joint in whole.passive if joint in single]
    chosen = [str(joint) for joint in rng.permutation(more)[: TIED[name]]]
    machine = pj.Mechanism.from_pinocchio(
        whole.model,
        spec.loops,
        [*spec.actuated, *chosen],
        spec.tool.frame or spec.tool.points,
        home=whole.home.q,
    )
    return machine.home, len(chosen)


def loaded(name, rng):
    configuration, more = tied(name, rng)
    wrench = rng.normal(size=6) * 10.0
    return configuration, wrench, configuration.statics(wrench), more


def counted(configuration):
    """What efforts are counted by, where their norm is taken."""
    return configuration.mechanism.problem.partition.motor_scale


@pytest.mark.parametrize("name", TIED)
def test_all_that_balances_a_load_is_told(name, rng):
    """Efforts and loop forces of any share between the motors, on every freedom of the tree."""
    configuration, wrench, statics, more = loaded(name, rng)
    assert statics.internal_efforts.shape[1] == more
    scaled = counted(configuration)[:, None] * statics.internal_efforts
    np.testing.assert_allclose(scaled.T @ scaled, np.eye(more), atol=1e-12)
    for share in rng.normal(size=(3, more)) * 5.0:
        efforts = statics.efforts + statics.internal_efforts @ share
        forces = statics.loop_forces + statics.internal_forces @ share
        other = type("Held", (), {"efforts": efforts, "loop_forces": forces})
        left = left_over(configuration, other, wrench)
        np.testing.assert_allclose(left, 0, atol=1e-9 * max(1.0, np.abs(forces).max()))


@pytest.mark.parametrize("tight", [1.0 + 1e-7, 1.01, 1.3, 2.0])
@pytest.mark.parametrize("name", TIED)
def test_the_least_within_limits_has_multipliers_of_one_sign(name, tight, rng):
    """Karush, Kuhn and Tucker: S²τ + Σ μᵢ sign(τᵢ) eᵢ ⊥ internal efforts, μ ≥ 0, 0 within."""
    configuration, wrench, statics, _ = loaded(name, rng)
    scale = counted(configuration)
    limits = rng.uniform(0.3, 3.0, scale.size) * np.abs(statics.efforts).max()
    limits *= tight * least_share(statics, limits)
    found = statics.within(limits)
    assert (np.abs(found.efforts) <= limits * (1.0 + 1e-9)).all()
    left = left_over(configuration, found, wrench)
    np.testing.assert_allclose(left, 0, atol=1e-9 * max(1.0, np.abs(found.loop_forces).max()))
    ways, at = statics.internal_efforts, np.abs(found.efforts) > limits * (1.0 - 1e-7)
    slope = ways.T @ (scale**2 * found.efforts)
    size = np.linalg.norm(scale * found.efforts)
    pushing = (ways[at] * np.sign(found.efforts[at])[:, None]).T
    off = nnls(pushing, -slope / size)[1] if at.any() else np.linalg.norm(slope) / size
    assert off < 1e-9


def least_share(statics, limits):
    """Of the limits, the least factor with which some efforts are within them; by bisection."""

    def possible(factor):
        ways = np.vstack([statics.internal_efforts, -statics.internal_efforts])
        room = np.r_[factor * limits - statics.efforts, factor * limits + statics.efforts]
        free = np.zeros(ways.shape[1])
        return linprog(free, A_ub=ways, b_ub=room, bounds=(None, None)).status == 0

    low, high = 0.0, (np.abs(statics.efforts) / limits).max()
    while high - low > 1e-9 * high:
        middle = 0.5 * (low + high)
        low, high = (low, middle) if possible(middle) else (middle, high)
    return high


@pytest.mark.parametrize("name", TIED)
def test_where_no_efforts_are_within_it_says_which_motors_lack_how_much(name, rng):
    _, _, statics, _ = loaded(name, rng)
    limits = rng.uniform(0.3, 3.0, statics.efforts.size)
    factor = least_share(statics, limits)
    limits *= 0.8 * factor
    with pytest.raises(pj.EffortLimitError, match="shared at best it takes") as caught:
        statics.within(limits)
    lacking, names = caught.value.lacking, statics.partition.actuated_names
    assert statics.within(limits * 1.2501) is not None
    which = [names.index(motor) for motor in lacking]
    needed = {k: limits[k] + lacking[names[k]] for k in which}
    assert max(needed[k] / limits[k] for k in which) == pytest.approx(1.25, rel=1e-6)
    told = (f"{names[k]} {needed[k]:.6g} of {limits[k]:.6g}" for k in which)
    assert all(each in str(caught.value) for each in told)
    relieved = np.linalg.norm(statics.internal_efforts, axis=1) > 1e-9
    for k in which:
        if not relieved[k]:
            assert needed[k] == pytest.approx(abs(statics.efforts[k]))
    # All others without limits, these alone are not enough: not until all are so much higher.
    sharing = [k for k in which if relieved[k]]
    endless = np.full(limits.size, 1e6)
    for more, enough in ((0.9999, False), (1.0001, True)):
        endless[sharing] = more * np.array([needed[k] for k in sharing])
        assert not sharing or (least_share(statics, endless) <= 1.0) == enough


def test_what_is_within_already_stays(rng):
    _, _, statics, _ = loaded("five_bar", rng)
    wide = statics.within(np.abs(statics.efforts) * 1.01 + 1e-3)
    np.testing.assert_array_equal(wide.efforts, statics.efforts)
    np.testing.assert_array_equal(wide.loop_forces, statics.loop_forces)


def test_of_one_way_to_share_it_is_asked_whether_it_is_within():
    home = pj.load("three_rps").home
    statics = home.statics([0, 0, -30.0, 0, 0, 0], gravity=False)  # 11.547 N each
    assert statics.within([12.0, 11.6, 11.55]).efforts == pytest.approx(statics.efforts)
    with pytest.raises(pj.EffortLimitError, match=r"it takes l2 11\.547 of 10$") as caught:
        statics.within([12.0, 10.0, 12.0])
    assert caught.value.lacking == pytest.approx({"l2": 1.5470054})


def test_limits_of_the_model():
    """100 N of each leg of the 3-RPS; a motor without a limit is named."""
    home = pj.load("three_rps").home
    heavy_load = home.statics([0, 0, -200.0, 0, 0, 0], gravity=False)
    np.testing.assert_array_equal(heavy_load.within().efforts, heavy_load.efforts)
    with pytest.raises(pj.EffortLimitError, match=r"l1 115\.47 of 100"):
        home.statics([0, 0, -300.0, 0, 0, 0], gravity=False).within()
    mechanism = pj.load("five_bar")
    model = mechanism.model
    model.upperEffortLimit[mechanism.problem.partition.actuated[1]] = 0.0
    with pytest.raises(pj.ArgumentError, match="states no effort limit of theta2: give limits"):
        rebuilt(mechanism, model).home.statics().within()


@pytest.mark.parametrize(
    ("limits", "message"),
    [
        ([1.0], r"motor limits: 2 numbers expected, got shape \(1,\)"),
        ([1.0, -1.0], "motor limits are numbers above 0"),
        ("motors", "motor limits are numbers or 'model', got 'motors'"),
    ],
)
def test_limits_that_are_none(limits, message):
    with pytest.raises(pj.ArgumentError, match=message):
        pj.load("five_bar").home.statics().within(limits)
