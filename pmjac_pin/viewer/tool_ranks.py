"""How many independent velocities the tool has here, and how many elsewhere.

`Singularity` looks at the judged rows of the tool's twist together. Where both linear and angular
rows are judged, [J_v]eq and [J_ω]eq may each lose rank where the twist does not: a stretched arm
of two links still turns, but its tip moves along one line only.
"""

from __future__ import annotations

import contextlib
import functools
import itertools
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from pmjac_pin.errors import PmjacError
from pmjac_pin.mechanism import Mechanism
from pmjac_pin.model.tool_rows import ToolRows
from pmjac_pin.rates.factorisation import factorise
from pmjac_pin.rates.jacobian import EquivalentJacobian
from pmjac_pin.values.arrays import Array

_POSES_NEAR_HOME = 4  # poses near home, besides the named ones
_DISTANCE = 0.1  # of the motors from home, where a rate of 1 is one of the mechanism's size
_NEARLY_ZERO = 0.01  # of the largest singular value anywhere
_BLOCK_NAMES = ("[J_v]eq", "[J_ω]eq")


@dataclass(frozen=True, slots=True)
class ToolRanks:
    """The ranks of [J_v]eq and [J_ω]eq in general: the largest over some poses.

    Attributes
    ----------
    generic : tuple of two int
    sizes : tuple of two float
        The largest singular value of each among these poses, motor rates without dimension.
    """

    generic: tuple[int, int]
    sizes: tuple[float, float]

    @classmethod
    def of(cls, mechanism: Mechanism) -> ToolRanks:
        """Find them at the named poses and near home.

        Examples
        --------
        >>> import pmjac_pin as pj
        >>> ToolRanks.of(pj.load("serial_2r")).generic
        (2, 1)
        """
        probes = list(_probes(mechanism))
        found = [tuple(map(_largest_value, _scaled_blocks(jacobian))) for jacobian in probes]
        sizes = [max((pair[half] for pair in found), default=0.0) for half in (0, 1)]
        linear = max((jacobian.tool_ranks.linear for jacobian in probes), default=0)
        angular = max((jacobian.tool_ranks.angular for jacobian in probes), default=0)
        return cls((linear, angular), (sizes[0], sizes[1]))

    def loss(self, jacobian: EquivalentJacobian) -> str:
        """Say in a sentence what the tool has lost, or almost; empty where it has not."""
        (_, *ranks), rows = jacobian.tool_ranks, jacobian.partition.tool_rows
        if lost := self._drops(rows, ranks, "has"):
            return f"Here the tool cannot move in every way that it can elsewhere: {lost}."
        of_both = zip(_scaled_blocks(jacobian), self.sizes, strict=True)
        large = [factorise(half, size, _NEARLY_ZERO).rank for half, size in of_both]
        if almost := self._drops(rows, large, "is near"):
            return f"Here the tool almost loses a way to move: {almost}."
        return ""

    def _drops(self, rows: ToolRows, ranks: Sequence[int], verb: str) -> str:
        judged = (rows.linear, rows.angular)
        of_both = zip(judged, _BLOCK_NAMES, ranks, self.generic, strict=True)
        return ", ".join(
            f"{name} {verb} rank {rank} instead of {generic}"
            for counts, name, rank, generic in of_both
            if counts and rank < generic
        )


def _scaled_blocks(jacobian: EquivalentJacobian) -> tuple[Array, Array]:
    """Return [J_v]eq and [J_ω]eq, of motor rates without dimension."""
    scale = jacobian.partition.motor_scale
    return jacobian.Jv_eq * scale, jacobian.Jw_eq * scale


def _largest_value(half: Array) -> float:
    return float(factorise(half, 1.0).singular_values.max(initial=0.0))


def _probes(mechanism: Mechanism) -> Iterator[EquivalentJacobian]:
    rng = np.random.default_rng(0)
    partition = mechanism.home.split_jacobian().partition
    stride = _DISTANCE * partition.length * partition.motor_scale
    home = mechanism.home.actuated
    displaced = [home + stride * rng.normal(size=home.size) for _ in range(_POSES_NEAR_HOME)]
    finders = itertools.chain(
        (functools.partial(mechanism.pose, name) for name in mechanism.poses),
        (functools.partial(mechanism.close, values) for values in displaced),
    )
    for find in finders:
        with contextlib.suppress(PmjacError):  # out of reach, beyond limits, or singular
            yield find().jacobian()
