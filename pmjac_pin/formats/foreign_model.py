"""ForeignModel: what a file of another format says, in the words of our own model files."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from types import MappingProxyType

from pmjac_pin.errors import ModelFileError, unknown_name
from pmjac_pin.loop_spec import Loop
from pmjac_pin.spec import JointValue, MechanismSpec, Tool
from pmjac_pin.urdf import Urdf

_NO_VALUES: Mapping[str, JointValue] = MappingProxyType({})
_MOST_CANDIDATES = 40


@dataclass(frozen=True)
class ForeignModel:
    """A cut tree and its loops, and what the file says of motors, tool and home pose.

    Attributes
    ----------
    name : str
    urdf : Urdf
        The cut tree; its `path` is the file that was read.
    loops : tuple of Loop
    spherical : tuple of str
        Joints that `urdf` writes as ``floating`` and that only turn.
    home : mapping of str to float or tuple of float
        Joint values near which the loops are closed; neutral for the others.
    actuated : tuple of str
        Motors, where the format tells; empty where it does not.
    tool : str
        The tool's frame, where the format tells; "" where it does not.
    tolerance : float or None
        As in `MechanismSpec`.
    notes : tuple of str
        One sentence for each decision that the reader took: which joint it cut, what it left out.
    """

    name: str
    urdf: Urdf
    loops: tuple[Loop, ...] = ()
    spherical: tuple[str, ...] = ()
    home: Mapping[str, JointValue] = field(default_factory=lambda: _NO_VALUES)
    actuated: tuple[str, ...] = ()
    tool: str = ""
    tolerance: float | None = None
    notes: tuple[str, ...] = ()

    def spec(self, actuated: Iterable[str] | None = None, tool: str | None = None) -> MechanismSpec:
        """Return the model file's contents, with motors and tool as given or as the file tells.

        Raises
        ------
        ModelFileError
            Neither says which joints are motors, or which frame is the tool; the message lists
            the candidates.
        UnknownNameError
            A joint or frame that the model does not have.
        """
        path = self.urdf.path
        moving = tuple(joint.name for joint in self.urdf.joints if joint.type != "fixed")
        motors = self.actuated if actuated is None else tuple(actuated)
        frame = tool or self.tool
        if not motors:
            raise _missing(path, "which joints are motors", "actuated", moving)
        if not frame:
            raise _missing(path, "which frame is the tool", "tool", self.urdf.links)
        for name in motors:
            if name not in moving:
                raise unknown_name("joint", name, moving)
        if frame not in self.urdf.links:
            raise unknown_name("frame", frame, self.urdf.links)
        return MechanismSpec(
            name=self.name,
            actuated=motors,
            tool=Tool(frame=frame),
            loops=self.loops,
            spherical=self.spherical,
            tolerance=self.tolerance,
            poses={"home": dict(self.home)},
        )


def _missing(path: str, what: str, option: str, candidates: tuple[str, ...]) -> ModelFileError:
    more = len(candidates) - _MOST_CANDIDATES
    listed = ", ".join(candidates[:_MOST_CANDIDATES]) + (f" and {more} more" if more > 0 else "")
    message = f"{path}: the file does not say {what}; give `{option}`, of: {listed or 'none'}"
    return ModelFileError(message, path=path)
