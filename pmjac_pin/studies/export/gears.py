"""Gears as formats have them in which a joint follows one other: which follows which.

A joint loop ties two values either way round. Where a joint may follow only one, and a motor
none, the ties of joints that hang together are turned so that all follow one of them.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence

from pmjac_pin.errors import ArgumentError, quoted
from pmjac_pin.model.loop_spec import JointLoop
from pmjac_pin.values.groups import sharing_groups


def followers(gears: Sequence[JointLoop], motors: Collection[str], to: str) -> list[JointLoop]:
    """Return the gears, turned so that no joint follows two, and no motor any.

    Raises
    ------
    ArgumentError
        They cannot be turned so.
    """
    found: list[JointLoop] = []
    for numbers in sharing_groups([set(gear.joints) for gear in gears]):
        group = [gears[k] for k in numbers]
        joints = list(dict.fromkeys(name for gear in group for name in gear.joints))
        driven = [name for name in joints if name in motors]
        chains = [chain for root in driven or joints if (chain := _led_by(root, group))]
        if len(driven) > 1 or not chains:
            tied = " and ".join(map(quoted, driven[:2] if len(driven) > 1 else joints[:2]))
            why = "two motors" if len(driven) > 1 else "joints that follow more than one"
            todo = "mjcf or toml would do"
            raise ArgumentError(f"{to} cannot say that {tied}, {why}, are geared; {todo}")
        found += min(chains, key=lambda chain: sum(gear not in group for gear in chain))
    return found


def _led_by(root: str, group: Sequence[JointLoop]) -> list[JointLoop]:
    """Return the gears as they lead away from a joint; none where they do not."""
    reached, left, chain = {root}, list(group), []
    while left:
        for gear in left:
            first, second = gear.joints
            if (first in reached) != (second in reached):
                break
        else:
            return []
        left.remove(gear)
        if second in reached:
            if gear.ratio == 0.0:
                return []
            gear = _reversed(gear)
        reached |= {first, second}
        chain.append(gear)
    return chain


def _reversed(gear: JointLoop) -> JointLoop:
    first, second = gear.joints
    return JointLoop(
        joints=(second, first), ratio=1.0 / gear.ratio, offset=-gear.offset / gear.ratio
    )
