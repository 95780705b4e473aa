"""Placements as functions of parameters: at any values those of the machine that has them."""

from __future__ import annotations

import numpy as np
import pytest
from mechanisms import PARAMETRISED, loaded, mostly_slow

import pmjac_pin as pj
from pmjac_pin.algebra.tape import Tape
from pmjac_pin.algebra.tape_runner import run
from pmjac_pin.algebra.terms import Recording

CHAIN = """<robot name="chain"><link name="base"/>
<joint name="lead" type="revolute"><parent link="base"/><child link="arm"/>
  <origin xyz="0.1 0 0.2" rpy="0.3 0 0"/><axis xyz="0 1 0"/>
  <limit lower="-9" upper="9" effort="1" velocity="1"/></joint>
<link name="arm"/>
<joint name="bend" type="fixed"><parent link="arm"/><child link="bent"/>
  <origin xyz="0.5 0 0" rpy="0.2 -0.4 0.7"/></joint>
<link name="bent"/>
<joint name="kept" type="revolute"><parent link="bent"/><child link="held"/>
  <origin xyz="0 0.2 0" rpy="0 0.1 0"/><axis xyz="1 2 2"/>
  <limit lower="-9" upper="9" effort="1" velocity="1"/></joint>
<link name="held"/>
<joint name="screw" type="continuous"><parent link="held"/><child link="nut"/>
  <origin xyz="0.3 0 0.1"/><axis xyz="1 1 0"/></joint>
<link name="nut"/>
<joint name="slide" type="prismatic"><parent link="nut"/><child link="sledge"/>
  <origin xyz="0 0 0.3" rpy="0 0 1.5707963267948966"/><axis xyz="0 1 0"/>
  <limit lower="-9" upper="9" effort="1" velocity="1"/></joint>
<link name="sledge"/>
<joint name="ball" type="floating"><parent link="sledge"/><child link="head"/>
  <origin xyz="0.1 0.2 0.3" rpy="0 0.5 0"/></joint>
<link name="head"/>
<joint name="tip_end" type="fixed"><parent link="head"/><child link="tip"/>
  <origin xyz="0 0 0.4" rpy="0.1 0 0"/></joint>
<link name="tip"/></robot>"""
MODEL = """urdf = "chain.urdf"
actuated = ["lead", "screw", "slide", "ball"]
helical = { screw = 0.05 }
tool.frame = "tip"
locked = { kept = 0.8 }
SPHERICAL
[parameters.long]
default = 0.5
unit = "m"
meaning = "of the arm, and where the screw is"
moves = [
  {joint = "bend", xyz = [1.0, 0.2, 0.0]},
  {joint = "screw", xyz = [0.0, 0.5, 0.0]},
  {joint = "tip_end", xyz = [0.0, 0.0, 0.3]},
]
[parameters.tilt]
default = 0.1
unit = "rad"
meaning = "how origins are turned"
moves = [
  {joint = "kept", rpy = [0.0, 1.0, 0.5]},
  {joint = "lead", rpy = [0.0, 0.0, 1.0]},
  {joint = "ball", rpy = [1.0, 0.0, 0.0], xyz = [0.2, 0.0, 0.0]},
]
[poses.home]
"""


def assert_placed_alike(mechanism, values):
    """What is recorded, at these values, is where the machine with these has its joints."""
    machine, names = mechanism.with_parameters(values), tuple(mechanism.parameters)
    dimensions = mechanism.recorded.dimensions(mechanism.blueprint)
    recording = Recording(len(names))
    found = dimensions.at(dict(zip(names, recording.inputs, strict=True)))
    model = machine.kinematics.model
    pairs = [(place, model.jointPlacements[k]) for k, place in found.joints.items()]
    pairs += [(place, model.frames[k].placement) for k, place in found.frames.items()]
    terms = [x for place, _ in pairs for x in [*place.rotation.ravel(), *place.translation]]
    told = run(Tape.of(recording, terms), np.array([[values[name]] for name in names]))
    expected = [np.append(known.rotation.ravel(), known.translation) for _, known in pairs]
    np.testing.assert_allclose(told[:, 0], np.concatenate(expected), atol=1e-13)
    assert len(found.joints) == model.njoints - 1


@pytest.mark.parametrize("name", mostly_slow(PARAMETRISED))
def test_of_every_mechanism(name, rng):
    mechanism = loaded(name)
    own = np.array(list(mechanism.parameters.values()))
    # A loop of four hinges in space closes with special lengths alone.
    count = 1 if name == "bennett" else own.size
    changed = own + 0.01 * np.where(own, own, 0.1) * rng.uniform(-1.0, 1.0, count)
    values = dict(zip(mechanism.parameters, changed.tolist(), strict=True))
    assert_placed_alike(mechanism, values)


@pytest.mark.parametrize("ball", ["", 'spherical = ["ball"]'])
def test_trees_that_are_hung_up_anew(ball, tmp_path):
    """A screw, a ball and a locked joint: what the URDF has is built otherwise."""
    (tmp_path / "chain.urdf").write_text(CHAIN)
    path = tmp_path / "chain.toml"
    path.write_text(MODEL.replace("SPHERICAL", ball))
    mechanism = pj.load(path)
    assert_placed_alike(mechanism, {"long": 0.9, "tilt": -0.7})
    other = mechanism.with_parameters(tilt=0.4)
    assert_placed_alike(other, {"long": 0.3, "tilt": 1.9})
