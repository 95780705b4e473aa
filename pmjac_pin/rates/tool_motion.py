"""What the tool does with the motions that loops allow: in how many independent ways it moves.

Velocities are compared with the tool Jacobian before elimination. A motion that generically moves
the tool much less than that (by a crank a thousandth as long as the machine, say) is measured by
what it does: else it would count as lost long before its dead centre, or everywhere.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from pmjac_pin.model.tool_rows import ToolRows
from pmjac_pin.rates.factorisation import Factorisation, factorise
from pmjac_pin.values.arrays import Array, Index, norm

_SLOW = 1e-2  # of the tool's size: motions that move it less are measured by what they do to it
_FAINT = 1e-9  # of the tool's size: less is rounding at every pose
_POSE_ERRORS = 10.0  # gap/σ²: what the tool's motion may be off by, at a pose that is off by gap/σ


class TwistRanks(NamedTuple):
    """Dimensions of the tool's twists, of its linear and of its angular velocities."""

    twist: int
    linear: int
    angular: int


@dataclass(frozen=True, slots=True, eq=False)
class ToolMotion:
    """The tool Jacobian at one pose, on scaled rates.

    A linear velocity is ω × r, so its rounding is that of arms as long as the mechanism, even where
    all of them end in the tool: its rows count beside the angular ones times `length`. Angular
    velocities are sums of axes and know no arms.

    Attributes
    ----------
    scaled : ndarray, shape (6, nv)
        Angular rows times `length`.
    length : float
        The mechanism's characteristic length, m.
    rows : ToolRows
        Those of the twist that are judged; the Jacobian is in their axes.
    rates : ndarray, shape (nv,)
        Scaled rates by which the tool generically moves as fast as by all else; empty where they
        are 1.
    tolerance : float
        Relative size up to which velocities count as zero.
    """

    scaled: Array
    length: float
    rows: ToolRows
    rates: Array
    tolerance: float

    @property
    def size(self) -> float:
        """What linear velocities and twists are compared with, m/s per scaled rate."""
        return norm(self.scaled)

    @property
    def angular_size(self) -> float:
        """What angular velocities are compared with, rad/s per scaled rate."""
        return norm(self.scaled[3:]) / self.length

    @property
    def units(self) -> Array:
        """What makes wrenches of such that have moments over `length`, shape (6, 1)."""
        return np.repeat([1.0, self.length], 3)[:, None]

    @property
    def _judged_size(self) -> float:
        return self.size if self.rows.linear else norm(self.scaled[3:])

    def ranks(self, motions: Array) -> TwistRanks:
        """Return how many independent velocities these motions give the tool.

        Parameters
        ----------
        motions : ndarray, shape (nv, k)
            Orthonormal columns, on the scaled rates, that span what the loops allow.
        """
        moved = self._moved(motions)
        return TwistRanks(
            factorise(moved, self.size, self.tolerance).rank,
            factorise(moved[:3], self.size, self.tolerance).rank,
            factorise(moved[3:], norm(self.scaled[3:]), self.tolerance).rank,
        )

    def twist_rank(self, motions: Array) -> int:
        """Return how many independent twists they give the tool, on all six rows."""
        return factorise(self._moved(motions), self.size, self.tolerance).rank

    def judged_rank(self, motions: Array) -> int:
        """Return how many independent velocities they give the rows that are judged."""
        return factorise(self.judged(motions), self._judged_size, self.tolerance).rank

    def judged(self, motions: Array) -> Array:
        """Return the velocities that they give the judged rows, or such of them as move it alike.

        Angular ones times `length`.
        """
        return self._moved(motions)[self.rows.linear + self.rows.angular]

    def resting(self, motions: Array) -> Array:
        """Return those of the motions, (nv, k), by which the judged rows rest."""
        found = factorise(self.judged(motions), self._judged_size, self.tolerance)
        return self._alike(motions) @ found.null_space

    def felt_rank(self, free: Array, passive: Index) -> int:
        """Return how many independent velocities passive motions (m_p, k) give the judged rows."""
        motions = np.zeros((self.scaled.shape[1], free.shape[1]))
        motions[passive] = free
        return self.judged_rank(motions)

    def twists(self, free: Array, passive: Index) -> Array:
        """Return independent twists (6, k), m/s and rad/s, that passive motions (m_p, k) span."""
        if not free.shape[1]:
            return np.zeros((6, 0))
        found = factorise(self.scaled[:, passive] @ free, self.size, self.tolerance)
        return found.left[:, : found.rank] / self.units

    def borne(self, motions: Array) -> Array:
        """Return independent wrenches (6, k), N and N m, on the judged rows.

        They span those that do no work on the tool by these motions.
        """
        found = factorise(self.judged(motions), self._judged_size, self.tolerance)
        wrenches = np.zeros((6, len(found.matrix) - found.rank))
        wrenches[self.rows.linear + self.rows.angular] = found.left_null_space
        return wrenches * self.units

    def _moved(self, motions: Array) -> Array:
        """Return the tool's twists by these motions, or by such of them as move it alike."""
        moved: Array = self.scaled @ self._alike(motions)
        return moved

    def _alike(self, motions: Array) -> Array:
        if not self.rates.size:
            return motions
        alike: Array = self.rates[:, None] * np.linalg.qr(motions / self.rates[:, None])[0]
        return alike

    def commanded(self, whole: Factorisation, gap: float, motors: Index) -> CommandedMotion:
        """Return what motors do to the judged rows, told from rounding.

        Parameters
        ----------
        whole : Factorisation
            Of [K K*], dimensionless.
        gap : float
            Up to which the loops count as closed, as a share of `length`.
        motors : ndarray of int, shape (n,)
            Their columns.
        """
        motions = _commanded(whole, motors)
        twists = self.scaled[self.rows.linear + self.rows.angular] @ motions
        values = whole.singular_values[: whole.rank] / (whole.size or 1.0)
        rounding = max(_FAINT, _POSE_ERRORS * gap / float(values.min(initial=1.0)) ** 2)
        told_apart = factorise(twists, self._judged_size, min(self.tolerance, rounding))
        return CommandedMotion(self, whole, motions, told_apart)


@dataclass(frozen=True, slots=True, eq=False)
class CommandedMotion:
    """What motors do to the judged rows of a tool's twist at one pose.

    Attributes
    ----------
    tool : ToolMotion
    whole : Factorisation
        Of [K K*], dimensionless.
    motions : ndarray, shape (nv, k)
        Orthonormal columns, on the scaled rates: less those at which the motors rest.
    twists : Factorisation
        Of what these do to the judged rows, down to what is rounding.
    """

    tool: ToolMotion
    whole: Factorisation
    motions: Array
    twists: Factorisation

    def seen_rank(self) -> int:
        """Return in how many independent ways the judged rows move, slow ones counted.

        What motors command is told from rounding by far less than `tolerance`: by what the pose
        may be off. What idles is felt by more than `tolerance`, or counts as not felt.
        """
        allowed, rank = self.whole.null_space, self.twists.rank
        if rank == min(len(self.twists.matrix), allowed.shape[1]):  # there are no more
            return rank
        return max(rank, self.tool.judged_rank(allowed))

    def twist_rank(self) -> int:
        """Return in how many independent ways the tool moves, on all six rows."""
        return self.tool.twist_rank(self.whole.null_space)

    def generic_rates(self) -> Array:
        """Return `rates` by a regular pose: max |v| / σ over its motions v, of twists σ.

        Only those σ count that are small beside the tool's size, and no rounding.
        """
        twists = self.twists
        shares = twists.singular_values[: twists.rank] / (twists.size or 1.0)
        if not shares.size or shares[-1] >= _SLOW:
            return np.zeros(0)
        shares = np.where(shares < _SLOW, shares, 1.0)
        fastest = np.abs(self.motions @ twists.right[: twists.rank].T) / shares
        rates: Array = np.maximum(fastest.max(axis=1), 1.0)
        return rates


def _commanded(whole: Factorisation, motors: Index) -> Array:
    """Return the motions (nv, k) that [K K*] allows, less those at which the motors rest."""
    allowed = whole.null_space
    by_motors = factorise(allowed[motors], 1.0, _FAINT)
    commanded: Array = allowed @ by_motors.right[: by_motors.rank].T
    return commanded
