"""MJCF against MuJoCo itself: body poses, loop equations and the equivalent Jacobian."""

from __future__ import annotations

import re
from pathlib import Path
from xml.etree.ElementTree import Element

import numpy as np
import pinocchio as pin
import pytest
from mjcf_models import MODELS, body, mjcf, motor
from mujoco_oracle import Pair, mujoco
from peer_models import peer_model

from pmjac_pin.files.mjcf.reader import read_mjcf
from pmjac_pin.files.mjcf.vocabulary import MJCF_WORDS
from pmjac_pin.kinematics.loop_system import LoopSystem
from pmjac_pin.kinematics.pinocchio import Kinematics
from pmjac_pin.kinematics.tool import tool_kinematics
from pmjac_pin.model.loop_spec import FrameLoop, JointLoop
from pmjac_pin.model.tool_spec import Tool

CASSIE = "mjcf/cassie_closed_chain.xml"


@pytest.fixture(params=[*MODELS, CASSIE])
def pair(request, tmp_path, monkeypatch) -> Pair:
    monkeypatch.chdir(tmp_path)  # MuJoCo writes its log into the working directory
    if request.param == CASSIE:
        return Pair(peer_model(CASSIE))
    return Pair(written(tmp_path, MODELS[request.param]))


def written(folder: Path, text: str) -> Path:
    path = folder / "robot.xml"
    path.write_text(text)
    return path


def test_bodies_and_sites_are_where_mujoco_has_them(pair, rng) -> None:
    data = pair.pin.createData()
    for _ in range(5):
        qpos = pair.random(rng)
        pair.forward(qpos)
        pin.framesForwardKinematics(pair.pin, data, pair.q(qpos))
        for kind in ("body", "site"):
            for number in range(1 if kind == "body" else 0, getattr(pair.mj, f"n{kind}")):
                name = getattr(pair.mj, kind)(number).name
                theirs = pair.placement(name, kind)
                ours = data.oMf[pair.frame(name, kind)]
                np.testing.assert_allclose(ours.homogeneous, theirs.homogeneous, atol=2e-14)


ATTACHED = """
<mujoco model="arm"><compiler angle="radian"/>
  <include file="{}more.xml"/>
  <worldbody><body name="arm" pos="1 0 0" euler="0 0 1"><joint name="j" axis="1 1 0" ref=".3"/>
    <geom size=".1"/><site name="tip" pos="1 0 0"/>
    <body name="fore" pos="0 1 0"><joint name="k"/><geom size=".1"/></body></body></worldbody>
  <equality><connect body1="fore" body2="arm" anchor=".1 .2 0"/></equality>
  <actuator><position name="drive" joint="j"/></actuator>
</mujoco>"""
ATTACHING = mjcf(
    body(
        "base",
        '<joint name="turn"/><attach model="arm" body="arm" prefix="L-"/>'
        '<frame pos="0 0 1" euler="0 90 0"><attach model="arm" body="arm" prefix="R-"/></frame>',
    ),
    '<weld site1="L-tip" site2="R-tip"/>',
    '<asset><model name="arm" file="parts/arm.xml"/></asset>',
    motor("turn", "L-k"),
)


def attaching(folder: Path) -> Path:
    (folder / "parts").mkdir()
    (folder / "parts" / "arm.xml").write_text(ATTACHED.format(""))
    (folder / "parts" / "more.xml").write_text('<m><default><geom density="70"/></default></m>')
    return written(folder, ATTACHING)


def test_attached_models_are_mujocos(tmp_path, monkeypatch, rng) -> None:
    monkeypatch.chdir(tmp_path)
    pair = Pair(attaching(tmp_path))
    assert pair.found.actuated == ("turn", "L-k", "L-j", "R-j")
    assert len(pair.found.loops) == 3
    test_bodies_and_sites_are_where_mujoco_has_them(pair, rng)
    test_loop_equations_are_the_rows_of_efc_J(pair, rng)


TENDONS = mjcf(
    body("a", '<joint name="x" ref="30"/>' + body("b", '<joint name="y" ref="-20"/>'))
    + body("c", '<joint name="s" type="slide" ref=".4"/><joint name="h" axis="0 1 0" ref="10"/>'),
    '<tendon tendon1="xy" polycoef=".2"/><tendon tendon1="s" tendon2="y" polycoef=".3 -.5"/>'
    '<tendon tendon1="h" polycoef=".6"/><tendon tendon1="path" active="false"/>'
    '<tendon tendon1="h" tendon2="xy" polycoef=".1 0" active="false"/>',
    after='<tendon><fixed name="xy"><joint joint="x" coef="2"/><joint joint="y" coef="-4"/></fixed>'
    '<fixed name="s"><joint joint="s" coef="3"/></fixed>'
    '<fixed name="y"><joint joint="y" coef="1"/></fixed>'
    '<fixed name="h"><joint joint="h" coef="2"/></fixed>'
    '<spatial name="path"><site site="p"/><site site="o"/></spatial></tendon>',
).replace("<worldbody>", '<worldbody><site name="p"/><site name="o" pos="1 0 0"/>')


def test_fixed_tendons_tie_joints_as_in_efc_J(tmp_path, monkeypatch, rng) -> None:
    """MuJoCo's rows are ours, times the weight of the joint that follows."""
    monkeypatch.chdir(tmp_path)
    pair = Pair(written(tmp_path, TENDONS))
    assert [loop.joints for loop in pair.found.loops] == [("x", "y"), ("y", "s")]
    assert "joint 'h' is held at 0.474533" in pair.found.notes
    ours = equations(pair)
    for _ in range(3):
        qpos = pair.random(rng)
        eta, jacobian = ours.loop_equations(pair.q(qpos))
        for row, weight in enumerate((-4.0, 3.0)):
            residual, rates = pair.equations(qpos, row)
            np.testing.assert_allclose(weight * eta[row], residual[0], atol=1e-12)
            np.testing.assert_allclose(weight * jacobian[row], rates[0], atol=1e-12)


def equations(pair: Pair) -> Kinematics:
    loops = LoopSystem(pair.pin, pair.found.loops, {})
    return Kinematics(pair.pin, loops, tool_kinematics(pair.pin, Tool(frame="world")))


def rows_of(pair: Pair) -> list[slice]:
    sizes = [{FrameLoop: 6, JointLoop: 1}.get(type(loop), 3) for loop in pair.found.loops]
    ends = np.cumsum([0, *sizes])
    return [slice(*ends[k : k + 2]) for k in range(len(sizes))]


def half_angle(turn: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """x sin(|x|/2)/|x|, a quaternion's vector part, and its derivative by x."""
    angle = np.linalg.norm(turn)
    axis = turn / angle
    sine, along = np.sin(angle / 2) / angle, 0.5 * np.cos(angle / 2)
    across = np.eye(3) - np.outer(axis, axis)
    return sine * turn, sine * across + along * np.outer(axis, axis)


def as_mujoco(pair: Pair, q: np.ndarray, loop: FrameLoop, residual, jacobian):
    """A weld's turn as MuJoCo measures it: half the quaternion, in the second frame's axes."""
    data = pair.pin.createData()
    pin.computeJointJacobians(pair.pin, data, q)
    pin.updateFramePlacements(pair.pin, data)
    frame = pair.pin.getFrameId(loop.frames[1], pin.FrameType.BODY)
    turning = pin.getFrameJacobian(pair.pin, data, frame, pin.LOCAL_WORLD_ALIGNED)[3:]
    back = data.oMf[frame].rotation.T
    half, slope = half_angle(back @ residual[3:])
    seen = back @ (jacobian[3:] + pin.skew(residual[3:]) @ turning)
    return np.r_[residual[:3], half], np.vstack([jacobian[:3], slope @ seen])


def test_loop_equations_are_the_rows_of_efc_J(pair, rng) -> None:
    """At any qpos, open or closed."""
    ours = equations(pair)
    numbers = [k for k in pair.active() if not pair.geared(k) & set(pair.held())]
    assert len(numbers) == len(pair.found.loops)
    for _ in range(5):
        qpos = pair.random(rng)
        q = pair.q(qpos)
        eta, jacobian = ours.loop_equations(q)
        for number, rows, loop in zip(numbers, rows_of(pair), pair.found.loops, strict=True):
            found = eta[rows], jacobian[rows]
            if isinstance(loop, FrameLoop):
                found = as_mujoco(pair, q, loop, *found)
            wanted = pair.equations(qpos, number)
            if isinstance(loop, FrameLoop) and wanted[0][3:] @ found[0][3:] < 0.0:
                # The other of the two quaternions of this rotation.
                found = tuple(np.r_[part[:3], -part[3:]] for part in found)
            np.testing.assert_allclose(found[0], wanted[0], atol=1e-12)
            np.testing.assert_allclose(found[1], wanted[1], atol=1e-10)


@pytest.mark.parametrize(
    "pair", ["four-bar", "welded four-bar", "several joints", CASSIE], indirect=True
)
def test_loops_given_by_bodies_are_closed_at_qpos0(pair) -> None:
    residual, _ = equations(pair).loop_equations(pair.q(pair.mj.qpos0))
    np.testing.assert_allclose(residual, 0.0, atol=1e-13)


def columns(pair: Pair, names: tuple[str, ...]) -> np.ndarray:
    return np.array([pair.pin.joints[pair.pin.getJointId(name)].idx_v for name in names])


def equivalent(pair: Pair, q: np.ndarray, actuated: tuple[str, ...], body: str) -> np.ndarray:
    """J − J* K*⁺ K of MuJoCo's matrices."""
    qpos = pair.qpos(q)
    constraint, tool = pair.constraint_jacobian(qpos), pair.tool_jacobian(qpos, body)
    motors = columns(pair, actuated)
    passive = np.setdiff1d(np.arange(pair.pin.nv), motors)
    rates = -np.linalg.pinv(constraint[:, passive], rcond=1e-9) @ constraint[:, motors]
    np.testing.assert_allclose(constraint[:, passive] @ rates, -constraint[:, motors], atol=1e-10)
    return tool[:, motors] + tool[:, passive] @ rates


@pytest.mark.parametrize(
    ("pair", "tool"),
    [("four-bar", "coupler"), ("welded four-bar", "tip"), ("ball rod", "right")],
    indirect=["pair"],
)
def test_the_equivalent_jacobian_is_that_of_efc_J(pair, tool, rng) -> None:
    mechanism = pair.mechanism(tool=tool)
    start = mechanism.home.actuated
    for _ in range(5):
        found = mechanism.close(start + rng.uniform(-0.2, 0.2, start.size))
        wanted = equivalent(pair, found.q, mechanism.actuated, tool)
        np.testing.assert_allclose(found.jacobian().J_eq, wanted, atol=1e-10)


SIDES = ("left", "right")
LEG = ("hip-roll", "hip-yaw", "hip-pitch", "knee", "foot")
SPRINGS = tuple(f"{side}-{spring}" for side in SIDES for spring in ("shin", "heel-spring"))


@pytest.mark.parametrize(
    ("locked", "mobility"), [(SPRINGS, 12), ((), 16)], ids=["springs at rest", "springs moved"]
)
def test_the_feet_of_cassie_move_as_mujoco_says(tmp_path, monkeypatch, locked, mobility) -> None:
    """Held at the pelvis. Two rods spin idly; springs that move count as motors."""
    monkeypatch.chdir(tmp_path)
    pair = Pair(peer_model(CASSIE), ("cassie-pelvis_free", *locked))
    legs = tuple(f"{side}-{joint}" for side in SIDES for joint in LEG)
    motors = legs if locked else legs + SPRINGS
    for foot in ("left-foot", "right-foot"):
        mechanism = pair.mechanism(motors, foot)
        assert (mechanism.mobility, len(mechanism.rows)) == (mobility, 12)
        assert mechanism.home.residual_norm < 1e-12
        start = mechanism.home.actuated
        inside = np.mean([np.clip(mechanism.limits(name), -0.5, 0.5) for name in motors], axis=1)
        for share in (0.0, 0.05, 0.1):
            found = mechanism.close(start + share * (inside - start))
            wanted = equivalent(pair, found.q, motors, foot)
            np.testing.assert_allclose(found.jacobian().J_eq, wanted, atol=1e-10)


def schema() -> Element:
    """One of each element that MuJoCo knows, with all its attributes."""
    stack: list[tuple[int, Element]] = []
    for line in mujoco.mj_printSchema(False, False).splitlines():
        indent = len(line) - len(line.lstrip())
        if started := re.match(r" *(\S+) \(.\)(.*)", line):
            element, words = Element(started[1].replace("(world)", "world")), started[2]
            while stack and stack[-1][0] >= indent:
                stack.pop()
            if stack:
                stack[-1][1].append(element)
            stack.append((indent, element))
        else:
            words = line
        for attribute in words.split():
            stack[-1][1].set(attribute, "1")
    return stack[0][1]


def test_every_attribute_of_mujoco_passes_for_well_spelt() -> None:
    root = schema()
    world = root.find("worldbody")
    world.append(Element("body", world.attrib))
    for path in ("worldbody/body", "worldbody/joint", "default/joint", "equality/weld"):
        assert len(root.find(path).attrib) > 5
    MJCF_WORDS.unread(root)


def test_every_section_of_mujoco_is_known(tmp_path, monkeypatch) -> None:
    monkeypatch.chdir(tmp_path)
    sections = "".join(f"<{section.tag}/>" for section in schema())
    path = written(tmp_path, f"<mujoco>{sections}</mujoco>")
    assert read_mjcf(path).urdf.links == ("world",)
