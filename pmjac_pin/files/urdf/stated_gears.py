"""The gears of a model file's URDF beside those that the model file states itself."""

from __future__ import annotations

import math
from collections.abc import Sequence

from pmjac_pin.errors import ModelFileError
from pmjac_pin.model.loop_spec import JointLoop, Loop

_SAME_RATIO = 1e-12  # relative: a ratio and its inverse, both as decimals


def with_gears(loops: Sequence[Loop], gears: Sequence[JointLoop]) -> tuple[Loop, ...]:
    """Return a model file's loops with those gears of its URDF that it does not state itself.

    Raises
    ------
    ModelFileError
        It gears the same two joints otherwise.

    Examples
    --------
    >>> stated = JointLoop(joints=("b", "a"), ratio=0.5, offset=-1.0)
    >>> with_gears([stated], [JointLoop(joints=("a", "b"), ratio=2.0, offset=2.0)]) == (stated,)
    True
    """
    stated = [loop for loop in loops if isinstance(loop, JointLoop)]
    return (*loops, *(gear for gear in gears if not _is_stated(gear, stated)))


def _is_stated(gear: JointLoop, stated: Sequence[JointLoop]) -> bool:
    """Whether a model file states a gear, from whichever side."""
    same_pair = [loop for loop in stated if set(loop.joints) == set(gear.joints)]
    for loop in same_pair:
        if not _same_equation(loop, gear):
            leader, follower = gear.joints
            raise ModelFileError(
                f"joint {follower!r} follows {leader!r} otherwise by its URDF "
                f"({_gear_words(gear)}) than by the [[loop]] of the model file "
                f"({_gear_words(loop)}); change one of them"
            )
    return bool(same_pair)


def _same_equation(loop: JointLoop, gear: JointLoop) -> bool:
    if loop.joints == gear.joints:
        pairs = ((loop.ratio, gear.ratio), (loop.offset, gear.offset))
    else:  # q_a = r·q_b + o and q_b = s·q_a + p
        pairs = ((loop.ratio * gear.ratio, 1.0), (loop.ratio * gear.offset, -loop.offset))
    return all(math.isclose(one, other, rel_tol=_SAME_RATIO) for one, other in pairs)


def _gear_words(gear: JointLoop) -> str:
    leader, follower = gear.joints
    return f"{follower} = {gear.ratio!r} {leader} + {gear.offset!r}"
