"""Joints that are held: a URDF with them fixed, and what a mechanism makes of it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest

import pmjac_pin as pj
from pmjac_pin.files.urdf.locking import lock_joints
from pmjac_pin.files.urdf.robot import parse_urdf

CHAIN = """
<robot name="chain">
  <link name="base"/> <link name="arm"/> <link name="slide"/> <link name="tip"/>
  <joint name="turn" type="revolute">
    <parent link="base"/> <child link="arm"/> <origin xyz="1 2 3" rpy="0.3 1.5708 -2"/>
    <axis xyz="1 -2 0.5"/> <limit lower="-1" upper="1" effort="1" velocity="1"/>
    <dynamics damping="1"/>
  </joint>
  <joint name="push" type="prismatic">
    <parent link="arm"/> <child link="slide"/> <axis xyz="0 2 1"/>
    <limit lower="-1" upper="1" effort="1" velocity="1"/>
  </joint>
  <joint name="spin" type="continuous">
    <parent link="slide"/> <child link="tip"/> <origin xyz="0 0 1"/>
  </joint>
</robot>"""
LWA = pin.ReferenceFrame.LOCAL_WORLD_ALIGNED
VALUES = {"turn": -0.7, "push": 0.4, "spin": 2.5}


def tip(model: pin.Model, values: dict[str, float]) -> pin.SE3:
    q = pin.neutral(model)
    for name, value in values.items():
        joint = model.joints[model.getJointId(name)]
        q[joint.idx_q : joint.idx_q + joint.nq] = (
            value if joint.nq == 1 else (np.cos(value), np.sin(value))
        )
    data = model.createData()
    pin.framesForwardKinematics(model, data, q)
    return data.oMf[model.getFrameId("tip")].copy()


@pytest.mark.parametrize("held", [["turn"], ["push"], ["spin"], ["turn", "spin"], list(VALUES)])
def test_the_tree_is_where_it_was_with_these_joints_at_these_values(held: list[str]) -> None:
    urdf = parse_urdf(CHAIN, "chain.urdf")
    locked = lock_joints(urdf, {name: VALUES[name] for name in held})
    assert [joint.name for joint in locked.joints if joint.type == "fixed"] == held
    free = {name: value for name, value in VALUES.items() if name not in held}
    found = tip(pin.buildModelFromXML(locked.kinematic_xml()), free)
    wanted = tip(pin.buildModelFromXML(urdf.kinematic_xml()), VALUES)
    np.testing.assert_allclose(found.homogeneous, wanted.homogeneous, atol=1e-14)


def test_nothing_to_lock_gives_the_same_urdf() -> None:
    urdf = parse_urdf(CHAIN, "chain.urdf")
    assert lock_joints(urdf, {}) is urdf


@pytest.mark.parametrize(
    ("values", "error", "message"),
    [
        ({"trun": 0.0}, pj.UnknownNameError, "did you mean 'turn'"),
        ({"turn": 1.5}, pj.LimitError, r"locked at 1.5, outside \[-1, 1\]"),
    ],
)
def test_a_joint_that_cannot_be_locked_so(
    values: dict[str, float], error: type[Exception], message: str
) -> None:
    with pytest.raises(error, match=message):
        lock_joints(parse_urdf(CHAIN, "chain.urdf"), values)


FLOATING = CHAIN.replace('name="spin" type="continuous"', 'name="spin" type="floating"')
PLACES = {
    "origin": (0.0, [0, 0, 0, 0, 0, 0, 1]),
    "quaternion": ((1.0, 2.0, 3.0, 0.6, 0.0, 0.0, 0.8), [1, 2, 3, 0.6, 0, 0, 0.8]),
    "rotation vector": ((1.0, 2.0, 3.0, 0.0, np.pi / 2, 0.0), [1, 2, 3, 0, 0.5**0.5, 0, 0.5**0.5]),
}


@pytest.mark.parametrize(("value", "q"), PLACES.values(), ids=PLACES)
def test_a_floating_joint_is_held_where_a_pose_puts_it(value: object, q: list[float]) -> None:
    urdf = parse_urdf(FLOATING, "chain.urdf")
    model = pin.buildModelFromXML(urdf.kinematic_xml())
    data = model.createData()
    pin.framesForwardKinematics(model, data, np.array([0.0, 0.0, *q]))
    wanted = data.oMf[model.getFrameId("tip")]
    found = tip(pin.buildModelFromXML(lock_joints(urdf, {"spin": value}).kinematic_xml()), {})
    np.testing.assert_allclose(found.homogeneous, wanted.homogeneous, atol=1e-14)


@pytest.mark.parametrize(
    ("kind", "value", "message"),
    [
        ("fixed", 0.0, "'spin' is fixed; only joints that move can be locked"),
        ("planar", (1.0, 2.0), "joint 'spin' takes 3 or 4 values, got 2"),
        ("floating", 1.0, "joint 'spin' takes 6 or 7 values, got 1"),
        ("floating", (1.0, 2.0), "takes 6 or 7 values, got 2"),
        ("floating", (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 2.0), "not of unit length"),
        ("continuous", (1.0, 2.0), "'spin' is locked at one number, got 2"),
    ],
)
def test_values_that_do_not_fit_the_joint(kind: str, value: object, message: str) -> None:
    text = CHAIN.replace('name="spin" type="continuous"', f'name="spin" type="{kind}"')
    text = text.replace('<origin xyz="0 0 1"/>', '<origin xyz="0 0 1"/><axis xyz="0 0 1"/>')
    with pytest.raises(pj.ArgumentError, match=message):
        lock_joints(parse_urdf(text, "chain.urdf"), {"spin": value})


MODEL = """
urdf = "chain.urdf"
actuated = ["turn", "push"]
tool.frame = "tip"
[poses.home]
turn = -0.7
push = 0.4
spin = 2.5
"""


@pytest.fixture
def chain(tmp_path: Path) -> Path:
    (tmp_path / "chain.urdf").write_text(CHAIN)
    path = tmp_path / "chain.toml"
    path.write_text(MODEL)
    return path


def test_a_mechanism_has_no_column_for_a_locked_joint(chain: Path) -> None:
    free, held = pj.load(chain), pj.load(chain, locked=["spin"])
    assert (free.passive, held.passive) == (("spin",), ())
    assert held.spec.locked == {"spin": 2.5}
    assert "spin" not in held.spec.poses["home"]
    split = free.home.split_jacobian()
    np.testing.assert_allclose(held.home.jacobian().Jv_eq, split.Jv, atol=1e-14)
    np.testing.assert_allclose(held.home.jacobian().Jw_eq, split.Jw, atol=1e-14)
    assert free.home.tool_pose().isApprox(held.home.tool_pose(), 1e-12)


def test_a_value_given_goes_before_the_home_poses(chain: Path) -> None:
    assert pj.load(chain, locked={"spin": -1.0}).spec.locked == {"spin": -1.0}


def test_a_model_file_locks_joints_itself(chain: Path) -> None:
    held = pj.load(chain, locked=["spin"])
    chain.write_text(MODEL.replace("spin = 2.5", "[locked]\nspin = 2.5"))
    assert pj.load(chain) == pj.load(chain, locked=["spin"]) == held


@pytest.mark.parametrize(
    ("locked", "message"),
    [
        (["turn", "push"], r"all motors are locked \(turn, push\); hold fewer, or name others"),
        ("spin", "a list of joints or a mapping, got 'spin'"),
        (5, "a list of joints or a mapping, got 5"),
        ([["spin"]], "a list of joints or a mapping"),
        ({"spin": "1"}, "joint 'spin' is locked at one number, got '1'"),
        ({"spin": np.nan}, "finite"),
        ({"spin": (0.0, 1.0)}, "locked at one number, got 2"),
        (["spinn"], "did you mean 'spin'"),
    ],
)
def test_what_cannot_be_locked_in_a_mechanism(chain: Path, locked: object, message: str) -> None:
    with pytest.raises(pj.PmjacError, match=message):
        pj.load(chain, locked=locked)


@pytest.mark.parametrize("held", ["turn", "push"])
def test_a_locked_motor_is_none(chain: Path, held: str) -> None:
    """The columns of the others stay what they were."""
    free, locked = pj.load(chain), pj.load(chain, locked=[held])
    kept = [name for name in free.actuated if name != held]
    assert locked.actuated == tuple(kept)
    assert f"held, and so no motor: {held}" in locked.notes
    columns = [free.actuated.index(name) for name in kept]
    whole, part = free.home.split_jacobian(), locked.home.split_jacobian()
    np.testing.assert_allclose(part.Jv, whole.Jv[:, columns], atol=1e-14)
    np.testing.assert_allclose(part.Jw, whole.Jw[:, columns], atol=1e-14)
    with pytest.raises(pj.ArgumentError, match=f"{held!r} is given as `actuated` and as `locked`"):
        pj.load(chain, locked=[held], actuated=iter(["turn", "push"]))


def test_a_locked_joint_of_an_open_chain_is_no_motor(tmp_path: Path) -> None:
    (tmp_path / "chain.urdf").write_text(CHAIN)
    free = pj.load(tmp_path / "chain.urdf", tool="tip")
    held = pj.load(tmp_path / "chain.urdf", tool="tip", locked=["spin"])
    assert {*free.actuated} - {*held.actuated} == {"spin"}


def test_a_locked_joint_has_no_value_in_a_pose(chain: Path) -> None:
    chain.write_text(MODEL + "[locked]\nspin = 2.5")
    with pytest.raises(pj.ModelFileError, match=r"remove it from `poses.home`"):
        pj.load(chain)


def test_a_base_that_moves_freely_is_held_in_its_home_pose(chain: Path) -> None:
    (chain.parent / "chain.urdf").write_text(FLOATING)
    chain.write_text(MODEL.replace("spin = 2.5", "spin = [1, 2, 3, 0, 0, 1, 0]"))
    free, held = pj.load(chain), pj.load(chain, locked=["spin"])
    assert held.spec.locked == {"spin": (1.0, 2.0, 3.0, 0.0, 0.0, 1.0, 0.0)}
    assert held.passive == ()
    assert free.home.tool_pose().isApprox(held.home.tool_pose(), 1e-12)
    chain.write_text(MODEL.replace("spin = 2.5", "[locked]\nspin = [1, 2, 3, 0, 0, 1, 0]"))
    assert pj.load(chain) == held


#: A joint's type in the URDF, whether it is a ball, and values of it.
SEVERAL = {
    "floating": ("floating", False, (1.0, -2.0, 0.5, 0.3, -0.4, 0.5)),
    "planar": ("planar", False, (1.0, -2.0, 0.7)),
    "planar by (cos, sin)": ("planar", False, (1.0, -2.0, 0.6, 0.8)),
    "ball": ("floating", True, (0.3, -0.4, 0.5)),
    "ball by its quaternion": ("floating", True, (0.0, 0.6, 0.0, 0.8)),
    "ball at its origin": ("floating", True, 0.0),
}


@pytest.mark.parametrize(("kind", "ball", "values"), SEVERAL.values(), ids=SEVERAL)
@pytest.mark.parametrize("said", ["load", "file"])
def test_a_joint_of_several_freedoms_is_held_where_a_pose_puts_it(
    chain: Path, kind: str, ball: bool, values: object, said: str
) -> None:
    text = CHAIN.replace('name="spin" type="continuous"', f'name="spin" type="{kind}"')
    text = text.replace('<origin xyz="0 0 1"/>', '<origin xyz="0 0 1"/><axis xyz="0 0 1"/>')
    (chain.parent / "chain.urdf").write_text(text)
    head = 'spherical = ["spin"]\n' if ball else ""
    written = list(values) if isinstance(values, tuple) else values
    posed = "" if values == 0.0 else f"spin = {written}"
    chain.write_text(head + MODEL.replace("spin = 2.5", posed))
    free = pj.load(chain)
    if said == "file":
        chain.write_text(head + MODEL.replace("spin = 2.5", f"[locked]\nspin = {written}"))
    held = pj.load(chain, locked=["spin"] if said == "load" else ())
    assert held.passive == ()
    np.testing.assert_allclose(
        held.home.tool_pose().homogeneous, free.home.tool_pose().homogeneous, atol=1e-14
    )
    J = held.close([0.2, -0.3]).jacobian().Jv_eq
    pose = {**free.home.joint_values, "turn": 0.2, "push": -0.3}
    at = free.configuration(free.coordinates.q(pose))
    tool = pin.computeFrameJacobian(
        free.model, free.model.createData(), at.q, free.model.getFrameId("tip"), LWA
    )
    np.testing.assert_allclose(J, tool[:3, :2], atol=1e-14)


@pytest.mark.parametrize("kind", ["floating", "planar", "ball"])
def test_the_advice_for_a_loose_joint_is_taken(chain: Path, kind: str) -> None:
    written = "floating" if kind == "ball" else kind
    text = CHAIN.replace('name="spin" type="continuous"', f'name="spin" type="{written}"')
    text = text.replace('<origin xyz="0 0 1"/>', '<origin xyz="0 0 1"/><axis xyz="0 0 1"/>')
    (chain.parent / "chain.urdf").write_text(text)
    head = 'spherical = ["spin"]\n' if kind == "ball" else ""
    chain.write_text(head + MODEL.replace("spin = 2.5", ""))
    errors = [f for f in pj.check(chain).findings if f.severity == "error"]
    assert [f.code for f in errors] == ["free-joint"]
    assert "`--locked spin`" in errors[0].advice
    assert not [
        f for f in pj.check(pj.load(chain, locked=["spin"])).findings if f.severity == "error"
    ]
