"""Cassie as example-robot-data publishes it in SDFormat: its leg's loops, springs and motors.

The motors are those that the file's Gazebo plugin drives (DAIRLab/cassie-gazebo-sim): the joints
roll-op, yaw-op, pitch-op, knee-op and foot-op of each leg.
"""

from __future__ import annotations

import importlib.metadata
import os
from collections.abc import Iterable
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest

import pmjac_pin as pj
from pmjac_pin.closing.assembly import build_parts
from pmjac_pin.files.foreign_model import ForeignModel
from pmjac_pin.files.sdf.reader import read_sdf
from pmjac_pin.files.urdf.locking import lock_joints
from pmjac_pin.mechanism import Mechanism
from pmjac_pin.model.linkage import with_spherical

ROBOTS = "cmeel.prefix/share/example-robot-data/robots/cassie_description/robots"
FILES = ("cassie", "cassie_reduced", "cassie_simple", "cassie_v2", "cassie_wo_gearbox_spring")
SIDES = ("left", "right")
MOTORS = [
    f"{side}-{joint}-op" for side in SIDES for joint in ("roll", "yaw", "pitch", "knee", "foot")
]
SHIN_SPRINGS = [f"{side}-knee-shin-joint" for side in SIDES]
HEEL_SPRINGS = [f"{side}-tarsus-spring-joint" for side in SIDES]
# Angles of four to six digits leave the plantar linkages' axes parallel to 1e-7 rad, so that over
# the foot's range one of their loop equations, redundant but for that, is open by up to 1e-7 m.
TOLERANCE = 1e-7


@cache
def cassie(name: str = "cassie_v2") -> ForeignModel:
    package = importlib.metadata.distribution("example-robot-data")
    path = Path(str(package.locate_file(f"{ROBOTS}/{name}.sdf")))
    return replace(read_sdf(path, MOTORS), tolerance=TOLERANCE)


@cache
def mechanism(locked: tuple[str, ...], rods: bool = False, tool: str = "left-foot") -> Mechanism:
    return assembled(with_rods(cassie()) if rods else cassie(), locked, tool)


def assembled(found: ForeignModel, locked: Iterable[str], tool: str = "left-foot") -> Mechanism:
    spec = found.spec(MOTORS, tool).with_locked(locked)
    urdf = lock_joints(found.urdf, spec.locked)
    model = pin.buildModelFromXML(urdf.kinematic_xml())
    model = with_spherical(model, spec.spherical) if spec.spherical else model
    return Mechanism(build_parts(model, spec, {}, urdf))


def with_rods(found: ForeignModel) -> ForeignModel:
    """Cassie with achilles rods between two ball joints, as on the robot: one distance each."""
    placement = placements(found)
    loops = [loop for loop in found.loops if "pitch-rod-joint" not in loop.ends[0]]
    for side in SIDES:
        heel = f"{side}-achilles-spring-joint_on_{side}-achilles-rod"
        hip = f"{side}-pitch-rod-joint_on_{side}-hip-pitch"
        between = placement(heel).translation - placement(hip).translation
        loops.append(pj.DistanceLoop(frames=(heel, hip), length=float(np.linalg.norm(between))))
    return replace(found, loops=tuple(loops))


def placements(found: ForeignModel):
    model = pin.buildModelFromXML(found.urdf.kinematic_xml())
    data = model.createData()
    pin.framesForwardKinematics(model, data, pin.neutral(model))
    return lambda name: data.oMf[model.getFrameId(name, pin.BODY)]


@pytest.mark.parametrize("name", FILES)
def test_all_joints_of_each_file_are_in_the_tree_or_close_loops_at_zero(name: str) -> None:
    found = cassie(name)
    assert set(MOTORS) <= {joint.name for joint in found.urdf.joints}
    placement = placements(found)
    loops = [loop for loop in found.loops if not isinstance(loop, pj.JointLoop)]
    assert len(loops) == (6 if name == "cassie" else 4)
    for loop in loops:
        first, second = map(placement, loop.ends)
        np.testing.assert_allclose(first.homogeneous, second.homogeneous, atol=2e-15)


def test_the_file_with_gearboxes_has_one_coupling_a_motor() -> None:
    """θ_out = −ratio·θ_in by SDFormat; the ratios are 1/25, 1/25, 1/16, 1/16 and 1/50."""
    gears = {
        loop.joints: loop.ratio for loop in cassie("cassie").loops if isinstance(loop, pj.JointLoop)
    }
    ratios = {"roll": -0.04, "yaw": -0.04, "pitch": -0.0625, "knee": -0.0625, "foot": -0.02}
    assert gears == {
        (f"{side}-{joint}-ip", f"{side}-{joint}-op"): ratio
        for side in SIDES
        for joint, ratio in ratios.items()
    }


def test_the_rods_that_close_the_loops_are_as_long_as_the_robots() -> None:
    """Achilles rod 0.5012 m and plantar rod 0.35012 m (Cassie's MJCF), to the file's rounding."""
    placement = placements(cassie())
    for side in SIDES:
        heel = placement(f"{side}-achilles-spring-joint_on_{side}-achilles-rod")
        hip = placement(f"{side}-pitch-rod-joint_on_{side}-hip-pitch")
        assert np.linalg.norm(heel.translation - hip.translation) == pytest.approx(0.5012, abs=5e-5)
        rod = placement(f"{side}-plantar-rod").actInv(
            placement(f"{side}-plantar-foot-joint_on_{side}-foot")
        )
        assert np.linalg.norm(rod.translation[:2]) == pytest.approx(0.35012, abs=1e-4)


HELD = {
    "shin springs held": (tuple(SHIN_SPRINGS), False),
    "heel springs held": (tuple(HEEL_SPRINGS), False),
    "all held, rods between balls": ((*SHIN_SPRINGS, *HEEL_SPRINGS), True),
}


@pytest.mark.parametrize(("locked", "rods"), HELD.values(), ids=HELD)
def test_the_foot_moves_as_differences_through_the_closure_say(locked, rods) -> None:
    cassies = mechanism(locked, rods)
    middle = [0.05, -0.1, 0.2, -0.15, -1.4] * 2
    here = cassies.close(middle)
    step, jacobian = 1e-4, here.jacobian()
    for column in range(5):
        shift = step * np.eye(10)[column]
        ahead, behind = (
            cassies.close(here.actuated + sign * shift, here).tool_pose() for sign in (1, -1)
        )
        linear = (ahead.translation - behind.translation) / (2 * step)
        angular = pin.log3(ahead.rotation @ behind.rotation.T) / (2 * step)
        np.testing.assert_allclose(jacobian.Jv_eq[:, column], linear, atol=2e-6)
        np.testing.assert_allclose(jacobian.Jw_eq[:, column], angular, atol=2e-6)
    np.testing.assert_allclose(jacobian.J_eq[:, 5:], 0.0, atol=1e-9)


def test_a_parallelogram_turns_the_foot_as_its_crank() -> None:
    """The plantar linkage: crank and foot 0.055 m, rod as long as the tarsus between them.

    To the five digits of the file's lengths.
    """
    cassies = mechanism(tuple(SHIN_SPRINGS))
    here = cassies.close([0.0, 0.0, 0.0, 0.0, -1.2] * 2)
    rates = here.jacobian().passive_rates[:, cassies.actuated.index("left-foot-op")]
    named = dict(zip(cassies.passive, rates, strict=True))
    assert named["left-tarsus-crank-joint"] == pytest.approx(1.0, abs=5e-5)
    assert named["left-crank-rod-joint"] == pytest.approx(-1.0, abs=5e-5)
    assert here.joint_values["left-tarsus-crank-joint"] == pytest.approx(-1.2, abs=5e-5)


def test_springs_set_free_move_the_foot_without_a_motor() -> None:
    cassies = mechanism(())
    assert cassies.mobility == 12
    with pytest.raises(
        pj.NoJacobianError, match=r"left-knee-shin-joint, .*left-tarsus-spring-joint"
    ):
        cassies.home.jacobian()


def test_with_all_springs_held_the_files_heel_hinge_forbids_the_knee() -> None:
    """The rod hangs on a hinge 4.5 degrees off the leg's plane, where the robot has a ball."""
    cassies = mechanism((*SHIN_SPRINGS, *HEEL_SPRINGS))
    assert cassies.mobility == 8
    with pytest.raises(pj.NoJacobianError, match="make 2 of them passive") as caught:
        cassies.home.jacobian()
    forbidden = np.abs(caught.value.forbidden_rates).max(axis=1)
    knees = [motor.endswith("knee-op") for motor in MOTORS]
    np.testing.assert_allclose(forbidden, np.asarray(knees, dtype=float), atol=1e-9)


def test_which_hinges_are_off_the_plane_of_their_linkage() -> None:
    """The heel's in all files, by 4.5 degrees; the plantar rod's in two, by 5.7 (0.1 rad)."""
    for name in FILES:
        placement = placements(cassie(name))
        for side in SIDES:
            tarsus = placement(f"{side}-tarsus").rotation[:, 2]
            heel = placement(f"{side}-achilles-spring-joint_on_{side}-achilles-rod").rotation[:, 2]
            assert np.degrees(np.arccos(abs(tarsus @ heel))) == pytest.approx(4.5, abs=0.1)
    for name in ("cassie_reduced", "cassie_simple"):
        rod = placements(cassie(name))("left-plantar-rod").rotation[:, 2]
        assert np.arccos(abs(rod[1])) == pytest.approx(0.1, abs=1e-3)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["cassie_reduced", "cassie_simple"])
def test_a_file_that_closes_outside_its_limits_only_says_so(name: str) -> None:
    with pytest.raises(pj.ClosureError, match=r"'left-foot-op' = -0.0\d* rad is outside"):
        assembled(cassie(name), (*SHIN_SPRINGS, "static"))


@pytest.mark.parametrize("name", ["cassie", "cassie_wo_gearbox_spring"])
def test_files_with_axes_in_the_models_frame_close_without_a_tolerance(name: str) -> None:
    have = {joint.name for joint in cassie(name).urdf.joints}
    found = replace(cassie(name), tolerance=None)
    home = assembled(found, [joint for joint in (*SHIN_SPRINGS, "static") if joint in have]).home
    assert home.residual_norm < 1e-12
    assert np.isfinite(home.jacobian().J_eq).all()


def test_a_rod_between_balls_spins_and_the_foot_does_not_feel_it() -> None:
    cassies = mechanism((*SHIN_SPRINGS, *HEEL_SPRINGS), rods=True)
    assert cassies.mobility == 12
    assert cassies.home.singularity().idle == 2
    assert np.isfinite(cassies.home.jacobian().J_eq).all()


def test_the_foot_moves_as_in_the_mjcf_model_to_what_their_anchors_differ() -> None:
    """J_eq of the left foot against MuJoCo's constraint Jacobian, springs held in both.

    The bodies are placed alike to 1e-5 m, and the hip pitch axis differs by 8e-4 rad (the SDF
    writes -1.57 for -π/2). The heel's anchor is 1.5 mm elsewhere: that is 2 % in the knee's
    column. With the foot at zero the plantar linkage is flat, so the foot's column is J's own.
    """
    mujoco = pytest.importorskip("mujoco")
    folder = Path(
        os.environ.get("PMJAC_PEER_MODELS", Path(__file__).parents[2] / "shared/peer_models")
    )
    path = folder / "mjcf" / "cassie_closed_chain.xml"
    if not path.is_file():
        pytest.skip("the MJCF of Cassie is not here: set PMJAC_PEER_MODELS")
    model = mujoco.MjModel.from_xml_path(str(path))
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    linear, angular = np.zeros((2, 3, model.nv))
    mujoco.mj_jacBody(model, data, linear, angular, model.body("left-foot").id)
    tool = np.vstack([linear, angular])

    def columns(*names: str) -> list[int]:
        joints = [model.joint(f"left-{name}") for name in names]
        return [
            at + k
            for at, size in ((j.dofadr[0], 3 if j.type[0] == 1 else 1) for j in joints)
            for k in range(size)
        ]

    motors = columns("hip-roll", "hip-yaw", "hip-pitch", "knee")
    passive = columns("tarsus", "achilles-rod")
    achilles = data.efc_J.reshape(-1, model.nv)[3:6]
    rates = -np.linalg.lstsq(achilles[:, passive], achilles[:, motors])[0]
    wanted = tool[:, motors] + tool[:, passive] @ rates

    found = mechanism((*SHIN_SPRINGS, *HEEL_SPRINGS), rods=True)
    at_zero = found.configuration(np.zeros(found.nq))
    ours = at_zero.jacobian().J_eq[:, :4].copy()
    ours[:, 1] *= -1.0  # the SDF's yaw axis points down, the MJCF's up
    np.testing.assert_allclose(ours[:, :3], wanted[:, :3], atol=1e-3)
    np.testing.assert_allclose(ours[:, 3], wanted[:, 3], atol=0.02)
    assert np.abs(ours[:, 3] - wanted[:, 3]).max() > 1e-3
