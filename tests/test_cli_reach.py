"""`pmjac reach`: tables, JSON, exit status."""

from __future__ import annotations

import json

import numpy as np
import pinocchio as pin
import pytest

import pmjac_pin as pj
from pmjac_pin.cli import main


def test_it_prints_where_the_motors_are(capsys):
    assert main(["reach", "five_bar", "--target", "x=0.2,y=0.4"]) == 0
    shown = capsys.readouterr().out
    motors = pj.reach(pj.load("five_bar"), {"x": 0.2, "y": 0.4}).actuated
    assert "five_bar: reached" in shown
    assert (
        "  ".join(f"{value:.4f}" for value in motors).split() == shown.split("value")[1].split()[:2]
    )


def test_a_pose_is_six_numbers_and_json_has_all_digits(capsys):
    assert main(["reach", "head_6rss", "--target", "0.005,0,0.173,0,0.1,-0.2", "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    pose = pin.SE3(pin.rpy.rpyToMatrix(0.0, 0.1, -0.2), np.array([0.005, 0.0, 0.173]))
    found = pj.reach(pj.load("head_6rss"), pose)
    assert list(told["actuated"].values()) == found.actuated.tolist()
    np.testing.assert_allclose(told["pose"]["rotation"], pose.rotation, atol=1e-12)


@pytest.mark.parametrize(
    ("command", "status", "told"),
    [
        (["serial_2r", "--target", "-3,4,0"], 1, "serial_2r: out of reach"),
        (["five_bar", "--target", "0.2,0.4,0", "--modes"], 0, "five_bar: 4 working modes"),
        (["humanoid_ankle", "--target", "pitch=0.1,roll=0.05"], 0, "reached"),
        (["five_bar", "--target", "2,2,0", "--modes"], 0, "0 working modes"),
    ],
)
def test_the_exit_status_says_whether_it_got_there(command, status, told, capsys):
    assert main(["reach", *command]) == status
    assert told in capsys.readouterr().out


def test_a_mask_says_what_counts(capsys):
    pose = "0.3,0.2,0.4,0.1,0.2,0.3"
    assert main(["reach", "ur5", "--target", pose, "--mask", "1,1,1,0,0,0", "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    found = pj.reach(pj.load("ur5"), [0.3, 0.2, 0.4])
    assert list(told["actuated"].values()) == found.actuated.tolist()
    for mask in ("1,1,1", "1,1,1,0,0,2", "vx,vy"):
        assert main(["reach", "ur5", "--target", pose, "--mask", mask]) == 2
        assert "1 or 0 for each of vx,vy,vz,wx,wy,wz" in capsys.readouterr().err


@pytest.mark.parametrize("target", ["0.2,0.4", "0.2", "1,2,3,4", "1,2,3,4,5,6,7"])
def test_how_many_numbers_are_wanted_is_told(target, capsys):
    assert main(["reach", "five_bar", "--target", target]) == 2
    told = capsys.readouterr().err
    assert "--target takes x,y,z, or x,y,z,roll,pitch,yaw, or some by name, such as x=0.2" in told
    assert told.rstrip().endswith(f"numbers: {target}")


def test_what_is_no_target_is_told_in_one_line(capsys):
    for target in ("0.1,0.2", "tip", "u=3", "1,2,3,inf,0,0"):
        assert main(["reach", "five_bar", "--target", target]) == 2
        assert capsys.readouterr().err.startswith("pmjac: ")
