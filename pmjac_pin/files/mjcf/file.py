"""The XML of an MJCF model: trees of known elements, with their <include> files put in."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path, PurePosixPath, PureWindowsPath
from xml.etree.ElementTree import Element

from pmjac_pin.errors import ArgumentError, ModelFileError, did_you_mean, quoted, shortened
from pmjac_pin.files.bounded_xml import MAXIMAL_NESTING
from pmjac_pin.files.text_file import at_file, read_text
from pmjac_pin.files.user_path import is_file, is_folder, real, shown_path
from pmjac_pin.files.xml_text import parse_xml

MAXIMAL_MJCF = 5_000_000  # bytes; elements take a hundred times that in memory
MAXIMAL_INCLUDES = 50
_LONGEST_ROOT = 200  # characters of one in a message
_OUTSIDE = (
    "only files in or below the model's own folder are read; give the folder above both as "
    "`include_root` (--include-root) if you trust it, or save the whole model as one file "
    "(MuJoCo's mj_saveLastXML)"
)

_SECTIONS = (
    *("actuator", "asset", "compiler", "contact", "custom", "default", "deformable", "equality"),
    *("extension", "keyframe", "option", "sensor", "size", "statistic", "tendon", "visual"),
    "worldbody",
)


@dataclass(frozen=True, eq=False)
class MjcfFile:
    """A model as a tree of elements.

    Attributes
    ----------
    path : Path
    root : Element
        <mujoco>, without attributes that are blank.
    attached : mapping of str to MjcfFile
        The models that it attaches, by what `file` of their <model> says in `root`.
    """

    path: Path
    root: Element
    attached: Mapping[str, MjcfFile]


def read_mujoco(path: Path, root: Path | None = None) -> MjcfFile:
    """Read an MJCF file, and the files that it includes or attaches.

    A file is looked for in the model's folder, then in that of the file that names it. It
    must be below the model's folder, or below the root where that is given.

    Raises
    ------
    ModelFileError
        The message starts with the path of the file at fault.
    ArgumentError
        The root is no folder above the model.
    """
    if root is not None and not (is_folder(root) and real(path).is_relative_to(real(root))):
        what = f"`include_root` is a folder that holds the model, got {quoted(str(root))}"
        raise ArgumentError(f"{what} for {shown_path(path)}")
    return _Reader(path.parent, root).model(path, ())


class _Reader:
    """Reads the files of a folder, or of a root above it; all together are bounded."""

    def __init__(self, folder: Path, root: Path | None) -> None:
        self._folder, self._root = folder, root
        self._files = self._read = 0

    def model(self, path: Path, above: Sequence[Path]) -> MjcfFile:
        """Return a model that those `above` attach, one by one."""
        included: list[Path] = []
        root = self._parsed(path, included)
        with at_file(str(path)):
            if root.tag != "mujoco":
                got = f"the root element is <{quoted(root.tag)[1:-1]}>"
                raise ModelFileError(f"{got}; an MJCF file's is <mujoco>")
            expanded = self._expanded(root, path, included, 0)
            for section in expanded:
                if section.tag not in _SECTIONS:
                    known = did_you_mean(section.tag, _SECTIONS)
                    raise ModelFileError(
                        f"<{quoted(section.tag)[1:-1]}> is no section of MJCF{known}"
                    )
            return MjcfFile(path, expanded, self._attached(expanded, path, (*above, real(path))))

    def _attached(self, root: Element, path: Path, above: Sequence[Path]) -> Mapping[str, MjcfFile]:
        """Return the models that a model names, whose elements get names like no other's."""
        found = {}
        for element in root.iterfind("asset/model"):
            file = self._found(element, path)
            if real(file) in above:
                raise ModelFileError(f"{_file_called(element)}: the model attaches itself")
            element.set("file", f"{self._files}.xml")
            found[element.get("file", "")] = self.model(file, above)
        return found

    def _parsed(self, path: Path, included: list[Path]) -> Element:
        if self._files > MAXIMAL_INCLUDES:
            raise ModelFileError(f"more than {MAXIMAL_INCLUDES} files are included")
        self._files += 1
        included.append(real(path))
        text = read_text(path, MAXIMAL_MJCF)
        self._read += len(text)
        if self._read > MAXIMAL_MJCF:
            what = f"the included files have more than {MAXIMAL_MJCF} characters together"
            raise ModelFileError(f"{path}: {what}", path=str(path))
        with at_file(str(path)):
            return parse_xml(text)

    def _expanded(self, element: Element, path: Path, included: list[Path], depth: int) -> Element:
        """Return a copy with the contents of included files in the place of each <include>."""
        if depth > MAXIMAL_NESTING:
            raise ModelFileError(f"elements are nested more than {MAXIMAL_NESTING} deep")
        given = {key: value for key, value in element.attrib.items() if value.strip()}
        copy = Element(element.tag, given)
        copy.extend(list(self._children(element, path, included, depth)))
        return copy

    def _children(
        self, element: Element, path: Path, included: list[Path], depth: int
    ) -> Iterator[Element]:
        for child in element:
            if child.tag != "include":
                yield self._expanded(child, path, included, depth + 1)
                continue
            file = self._found(child, path)
            if real(file) in included:
                raise ModelFileError(f"{_file_called(child)}: a file is included only once")
            # Its root counts as nesting, so that files that include each other come to an end.
            root = self._parsed(file, included)
            yield from self._expanded(root, file, included, depth + 1)

    def _found(self, element: Element, path: Path) -> Path:
        """Return the file that an element names, once it is certain that it may be read."""
        name = element.get("file", "")
        found = self._folder / name if is_file(self._folder / name) else path.parent / name
        if (why := self._why_not(name, found)) is not None:
            raise ModelFileError(f"{_file_called(element)}: {why}")
        if not is_file(found):
            raise ModelFileError(f"{_file_called(element)}: there is no such file")
        return found

    def _why_not(self, name: str, found: Path) -> str | None:
        """Return why a file that was found by this name may not be read."""
        if self._root is not None:
            if real(found).is_relative_to(real(self._root)):
                return None
            below = shortened(str(self._root), _LONGEST_ROOT)
            return f"only files in or below {quoted(below)}, the include_root, are read"
        parts = {*PurePosixPath(name).parts, *PureWindowsPath(name).parts}
        absolute = PurePosixPath(name).is_absolute() or bool(PureWindowsPath(name).anchor)
        inside = real(found).is_relative_to(real(self._folder))
        return _OUTSIDE if absolute or ".." in parts or not inside else None


def _file_called(element: Element) -> str:
    return f"<{element.tag} file={quoted(element.get('file', ''))}>"
