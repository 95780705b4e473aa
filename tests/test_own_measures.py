"""Measures by functions of one's own: what they say of each closed pose, in whatever process."""

from __future__ import annotations

import importlib
import pickle
import sys
import threading

import mechanisms
import numpy as np
import pytest
import xarray
from mechanisms import loaded
from swept_for_kill import reach

import pmjac_pin as pj
from pmjac_pin.studies.sweep.own_measures import OwnMeasure

LENGTHS = np.linspace(0.85, 1.2, 5)
NAMES = ["Jv_eq", "Jw_eq"] + [
    f"{kind}_{what}" for kind in ("velocity", "angular") for what in ("radii", "rank", "volume")
]


def swept(measures, name="three_rps", **given):
    over = given.pop("over", {"l1": [*LENGTHS, 3.0], "l3": LENGTHS})
    return pj.sweep(loaded(name), over, measures=measures, **{"workers": 1, **given})


@pytest.mark.parametrize("name", mechanisms.mostly_slow(mechanisms.CATALOGUE))
def test_ellipsoids_and_rows_are_those_of_single_calls(name, rng):
    mechanism = loaded(name)
    targets = mechanism.home.actuated + rng.uniform(-0.1, 0.1, (5, len(mechanism.actuated)))
    many = pj.batch(mechanism)
    poses, found = many.measures_at(targets, enforce_limits=False)
    where = np.flatnonzero(found.status == pj.Status.CLOSED)
    assert where.size
    for one in (found, many.ellipsoids(poses.q)):
        for k in where.tolist():
            single = mechanism.configuration(poses.q[k]).jacobian()
            sizes = np.abs(single.J_eq).max(initial=1.0)
            np.testing.assert_allclose(one.Jv_eq[k], single.Jv_eq, rtol=1e-9, atol=1e-9 * sizes)
            np.testing.assert_allclose(one.Jw_eq[k], single.Jw_eq, rtol=1e-9, atol=1e-9 * sizes)
            for kind in ("velocity", "angular"):
                ellipsoid = getattr(single, f"{kind}_ellipsoid")()
                assert getattr(one, f"{kind}_rank")[k] == ellipsoid.rank
                volume, scale = getattr(one, f"{kind}_volume")[k], ellipsoid.radii[0] ** 3
                assert volume == pytest.approx(ellipsoid.volume, rel=1e-7, abs=1e-9 * scale)
    for array in (found.Jv_eq, found.Jw_eq, found.velocity_rank, found.angular_volume):
        assert not array.flags.writeable


def test_where_there_is_no_jacobian_there_is_no_rank():
    mechanism = loaded("four_bar")
    q = np.array([mechanism.home.q, mechanism.home.q + 0.1])
    found = pj.batch(mechanism).ellipsoids(q)
    assert found.status.tolist() == [pj.Status.CLOSED, pj.Status.OPEN]
    for name in ("velocity_rank", "angular_rank", "velocity_volume", "angular_volume"):
        np.testing.assert_array_equal(np.isnan(getattr(found, name)), [False, True])


def test_all_names_in_a_sweep():
    found = swept(NAMES)
    closed = (found.status == pj.Status.CLOSED).values
    assert closed.any()
    assert not closed.all()
    l1, l3 = np.meshgrid(found.l1, found.l3, indexing="ij")
    values = np.stack([l1, np.full(l1.shape, loaded("three_rps").home.actuated[1]), l3], axis=-1)
    _, single = pj.batch(loaded("three_rps")).measures_at(values[closed])
    for name in NAMES:
        np.testing.assert_allclose(found[name].values[closed], getattr(single, name), atol=1e-12)
        assert np.isnan(found[name].values[~closed]).all()
    assert found.Jv_eq.dims == ("l1", "l3", "xyz", "motor")


@pytest.mark.parametrize("chunk", [1, 7, 10_000])
@pytest.mark.parametrize("over", [{"l1": [0.85, 1.0, 3.0]}, {"a": [1.0, 1.1], "l1": [1.0, 6.0]}])
def test_functions_say_what_they_say_of_single_poses(chunk, over, tmp_path):
    found = swept(["q", "position", ("reach", reach)], over=over, chunk=chunk)
    closed = (found.status == pj.Status.CLOSED).values
    assert closed.any()
    assert not closed.all()
    column = loaded("three_rps").model.joints[loaded("three_rps").model.getJointId("theta1")].idx_q
    expected = np.linalg.norm(found.position.values[closed], axis=-1)
    np.testing.assert_allclose(found.reach.values[closed][:, 0], expected, rtol=1e-14)
    np.testing.assert_array_equal(
        found.reach.values[closed][:, 1], found.q.values[closed][:, column]
    )
    assert np.isnan(found.reach.values[~closed]).all()
    assert found.reach.dims == (*over, "reach_0")
    assert "functions that the caller gave say of them: reach" in found.attrs["evidence"]


@pytest.mark.parametrize("designs", [3, 60])
def test_functions_and_many_designs(designs):
    """By single machines, and where the programs of all are recorded."""
    over = {"l1": np.linspace(0.9, 1.1, designs), "theta1": [0.8, 1.0]}
    height = {"height": lambda poses, found: found.position[:, 1]}
    found = swept(height, "four_bar", over=over)
    plain = swept(["position"], "four_bar", over=over)
    assert (found.status == pj.Status.CLOSED).any()
    np.testing.assert_array_equal(found.height, plain.position.sel(xyz="y"))


def test_a_mapping_and_pairs_are_alike():
    one = swept({"reach": reach})
    other = swept([("reach", reach)])
    xarray.testing.assert_equal(one, other)
    flags = swept([("near", lambda poses, found: found.position[:, 2] < 1.0)])
    assert set(np.unique(flags.near.values[~np.isnan(flags.near.values)])) <= {0.0, 1.0}


def test_interrupted_and_resumed_is_as_never_interrupted(tmp_path):
    measures = ["J_eq", "angular_volume", ("reach", reach)]

    def stop(done, count):
        if done == 3:
            raise KeyboardInterrupt

    expected = swept(measures, chunk=4, out=tmp_path / "whole.zarr").load()
    with pytest.raises(pj.Interrupted):
        swept(measures, chunk=4, out=tmp_path / "other.zarr", progress=stop)
    found = swept(measures, chunk=4, out=tmp_path / "other.zarr", resume=True).load()
    xarray.testing.assert_identical(found, expected)
    raw = [
        {
            path.name: path.read_bytes()
            for path in (tmp_path / name / "reach").rglob("*")
            if path.is_file()
        }
        for name in ("whole.zarr", "other.zarr")
    ]
    assert raw[0] == raw[1]
    for other in (["J_eq", "angular_volume"], [*measures[:2], ("reach", lambda p, f: p.share)]):
        with pytest.raises(pj.ArgumentError, match="another sweep: it differs in its measures"):
            swept(other, chunk=4, out=tmp_path / "other.zarr", resume=True)


def fails(poses, found):
    raise ZeroDivisionError("nothing to divide")


def fails_late(poses, found):
    """Where it was tried all is well."""
    return poses.share[:1] if (poses.share == 1.0).all() and len(poses.q) == 25 else poses.share


def sorted_series(poses, found):
    pandas = pytest.importorskip("pandas")
    return pandas.Series(np.arange(len(poses.q)))[::-1]


def sorted_array(poses, found):
    xarray = pytest.importorskip("xarray")
    rows = range(len(poses.q))
    return xarray.DataArray(np.arange(len(poses.q)), {"row": rows}, dims="row")[::-1]


FUNCTIONS = [
    (fails, "measure 'mine': its function raised ZeroDivisionError: nothing to divide"),
    (lambda poses: 1.0, "raised TypeError"),
    (lambda poses, found: 1.0, r"a number or an array for each of 11 poses, \(11, ...\), it"),
    (lambda poses, found: found.J_eq.T, r"it returned shape \(3, 6, 11\)"),
    (lambda poses, found: np.ones((len(poses.q), 0)), r"it returned shape \(11, 0\)"),
    (lambda poses, found: None, "is to return real numbers, it returned None"),
    (lambda poses, found: ["a"] * len(poses.q), "is to return real numbers"),
    (lambda poses, found: poses.share * 1j, "is to return real numbers"),
    (lambda poses, found: [[1.0], [1.0, 2.0]], "is to return real numbers"),
    (lambda poses, found: np.ma.masked_less(poses.share, 2.0), "is to return real numbers"),
    (lambda poses, found: poses.joint("nowhere"), "raised UnknownNameError"),
    (lambda poses, found: found.J_eq.fill(0.0), "raised ValueError: .*read-only"),
    (sorted_series, r"returned rows labelled \[10, .*\], not the poses', in their order"),
    (sorted_array, r"returned rows labelled \[10, .*\], not the poses', in their order"),
    (fails_late, r"for each of 25 poses, \(25, ...\), it returned shape \(1,\)"),
    (lambda p, f: p.q[:, : 1 + (len(p.q) == 25)], r"shape \(25, 2\), where \(25, 1\) was"),
]


@pytest.mark.parametrize(("function", "said"), FUNCTIONS)
def test_what_functions_must_not_do(function, said):
    with pytest.raises(pj.ArgumentError, match=said):
        swept({"mine": function}, over={"l1": LENGTHS, "l3": np.linspace(0.95, 1.05, 5)})


@pytest.mark.parametrize(
    ("measures", "said"),
    [
        ([reach], r"a list of names, or of pairs \(name, function\), it holds <function reach"),
        ([("reach", 3)], r"it holds \('reach', 3\)"),
        ([(3, reach)], "it holds "),
        ({"a/b": reach}, "has a name like 'reach_2', got 'a/b'"),
        ({"J_eq": reach}, "cannot be told from what has this name already: 'J_eq'"),
        ({"l1": reach}, "cannot be told from what has this name already: 'l1'"),
        ({"done": reach}, "cannot be told from what has this name already: 'done'"),
        ([("mine", reach), ("mine", fails)], "`measures` has the name 'mine' twice"),
        (["reach"], "unknown measure 'reach'"),
    ],
)
def test_names_that_are_refused(measures, said):
    with pytest.raises(pj.PmjacError, match=said):
        swept(measures)


def test_what_cannot_be_sent_is_told_before_any_work():
    lock = threading.Lock()
    with pytest.raises(pj.ArgumentError, match="'mine': its function cannot be sent to other proc"):
        swept({"mine": lambda poses, found: lock and poses.share}, workers=2, chunk=4)


def test_what_other_processes_cannot_import(tmp_path, monkeypatch):
    """It is said where the function is called, so that no worker dies of it."""
    (tmp_path / "only_here_once.py").write_text(
        "def share(poses, found):\n    return poses.share\n"
    )
    monkeypatch.syspath_prepend(tmp_path)
    function = importlib.import_module("only_here_once").share
    sent = pickle.dumps(OwnMeasure("mine", function, ()))
    poses = pj.batch(loaded("four_bar")).measures_at([[0.9], [1.0]])
    np.testing.assert_array_equal(pickle.loads(sent).at(*poses), [1.0, 1.0])
    monkeypatch.delitem(sys.modules, "only_here_once")
    (tmp_path / "only_here_once.py").unlink()
    importlib.invalidate_caches()
    with pytest.raises(pj.ArgumentError, match="'mine': its function is not found by other proc"):
        pickle.loads(sent).at(*poses)


@pytest.mark.slow
def test_what_other_processes_say(tmp_path):
    whole = swept({"reach": reach}, chunk=4)
    xarray.testing.assert_equal(swept({"reach": reach}, chunk=4, workers=2), whole)
    with pytest.raises(pj.ArgumentError, match="measure 'mine': its function raised ZeroDivision"):
        swept({"mine": fails_beside_the_guess}, chunk=4, workers=2)


def fails_beside_the_guess(poses, found):
    if len(poses.q) != 11:
        raise ZeroDivisionError("nothing to divide")
    return poses.share


def test_a_guess_without_jacobian():
    """What functions return is learnt where paths begin."""
    with pytest.raises(pj.ArgumentError, match="tried at the guess, 'home', where J_eq is NO_JAC"):
        pj.sweep(mechanisms.rssr("rod_side"), {"theta": [0.4]}, measures={"reach": reach})


def test_poses_that_are_stretched():
    """J_eq is there, and flat: the rank drops."""
    rank = {"rank": lambda poses, found: found.velocity_rank}
    found = swept(rank, "serial_2r", over={"theta2": [0.0, 1.0]})
    assert found["rank"].values.tolist() == [1.0, 2.0]
