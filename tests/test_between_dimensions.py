"""Machines between two of other dimensions are those that a file would give there."""

from __future__ import annotations

import mechanisms
import numpy as np
import pinocchio as pin
import pytest
from mechanisms import loaded

import pmjac_pin as pj
from pmjac_pin.closing.home_on_the_way import part_of_the_way
from pmjac_pin.kinematics.between_dimensions import BetweenDimensions

WITH_PARAMETERS = [name for name in mechanisms.CATALOGUE if loaded(name).spec.parameters]
TIED = {"bennett"}  # its lengths


def between(stops):
    """What is between these mechanisms."""
    first, last = stops[0], stops[-1]

    def rows(share):
        values = part_of_the_way(first.parameters, last.parameters, share)
        loops = last.spec.loops
        return [loop.rows(values) for loop in loops if not isinstance(loop, pj.JointLoop)]

    return BetweenDimensions([stop.kinematics for stop in stops], rows)


def assert_same_loops(kinematics, mechanism, rng):
    """At any pose, closed or not."""
    for _ in range(3):
        q = pin.integrate(mechanism.model, mechanism.home.q, rng.normal(size=mechanism.model.nv))
        for one, other in zip(
            kinematics.loop_equations(q), mechanism.kinematics.loop_equations(q), strict=True
        ):
            np.testing.assert_allclose(one, other, atol=1e-12)


@pytest.mark.parametrize("name", WITH_PARAMETERS)
def test_loops_on_the_way(name, rng):
    first = loaded(name)
    parameters = first.parameters
    factors = 1.0 + rng.uniform(-0.02, 0.02, 1 if name in TIED else len(parameters))
    sizes = np.array([*parameters.values()]) * factors
    last = first.with_parameters(dict(zip(parameters, sizes.tolist(), strict=True)))
    way = between([first, last])
    for share in (0.0, 0.3, 1.0):
        there = pj.load(name, part_of_the_way(parameters, last.parameters, share))
        assert_same_loops(way.at(share), there, rng)


TURNED = """
name = "turned"
urdf = "turned.urdf"
actuated = ["theta"]
tool.frame = "hand"
loop = [{kind = "frame", frames = ["hand", "other_hand"]}]
[parameters.turn]
default = 0.0
unit = "rad"
meaning = "how the second arm's origin is turned"
moves = [{joint = "phi", rpy = [0.0, 0.0, 1.0]}]
[parameters.arm]
default = 1.0
unit = "m"
meaning = "both arms"
moves = [{joint = "end", xyz = [1.0, 0.0, 0.0]}, {joint = "other_end", xyz = [1.0, 0.0, 0.0]}]
[poses.home]
theta = 0.5
phi = 0.5
"""
ARM = """
<joint name="{joint}" type="revolute"><parent link="base"/><child link="{joint}_arm"/>
  <axis xyz="0 0 1"/><limit lower="-9" upper="9" effort="1" velocity="1"/></joint>
<link name="{joint}_arm"/><link name="{hand}"/>
<joint name="{end}" type="fixed"><parent link="{joint}_arm"/><child link="{hand}"/>
  <origin xyz="1 0 0"/></joint>"""


@pytest.fixture
def turned(tmp_path):
    """Two arms about one axis, welded together; the second one's origin may be turned."""
    arms = ARM.format(joint="theta", hand="hand", end="end")
    arms += ARM.format(joint="phi", hand="other_hand", end="other_end")
    (tmp_path / "turned.urdf").write_text(f'<robot name="turned"><link name="base"/>{arms}</robot>')
    (tmp_path / "turned.toml").write_text(TURNED)
    return tmp_path / "turned.toml"


@pytest.mark.parametrize("turn", [0.3, 2.0, 4.0, -8.0])
def test_what_turns_far_goes_all_the_way(turned, turn):
    """Where the shortest way is another: φ = θ − turn, and no full turn beside it."""
    values = {"turn": turn, "arm": 1.2}
    for mechanism in (pj.load(turned, values), pj.load(turned).with_parameters(values)):
        np.testing.assert_allclose(mechanism.home.passive, [0.5 - turn], atol=1e-12)


@pytest.mark.parametrize("turn", [0.3, 0.9])
def test_turns_on_the_way(turned, turn, rng):
    first = pj.load(turned)
    last = first.with_parameters(turn=turn, arm=0.7)
    way = between([first, last])
    for share in (0.25, 0.5):
        there = pj.load(turned, part_of_the_way(first.parameters, last.parameters, share))
        assert_same_loops(way.at(share), there, rng)


def test_balls_on_the_way(turned, rng):
    """Of a tree that was hung up anew."""
    urdf = turned.with_suffix(".urdf")
    ball = '<joint name="ball" type="floating"><parent link="hand"/><child link="tip"/></joint>'
    urdf.write_text(urdf.read_text().replace("</robot>", f'{ball}<link name="tip"/></robot>'))
    turned.write_text(turned.read_text().replace("loop =", 'spherical = ["ball"]\nloop ='))
    first = pj.load(turned)
    last = first.with_parameters(turn=0.4, arm=0.7)
    way = between([first, last])
    there = pj.load(turned, part_of_the_way(first.parameters, last.parameters, 0.25))
    assert_same_loops(way.at(0.25), there, rng)


def test_stops_on_the_way(turned, rng):
    stops = [pj.load(turned, {"turn": turn}) for turn in (0.0, 2.0, 4.0)]
    way = between(stops)
    for share in (0.1, 0.5, 0.8, 1.0):
        assert_same_loops(way.at(share), pj.load(turned, {"turn": 4.0 * share}), rng)
