"""ForeignModel: what a file of another format says, in the words of our own model files."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from types import MappingProxyType

from pmjac_pin.errors import (
    ArgumentError,
    ModelFileError,
    NoMotorsError,
    enumerated,
    quoted,
    unknown_name,
)
from pmjac_pin.files.urdf.checks import VELOCITIES
from pmjac_pin.files.urdf.robot import Urdf
from pmjac_pin.files.user_path import readable
from pmjac_pin.model.loop_spec import MAXIMAL_LOOPS, JointLoop, Loop
from pmjac_pin.model.spec import JointValue, MechanismSpec
from pmjac_pin.model.tool_spec import NO_TOOL, Tool

_NO_VALUES: Mapping[str, JointValue] = MappingProxyType({})
_UNSTATED: Mapping[str, float] = MappingProxyType({})
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
    helical : mapping of str to float
        Joints that `urdf` writes as ``revolute`` and that slide as they turn, m/rad.
    armature : mapping of str to float
        As in `MechanismSpec`.
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
    unread : tuple of str
        One sentence for each kind of thing in the file that the reader does not know.
    """

    name: str
    urdf: Urdf
    loops: tuple[Loop, ...] = ()
    spherical: tuple[str, ...] = ()
    helical: Mapping[str, float] = field(default_factory=lambda: _UNSTATED)
    armature: Mapping[str, float] = field(default_factory=lambda: _UNSTATED)
    home: Mapping[str, JointValue] = field(default_factory=lambda: _NO_VALUES)
    actuated: tuple[str, ...] = ()
    tool: str = ""
    tolerance: float | None = None
    notes: tuple[str, ...] = ()
    unread: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        if (count := len(self.loops)) > MAXIMAL_LOOPS:
            path, most = self.urdf.path, f"at most {MAXIMAL_LOOPS} are read"
            raise ModelFileError(f"{path}: {count} loops are too many; {most}", path=path)

    def spec(self, actuated: Iterable[str] | None = None, tool: str | None = None) -> MechanismSpec:
        """Return the model file's contents, with motors and tool as given or as the file tells.

        Raises
        ------
        ModelFileError
            Neither says which joints are motors (`NoMotorsError`, which lists the candidates).
        UnknownNameError
            A joint or frame that the model does not have.
        """
        path = self.urdf.path
        motors = self.actuated if actuated is None else tuple(actuated)
        frame = self.tool if tool is None else tool
        if not motors:
            raise _no_motors(path, self._single_joints() or _movable(self.urdf))
        checked_motors(self.urdf, motors)
        if frame or tool is not None:
            check_frame(self.urdf, frame)
        return MechanismSpec(
            name=readable(self.name),
            actuated=motors,
            tool=Tool(frame=frame) if frame else NO_TOOL,
            loops=self.loops,
            spherical=self.spherical,
            helical=dict(self.helical),
            armature=dict(self.armature),
            tolerance=self.tolerance,
            poses={"home": dict(self.home)},
        )

    def with_open_chain(self) -> ForeignModel:
        """Return the model with all its joints as motors where no loop closes and no file tells.

        Those of one degree of freedom, but for those that follow another.
        """
        if self.actuated or any(not isinstance(loop, JointLoop) for loop in self.loops):
            return self
        followers = {loop.joints[1] for loop in self.loops if isinstance(loop, JointLoop)}
        motors = tuple(name for name in self._single_joints() if name not in followers)
        if not motors:
            return self
        followed = ", but those that follow another," if followers else ""
        note = f"no loop closes: every joint of one degree of freedom{followed} counts as a motor"
        return replace(self, actuated=motors, notes=(*self.notes, note))

    def _single_joints(self) -> tuple[str, ...]:
        return tuple(
            joint.name
            for joint in self.urdf.joints
            if VELOCITIES[joint.type] == 1 and joint.name not in self.spherical
        )


def checked_motors(urdf: Urdf, names: tuple[str, ...]) -> tuple[str, ...]:
    """Return the names, if all of them are joints that move."""
    moving = _movable(urdf)
    for name in names:
        if name not in moving:
            raise unknown_name("joint", name, moving)
    return names


def check_frame(urdf: Urdf, name: str) -> str:
    """Return the name, if it is a link's or a joint's."""
    if not isinstance(name, str):
        raise ArgumentError(f"`tool` is the name of one frame, got {quoted(name)}")
    frames = (*urdf.links, *(joint.name for joint in urdf.joints))
    if name not in frames:
        raise unknown_name("frame", name, frames)
    return name


def _movable(urdf: Urdf) -> tuple[str, ...]:
    return tuple(joint.name for joint in urdf.joints if joint.type != "fixed")


def links_from_the_ends(urdf: Urdf) -> tuple[str, ...]:
    """Return the links, those at the ends of chains first, of these the farthest from the root."""
    above = {joint.child: joint.parent for joint in urdf.joints}

    def depth(link: str) -> int:
        count = 0
        while (link := above.get(link, "")) and count <= len(above):
            count += 1
        return count

    held = set(above.values())
    return tuple(sorted(urdf.links, key=lambda link: (link in held, -depth(link))))


def _no_motors(path: str, candidates: tuple[str, ...]) -> ModelFileError:
    if not candidates:
        return ModelFileError(f"{path}: no joint of it moves: a mechanism has one at least")
    listed = enumerated(candidates, _MOST_CANDIDATES)
    return NoMotorsError(
        f"{path}: the file does not say which joints are motors; give `actuated`, of: {listed}",
        path=path,
        candidates=candidates,
    )
