"""Drake: inverse kinematics by its optimisation."""

from __future__ import annotations

import tempfile
from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pydrake
import pydrake.all as dr
from compared.known import BEYOND, CRANK, LENGTHS, SHORT, error, none, rocker, rocker_rate

import pmjac_pin as pj


def solved(
    lengths: Mapping[str, float], crank: float
) -> tuple[bool, dr.MultibodyPlant, np.ndarray]:
    """Return whether a pose was found with the crank at an angle, the plant and q."""
    plant = dr.MultibodyPlant(time_step=0.001)
    mechanism = pj.load("four_bar", lengths)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "bar.urdf"
        pj.export(mechanism, to="toml", file=path.with_suffix(".toml"))
        dr.Parser(plant).AddModels(str(path))
    plant.WeldFrames(plant.world_frame(), plant.GetFrameByName("ground"))
    plant.Finalize()
    asked = dr.InverseKinematics(plant)
    tips = [plant.GetFrameByName(name) for name in ("coupler_tip", "rocker_tip")]
    nothing = np.zeros(3)
    asked.AddPositionConstraint(tips[1], nothing, tips[0], nothing, nothing)
    joint = plant.GetJointByName("theta1").position_start()
    asked.prog().AddBoundingBoxConstraint(crank, crank, asked.q()[joint])
    start = [mechanism.home.joint_values[name] for name in ("theta1", "phi2", "phi1")]
    guess = np.zeros(3)
    for name, value in zip(("theta1", "phi2", "phi1"), start, strict=True):
        guess[plant.GetJointByName(name).position_start()] = value
    found = dr.Solve(asked.prog(), guess)
    return found.is_success(), plant, found.GetSolution(asked.q())


def answers() -> Mapping[str, str]:
    """Return what it says, by question."""
    _, plant, q = solved(LENGTHS, CRANK)
    place = plant.GetJointByName("phi1").position_start()
    success, *_ = solved(SHORT, BEYOND)
    context = plant.CreateDefaultContext()
    plant.SetPositions(context, q)
    world, tips = plant.world_frame(), ("coupler_tip", "rocker_tip")
    first, second = (
        plant.CalcJacobianTranslationalVelocity(
            context, dr.JacobianWrtVariable.kV, plant.GetFrameByName(tip), np.zeros(3), world, world
        )
        for tip in tips
    )
    crank = plant.GetJointByName("theta1").velocity_start()
    others = [k for k in range(3) if k != crank]
    rates = -np.linalg.lstsq((first - second)[:, others], (first - second)[:, crank], rcond=None)[0]
    row = others.index(plant.GetJointByName("phi1").velocity_start())
    return {
        "close": error(q[place], rocker(CRANK)),
        "beyond": "success" if success else "refused: no solution found",
        "rate": f"by own lines, {error(rates[row], rocker_rate(CRANK))}",
        "singular": none(pydrake, "singular"),
        "modes": none(pydrake, "modes"),
        "mobility": none(pydrake, "mobility"),
        "simulate": f"yes: {dr.Simulator.__name__}, {dr.MultibodyPlant.AddBallConstraint.__name__}",
    }
