"""J_eq that is known before the matrices that it is made of."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

from pmjac_pin.model.twist_frame import FrameName
from pmjac_pin.rates.error_estimate import JacobianPose
from pmjac_pin.rates.jacobian import EquivalentJacobian
from pmjac_pin.rates.partition import Partition
from pmjac_pin.values.arrays import Array
from pmjac_pin.values.found_once import found_once

_MATRIX_FIELDS = frozenset({"constraint_jacobian", "tool_jacobian", "passive_rates"})


@dataclass(frozen=True, eq=False, repr=False)
class KnownJacobian(EquivalentJacobian):
    """An `EquivalentJacobian` whose other matrices are found when they are asked for."""

    @classmethod
    def of(
        cls,
        J_eq: Array,
        frame: FrameName,
        partition: Partition,
        pose: JacobianPose,
        find: Callable[[], EquivalentJacobian],
    ) -> KnownJacobian:
        """Return it with J_eq, read-only, and what returns all matrices."""
        jacobian = object.__new__(cls)
        jacobian.__dict__.update(J_eq=J_eq, frame=frame, partition=partition, pose=pose, _find=find)
        return jacobian

    @found_once
    def _found(self) -> EquivalentJacobian:
        found: EquivalentJacobian = self.__dict__["_find"]()
        return found

    @found_once
    def sizes(self) -> Array:
        """`TwistMap.sizes`, by the program that gave J_eq where it told them."""
        told = None if self.pose is None else self.pose.sizes()
        return self._found.sizes if told is None else told

    def __getattr__(self, name: str) -> Any:
        if name not in _MATRIX_FIELDS:
            message = f"{type(self).__name__!r} object has no attribute {name!r}"
            raise AttributeError(message, name=name, obj=self)
        found = self.__dict__[name] = getattr(self._found, name)
        return found

    def __reduce__(self) -> tuple[Any, ...]:
        return (_as_it_is, (replace(self._found, J_eq=self.J_eq),))


def _as_it_is(jacobian: EquivalentJacobian) -> EquivalentJacobian:
    return jacobian
