"""What a sweep can say of each pose, by name."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pmjac_pin.batches.batch import Batch
from pmjac_pin.batches.results import ManyClosed, Status
from pmjac_pin.mechanism import Mechanism
from pmjac_pin.model.coordinates import entry_names

ROWS = ("vx", "vy", "vz", "wx", "wy", "wz")


@dataclass(frozen=True, slots=True)
class Variable:
    """A variable of the dataset.

    Attributes
    ----------
    dims : tuple of str
        Behind those of the points.
    nothing : number
        What stands where there is no value; it tells the type of the others.
    of : callable
        What computes it for many poses, shape (points, ...).
    """

    dims: tuple[str, ...]
    nothing: np.float64 | np.int8
    of: Callable[[Batch, ManyClosed], NDArray[Any]]

    def empty(self, points: Sequence[int], labels: Mapping[str, Sequence[str]]) -> NDArray[Any]:
        """Return an array without values.

        Parameters
        ----------
        points : sequence of int
            Its shape along the axes of the points.
        labels : mapping
            Those of the other axes.
        """
        shape = (*points, *(len(labels[dim]) for dim in self.dims))
        return np.full(shape, self.nothing, dtype=self.nothing.dtype)


def labels_of(mechanism: Mechanism) -> dict[str, Sequence[str]]:
    """Return the labels of the axes that are not those of the points."""
    return {
        "row": ROWS,
        "motor": mechanism.actuated,
        "entry": entry_names(mechanism.model),
    }


def _status(many: Batch, poses: ManyClosed) -> NDArray[np.int8]:
    """Return what became of each pose: of its loops and, where these are closed, of J_eq."""
    found: NDArray[np.int8] = poses.status.copy()
    closed = np.flatnonzero(found == Status.CLOSED)
    found[closed] = many.jacobian(poses.q[closed]).status
    return found


def _jacobian(many: Batch, poses: ManyClosed) -> NDArray[np.float64]:
    """Return J_eq, NaN where the target was not reached."""
    found = np.full((len(poses.q), 6, len(many.mechanism.actuated)), np.nan)
    closed = np.flatnonzero(poses.status == Status.CLOSED)
    found[closed] = many.jacobian(poses.q[closed]).J_eq
    return found


_NAN = np.float64(np.nan)
VARIABLES: Mapping[str, Variable] = MappingProxyType(
    {
        "status": Variable((), np.int8(Status.NOT_ASSEMBLED), _status),
        "share": Variable((), _NAN, lambda _, poses: poses.share),
        "q": Variable(("entry",), _NAN, lambda _, poses: poses.q),
        "J_eq": Variable(("row", "motor"), _NAN, _jacobian),
    }
)
