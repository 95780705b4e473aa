"""What sweeps take: mappings, tables, datasets say the same; what they contradict is told."""

from __future__ import annotations

import numpy as np
import pandas
import pytest
import xarray
from mechanisms import loaded

import pmjac_pin as pj

L1, L2 = np.array([0.95, 1.0, 1.08]), np.array([0.93, 1.02])
TOGETHER = {"l3": np.array([1.0, 1.05, 0.97]), "l1": L1}
GRID = {"l2": L2, "l1": L1}


def arrays(columns, dimension="s"):
    return {name: (dimension, values) for name, values in columns.items()}


def swept(**given):
    return pj.sweep(loaded("three_rps"), measures=["q"], workers=1, **given)


GRIDS = {
    "coordinates": lambda: xarray.Dataset(coords=GRID),
    "variables": lambda: xarray.Dataset({name: (name, one) for name, one in GRID.items()}),
    "variables along labels": lambda: xarray.Dataset(
        {name: (f"along {name}", one) for name, one in GRID.items()},
        coords={"along l1": ["a", "b", "c"]},
    ),
    "with units": lambda: xarray.Dataset(
        {name: (name, one, {"units": "m"}) for name, one in GRID.items()}
    ),
    "arrays": lambda: {name: xarray.DataArray(one) for name, one in GRID.items()},
    "series": lambda: {name: pandas.Series(one) for name, one in GRID.items()},
}
SAMPLES = {
    "frame": lambda: pandas.DataFrame(TOGETHER, index=["a", "b", "c"]),
    "frame by an index": lambda: pandas.DataFrame(TOGETHER).set_index("l1"),
    "frame by two": lambda: pandas.DataFrame(TOGETHER | {"k": 1}).set_index(["l1", "k"]),
    "records": lambda: pandas.DataFrame(TOGETHER).to_records(index=False),
    "dataset": lambda: xarray.Dataset(arrays(TOGETHER)),
    "dataset with labels": lambda: xarray.Dataset(arrays(TOGETHER), coords={"s": ["a", "b", "c"]}),
    "dataset of coordinates": lambda: xarray.Dataset(coords=arrays(TOGETHER)),
    "dataset along a motor": lambda: xarray.Dataset(
        arrays({"l3": TOGETHER["l3"]}, "l1"), coords={"l1": L1}
    ),
    "dataset of a frame": lambda: pandas.DataFrame(TOGETHER).to_xarray(),
    "array": lambda: pandas.DataFrame(TOGETHER).to_xarray().to_array("motor"),
}


@pytest.mark.parametrize("kind", GRIDS)
def test_a_grid_in_whatever_holds_it(kind):
    expected, found = swept(over=GRID), swept(over=GRIDS[kind]())
    np.testing.assert_array_equal(found.q.transpose(*expected.q.dims), expected.q)
    assert set(found.q.dims) == {"l1", "l2", "entry"}
    grids = [pj.batch(loaded("three_rps")).grid(over) for over in (GRID, GRIDS["coordinates"]())]
    np.testing.assert_array_equal(grids[0].q, grids[1].q)


@pytest.mark.parametrize("kind", SAMPLES)
def test_samples_in_whatever_holds_them(kind):
    expected, found = swept(samples=TOGETHER), swept(samples=SAMPLES[kind]())
    assert found.q.dims == ("sample", "entry")
    np.testing.assert_array_equal(found.q, expected.q)
    for name, values in TOGETHER.items():
        np.testing.assert_array_equal(found[name], values)


def test_what_came_out_goes_in(tmp_path):
    """The axes of one sweep are those of the next."""
    first = swept(over=GRID, out=tmp_path / "first.zarr")
    again = swept(over=first[["l2", "l1"]])
    np.testing.assert_array_equal(again.q, first.q)


def in_unit(unit, key="units"):
    return xarray.Dataset({"l1": ("l1", L1, {key: unit})})


REFUSED = [
    ({"over": in_unit("mm")}, "`over`: 'l1' has the units 'mm': values in m are wanted, and"),
    ({"over": in_unit("inch", "unit")}, "'l1' has the unit 'inch': values in m are wanted"),
    ({"samples": in_unit("mm")}, "`samples`: 'l1' has the units 'mm'"),
    ({"over": {"l1": in_unit("mm").l1}}, "'l1' has the units 'mm'"),
    ({"over": xarray.Dataset({"a": ("a", L1, {"units": "cm"})})}, "'a' has the units 'cm'"),
    ({"over": xarray.Dataset()}, "`over` is a mapping of names to values, and here are none"),
    ({"over": xarray.Dataset(arrays(TOGETHER))}, "'l3' and 'l1' lie along one dimension, 's'"),
    ({"over": xarray.Dataset({"l1": (("x", "y"), np.ones((2, 2)))})}, r"got shape \(2, 2\)"),
    ({"over": xarray.Dataset(coords=GRID | {"l3": 1.0})}, r"for 'l3' expected, got shape \(\)"),
    ({"over": xarray.Dataset(coords=GRID | {"l4": L1})}, "unknown motor or parameter 'l4'"),
    ({"over": xarray.Dataset(coords={"l1": ["a", "b"]})}, "the values of 'l1' must be real"),
    ({"over": pandas.DataFrame(TOGETHER)}, "in a row of a table belong together: they are samples"),
    ({"over": SAMPLES["records"]()}, "in a row of a table belong together"),
    ({"samples": xarray.Dataset(coords=TOGETHER)}, "got 'l3' along 'l3', 'l1' along 'l1'"),
    ({"samples": xarray.Dataset({"l1": (("x", "y"), np.ones((2, 2)))})}, r"got shape \(2, 2\)"),
    ({"samples": pandas.DataFrame({"l1": L1, "note": 1.0})}, "motor or parameter 'note'"),
    ({"samples": pandas.DataFrame({"l1": [1.0, None]})}, "the values of 'l1' must be finite"),
    ({"samples": pandas.DataFrame({0: L1})}, r"for 0 expected"),
    ({"samples": pandas.DataFrame()}, "`samples` is a mapping of names to values, and here are"),
    ({"samples": np.ones((3, 3))}, "`samples` is a mapping of names to values, got"),
]


@pytest.mark.parametrize(("given", "message"), REFUSED)
def test_what_is_refused(given, message):
    with pytest.raises(pj.PmjacError, match=message):
        swept(**given)


def test_angles_in_degrees_are_refused():
    degrees = xarray.Dataset({"theta1": ("theta1", [50.0, 60.0], {"units": "deg"})})
    mechanism = loaded("four_bar")
    many, together = pj.batch(mechanism), xarray.Dataset(arrays({"theta1": degrees.theta1.values}))
    together.theta1.attrs["units"] = "deg"
    for call in (
        lambda: pj.sweep(mechanism, degrees),
        lambda: many.grid(degrees),
        lambda: many.close(together),
    ):
        with pytest.raises(pj.ArgumentError, match="'theta1' has the units 'deg': values in rad"):
            call()
    right = xarray.Dataset({"theta1": ("theta1", np.deg2rad([50.0, 60.0]), {"units": "radian"})})
    assert pj.sweep(mechanism, right, workers=1).sizes["theta1"] == 2


def test_units_of_a_labelled_table_and_a_column_beside_its_index():
    table = xarray.DataArray(
        [[125.3, 54.7]],
        {"motor": ["theta1", "theta2"]},
        ("sample", "motor"),
        attrs={"units": "deg"},
    )
    with pytest.raises(pj.ArgumentError, match="deg"):
        pj.sweep("five_bar", samples=table, measures=["share"], workers=1)
    frame = pandas.DataFrame({"l1": [0.9, 1.0], "l2": 1.0, "l3": 1.0}).set_index("l1", drop=False)
    frame["l1"] *= 1.02
    found = pj.sweep("three_rps", samples=frame, measures=["q"], workers=1)
    expected = pj.batch(pj.load("three_rps")).close(frame).q
    np.testing.assert_allclose(found.q, expected, atol=1e-12)
