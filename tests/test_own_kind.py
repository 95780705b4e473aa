"""A kind of loop of one's own, a pin in a slot: one class, and everything works with it."""

from __future__ import annotations

from collections.abc import Mapping

import msgspec
import numpy as np
import pinocchio as pin
import pytest
from drawn import draws_and_shows

import pmjac_pin as pj
from pmjac_pin.model import loop_spec
from pmjac_pin.model.joint_form import JointForm, Step, about_z, frame_along
from pmjac_pin.model.loop_between_frames import LoopBetweenFrames
from pmjac_pin.model.loop_spec import LOOP_KINDS, register
from pmjac_pin.model.rows import Along, Rows, Tilt, across
from pmjac_pin.model.spec import decode_spec, encode_spec
from pmjac_pin.model.table import Vector

AXIS, SLOT = np.array([0.0, 0.0, 1.0]), np.array([1.0, 0.0, 0.0])
REACH, DISTANCE = 0.4, 1.0  # of the crank; from its hinge to that of the slotted lever, m


class PinInSlot(LoopBetweenFrames, frozen=True, tag_field="kind", tag="pin_in_slot"):
    """The first frame's pin about z turns in, and slides along, the slot x of the second."""

    @property
    def lines(self) -> tuple[Vector, Vector] | None:
        return (0.0, 0.0, 1.0), (0.0, 0.0, 1.0)

    def rows(self, values: Mapping[str, float]) -> tuple[Rows, ...]:
        return Along(across(SLOT), ("aside", "above")), Tilt(AXIS, across(AXIS))

    def form(self, values: Mapping[str, float]) -> JointForm:
        about, along = frame_along(AXIS), frame_along(SLOT)
        turn = Step("turn", "continuous", about, about.T)
        slide = Step("slide", "prismatic", along, along.T)
        return JointForm(
            (turn, slide), lambda seen: about @ about_z((about.T @ seen @ about)[:3, 0]) @ about.T
        )


@pytest.fixture(scope="module", autouse=True)
def registered():
    register(PinInSlot)
    yield
    del LOOP_KINDS["pin_in_slot"]


@pytest.fixture(scope="module")
def lever(registered):
    """A crank whose pin drives a slotted lever."""
    model = pin.Model()
    crank = model.addJoint(0, pin.JointModelRZ(), pin.SE3.Identity(), "crank")
    away = pin.SE3(np.eye(3), np.array([-DISTANCE, 0.0, 0.0]))
    slotted = model.addJoint(0, pin.JointModelRZ(), away, "lever")
    tip = pin.SE3(np.eye(3), np.array([REACH, 0.0, 0.0]))
    for name, joint, place in (
        ("pin", crank, tip),
        ("slot", slotted, pin.SE3.Identity()),
        ("tool", slotted, pin.SE3(np.eye(3), np.array([1.5, 0.0, 0.0]))),
    ):
        model.addFrame(pin.Frame(name, joint, place, pin.FrameType.OP_FRAME))
    loop = PinInSlot(frames=("pin", "slot"))
    return pj.Mechanism.from_pinocchio(model, [loop], ["crank"], "tool", home=np.zeros(2))


def by_hand(crank):
    """The lever's angle, and its rate per rate of the crank."""
    x, y = DISTANCE + REACH * np.cos(crank), REACH * np.sin(crank)
    rate = REACH * (x * np.cos(crank) + y * np.sin(crank)) / (x * x + y * y)
    return np.arctan2(y, x), rate


def test_close_and_jacobian(lever):
    for crank in (0.3, 1.2, 2.5):
        configuration = lever.close([crank])
        angle, rate = by_hand(crank)
        assert configuration.passive == pytest.approx([angle])
        assert configuration.jacobian().J_eq[5, 0] == pytest.approx(rate)


def test_all_modes_by_search_proof_and_homotopy(lever):
    modes = pj.assembly_modes(lever, [0.7], rng=0)
    assert (len(modes), modes.evidence.kind) == (2, "proof")
    assert pj.prove(lever, [0.7])
    assert pj.parameter_homotopy(lever, rng=0).count == 2


def test_certificate_and_findings(lever):
    assert pj.certify(lever.close([0.7]))
    assert pj.check(lever) is not None


def test_the_jacobian_does_not_depend_on_the_cut(lever):
    configuration = lever.close([0.7])
    cut = pj.recut(lever, "lever")
    moved = cut.close([0.7])
    np.testing.assert_allclose(moved.jacobian().J_eq, configuration.jacobian().J_eq, atol=1e-9)


def test_it_is_written_read_and_pickled(lever):
    import pickle

    spec = decode_spec(encode_spec(lever.spec))
    assert spec == lever.spec
    assert isinstance(spec.loops[0], PinInSlot)
    assert pickle.loads(pickle.dumps(lever)).spec == lever.spec
    assert msgspec.to_builtins(spec.loops[0])["kind"] == "pin_in_slot"


def test_drawing_and_page(lever, tmp_path):
    assert draws_and_shows(lever, [0.7], tmp_path)


def test_every_kind_says_all_of_itself():
    for kind in LOOP_KINDS.values():
        if kind is loop_spec.JointLoop:
            continue
        loop = kind(frames=("a", "b"), **({"length": 1.0} if kind is pj.DistanceLoop else {}))
        assert loop.rows({})
        assert loop.form({}).steps
