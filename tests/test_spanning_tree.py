"""Cutting a graph: what stays is a tree that reaches everything, whatever the order."""

from __future__ import annotations

import numpy as np
import pytest

from pmjac_pin.formats.spanning_tree import cut_joints
from pmjac_pin.urdf_checks import UrdfJoint


def joints(*ends):
    return [UrdfJoint(f"{pair}{k}", "revolute", *pair) for k, pair in enumerate(ends)]


def cuts(links, *ends, motors=()):
    return [joint.name for joint in cut_joints(links, joints(*ends), motors)]


@pytest.mark.parametrize(
    ("links", "ends", "expected"),
    [
        ("ABC", ("AB", "BC"), []),
        ("ABC", ("AB", "BC", "AC"), ["AC2"]),
        ("ABC", ("AC", "AB", "BC"), ["BC2"]),
        ("ABC", ("AB", "BC", "CA"), ["CA2"]),  # a cycle: the file's first link is the base
        ("CBA", ("AB", "BC", "CA"), ["BC1"]),
        ("AB", ("AB", "AB"), ["AB1"]),
        # B's first joint comes from C, which only B leads to: A could reach neither.
        ("ABC", ("CB", "AB", "BC"), ["CB0"]),
        ("ABCD", ("AB", "AC", "BD", "CD"), ["CD3"]),
    ],
)
def test_the_first_joint_to_a_link_stays(links, ends, expected):
    assert cuts(links, *ends) == expected


def test_motors_are_cut_last():
    assert cuts("ABC", "AB", "BC", "AC", motors={"AC2"}) == ["BC1"]


def reached(base, kept):
    links = {base}
    while more := {joint.child for joint in kept if joint.parent in links} - links:
        links |= more
    return links


@pytest.mark.parametrize("seed", range(200))
def test_what_stays_is_one_tree(seed):
    rng = np.random.default_rng(seed)
    count = int(rng.integers(2, 9))
    links = [f"L{k}" for k in range(count)]
    tree = [(int(rng.integers(0, k)), k) for k in range(1, count)]
    more = [tuple(rng.choice(count, 2, replace=False)) for _ in range(int(rng.integers(0, 12)))]
    if not seed % 2:
        more = [pair for pair in more if pair[1] != 0]
    ends = [*tree, *more]
    rng.shuffle(ends)
    graph = [
        UrdfJoint(f"j{k}", "revolute", links[first], links[second])
        for k, (first, second) in enumerate(ends)
    ]
    motors = {joint.name for joint in graph if rng.random() < 0.2}
    gone = cut_joints(links, graph, motors)
    kept = [joint for joint in graph if joint not in gone]
    assert len({joint.child for joint in kept}) == len(kept) == count - 1
    assert reached(links[0], kept) == set(links)
    assert gone == cut_joints(links, graph, motors)
