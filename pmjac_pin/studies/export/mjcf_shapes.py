"""Shapes as MJCF's geoms, which are seen and touch nothing, and the meshes that they show."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from xml.etree.ElementTree import Element, SubElement

import pinocchio as pin

from pmjac_pin.errors import ArgumentError, quoted
from pmjac_pin.files.joint_dialects import listed
from pmjac_pin.files.unused_name import unused_name
from pmjac_pin.files.xml_text import written
from pmjac_pin.studies.export.mesh_files import mesh_file, mesh_path
from pmjac_pin.studies.export.plain_machine import PlainShape

_MESHES = (".stl", ".obj")
_HEADER, _FACET = 84, 50  # bytes of binary STL


class Shapes:
    """Writes <geom> elements, and <asset> for those that are meshes.

    Parameters
    ----------
    folder : Path
        Of the file that is written, from where a mesh's path counts.
    """

    def __init__(self, folder: Path) -> None:
        self.assets = Element("asset")
        self._folder = folder
        self._names: set[str] = set()
        self._known: dict[tuple[str, str], str] = {}
        self._lost: list[str] = []

    def geoms(self, drawn: PlainShape) -> Iterator[Element]:
        """Yield the geom of a shape; none of a mesh that MuJoCo cannot open."""
        given = _sizes(drawn.shape)
        if drawn.shape.tag == "mesh":
            if (mesh := self._mesh(drawn)) is None:
                return
            given = {"type": "mesh", "mesh": mesh}
        if drawn.colour is not None:
            given["rgba"] = written(drawn.colour)
        seen = {"contype": "0", "conaffinity": "0", "group": "2", "mass": "0"}
        yield Element("geom", {**given, **place_attributes(drawn.place), **seen})

    def _mesh(self, drawn: PlainShape) -> str | None:
        named, scale = drawn.shape.get("filename", ""), drawn.shape.get("scale", "1 1 1")
        file = mesh_file(drawn)
        if file is None or not _opens(file):
            self._lost.append(named)
            return None
        if (named, scale) not in self._known:
            name = unused_name(file.stem, self._names)
            where = mesh_path(drawn, self._folder)
            # As a shell: one whose volume is 0 or below is refused otherwise.
            told = {"file": where, "scale": scale, "inertia": "shell"}
            SubElement(self.assets, "mesh", {"name": name, **told})
            self._known[named, scale] = name
        return self._known[named, scale]

    def notes(self) -> Iterator[str]:
        """Yield which meshes are left out."""
        if self._lost:
            lost = listed(tuple(dict.fromkeys(self._lost)))
            yield f"meshes that MuJoCo does not open are left out (it opens STL and OBJ): {lost}"


def place_attributes(place: pin.SE3) -> dict[str, str]:
    """Return the attributes of where something is; MuJoCo writes w first."""
    x, y, z, w = pin.Quaternion(place.rotation).coeffs().tolist()
    return {"pos": written(place.translation), "quat": written((w, x, y, z))}


def _sizes(shape: Element) -> dict[str, str]:
    """Return a geom's type and sizes: MuJoCo's are half-lengths, a URDF's are whole ones."""

    def number(key: str) -> float:
        return float(shape.get(key, ""))

    match shape.tag:
        case "box":
            sides = [float(side) / 2.0 for side in shape.get("size", "").split()]
            return {"type": "box", "size": written(sides)}
        case "sphere":
            return {"type": "sphere", "size": written([number("radius")])}
        case "cylinder" | "capsule":
            sizes = [number("radius"), number("length") / 2.0]
            return {"type": shape.tag, "size": written(sizes)}
        case "mesh":
            return {}
        case unknown:
            raise ArgumentError(f"MJCF is told no shape of the kind {quoted(unknown)}")


def _opens(file: Path) -> bool:
    """Tell whether MuJoCo opens a mesh: of STL it knows the binary kind."""
    if file.suffix.lower() not in _MESHES:
        return False
    if file.suffix.lower() != ".stl":
        return True
    with file.open("rb") as stream:
        head = stream.read(_HEADER)
    count = int.from_bytes(head[80:84], "little")
    return len(head) == _HEADER and file.stat().st_size == _HEADER + _FACET * count
