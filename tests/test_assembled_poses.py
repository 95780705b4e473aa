"""The named poses that close, whatever the parameters."""

from __future__ import annotations

import pytest

import pmjac_pin as pj
from pmjac_pin.studies.assembled_poses import assembled_poses
from pmjac_pin.viewer.scene_options import SceneOptions
from pmjac_pin.viewer.session import Session


@pytest.fixture
def mechanism():
    """A six-bar whose pose 'below' is out of reach."""
    mechanism = pj.load("watt_six_bar", {"CD": 5.0})
    with pytest.raises(pj.ClosureError):
        mechanism.pose("below")
    return mechanism


@pytest.mark.slow
def test_poses_that_do_not_close_are_left_out(mechanism):
    poses = assembled_poses(mechanism)
    assert list(poses) == ["home", "turned", "folded"]
    assert all(pose is mechanism.pose(name) for name, pose in poses.items())


def test_the_viewer_says_what_it_leaves_out(mechanism, caplog):
    Session(mechanism.home, SceneOptions())
    assert caplog.messages == ["poses that do not close are left out: below"]
