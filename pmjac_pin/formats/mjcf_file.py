"""The XML of an MJCF model: one tree of known elements, with its <include> files put in."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path, PurePosixPath, PureWindowsPath
from xml.etree.ElementTree import Element

from pmjac_pin.bounded_xml import MAXIMAL_NESTING
from pmjac_pin.errors import ModelFileError, did_you_mean
from pmjac_pin.text_file import at_file, read_text
from pmjac_pin.urdf_xml import parse_xml, shown
from pmjac_pin.user_path import is_file, real

MAXIMAL_SIZE = 5_000_000  # bytes; elements take a hundred times that in memory
MAXIMAL_INCLUDES = 50

_SECTIONS = (
    *("actuator", "asset", "compiler", "contact", "custom", "default", "deformable", "equality"),
    *("extension", "keyframe", "option", "sensor", "size", "statistic", "tendon", "visual"),
    "worldbody",
)


def read_mujoco(path: Path) -> Element:
    """Read an MJCF file and the files that it includes; attributes that are blank are dropped.

    A file is looked for in the model's folder, then in that of the file that includes it. It
    must be below the model's folder.

    Raises
    ------
    ModelFileError
        The message starts with the path of the file at fault.
    """
    return _Reader(path).root()


class _Reader:
    def __init__(self, path: Path) -> None:
        self._path = path
        self._files: list[Path] = []
        self._read = 0

    def root(self) -> Element:
        root = self._parsed(self._path)
        with at_file(str(self._path)):
            if root.tag != "mujoco":
                got = f"the root element is <{shown(root.tag)[1:-1]}>"
                raise ModelFileError(f"{got}; an MJCF file's is <mujoco>")
            expanded = self._expanded(root, self._path, 0)
            for section in expanded:
                if section.tag not in _SECTIONS:
                    known = did_you_mean(section.tag, _SECTIONS)
                    raise ModelFileError(
                        f"<{shown(section.tag)[1:-1]}> is no section of MJCF{known}"
                    )
        return expanded

    def _parsed(self, path: Path) -> Element:
        self._files.append(real(path))
        text = read_text(path, MAXIMAL_SIZE)
        self._read += len(text)
        if self._read > MAXIMAL_SIZE:
            what = f"the included files have more than {MAXIMAL_SIZE} characters together"
            raise ModelFileError(f"{path}: {what}", path=str(path))
        with at_file(str(path)):
            return parse_xml(text)

    def _expanded(self, element: Element, path: Path, depth: int) -> Element:
        """Return a copy with the contents of included files in the place of each <include>."""
        if depth > MAXIMAL_NESTING:
            raise ModelFileError(f"elements are nested more than {MAXIMAL_NESTING} deep")
        given = {key: value for key, value in element.attrib.items() if value.strip()}
        copy = Element(element.tag, given)
        copy.text = element.text
        copy.extend(list(self._children(element, path, depth)))
        return copy

    def _children(self, element: Element, path: Path, depth: int) -> Iterator[Element]:
        for child in element:
            if child.tag != "include":
                yield self._expanded(child, path, depth + 1)
                continue
            included = self._included(child, path)
            # Its root counts as nesting, so that files that include each other come to an end.
            yield from self._expanded(self._parsed(included), included, depth + 1)

    def _included(self, include: Element, path: Path) -> Path:
        name = include.get("file", "")
        parts = {*PurePosixPath(name).parts, *PureWindowsPath(name).parts}
        absolute = PurePosixPath(name).is_absolute() or bool(PureWindowsPath(name).anchor)
        folder = self._path.parent
        found = folder / name if is_file(folder / name) else path.parent / name
        inside = real(found).is_relative_to(real(folder))
        if absolute or ".." in parts or not inside:
            why = "only files in or below the model's own folder are read"
            raise ModelFileError(f"<include file={shown(name)}>: {why}")
        if not is_file(found):
            raise ModelFileError(f"<include file={shown(name)}>: there is no such file")
        if real(found) in self._files:
            raise ModelFileError(f"<include file={shown(name)}>: a file is included only once")
        if len(self._files) > MAXIMAL_INCLUDES:
            raise ModelFileError(f"more than {MAXIMAL_INCLUDES} files are included")
        return found
