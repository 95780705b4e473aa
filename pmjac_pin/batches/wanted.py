"""Wanted: which results of so many poses, of which shapes."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Generic, NamedTuple, TypeVar

from pmjac_pin.batches.filled_again import Refillable
from pmjac_pin.batches.result_shapes import ResultShapes, shapes_of
from pmjac_pin.batches.results import ManyClosed
from pmjac_pin.mechanism import Mechanism

Results = TypeVar("Results", bound=Refillable)


class Wanted(NamedTuple, Generic[Results]):
    """Results of many poses that are wanted.

    Attributes
    ----------
    kind : type
        A dataclass of arrays, one of which is called `status`.
    shapes : ResultShapes
        Of its arrays, by their names.
    more : mapping of str to object
        What the results know besides their arrays.
    """

    kind: type[Results]
    shapes: ResultShapes
    more: Mapping[str, Any]

    @classmethod
    def of(cls, mechanism: Mechanism, kind: type[Results], count: int) -> Wanted[Results]:
        """Return what says that results of this kind are wanted of so many poses."""
        motors, nq = len(mechanism.actuated), mechanism.nq
        shapes = shapes_of(kind, count, motors, nq)  # type: ignore[arg-type]
        more = {"_coordinates": mechanism.coordinates} if kind is ManyClosed else {}
        return cls(kind, shapes, more)
