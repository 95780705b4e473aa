"""Drake: inverse kinematics by its optimisation."""

from __future__ import annotations

import tempfile
from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pydrake
from compared import own_lines as own
from compared.known import (
    BEYOND,
    CRANK,
    LENGTHS,
    SHORT,
    SHORT_ENDS,
    SHORT_NEAR,
    error,
    own_lines,
    rocker,
    rocker_rate,
)
from pydrake.multibody.inverse_kinematics import InverseKinematics
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import JacobianWrtVariable
from pydrake.solvers import Solve
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import Context

import pmjac_pin as pj

TIPS = ("coupler_tip", "rocker_tip")


def plant_of(mechanism: pj.Mechanism, ground: str) -> MultibodyPlant:
    """Return the machine's tree, its loops left open."""
    plant = MultibodyPlant(time_step=0.001)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "machine.urdf"
        pj.export(mechanism, to="toml", file=path.with_suffix(".toml"))
        Parser(plant).AddModels(str(path))
    plant.WeldFrames(plant.world_frame(), plant.GetFrameByName(ground))
    plant.Finalize()
    return plant


def at_home(plant: MultibodyPlant, mechanism: pj.Mechanism) -> np.ndarray:
    """Return the values of its joints at home."""
    q = np.zeros(plant.num_positions())
    for name, value in mechanism.home.joint_values.items():
        q[plant.GetJointByName(name).position_start()] = float(value)
    return q


def solved(lengths: Mapping[str, float], crank: float) -> tuple[bool, float]:
    """Return whether a pose was found with the crank at an angle, and the rocker's."""
    mechanism = pj.load("four_bar", lengths)
    plant = plant_of(mechanism, "ground")
    asked, nothing = InverseKinematics(plant), np.zeros(3)
    tips = [plant.GetFrameByName(name) for name in TIPS]
    asked.AddPositionConstraint(tips[1], nothing, tips[0], nothing, nothing)
    joint = plant.GetJointByName("theta1").position_start()
    asked.prog().AddBoundingBoxConstraint(crank, crank, asked.q()[joint])
    found = Solve(asked.prog(), at_home(plant, mechanism))
    q = found.GetSolution(asked.q())
    return found.is_success(), q[plant.GetJointByName("phi1").position_start()]


def apart(
    plant: MultibodyPlant, context: Context, tips: tuple[str, str]
) -> tuple[np.ndarray, np.ndarray]:
    """Return where the one is from the other, and how it turns and moves, in the world."""
    world, nothing = plant.world_frame(), np.zeros(3)
    first, second = (plant.GetFrameByName(tip) for tip in tips)
    turned_and_moved = [
        plant.CalcJacobianSpatialVelocity(
            context, JacobianWrtVariable.kV, tip, nothing, world, world
        )
        for tip in (first, second)
    ]
    places = [plant.CalcPointsPositions(context, tip, nothing, world) for tip in (first, second)]
    return (places[0] - places[1]).ravel(), turned_and_moved[0] - turned_and_moved[1]


def loop_of(lengths: Mapping[str, float]) -> own.Loop:
    """Return the four-bar's loop."""
    mechanism = pj.load("four_bar", lengths)
    plant = plant_of(mechanism, "ground")
    context = plant.CreateDefaultContext()

    def opened(q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        plant.SetPositions(context, q)
        gap, jacobian = apart(plant, context, TIPS)
        return gap[:2], jacobian[3:5]

    joints = (plant.GetJointByName(name).position_start() for name in ("theta1", "phi1"))
    return own.Loop(opened, at_home(plant, mechanism), *joints)


def bennett() -> str:
    """Return its mobility: a hinge leaves the rotation about its z free."""
    machine = pj.load("bennett")
    plant = plant_of(machine, "ground")
    context = plant.CreateDefaultContext()
    plant.SetPositions(context, at_home(plant, machine))
    _, jacobian = apart(plant, context, ("follower_tip", "ground_tip"))
    hinge = plant.GetFrameByName("ground_tip").CalcPoseInWorld(context).rotation().matrix()
    return own.mobility(np.vstack([jacobian[3:], hinge[:, :2].T @ jacobian[:3]]))


def answers() -> Mapping[str, str]:
    """Return what it says, by question."""
    _, angle = solved(LENGTHS, CRANK)
    success, _ = solved(SHORT, BEYOND)
    bar, short = loop_of(LENGTHS), loop_of(SHORT)
    rates = bar.rates(own.newton(bar, CRANK)[0])
    end = error(own.end_of_mode(short, SHORT_NEAR), SHORT_ENDS)
    return {
        "close": error(angle, rocker(CRANK)),
        "beyond": "success" if success else "refused: no solution found",
        "rate": f"by own lines, {error(rates[bar.rocker], rocker_rate(CRANK))}",
        "singular": own_lines(pydrake, "singular", end),
        "modes": own_lines(pydrake, "modes", f"{own.ways(bar, CRANK)} from random starts"),
        "mobility": own_lines(pydrake, "mobility", bennett()),
        "simulate": f"yes: {Simulator.__name__}, {MultibodyPlant.AddBallConstraint.__name__}",
    }
