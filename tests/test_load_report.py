"""Rates, wrenches and dynamics in a report: the library's own numbers, told whole or not at all."""

from __future__ import annotations

import mechanisms
import numpy as np
import pinocchio as pin
import pytest
from mechanisms import loaded
from test_report import fold, strict

import pmjac_pin as pj
from pmjac_pin.cli import main
from pmjac_pin.words.plain import to_json


def heavy_four_bar():
    """A four-bar whose links have masses."""
    model = pj.load("four_bar")
    tree, spec = model.model, model.spec
    for index in range(1, tree.njoints):
        tree.inertias[index].mass = 0.5 * index
        tree.inertias[index].lever = np.array([0.3, 0.1 * index, 0.0])
        tree.inertias[index].inertia = np.diag([0.1, 0.2, 0.3])
    home = dict(model.home.joint_values)
    return pj.Mechanism.from_pinocchio(
        tree,
        loops=spec.loops,
        actuated=spec.actuated,
        tool=spec.tool.names[0],
        home=home,
        tool_rows=spec.tool.rows,
    ).home


HEAVY = {"ur5": lambda: loaded("ur5").home, "four-bar": heavy_four_bar}


def values(told):
    return [one["value"] for one in told]


@pytest.mark.parametrize("name", mechanisms.CATALOGUE)
def test_a_report_tells_of_motion_and_statics_what_the_configuration_does(name):
    home, rng = loaded(name).home, np.random.default_rng(14)
    rates, accelerations, wrench = (rng.normal(size=k) for k in (*home.actuated.shape * 2, 6))
    found = pj.report(home, "LOCAL", rates=rates, accelerations=accelerations, wrench=wrench)
    told = strict(to_json(found.told()))
    motion, statics = home.motion(rates, accelerations, "LOCAL"), home.statics(wrench)
    for key in ("rates", "passive_rates", "passive_accelerations", "twist", "acceleration"):
        np.testing.assert_array_equal(values(told["motion"][key]), getattr(motion, key))
    for key in ("efforts", "loop_forces"):
        np.testing.assert_array_equal(values(told["statics"][key]), getattr(statics, key))
    assert told["motion"]["frame"] == "LOCAL"
    assert told["statics"]["frame"] == "LOCAL_WORLD_ALIGNED"
    assert told["statics"]["determinate"] is statics.determinate
    assert len(told["statics"]["self_stress"]) == statics.self_stress.shape[1]
    assert told["dynamics"] is None
    units = loaded(name).units
    forces = {"m": "N", "rad": "N m"}
    for one in told["statics"]["efforts"]:
        assert one["unit"] == forces[units[one["name"]]]
    text = str(found)
    assert "Motion" in text
    assert "Motor efforts that balance it" in text


@pytest.mark.parametrize("name", HEAVY)
def test_efforts_of_inverse_dynamics_do_the_work_that_the_energy_gains(name):
    """Power of efforts and wrench is dE/dt, by differences through `close`."""
    home, rng = HEAVY[name](), np.random.default_rng(2)
    rates, accelerations, wrench = (rng.normal(size=k) for k in (*home.actuated.shape * 2, 6))
    load = pj.report(
        home, rates=rates, accelerations=accelerations, wrench=wrench, dynamics=True
    ).load
    power = load.efforts @ rates + load.motion.twist @ wrench
    step = 1e-5
    after, before = (
        _energy(
            home, home.actuated + s * rates + 0.5 * s**2 * accelerations, rates + s * accelerations
        )
        for s in (step, -step)
    )
    assert power == pytest.approx((after - before) / (2 * step), rel=1e-6, abs=1e-6)


def _energy(home, actuated, rates):
    model = home.mechanism.model
    there = home.mechanism.close(actuated, guess=home, enforce_limits=False)
    v, data = there.jacobian().motion_map @ rates, model.createData()
    kinetic = pin.computeKineticEnergy(model, data, there.q, v)
    return kinetic + pin.computePotentialEnergy(model, data, there.q)


def test_a_balanced_force_is_that_of_a_lever():
    """Virtual work: an arm of two links, its motors against a force at the tip, by hand."""
    arm = loaded("serial_2r")
    here = arm.close([0.3, 0.9])
    tip = here.tool_pose().translation
    force = np.array([2.0, -5.0, 0.0])
    told = pj.report(here, wrench=[*force, 0, 0, 0]).load.statics.efforts
    # The first joint is the world's origin; by its moment alone.
    assert told[0] == pytest.approx(-(tip[0] * force[1] - tip[1] * force[0]), abs=1e-12)


def test_a_wrench_is_given_by_names_too():
    home = loaded("three_rps").home
    by_name = pj.report(home, wrench={"fz": -30.0, "mx": 2.0}).load
    np.testing.assert_array_equal(by_name.wrench, [0, 0, -30.0, 2.0, 0, 0])
    np.testing.assert_array_equal(
        by_name.statics.efforts, home.statics([0, 0, -30.0, 2.0, 0, 0]).efforts
    )


def test_limits_are_those_of_the_file_and_what_is_beyond_is_told():
    home = loaded("three_rps").home
    light, heavy = (pj.report(home, wrench={"fz": -f}) for f in (30.0, 300.0))
    assert [one["limit"] for one in strict(to_json(light.told()))["statics"]["efforts"]] == [
        100.0
    ] * 3
    assert "Warning: more than the limit" not in str(light)
    assert "Warning: more than the limit of l1, l2, l3." in str(heavy)


def test_a_motor_without_a_limit_has_none():
    """A limit of 0, as readers of other formats write it, is none."""
    arm = loaded("serial_2r")
    model = arm.model
    model.upperEffortLimit = np.array([0.0, 7.0])
    model.lowerEffortLimit = -model.upperEffortLimit
    free = pj.Mechanism.from_pinocchio(model, [], arm.actuated, arm.spec.tool.names[0])
    found = pj.report(free.home, wrench=[0, 1.0, 0, 0, 0, 0])
    assert [one["limit"] for one in strict(to_json(found.told()))["statics"]["efforts"]] == [
        None,
        7,
    ]
    assert "none stated" in str(found)


def test_what_balances_by_more_motors_than_freedoms_is_said():
    tied = pj.load("four_bar", actuated=["theta1", "phi1"]).home
    text = str(pj.report(tied, wrench={"fy": -10.0}))
    assert "These are the smallest: motors may work against each other in one way." in text


@pytest.mark.parametrize(
    "asked", [{"rates": [1.0]}, {"wrench": [0, 1.0, 0, 0, 0, 0]}, {"dynamics": True}]
)
def test_singular_poses_have_a_report_but_neither_motion_nor_load(asked):
    assert pj.report(fold()).refusal is not None
    with pytest.raises(pj.SingularError):
        pj.report(fold(), **asked)


WRONG = {
    ("four_bar", "--dynamics"): "add inertia, or use statics",
    ("four_bar", "--wrench", "0,1"): "a wrench: 6 numbers expected",
    ("four_bar", "--wrench", "q=1"): "a wrench has fx, fy, fz, mx, my, mz; got 'q'",
    ("four_bar", "--rates", "1,2"): "1 motor rate (theta1) expected, got 2",
    ("four_bar", "--accelerations", "thet1=2"): "did you mean 'theta1'?",
    ("four_bar", "--rates", "a"): "--rates takes numbers joined by commas",
    (
        *("four_bar", "--set", "l1=3,l2=2.5,l3=2", "--at", "1.3715642395497258"),
        *("--wrench", "-1,0,0,0,0,0"),
    ): "no J_eq exists",
}


@pytest.mark.parametrize("argv", WRONG, ids=" ".join)
def test_the_command_line_refuses_in_one_line(argv, capsys):
    assert main(["report", *argv]) == 2
    captured = capsys.readouterr()
    assert captured.out == ""
    assert captured.err.count("\n") == 1
    assert WRONG[argv] in captured.err


def test_the_command_line_tells_what_python_does(capsys):
    argv = ["report", "ur5", "--rates", "-0.1,0,0,0,0,0", "--accelerations", "wrist_3_joint=1"]
    argv[-1] = ",".join(f"{name}={k}" for k, name in enumerate(loaded("ur5").actuated))
    assert main([*argv, "--wrench", "-1,0,-3,0,0,0", "--dynamics", "--json"]) == 0
    told = strict(capsys.readouterr().out)
    dynamics = loaded("ur5").home.dynamics([-0.1, 0, 0, 0, 0, 0])
    efforts = dynamics.efforts(np.arange(6.0), [-1.0, 0, -3.0, 0, 0, 0])
    np.testing.assert_array_equal(values(told["dynamics"]["efforts"]), efforts)
    matrix = told["dynamics"]["mass_matrix"]
    np.testing.assert_array_equal(matrix["values"], dynamics.mass_matrix)
    assert (matrix["row_units"][0], matrix["column_units"][0]) == ("N m", "rad/s²")
