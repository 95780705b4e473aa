"""Design: a mechanism at one choice of its parameters, with what the page needs of it only once."""

from __future__ import annotations

import logging
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from pmjac_pin.configuration import Configuration
from pmjac_pin.errors import ArgumentError, ClosureError, PmjacError
from pmjac_pin.mechanism import Mechanism
from pmjac_pin.model.parameter import Parameter
from pmjac_pin.studies.assembled_poses import assembled_poses
from pmjac_pin.viewer.load_sliders import load_sliders
from pmjac_pin.viewer.messages import Slider
from pmjac_pin.viewer.motors import motors_of
from pmjac_pin.viewer.scene import SceneMaker
from pmjac_pin.viewer.tool_ranks import ToolRanks

_FACTOR = 3.0  # how far a slider goes where a model file gives no range
_logger = logging.getLogger(__name__)


@dataclass(frozen=True, eq=False)
class Design:
    """What is the same at all poses of one mechanism.

    Attributes
    ----------
    mechanism : Mechanism
    poses : mapping of str to Configuration
        Those that close.
    maker : SceneMaker
    motors : tuple of Slider
    loads : tuple of Slider
        Of what acts on the tool.
    ranks : ToolRanks
    """

    mechanism: Mechanism
    poses: Mapping[str, Configuration]
    maker: SceneMaker
    motors: tuple[Slider, ...]
    loads: tuple[Slider, ...]
    ranks: ToolRanks

    @classmethod
    def of(cls, mechanism: Mechanism) -> Design:
        """Return the design of a mechanism."""
        poses = assembled_poses(mechanism)
        if left_out := [name for name in mechanism.poses if name not in poses]:
            _logger.warning("poses that do not close are left out: %s", ", ".join(left_out))
        ranks = ToolRanks.of(mechanism)
        sliders = motors_of(mechanism), load_sliders(mechanism)
        return cls(mechanism, poses, SceneMaker(mechanism), *sliders, ranks)

    @property
    def parameters(self) -> tuple[Slider, ...]:
        """The sliders of the parameters, in the order of the model file."""
        spec, length = self.mechanism.spec, self.mechanism.characteristic_length
        declared = spec.parameters if self.mechanism.blueprint is not None else {}
        return tuple(_slider(name, it, length) for name, it in declared.items())


def redesigned(
    shown: Configuration, values: Sequence[float | None]
) -> tuple[Design, Configuration]:
    """Return a design with other parameters, and its pose beside the one that is shown.

    The motors stay; the passive joints go where the loops close, from where they are.

    Parameters
    ----------
    shown : Configuration
    values : sequence of float or None
        One for each parameter, m or rad; None where it stays.

    Raises
    ------
    ArgumentError
        Another number of values, one beyond its parameter's range, or what does not assemble.
    """
    mechanism = shown.mechanism
    names = tuple(mechanism.parameters)
    if len(values) != len(names):
        raise ArgumentError(f"{len(names)} parameters expected, got {len(values)}")
    wanted = {name: value for name, value in zip(names, values, strict=True) if value is not None}
    try:
        other = mechanism.with_parameters(wanted)
        pose = other.close(shown.actuated, guess=shown)
    except ClosureError as error:
        said = ", ".join(
            f"{name} = {value:g} {mechanism.spec.parameters[name].unit}"
            for name, value in wanted.items()
        )
        raise ArgumentError(
            f"With {said} it does not assemble: its loops stay open by "
            f"{error.residual_norm:.3g} m. All stays as it was."
        ) from None
    return Design.of(other), pose


def is_sibling(one: Mechanism, other: Mechanism) -> bool:
    """Tell whether a mechanism is another one with other values of its parameters."""
    if one.name != other.name or set(one.parameters) != set(other.parameters):
        return False
    try:
        return one.with_parameters(other.parameters) == other
    except PmjacError:
        return False


def _slider(name: str, parameter: Parameter, length: float) -> Slider:
    default, lower, upper = parameter.default, parameter.minimum, parameter.maximum
    if parameter.unit == "rad":
        reach = (default - math.pi, default + math.pi)
    elif default > 0.0:
        reach = (default / _FACTOR, default * _FACTOR)
    else:
        reach = (default - _FACTOR * length, default + _FACTOR * length)
    if lower is not None and upper is not None:
        return Slider(name, parameter.unit, lower, upper, True, parameter.meaning)
    low = reach[0] if lower is None else max(lower, reach[0])
    high = reach[1] if upper is None else min(upper, reach[1])
    return Slider(name, parameter.unit, low, max(low, high), False, parameter.meaning)
