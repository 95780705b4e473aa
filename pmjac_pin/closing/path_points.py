"""PathPoints: poses of many paths, and what their program knows there."""

from __future__ import annotations

from dataclasses import dataclass

from pmjac_pin.values.arrays import Array, Index, Mask


@dataclass(frozen=True, slots=True, eq=False)
class PathPoints:
    """Poses and what is known there, one column each.

    Attributes
    ----------
    numbers : ndarray, shape (nq + 5 + 2 nv, b)
        As `RecordedRates.arrival_tape` gives them.
    nq : int
    """

    numbers: Array
    nq: int

    def __getitem__(self, which: Index | Mask) -> PathPoints:
        return PathPoints(self.numbers[:, which], self.nq)

    def put(self, which: Index, others: PathPoints) -> None:
        """Take others' columns in place of some of these."""
        self.numbers[:, which] = others.numbers

    @property
    def q(self) -> Array:
        """Shape (nq, b)."""
        return self.numbers[: self.nq]

    @property
    def gap(self) -> Array:
        """How far the loops are open, m."""
        return self._known(0)

    @property
    def inverse(self) -> Array:
        """‖K*⁻¹‖, dimensionless."""
        return self._known(1)

    @property
    def size(self) -> Array:
        """‖[K K*]‖, dimensionless."""
        return self._known(2)

    @property
    def correction(self) -> Array:
        """The size of `newton`, a rad counted as one length."""
        return self._known(3)

    @property
    def pace(self) -> Array:
        """The size of `velocity`."""
        return self._known(4)

    @property
    def newton(self) -> Array:
        """What closes the loops, (nv, b)."""
        return self.numbers[self.nq + 5 :][: self._nv]

    @property
    def velocity(self) -> Array:
        """How all joints follow the motors, (nv, b)."""
        return self.numbers[self.nq + 5 + self._nv :]

    @property
    def _nv(self) -> int:
        return (len(self.numbers) - self.nq - 5) // 2

    def _known(self, place: int) -> Array:
        known: Array = self.numbers[self.nq + place]
        return known
