"""Which joints stay in the tree and which are cut."""

from __future__ import annotations

import numpy as np
import pytest

from pmjac_pin.files.spanning_tree import spanning_tree


def test_a_tree_is_left_as_it_is() -> None:
    tree = spanning_tree("abcd", [("b", "d"), ("a", "b"), ("a", "c")])
    assert (tree.root, tree.cut, tree.apart) == ("a", (), ())
    assert {(item.above, item.below) for item in tree.branches} == {
        ("a", "b"),
        ("a", "c"),
        ("b", "d"),
    }
    assert not any(item.turned for item in tree.branches)


@pytest.mark.parametrize("last", [[("c", "d"), ("b", "d")], [("b", "d"), ("c", "d")]])
def test_of_two_joints_with_one_child_the_first_keeps_it(last: list[tuple[str, str]]) -> None:
    tree = spanning_tree("abcd", [("a", "b"), ("a", "c"), *last])
    assert tree.cut == (3,)
    assert (tree.branches[-1].above, tree.branches[-1].below) == last[0]


def test_joints_named_first_are_cut_last() -> None:
    joints = [("a", "b"), ("a", "c"), ("c", "d"), ("b", "d")]
    assert spanning_tree("abcd", joints, first=[3]).cut == (2,)
    assert spanning_tree("abcd", joints, first=[2, 3]).cut == (3,)


def test_the_first_joint_does_not_keep_a_link_that_only_another_leads_to() -> None:
    """b would hang on c, which hangs on b."""
    tree = spanning_tree("abc", [("c", "b"), ("b", "c"), ("a", "b")])
    assert (tree.root, tree.cut) == ("a", (0,))
    assert not any(item.turned for item in tree.branches)


def test_a_joint_that_all_else_hangs_on_is_turned_round() -> None:
    """d is a parent only: its second joint is cut, and the first turned to carry it."""
    tree = spanning_tree("abcd", [("a", "b"), ("a", "c"), ("d", "b"), ("d", "c")], root="a")
    assert tree.cut == (3,)
    assert [(item.above, item.below, item.turned) for item in tree.branches] == [
        ("a", "b", False),
        ("a", "c", False),
        ("b", "d", True),
    ]


def test_a_cycle_of_joints_is_cut_at_its_last() -> None:
    tree = spanning_tree("abc", [("a", "b"), ("b", "c"), ("c", "a")])
    assert (tree.root, tree.cut) == ("a", (2,))


def test_joints_above_the_root_are_turned_round() -> None:
    tree = spanning_tree("abc", [("a", "b"), ("b", "c")], root="c")
    assert [(item.below, item.turned) for item in tree.branches] == [("b", True), ("a", True)]


def test_links_that_no_joint_joins_are_apart_with_their_loops() -> None:
    tree = spanning_tree("abcd", [("a", "b"), ("c", "d"), ("d", "c")])
    assert (tree.apart, tree.cut) == (("c", "d"), ())


@pytest.mark.parametrize("seed", range(30))
def test_every_graph_gives_a_tree_and_as_many_loops_as_it_has_cycles(seed: int) -> None:
    rng = np.random.default_rng(seed)
    links = [f"l{k}" for k in range(rng.integers(2, 12))]
    joints = []
    for _ in range(rng.integers(1, 20)):
        parent, child = rng.choice(len(links), 2, replace=False)
        joints.append((links[parent], links[child]))
    tree = spanning_tree(links, joints)
    reached = [tree.root]
    for branch in tree.branches:
        assert branch.above in reached
        assert branch.below not in reached
        ends = (branch.below, branch.above) if branch.turned else (branch.above, branch.below)
        assert joints[branch.joint] == ends
        reached.append(branch.below)
    assert sorted([*reached, *tree.apart]) == sorted(links)
    there = [k for k, (parent, _) in enumerate(joints) if parent in reached]
    assert len(tree.cut) == len(there) - len(reached) + 1
    assert sorted([*tree.cut, *(branch.joint for branch in tree.branches)]) == there
    assert all(set(joints[k]) <= set(reached) for k in tree.cut)


@pytest.mark.parametrize("seed", range(30))
def test_no_joint_is_turned_round_where_all_links_are_led_to(seed: int) -> None:
    rng = np.random.default_rng(seed)
    links = [f"l{k}" for k in range(rng.integers(2, 12))]
    tree = [(links[rng.integers(k)], links[k]) for k in range(1, len(links))]
    more = [tuple(rng.choice(links, 2, replace=False)) for _ in range(rng.integers(12))]
    joints = [(str(one), str(other)) for one, other in rng.permutation([*tree, *more])]
    found = spanning_tree(links, joints, root=links[0])
    assert not any(branch.turned for branch in found.branches)
    assert len(found.branches) == len(links) - 1
