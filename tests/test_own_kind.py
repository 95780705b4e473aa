"""A kind of loop of one's own, a pin in a slot: one class, and everything works with it."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

import msgspec
import numpy as np
import pinocchio as pin
import pytest
from drawn import draws_and_shows
from exported import FORMATS, round_trip

import pmjac_pin as pj
from pmjac_pin.model import loop_spec
from pmjac_pin.model.joint_form import JointForm, Step, about_z, frame_along
from pmjac_pin.model.loop_between_frames import LoopBetweenFrames
from pmjac_pin.model.loop_spec import LOOP_KINDS, register
from pmjac_pin.model.rows import Along, Equations, Rows, Tilt, across
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


@contextmanager
def known(kind):
    """Let model files name a kind while this lasts."""
    register(kind)
    yield
    del LOOP_KINDS[kind.__struct_config__.tag]


@pytest.fixture(scope="module", autouse=True)
def registered():
    with known(PinInSlot):
        yield


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
    found = pj.check(lever)
    assert (found.mobility.mobility, [loop.rank for loop in found.loops]) == (1, [1])


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


def test_it_is_followed_with_proof(lever):
    way = pj.follow(lever, [[0.3], [2.5]], certified=True)
    assert (way.status, way.evidence.kind) == ("end", "proof")
    for crank, passive, rates in zip(way.actuated[:, 0], way.passive, way.v, strict=True):
        angle, rate = by_hand(crank)
        assert passive == pytest.approx([angle])
        assert rates == pytest.approx([2.2, 2.2 * rate])
    [dead] = way.events
    assert (dead.kind, 0.3 + 2.2 * dead.t) == ("loss", pytest.approx(np.arccos(-REACH / DISTANCE)))


def test_it_is_reached_on_all_its_working_modes(lever):
    target = lever.close([1.2]).tool_pose()
    found = pj.reach(lever, target, guess={"crank": 0.8})
    assert (found.status, found.actuated) == ("reached", pytest.approx([1.2]))
    modes = pj.working_modes(lever, target, rng=0)
    angle, _ = by_hand(1.2)
    assert [by_hand(crank)[0] for crank in modes.actuated[:, 0]] == pytest.approx([angle] * 2)


def test_its_nearest_singularity_is_where_the_lever_turns_back(lever):
    nearest = pj.nearest_singularity(lever.close([1.5]), rng=0)
    assert nearest.freed == "loss"
    assert nearest.distance == pytest.approx(np.arccos(-REACH / DISTANCE) - 1.5)


@pytest.mark.parametrize("to", FORMATS)
def test_it_is_exported(lever, to, tmp_path):
    _, again = round_trip(lever, to, tmp_path)
    J_eq = again.close([0.7]).jacobian().J_eq
    np.testing.assert_allclose(J_eq, lever.close([0.7]).jacobian().J_eq, atol=1e-10)


def test_drawing_and_page(lever, tmp_path):
    assert draws_and_shows(lever, [0.7], tmp_path)


@dataclass(frozen=True, slots=True)
class Height:
    """η = y·(p₁ − p₂) − h in the second frame's axes: a row with a length of its own."""

    height: float
    names: ClassVar = ("height",)
    unit: ClassVar = "m"
    vector: ClassVar = False
    measures: ClassVar = "gap from second"

    def __call__(self, pose):
        return pose.gap[1:2] - self.height, pose.gap_rates[1:2]

    def equations(self, jets, one, other):
        gap, carried = one.origin() - other.origin(), other.carried(np.array([[0.0, 1.0, 0.0]]))
        return Equations(jets.dot(carried, gap[:, None]) - jets.measured([self.height]))


class Shelf(LoopBetweenFrames, frozen=True, tag_field="kind", tag="shelf"):
    """The first frame is a height above the second."""

    height: float

    def rows(self, values: Mapping[str, float]) -> tuple[Rows, ...]:
        return (Height(self.height),)

    def form(self, values: Mapping[str, float]) -> JointForm:
        raise NotImplementedError


@pytest.mark.parametrize("size", [1e-2, 1.0, 40.0])
def test_a_row_with_a_length_of_its_own_is_the_same_in_all_searches(size):
    """A crank whose pin stays at a height above the edge of a table: sin ψ by hand."""
    model, height = pin.Model(), 0.36 * size
    crank = model.addJoint(0, pin.JointModelRZ(), pin.SE3.Identity(), "crank")
    table = model.addJoint(0, pin.JointModelPY(), pin.SE3.Identity(), "table")
    for name, joint, place in (
        ("pin", crank, (0.4, 0.0, 0.0)),
        ("tool", crank, (1.0, 0.0, 0.0)),
        ("edge", table, (0.0, -0.2, 0.0)),
    ):
        placement = pin.SE3(np.eye(3), size * np.array(place))
        model.addFrame(pin.Frame(name, joint, placement, pin.FrameType.OP_FRAME))
    motor = 0.02 * size  # size (0.4 sin ψ + 0.2) − motor = height
    wanted = np.arcsin((height + motor - 0.2 * size) / (0.4 * size))
    loop = Shelf(frames=("pin", "edge"), height=height)
    home = np.array([wanted, motor])
    with known(Shelf):
        machine = pj.Mechanism.from_pinocchio(model, [loop], ["table"], "tool", home=home)
        modes = pj.assembly_modes(machine, [motor], rng=0, limits=False)
        solved = pj.parameter_homotopy(machine, rng=0).at([motor])
    by_hand = pytest.approx(sorted([wanted, np.pi - wanted]))
    assert (modes.evidence.kind, sorted(mode.passive[0] for mode in modes)) == ("proof", by_hand)
    assert sorted(mode.passive[0] for mode in solved.real) == by_hand


class ScaledRod(LoopBetweenFrames, frozen=True, tag_field="kind", tag="scaled_rod"):
    """A rod as long as a share of the parameter a."""

    share: float

    @property
    def parameter_names(self) -> frozenset[str]:
        return frozenset({"a"})

    def resolved(self, values: Mapping[str, float]) -> pj.DistanceLoop:
        return pj.DistanceLoop(frames=self.frames, length=self.share * values["a"])

    def rows(self, values: Mapping[str, float]) -> tuple[Rows, ...]:
        return self.resolved(values).rows(values)

    def form(self, values: Mapping[str, float]) -> JointForm:
        return self.resolved(values).form(values)

    def rod(self, values: Mapping[str, float]) -> float:
        return self.resolved(values).rod(values)


def test_a_kind_with_parameters_is_loaded_cut_elsewhere_and_refused_without_them(tmp_path):
    repository = Path(__file__).parents[1]
    text = (repository / "models" / "three_rps_ss.toml").read_text()
    own = text.replace('"distance"', '"scaled_rod"')
    own = own.replace("length = { a = 1.7320508075688772 }", "share = 1.7320508075688772")
    robot = (repository / "urdf" / "three_rps_ss.urdf").read_text()
    (tmp_path / "three_rps_ss.urdf").write_text(robot)
    (tmp_path / "own.toml").write_text(own)
    (tmp_path / "wrong.toml").write_text(own.replace("[parameters.a]", "[parameters.c]"))
    with known(ScaledRod):
        machine = pj.load(tmp_path / "own.toml", parameters={"a": 1.1})
        given = pj.load("three_rps_ss", parameters={"a": 1.1})
        moved = pj.recut(machine, "theta1").close(given.home.actuated)
        np.testing.assert_allclose(moved.jacobian().J_eq, given.home.jacobian().J_eq, atol=1e-9)
        with pytest.raises(pj.ModelFileError, match="parameter 'a'"):
            pj.load(tmp_path / "wrong.toml")


@dataclass(frozen=True, slots=True)
class SquaredHeight(Height):
    unit: ClassVar = "m²"


def test_rows_that_nothing_measures_are_refused():
    class SquaredShelf(Shelf, frozen=True, tag_field="kind", tag="squared_shelf"):
        def rows(self, values: Mapping[str, float]) -> tuple[Rows, ...]:
            return (SquaredHeight(self.height),)

    model = pin.Model()
    model.addJoint(0, pin.JointModelPY(), pin.SE3.Identity(), "table")
    model.addFrame(pin.Frame("edge", 1, pin.SE3.Identity(), pin.FrameType.OP_FRAME))
    loop = SquaredShelf(frames=("universe", "edge"), height=1.0)
    wanted = pytest.raises(pj.ArgumentError, match="write them in m or rad")
    with known(SquaredShelf), wanted:
        pj.Mechanism.from_pinocchio(model, [loop], ["table"], "edge", home=np.zeros(1))


def test_every_kind_says_all_of_itself():
    for kind in LOOP_KINDS.values():
        if kind is loop_spec.JointLoop:
            continue
        loop = kind(frames=("a", "b"), **({"length": 1.0} if kind is pj.DistanceLoop else {}))
        assert loop.rows({})
        assert loop.form({}).steps
