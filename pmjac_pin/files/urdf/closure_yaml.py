"""The YAML file of an extended URDF: what it says, checked; it knows nothing of the URDF."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import msgspec
import yaml

from pmjac_pin.errors import ModelFileError, did_you_mean, quoted, shortened
from pmjac_pin.files.text_file import at_file, read_text

MAXIMAL_YAML = 64_000  # bytes, read in a second; the largest published one has two thousand
_TYPES: Mapping[str, str] = {"3d": "point", "6d": "frame"}
_YAML_TRUTHS: Mapping[str, bool] = {"true": True, "false": False, "": False}


class ClosureFile(msgspec.Struct, frozen=True):
    """What the file says.

    Attributes
    ----------
    closed_loop : tuple of (str, str)
        Pairs of frames that coincide, each a joint's or a link's name.
    type : tuple of str
        "3d" or "6d" for each of them; 6d without this key.
    name_mot : tuple of str
        Parts of the motors' names.
    joint_name, joint_type : tuple of str
        Joints of the URDF, and what they are instead: SPHERICAL, FIXED, UJOINT_XY, ...
    free_flyer : str
        "true" where the base floats.
    """

    closed_loop: tuple[tuple[str, str], ...] = ()
    type: tuple[str, ...] | None = None
    name_mot: tuple[str, ...] = ()
    joint_name: tuple[str, ...] = ()
    joint_type: tuple[str, ...] = ()
    free_flyer: str = ""

    def kinds(self) -> tuple[str, ...]:
        """Return "point" or "frame" for each loop."""
        given = ("6d",) * len(self.closed_loop) if self.type is None else self.type
        if len(given) != len(self.closed_loop):
            got = f"`closed_loop` has {len(self.closed_loop)} entries and `type` {len(given)}"
            raise ModelFileError(f"{got}; give one type for each loop")
        for kind in given:
            if kind.lower() not in _TYPES:
                raise ModelFileError(f"`type` is {kind[:60]!r}; 3D and 6D are read")
        return tuple(_TYPES[kind.lower()] for kind in given)

    def replacements(self) -> dict[str, str]:
        """Return what each joint of `joint_name` is instead, in capitals."""
        if len(self.joint_name) != len(self.joint_type):
            got = f"{len(self.joint_name)} entries and `joint_type` {len(self.joint_type)}"
            raise ModelFileError(f"`joint_name` has {got}; give one type for each joint")
        found = dict(zip(self.joint_name, self.joint_type, strict=True))
        if len(found) < len(self.joint_name):
            raise ModelFileError("`joint_name` lists a joint twice")
        return {name: kind.upper() for name, kind in found.items()}

    def floats(self) -> bool:
        """Return whether the base floats."""
        if self.free_flyer.lower() not in _YAML_TRUTHS:
            got = f"`free_flyer` is {self.free_flyer[:60]!r}"
            raise ModelFileError(f"{got}, neither true nor false")
        return _YAML_TRUTHS[self.free_flyer.lower()]


class _Loader(yaml.BaseLoader):  # type: ignore[misc]
    """Refuses a key that is given twice, of which YAML would keep the last, and what is no text."""

    def construct_scalar(self, node: yaml.ScalarNode) -> str:
        text = str(super().construct_scalar(node))
        try:
            text.encode()
        except UnicodeEncodeError:
            problem = f"{quoted(text)} is no text: a lone surrogate in it is no character"
            raise yaml.constructor.ConstructorError(None, None, problem, node.start_mark) from None
        return text

    def construct_mapping(self, node: yaml.MappingNode, deep: bool = False) -> dict[Any, Any]:
        given: set[str] = set()
        for key, _ in node.value:
            if (name := str(key.value)) in given:
                problem = f"the key {name[:60]!r} is given twice"
                raise yaml.constructor.ConstructorError(None, None, problem, key.start_mark)
            given.add(name)
        found: dict[Any, Any] = super().construct_mapping(node, deep)
        return found


def read_closure_yaml(path: Path) -> tuple[ClosureFile, tuple[str, ...]]:
    """Read the file; also return the keys that were not used.

    Raises
    ------
    ModelFileError
        Not YAML, without any of the keys, or values of the wrong type.
    """
    text = read_text(path, MAXIMAL_YAML)
    keys = tuple(field.name for field in msgspec.structs.fields(ClosureFile))
    with at_file(str(path)):
        try:
            # Text, lists and tables only: no dates, numbers, objects or merged tables.
            contents = yaml.load(text, Loader=_Loader)
        except RecursionError:
            raise ModelFileError("not valid YAML: nested too deep to be read") from None
        except (yaml.YAMLError, ValueError, OverflowError) as error:
            problem = getattr(error, "problem", None) or type(error).__name__
            mark = getattr(error, "problem_mark", None)
            line = f" (line {mark.line + 1})" if mark else ""
            raise ModelFileError(f"not valid YAML: {shortened(problem)}{line}") from None
        if not isinstance(contents, dict) or not {"closed_loop", "name_mot"} & set(contents):
            got = ", ".join(map(str, contents))[:60] if isinstance(contents, dict) else "no table"
            wanted = "`closed_loop` and `name_mot` of an extended URDF"
            raise ModelFileError(f"{wanted} expected, since it lies beside one; it has: {got}")
        try:
            found = msgspec.convert(contents, ClosureFile)
        except msgspec.ValidationError as error:
            raise ModelFileError(str(error).replace("$.", "").replace("`$`", "the file")) from None
        unused = tuple(key for key in contents if key not in keys)
        for key in unused:
            if "mean" in (hint := did_you_mean(key, keys)):
                raise ModelFileError(f"unknown key {key[:60]!r}{hint}")
    return found, unused
