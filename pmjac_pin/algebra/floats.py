"""Floats: NumPy's doubles, real or complex, over any number of poses at once."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from pmjac_pin.algebra.arrays import Arrays, Numbers
from pmjac_pin.values.arrays import Array


class Floats(Arrays):
    """Doubles.

    Parameters
    ----------
    rooted : bool
        Measure tilts and turns by their chords and angles, as Pinocchio does; only for real ones.

    Examples
    --------
    >>> floats = Floats()
    >>> x, y = floats.constant([1.0, 0.0, 0.0]), floats.constant([0.0, 1.0, 0.0])
    >>> floats.cross(x, y).ravel().tolist()
    [0.0, 0.0, 1.0]
    """

    __slots__ = ("rooted",)

    def __init__(self, rooted: bool = True) -> None:
        self.rooted = rooted

    def replaced(self, x: Numbers, by: ArrayLike, of: Numbers, least: float) -> Numbers:
        """Return x, constant where another number is below a double."""
        return np.where(of < least, self.constant(by), x)

    def rotation_vector(self, rotation: Numbers) -> Numbers:
        """Return log R."""
        # Imported by the first that needs it: a third of a second, in which many poses are done.
        from scipy.spatial.transform import Rotation  # noqa: PLC0415

        matrices = np.moveaxis(rotation, (0, 1), (-2, -1)).reshape(-1, 3, 3)
        vectors: Array = Rotation.from_matrix(matrices).as_rotvec()
        return vectors.T.reshape(3, *rotation.shape[2:])

    def cos(self, x: Numbers) -> Numbers:
        """Return cos x."""
        return np.asarray(np.cos(x))

    def sin(self, x: Numbers) -> Numbers:
        """Return sin x."""
        return np.asarray(np.sin(x))

    def vanishes(self, x: Numbers) -> bool:
        """Tell whether x is zero whatever the numbers are: of doubles, no more is known."""
        return not x.size

    def sqrt(self, x: Numbers) -> Numbers:
        """Return √x."""
        return np.asarray(np.sqrt(x))

    def atan2(self, sine: Numbers, cosine: Numbers) -> Numbers:
        """Return the angle of a sine and a cosine."""
        return np.asarray(np.arctan2(sine, cosine))

    def largest(self, x: Numbers, y: ArrayLike) -> Numbers:
        """Return the larger of each two."""
        return np.asarray(np.maximum(x, y))

    def with_sign(self, x: Numbers, of: Numbers) -> Numbers:
        """Return |x| with the sign of another number."""
        return np.asarray(np.copysign(x, of))

    def unit(self, x: Numbers) -> Numbers:
        """Return x by its length, over the first components."""
        return np.asarray(x / np.sqrt(self.squared(x)))
