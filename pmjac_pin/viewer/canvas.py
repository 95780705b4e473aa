"""The thin layer that turns items into meshcat's commands, and keeps those that are current.

A command is one MessagePack map, as `meshcat.commands` makes it. Here it is written directly:
importing meshcat would load ZeroMQ, and it knows neither cones nor text that faces the eye.
"""

from __future__ import annotations

import uuid
from collections.abc import Iterable
from typing import Any, assert_never

import msgspec

from pmjac_pin.files.shapes import Box, Colour, Cone, Cylinder, Shape, Sphere, Text
from pmjac_pin.values.arrays import Array
from pmjac_pin.viewer.facets import Facets
from pmjac_pin.viewer.items import Item
from pmjac_pin.viewer.palette import hexadecimal

Packet = tuple[str, bytes]

ROOT = "/pmjac"

# Three.js stands its cylinders along y: a quarter turn about x puts them along z.
_FOUR_BYTE_NUMBERS = 0x17  # of meshcat's MessagePack extensions: numbers of four bytes
_UPRIGHT = [1, 0, 0, 0, 0, 0, 1, 0, 0, -1, 0, 0, 0, 0, 0, 1]
_AS_IT_IS = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]


class Canvas:
    """The current picture as commands by path.

    Commands are pairs of a key and bytes. A later command with the same key makes the earlier
    one superfluous; a browser that has had the newest of every key shows the picture.
    """

    def __init__(self) -> None:
        self._commands: dict[str, bytes] = dict(_STAGE)
        self._shapes: dict[str, Shape | Facets] = {}
        self._matrices: dict[str, bytes] = {}
        self._visible: dict[str, bool] = {}

    def update(self, items: Iterable[Item]) -> list[Packet]:
        """Draw these items; return the commands for what has changed.

        From pose to pose these are transforms, the labels whose text has changed, and what
        appears or is hidden. What was drawn and is not among the items is hidden.
        """
        changed: list[Packet] = []
        hidden = {path for path, visible in self._visible.items() if visible}
        for item in items:
            if item.visible:
                path = _safe_path(item.name)
                hidden.discard(path)
                self._draw(path, item, changed)
        for path in hidden:
            self._show(path, False, changed)
        self._commands.update(changed)
        return changed

    def commands(self) -> list[Packet]:
        """Return the whole picture."""
        return list(self._commands.items())

    def _draw(self, path: str, item: Item, changed: list[Packet]) -> None:
        if self._shapes.get(path) != item.shape:
            self._shapes[path] = item.shape
            changed.append((f"object {path}", _set_object(path, item)))
        values = item.transform.tobytes()
        if self._matrices.get(path) != values:
            self._matrices[path] = values
            changed.append((f"transform {path}", _set_transform(path, item.transform)))
        if not self._visible.get(path):
            self._show(path, True, changed)

    def _show(self, path: str, visible: bool, changed: list[Packet]) -> None:
        self._visible[path] = visible
        changed.append(_property(path, "visible", visible))


def _safe_path(name: str) -> str:
    """Return a path that is safe for meshcat, to which "constructor" is no name for a child."""
    return f"{ROOT}/_" + name.replace("/", "/_")


def _set_transform(path: str, matrix: Array) -> bytes:
    columns = matrix.ravel("F").tolist()
    return msgspec.msgpack.encode({"type": "set_transform", "path": path, "matrix": columns})


def _set_object(path: str, item: Item) -> bytes:
    shape, colour = item.shape, item.colour
    if isinstance(shape, Text):
        made = _sprite(shape.text, colour)
    else:
        made = _mesh(shape, colour, on_top=item.on_top)
    made["metadata"] = {"version": 4.5, "type": "Object"}
    return msgspec.msgpack.encode({"type": "set_object", "path": path, "object": made})


def _mesh(
    shape: Box | Cylinder | Cone | Sphere | Facets, colour: Colour, *, on_top: bool
) -> dict[str, Any]:
    geometry, material = _identity(), _identity()
    opacity = colour[3]
    clear = opacity < 1.0
    return {
        "geometries": [{"uuid": geometry, **_geometry(shape)}],
        "materials": [
            {
                "uuid": material,
                # Not Phong's: without a graphics card it takes half as long again to draw.
                "type": "MeshLambertMaterial",
                "color": int(hexadecimal(colour)[1:], 16),
                # What is on top is drawn after all else, with what is clear.
                "transparent": clear or on_top,
                "opacity": opacity,
                # What is inside a clear surface is seen through it.
                "depthWrite": not (clear or on_top),
                "depthTest": not on_top,
                # Of a polygon both sides are seen; of a closed shape the front is enough.
                "side": 2 if isinstance(shape, Facets) else 0,
            }
        ],
        "object": {
            "uuid": _identity(),
            "type": "Mesh",
            "geometry": geometry,
            "material": material,
            "matrix": _UPRIGHT if isinstance(shape, Cylinder | Cone) else _AS_IT_IS,
            "renderOrder": int(on_top),
        },
    }


def _geometry(shape: Box | Cylinder | Cone | Sphere | Facets) -> dict[str, Any]:
    match shape:
        case Facets():
            attributes = {"position": _threes(shape.corners), "normal": _threes(shape.normals)}
            return {"type": "BufferGeometry", "data": {"attributes": attributes}}
        case Box():
            return {"type": "BoxGeometry", "width": 1, "height": 1, "depth": 1}
        case Sphere():
            size = {"widthSegments": 24, "heightSegments": 16}
            return {"type": "SphereGeometry", "radius": 1, **size}
        case Cylinder():
            return _round(1.0)
        case Cone():
            return _round(0.0)
        case _:
            assert_never(shape)


def _threes(numbers: bytes) -> dict[str, Any]:
    """Return threes of numbers of four bytes as Three.js reads them."""
    array = msgspec.msgpack.Ext(_FOUR_BYTE_NUMBERS, numbers)
    return {"itemSize": 3, "type": "Float32Array", "array": array, "normalized": False}


def _round(top: float) -> dict[str, Any]:
    size = {"radiusTop": top, "radiusBottom": 1, "height": 1, "radialSegments": 24}
    return {"type": "CylinderGeometry", **size}


def _sprite(text: str, colour: Colour) -> dict[str, Any]:
    """Return a sprite, which always faces the eye; labels.js writes the text and finds it room."""
    texture, material = _identity(), _identity()
    return {
        "geometries": [],
        "textures": [
            # What a browser without labels.js shows: meshcat's own small letters.
            {
                "uuid": texture,
                "type": "_text",
                "text": text,
                "font_size": 24,
                "font_face": "sans-serif",
            }
        ],
        "materials": [
            {
                "uuid": material,
                "type": "SpriteMaterial",
                "map": texture,
                "transparent": True,
                "depthTest": False,
                "depthWrite": False,
            }
        ],
        "object": {
            "uuid": _identity(),
            "type": "Sprite",
            "material": material,
            "matrix": _AS_IT_IS,
            "renderOrder": 1,
            "userData": {"text": text, "colour": hexadecimal(colour)},
        },
    }


def _identity() -> str:
    return str(uuid.uuid4())


def _property(path: str, name: str, value: Any) -> Packet:
    command = {"type": "set_property", "path": path, "property": name, "value": value}
    return f"property {path} {name}", msgspec.msgpack.encode(command)


# A light ground; meshcat's own grid and axes are too large for one mechanism, too small for others.
_STAGE = (
    _property("/Background", "top_color", [1.0, 1.0, 1.0]),
    _property("/Background", "bottom_color", [0.91, 0.93, 0.95]),
    _property("/Grid", "visible", False),
    _property("/Axes", "visible", False),
)
