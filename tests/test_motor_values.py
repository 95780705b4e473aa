"""Motor values by name and by order: never one for the other."""

from __future__ import annotations

import sqlite3
from collections import namedtuple
from types import MappingProxyType

import mechanisms
import numpy as np
import pandas
import pytest
from mechanisms import loaded

import pmjac_pin as pj
from pmjac_pin.cli import main
from pmjac_pin.words.modes_report import make_modes_report

VALUES = {"l3": 0.9, "l1": 1.0, "l2": 1.1}
IN_ORDER = [1.0, 1.1, 0.9]


class Series:
    """As pandas has it: an index, keys and values, and an array of the values in their order."""

    def __init__(self, pairs):
        self.index = [label for label, _ in pairs]
        self.values = np.array([value for _, value in pairs])

    def keys(self):
        return self.index

    def __array__(self, dtype=None, copy=None):
        return self.values

    def __iter__(self):
        return iter(self.values)

    def __len__(self):
        return len(self.index)


class DataArray(Series):
    """As xarray has it: one dimension with a coordinate."""

    keys = None
    dims = ("motor",)

    @property
    def coords(self):
        return {"motor": np.array(self.index)}


class Coordinate:
    """Labels along a dimension, as xarray has them."""

    def __init__(self, labels):
        self.labels, self.dims = labels, ("place",)

    def __array__(self, dtype=None, copy=None):
        return np.array(self.labels)


class LabelledBeside(DataArray):
    """As xarray has it where the coordinate has another name than the dimension."""

    dims = ("place",)

    @property
    def coords(self):
        return {"motor": Coordinate(self.index), "weight": Coordinate([2.0] * len(self.index))}


class LabelledTwice(LabelledBeside):
    @property
    def coords(self):
        other = Coordinate([f"x{label}" for label in self.index])
        return {"motor": Coordinate(self.index), "other": other}


def record(values):
    array = np.zeros((), dtype=[(name, float) for name in values])
    for name, value in values.items():
        array[name] = value
    return array


def row(values):
    base = sqlite3.connect(":memory:")
    base.row_factory = sqlite3.Row
    columns = ", ".join(f"{value!r} as {name}" for name, value in values.items())
    found = base.execute(f"select {columns}").fetchone()
    base.close()
    return found


KINDS = {
    "dict": dict,
    "mapping": MappingProxyType,
    "Series": lambda values: Series(list(values.items())),
    "DataArray": lambda values: DataArray(list(values.items())),
    "DataArray labelled beside": lambda values: LabelledBeside(list(values.items())),
    "record": record,
    "records": lambda values: record(values).reshape(1),
    "named tuple": lambda values: namedtuple("Lengths", values)(**values),
    "row of a database": row,
}


@pytest.fixture(scope="module")
def three_rps():
    return loaded("three_rps")


@pytest.mark.parametrize("kind", KINDS)
def test_names_decide(three_rps, kind):
    named = KINDS[kind](VALUES)
    closed = three_rps.close(named)
    assert closed.actuated.tolist() == IN_ORDER
    assert np.array_equal(closed.q, three_rps.close(IN_ORDER).q)


@pytest.mark.parametrize("kind", KINDS)
def test_unknown_and_missing_names_are_refused(three_rps, kind):
    with pytest.raises(pj.UnknownNameError, match="unknown motor 'L1'; did you mean 'l1'"):
        three_rps.close(KINDS[kind]({"L1": 1.0, "l2": 1.1, "l3": 0.9}))
    with pytest.raises(pj.ArgumentError, match="no value is given for motor 'l2'"):
        three_rps.close(KINDS[kind]({"l1": 1.0, "l3": 0.9}))


@pytest.mark.parametrize("kind", ["dict", "Series", "named tuple"])
def test_everywhere(kind):
    mechanism = loaded("five_bar")
    theta = mechanism.home.actuated
    named = KINDS[kind]({"theta2": float(theta[1]), "theta1": float(theta[0])})
    modes = pj.assembly_modes(mechanism, theta, rng=0)
    same = pj.assembly_modes(mechanism, named, rng=0)
    assert [mode.q.tolist() for mode in modes] == [mode.q.tolist() for mode in same]
    report = make_modes_report(mechanism, named, modes)
    assert [motor.value for motor in report.motors] == theta.tolist()
    assert pj.prove(mechanism, named)
    assert mechanism.close(theta, guess=KINDS[kind](dict(mechanism.home.joint_values)))


def test_of_a_homotopy():
    mechanism = loaded("four_bar")
    homotopy = pj.parameter_homotopy(mechanism, rng=0)
    assert homotopy.at({"theta1": 0.9}).count == homotopy.at([0.9]).count
    with pytest.raises(pj.UnknownNameError):
        homotopy.at({"theta": 0.9})


def test_labels_that_are_no_names(three_rps):
    with pytest.raises(pj.ArgumentError, match="labelled in 2 ways"):
        three_rps.close(LabelledTwice(list(VALUES.items())))
    assert three_rps.close(Series(list(enumerate(IN_ORDER)))).actuated.tolist() == IN_ORDER
    for labels in ([2, 0, 1], ["l1", "l1", "l2"], ["l1", 1, 2]):
        with pytest.raises(pj.ArgumentError, match="labelled"):
            three_rps.close(Series(list(zip(labels, IN_ORDER, strict=True))))
    with pytest.raises(pj.UnknownNameError):
        three_rps.close(dict(enumerate(IN_ORDER)))


def test_a_passive_joint_is_no_motor(three_rps):
    bar = loaded("four_bar")
    with pytest.raises(pj.ArgumentError, match="'phi1' is passive; motors are: theta1"):
        bar.close(bar.home.joint_values)


@pytest.mark.parametrize("value", ["1", None, [1.0, 2.0], float("nan"), 1j])
def test_values_by_name_are_numbers(value):
    with pytest.raises(pj.ArgumentError, match="motor 'theta1'"):
        loaded("four_bar").close({"theta1": value})


@pytest.mark.parametrize("kind", ["Series", "named tuple", "row of a database"])
def test_what_goes_by_order_takes_no_names(kind):
    """A q has no names, and a wrong order would be silent."""
    bar = loaded("four_bar")
    named = KINDS[kind]({"phi1": 2.0, "theta1": 0.9, "phi2": 0.0})
    with pytest.raises(pj.ArgumentError, match="plain numbers"):
        bar.loop_equations(named)
    made = pj.Mechanism.from_pinocchio(
        bar.model, bar.spec.loops, ["theta1"], "coupler_midpoint", home=named
    )
    assert made.home.actuated.tolist() == [0.9]


def test_on_the_command_line(capsys):
    assert main(["report", "three_rps", "--at", "l3=0.9,l1=1,l2=1.1"]) == 0
    named = capsys.readouterr().out
    assert main(["report", "three_rps", "--at", "1,1.1,0.9"]) == 0
    assert capsys.readouterr().out == named
    for given in ("l3=0.9,l1=1", "l3=0.9,l1=1,l1=2", "l3=0.9,1,2", "x=1,l2=1,l3=1"):
        assert main(["report", "three_rps", "--at", given]) == 2
        assert capsys.readouterr().err.count("\n") == 1
    assert main(["modes", "four_bar", "--at", "theta1=0.9"]) == 0


@pytest.mark.parametrize("rows", [1, 2])
def test_of_a_table_one_row_is_wanted(rows):
    mechanism = loaded("five_bar")
    frame = pandas.DataFrame([mechanism.home.actuated] * rows, columns=mechanism.actuated)
    with pytest.raises(
        pj.ArgumentError, match=r"a table; give one row of it, e.g. frame.iloc\[0\]"
    ):
        mechanism.close(frame)
    np.testing.assert_array_equal(mechanism.close(frame.iloc[0]).q, mechanism.home.q)


@pytest.mark.parametrize("name", mechanisms.CATALOGUE)
def test_motors_know_their_values_as_the_coordinates_do(name, rng):
    """Among them such as turn endlessly, and such as are entries of q."""
    mechanism = loaded(name)
    coordinates, motors = mechanism.coordinates, mechanism.motors
    columns, q = mechanism.problem.partition.actuated, mechanism.home.q
    for size in (0.1, 1.0, 10.0):
        values = mechanism.home.actuated + rng.normal(0.0, size, columns.size)
        there = motors.at(q, values)
        np.testing.assert_array_equal(there, coordinates.with_values(q, columns, values))
        np.testing.assert_array_equal(
            motors.way(q, values), coordinates.motion_to(q, columns, values)
        )
        np.testing.assert_allclose(motors.way(there, values), 0.0, atol=1e-14)
        beyond = coordinates.outside(values, columns)
        within = motors.within_limits(values)
        assert (within is None) == bool(beyond)
        if within is not None:
            np.testing.assert_array_equal(within, values)
            assert not np.shares_memory(within, values)
    for other in (q.tolist(), values[:0], values.astype(np.float32), np.full(columns.size, np.nan)):
        assert motors.within_limits(other) is None


def test_stated_units_are_ours_however_values_are_given():
    xarray = pytest.importorskip("xarray")
    mechanism = loaded("three_rps")
    many, names = pj.batch(mechanism), list(mechanism.actuated)
    row = xarray.DataArray([1000.0] * 3, {"motor": names}, "motor", attrs={"units": "mm"})
    table = row.expand_dims(sample=2)
    table.attrs["Units"] = table.attrs.pop("units", "mm")
    for given in (row, {name: row.sel(motor=name) for name in names}):
        with pytest.raises(pj.ArgumentError, match="mm"):
            mechanism.close(given)
    with pytest.raises(pj.ArgumentError, match="mm"):
        many.close(table)
    row.attrs["units"] = "m"
    expected = mechanism.close([1.0] * 3)
    np.testing.assert_array_equal(mechanism.close(row / 1000.0).q, expected.q)
    kept = (row / 1000.0).assign_attrs(units="m")
    np.testing.assert_array_equal(mechanism.close(kept).q, expected.q)
