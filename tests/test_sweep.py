"""Sweeps: each point is what the single call says, however the work was cut, spread or killed."""

from __future__ import annotations

import contextlib
import io
import multiprocessing
import os
import signal
import sys

import mechanisms
import numpy as np
import pytest
import xarray
from mechanisms import loaded
from rich.progress import Progress
from swept_for_kill import PRELOADED, go_on, swept_for_kill

import pmjac_pin as pj
from pmjac_pin.batches.few_poses import FewPoses
from pmjac_pin.cli import main
from pmjac_pin.closing import recorded_mechanism
from pmjac_pin.studies.sweep.points import Points

LENGTHS = np.linspace(0.85, 1.2, 5)
ALL = ("J_eq", "q", "share")


def swept(**given):
    return pj.sweep(
        loaded("three_rps"), {"l1": LENGTHS, "l3": LENGTHS}, measures=ALL, workers=1, **given
    )


def alone(mechanism, values):
    """What the single calls say: status, q, J_eq."""
    try:
        pose = mechanism.close(values)
    except pj.LimitError:
        return pj.Status.LIMITS, None, None
    except pj.ClosureError:
        return pj.Status.STOPPED, None, None
    try:
        return pj.Status.CLOSED, pose.q, pose.jacobian().J_eq
    except pj.SingularError:
        return pj.Status.SINGULAR, pose.q, None


def check(point, mechanism, values):
    status, q, J_eq = alone(mechanism, values)
    assert point.status == status
    if q is not None:
        np.testing.assert_allclose(point.q, q, atol=1e-9)
    if J_eq is None:
        assert np.isnan(point.J_eq).all()
    else:
        np.testing.assert_allclose(point.J_eq, J_eq, atol=1e-8)


def test_each_point_of_a_grid():
    mechanism, found = loaded("three_rps"), swept(chunk=7)
    assert found.J_eq.dims == ("l1", "l3", "row", "motor")
    np.testing.assert_array_equal(found.l1, LENGTHS)
    for l1 in LENGTHS:
        for l3 in LENGTHS:
            check(found.sel(l1=l1, l3=l3), mechanism, [l1, mechanism.home.actuated[1], l3])


def test_measures():
    measures = ("velocity_radii", "angular_radii", "smallest", "condition", "position", "rotation")
    mechanism = loaded("three_rps")
    found = pj.sweep(mechanism, {"l1": [*LENGTHS, 3.0]}, measures=measures, workers=1)
    closed = found.status == pj.Status.CLOSED
    assert closed.any()
    assert not closed.all()
    for point in (found.isel(l1=k) for k in np.flatnonzero(closed)):
        pose = mechanism.close([float(point.l1), *mechanism.home.actuated[1:]])
        radii = pose.jacobian().velocity_ellipsoid().radii
        np.testing.assert_allclose(point.velocity_radii, radii, atol=1e-9)
        singularity, placed = pose.singularity(), pose.tool_pose()
        assert point.smallest == pytest.approx(singularity.smallest, rel=1e-8)
        assert point.condition == pytest.approx(singularity.condition, rel=1e-8)
        np.testing.assert_allclose(point.position, placed.translation, atol=1e-9)
        np.testing.assert_allclose(point.rotation, placed.rotation, atol=1e-9)
    for name in measures:
        assert np.isnan(found[name].where(~closed, drop=True)).all()


def test_samples_of_motors_and_parameters(rng):
    l1, theta = rng.uniform(0.8, 1.3, 12), rng.uniform(0.5, 1.2, 12)
    l1[3:6] = l1[0]
    found = pj.sweep("four_bar", samples={"l1": l1, "theta1": theta}, measures=ALL, workers=1)
    assert found.status.dims == ("sample",)
    for k in range(12):
        machine = pj.load("four_bar", parameters={"l1": l1[k]})
        check(found.isel(sample=k), machine, [theta[k]])


def test_a_machine_that_does_not_assemble():
    lengths = [1.0, 9.5]
    with pytest.raises(pj.ClosureError):
        pj.load("four_bar", parameters={"l2": lengths[1]})
    found = pj.sweep("four_bar", {"l2": lengths, "theta1": [0.9, 1.0]}, measures=ALL, workers=1)
    assert (found.status.isel(l2=1) == pj.Status.NOT_ASSEMBLED).all()
    assert np.isnan(found.q.isel(l2=1)).all()


@pytest.mark.parametrize("name", mechanisms.mostly_slow(mechanisms.CATALOGUE))
def test_few_poses_are_what_many_are(name, rng):
    """Where it does not pay to record a mechanism, single calls say the same."""
    mechanism = loaded(name)
    targets = mechanism.home.actuated + rng.uniform(-0.3, 0.3, (6, len(mechanism.actuated)))
    few, many = FewPoses(mechanism), pj.batch(mechanism)
    mine, theirs = few.close(targets), many.close(targets)
    np.testing.assert_array_equal(mine.status, theirs.status)
    closed = mine.status == pj.Status.CLOSED
    assert_alike(vars(few.measures(mine.q[closed])), vars(many.measures(mine.q[closed])))
    jacobians = (one.jacobian(mine.q[closed], "LOCAL") for one in (few, many))
    assert_alike(*map(vars, jacobians))


def assert_alike(found, expected):
    assert found.keys() == expected.keys()
    for key, values in found.items():
        np.testing.assert_allclose(values, expected[key], rtol=1e-7, atol=1e-9, err_msg=key)


def test_what_few_poses_say_does_not_depend_on_calls_before(monkeypatch):
    """Not even by rounding: a sweep that goes on is the one that was not interrupted."""
    monkeypatch.setattr(recorded_mechanism, "_CALLS", 0.05)
    mechanism = loaded("three_rps")
    targets = mechanism.home.actuated + np.linspace(-0.1, 0.1, 12)[:, None]
    first = FewPoses(mechanism)
    expected = first.close(targets)
    measures = first.measures(expected.q)
    for _ in range(2):
        again = FewPoses(mechanism)
        np.testing.assert_array_equal(again.close(targets).q, expected.q)
        np.testing.assert_array_equal(again.measures(expected.q).J_eq, measures.J_eq)


@pytest.mark.parametrize("chunk", [1, 6, 25, 1000])
def test_results_do_not_depend_on_chunks_and_stores(chunk, tmp_path):
    expected = swept(chunk=10)
    found = swept(chunk=chunk, out=tmp_path / "store.zarr")
    for name in ("status", *ALL):
        np.testing.assert_allclose(found[name], expected[name], rtol=1e-10, atol=1e-10)
    assert found.attrs["pmjac_pin_sweep"]["name"] == "three_rps"
    assert found.attrs["evidence"].startswith("tolerance: ")
    assert list(found.motor) == ["l1", "l2", "l3"]
    opened = xarray.open_zarr(tmp_path / "store.zarr", consolidated=False, chunks=None)
    assert opened.done.all()


def test_nothing_is_computed_twice(tmp_path, monkeypatch):
    from pmjac_pin.studies.sweep.work import SweepWork

    done, out = [], tmp_path / "store.zarr"
    first = swept(chunk=5, out=out, progress=lambda *now: done.append(now)).load()
    assert done == [(k + 1, 5) for k in range(5)]
    monkeypatch.setattr(SweepWork, "compute", None)
    again = swept(chunk=5, out=out, resume=True)
    xarray.testing.assert_identical(again.load(), first)
    assert len(done) == 5


def test_a_store_of_another_sweep(tmp_path):
    out = tmp_path / "store.zarr"
    swept(out=out)
    with pytest.raises(pj.OutputError, match="exists already; with `resume` a sweep goes on there"):
        swept(out=out)
    with pytest.raises(pj.ArgumentError, match="another sweep: it differs in its chunk; give"):
        swept(out=out, chunk=5, resume=True)
    with pytest.raises(pj.ArgumentError, match="differs in its name, mechanism, dim"):
        pj.sweep(loaded("four_bar"), {"theta1": [0.9]}, out=out, resume=True)
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "notes").write_text("mine")
    for resume in (True, False):
        with pytest.raises(pj.OutputError, match=r"exists already|is no store of a sweep"):
            swept(out=tmp_path / "mine", resume=resume)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["mine", "store.zarr"]
    assert (tmp_path / "mine" / "notes").read_text() == "mine"


@pytest.fixture(scope="module")
def forks():
    """Starts processes as forks of one that has imported all: a kill takes no second of start."""
    context = multiprocessing.get_context("forkserver")
    context.set_forkserver_preload(PRELOADED)
    return context


@pytest.mark.slow
@pytest.mark.parametrize(("workers", "count", "most", "least"), [(1, 8, 5, 20), (2, 6, 20, 2)])
def test_killed_and_resumed_is_as_never_interrupted(
    workers, count, most, least, tmp_path, rng, forks
):
    kills, out = 0, tmp_path / "killed.zarr"
    while True:
        here, there = forks.Pipe(duplex=False)
        child = forks.Process(target=swept_for_kill, args=(out, count, workers, there))
        child.start()
        there.close()
        # By its own word, and then at some moment of what comes next.
        with here, contextlib.suppress(EOFError):
            for _ in range(int(rng.integers(1, most))):
                here.recv_bytes()
            child.join(timeout=rng.uniform(0.0, 0.01))
        with contextlib.suppress(ProcessLookupError):
            os.killpg(child.pid, signal.SIGKILL)
        child.join()
        if child.exitcode == 0:
            break
        assert child.exitcode == -signal.SIGKILL
        kills += 1
    assert kills >= least
    go_on(tmp_path / "whole.zarr", count)
    one, other = (
        xarray.open_zarr(path, consolidated=False, chunks=None).load()
        for path in (tmp_path / "whole.zarr", out)
    )
    xarray.testing.assert_identical(one, other)
    assert one.done.all()


# --- what is refused ---------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({}, "either `over`, the axes of a grid, or `samples` is wanted"),
        ({"over": {"l1": [1.0]}, "samples": {"l1": [1.0]}}, "either `over`"),
        ({"over": [1.0]}, "`over` is a mapping of names to values, got"),
        ({"over": {}}, "`over` is a mapping of names to values, got {}"),
        ({"over": {"l9": [1.0]}}, "unknown motor or parameter 'l9'; there are: l1, l2, l3, a, b"),
        ({"over": {"l1": 1.0}}, r"a list of values for 'l1' expected, got shape \(\)"),
        ({"over": {"l1": []}}, r"a list of values for 'l1' expected, got shape \(0,\)"),
        ({"over": {"l1": ["a"]}}, "the values of 'l1' must be real numbers"),
        ({"over": {"l1": [np.nan]}}, "the values of 'l1' must be finite"),
        ({"samples": {"l1": [1.0], "l2": [1.0, 1.1]}}, "got 1 of 'l1', 2 of 'l2'"),
        ({"over": {"l1": [1.0]}, "measures": "J_eq"}, "`measures` is a list of names"),
        ({"over": {"l1": [1.0]}, "measures": ["Jeq"]}, "unknown measure 'Jeq'; did you mean"),
        ({"over": {"l1": [1.0]}, "guess": "lecture"}, "unknown pose 'lecture'"),
        ({"over": {"l1": [1.0]}, "chunk": 0}, "`chunk` is a whole number ≥ 1, got 0"),
        ({"over": {"l1": [1.0]}, "workers": 0}, "`workers` is a whole number ≥ 1, got 0"),
        ({"over": {"l1": [1.0]}, "client": 3}, "`client` is Dask's Client, an executor or"),
        ({"over": {"l1": [1.0]}, "enforce_limits": "no"}, "enforce_limits"),
        ({"over": {"l1": [1.0]}, "out": ""}, "got an empty text"),
        ({"over": {"l1": [1.0]}, "out": "/nowhere/at/all"}, "there is no folder /nowhere/at"),
    ],
)
def test_what_is_refused(given, message):
    with pytest.raises(pj.PmjacError, match=message):
        pj.sweep(loaded("three_rps"), **{"workers": 1, **given})


def test_places_where_no_store_can_be(tmp_path):
    link = tmp_path / "circle"
    link.symlink_to(tmp_path / "other")
    (tmp_path / "other").symlink_to(link)
    for resume in (False, True):
        for out, said in ((link, "exists already"), (tmp_path / ("x" * 10_000), "too long")):
            with pytest.raises(pj.OutputError, match=said) as caught:
                pj.sweep("four_bar", {"l1": [1.0]}, out=out, workers=1, resume=resume)
            assert len(str(caught.value)) < 700
    assert {one.name for one in tmp_path.iterdir()} == {"circle", "other"}


def test_parameters_of_a_mechanism_that_has_its_own():
    """Those that are not swept stay as they are."""
    given = pj.load("four_bar", {"l1": 1.2, "l2": 2.9})
    found = pj.sweep(given, {"l1": [1.0, 1.1]}, measures=ALL, workers=1)
    for k, l1 in enumerate([1.0, 1.1]):
        machine = pj.load("four_bar", {"l1": l1, "l2": 2.9})
        check(found.isel(l1=k), machine, machine.home.actuated)
    with pytest.raises(pj.ArgumentError, match="l1"):
        pj.sweep("four_bar", {"l1": [1.0, -1.0]}, workers=1)


def test_without_the_packages(monkeypatch):
    monkeypatch.setitem(sys.modules, "xarray", None)
    with pytest.raises(pj.MissingDependencyError, match=r"pip install 'pmjac_pin\[sweep\]'"):
        swept()


@pytest.mark.parametrize("most", [1, 2, 7, 12, 1000])
def test_chunks_cover_a_grid_once(most):
    points = Points.grid({"a": np.arange(3.0), "b": np.arange(4.0), "c": np.arange(5.0)}, {})
    chunk, seen = points.chunk(most), np.zeros(points.shape, dtype=int)
    assert np.prod(chunk) <= most
    for region in points.regions(chunk):
        seen[region] += 1
        a, b, c = points.at(region).values()
        np.testing.assert_array_equal(
            np.ravel_multi_index((a.astype(int), b.astype(int), c.astype(int)), points.shape),
            np.arange(60).reshape(points.shape)[region].ravel(),
        )
    assert (seen == 1).all()


# --- the command line --------------------------------------------------------------------------

FILE = """
mechanism = "three_rps"
out = "map.zarr"
measures = ["q"]

[over]
l1 = { from = 0.9, to = 1.1, count = 3 }
l2 = [0.9, 1.0]
"""


def test_the_command(tmp_path, capsys):
    path = tmp_path / "map.toml"
    path.write_text(FILE)
    assert main(["sweep", str(path), "--workers", "1"]) == 0
    assert capsys.readouterr().out == f"{tmp_path / 'map.zarr'}\n6 CLOSED\n"
    assert main(["sweep", str(path), "--workers", "1"]) == 2
    assert "exists already" in capsys.readouterr().err
    assert main(["sweep", str(path), "--resume", "--workers", "1"]) == 0
    found = xarray.open_zarr(tmp_path / "map.zarr", consolidated=False, chunks=None)
    np.testing.assert_allclose(found.l1, [0.9, 1.0, 1.1])
    assert found.q.shape == (3, 2, loaded("three_rps").nq)


@pytest.mark.parametrize("watched", [True, False])
def test_the_command_shows_a_bar_of_chunks_to_who_watches(tmp_path, monkeypatch, watched):
    stderr = io.StringIO()
    stderr.isatty = lambda: watched
    monkeypatch.setattr(sys, "stderr", stderr)
    monkeypatch.setenv("TERM", "xterm")
    seen, update = [], Progress.update

    def seen_too(bar, task, *, completed, total):
        seen.append((completed, total))
        update(bar, task, completed=completed, total=total)

    monkeypatch.setattr(Progress, "update", seen_too)
    path = tmp_path / "map.toml"
    path.write_text(FILE.replace("[over]", "chunk = 2\n[over]"))
    assert main(["sweep", str(path), "--workers", "1"]) == 0
    last = seen[-1][1]
    assert seen == [(done, last) for done in range(1, last + 1)]
    assert last > 2
    shown = stderr.getvalue()
    assert ("chunks" in shown, "100%" in shown) == (watched, watched)
    assert bool(shown) == watched


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("measures", "mesures", "unknown key `mesures`; did you mean 'measures'?"),
        ("count = 3", "cuont = 3", "unknown key `cuont` - at `over[...]`; did you mean 'count'?"),
        ("count = 3", "count = 0", "`count` is 1 or more, got 0"),
        ('mechanism = "three_rps"', "", "missing key `mechanism`"),
        ("three_rps", "three_rsp", "No such file or directory"),
        ("[over]", "[over", "not valid TOML"),
    ],
)
def test_faults_of_a_file(tmp_path, capsys, old, new, message):
    path = tmp_path / "map.toml"
    path.write_text(FILE.replace(old, new))
    assert main(["sweep", str(path), "--workers", "1"]) == 2
    error = capsys.readouterr().err
    assert message in error
    assert error.count("\n") == 1
    assert [one.name for one in tmp_path.iterdir()] == ["map.toml"]


@pytest.mark.parametrize(
    ("counts", "chunk", "said"),
    [
        ((10**6, 10**6), 10_000, "1000000 × 1000000 = 1e.12 points are too many"),
        ((10**5, 10**4), 10, "1e.08 chunks are too many"),
        ((10**5, 10**4), 10**9, "a chunk has at most 1e.07 points, got 1000000000"),
    ],
)
def test_what_is_too_large_is_refused_before_any_work(tmp_path, counts, chunk, said):
    over = {f"theta{k}": np.linspace(0.0, 1.0, count) for k, count in enumerate(counts, 1)}
    with pytest.raises(pj.ArgumentError, match=said):
        pj.sweep("five_bar", over=over, out=tmp_path / "map.zarr", chunk=chunk)
    assert not list(tmp_path.iterdir())


def test_what_does_not_fit_in_memory_asks_for_a_folder():
    over = {"theta1": np.linspace(0.0, 1.0, 10**4), "theta2": np.linspace(0.0, 1.0, 10**4)}
    with pytest.raises(pj.ArgumentError, match=r"1e.08 points without `out`: at most 1e.07 are"):
        pj.sweep("five_bar", over=over)
