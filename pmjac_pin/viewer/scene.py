"""The scene: everything that is to be seen of a configuration, as plain data.

Nothing here draws. A scene is a list of items, each a unit shape, a colour and a transform; the
names are the same at all poses of one mechanism under one set of options, so that a viewer makes
the items once and then only moves them.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from types import MappingProxyType

import numpy as np

from pmjac_pin.configuration import Configuration
from pmjac_pin.errors import ArgumentError
from pmjac_pin.mechanism import Mechanism
from pmjac_pin.pictures.anatomy import Anatomy
from pmjac_pin.pictures.within_limits import ToolQuantity
from pmjac_pin.values.arrays import Array, read_only
from pmjac_pin.viewer.closures import anchor_layer, axis_layer, gap_layer, rod_layer
from pmjac_pin.viewer.ellipsoids import EllipsoidLayer, directions_after, find_ellipsoids
from pmjac_pin.viewer.force_arrow import ForceLayer
from pmjac_pin.viewer.free_motion import FreeMotionLayer
from pmjac_pin.viewer.gears import belt_layer, wheel_layer
from pmjac_pin.viewer.items import Item
from pmjac_pin.viewer.joints import joint_layer, motor_names, rail_layer, tool_layer
from pmjac_pin.viewer.layers import Drawing, DrawnPose, Layer, SolidKind
from pmjac_pin.viewer.links import link_layer
from pmjac_pin.viewer.load_sliders import load_sliders
from pmjac_pin.viewer.scene_options import SceneOptions
from pmjac_pin.viewer.solids import QUANTITY_OF, SolidLayer, find_solids

_DRAWN_ELLIPSOIDS: tuple[ToolQuantity, ...] = ("linear", "angular", "force")


@dataclass(frozen=True, eq=False, slots=True)
class Scene:
    """What is to be seen of one configuration.

    Attributes
    ----------
    items : tuple of Item
        In an order that depends on mechanism and options only.
    directions : mapping of str to ndarray, shape (3, 3)
        By ellipsoid: in column i the unit vector along which the arrow of its axis i points.
    """

    items: tuple[Item, ...]
    directions: Mapping[ToolQuantity, Array] = field(default_factory=lambda: MappingProxyType({}))


class SceneMaker:
    """Makes scenes of one mechanism: what does not change from pose to pose is computed once.

    Parameters
    ----------
    mechanism : Mechanism

    Examples
    --------
    >>> import pmjac_pin as pj
    >>> mechanism = pj.load("four_bar")
    >>> maker = SceneMaker(mechanism)
    >>> [item.name for item in maker.scene(mechanism.close([1.0])).items][:2]
    ['links/ground/ground_bar', 'links/crank/crank_bar']
    """

    def __init__(self, mechanism: Mechanism) -> None:
        self.mechanism = mechanism
        self._anatomy = anatomy = Anatomy(mechanism)
        self._always: tuple[Layer, ...] = (
            link_layer(anatomy),
            joint_layer(anatomy),
            rail_layer(anatomy),
            anchor_layer(anatomy),
            axis_layer(anatomy),
            rod_layer(anatomy),
            gap_layer(anatomy),
            wheel_layer(anatomy),
            belt_layer(anatomy),
            FreeMotionLayer(anatomy),
            tool_layer(anatomy),
            ForceLayer(anatomy, load_sliders(mechanism)[1].upper),
        )
        self._names = motor_names(anatomy)
        self._ellipsoids: dict[ToolQuantity, EllipsoidLayer] = {
            kind: EllipsoidLayer(anatomy, kind) for kind in _DRAWN_ELLIPSOIDS
        }
        self._solids: dict[SolidKind, SolidLayer] = {
            kind: SolidLayer(anatomy, kind, self._ellipsoids[like].automatic)
            for kind, like in QUANTITY_OF.items()
        }

    def scene(
        self,
        configuration: Configuration,
        options: SceneOptions | None = None,
        directions: Mapping[ToolQuantity, Array] | None = None,
        force: Array | None = None,
    ) -> Scene:
        """Return what is to be seen of a configuration.

        Parameters
        ----------
        configuration : Configuration
            Of this mechanism.
        options : SceneOptions, optional
        directions : mapping of str to ndarray, optional
            Those of an earlier scene. A principal axis has no sign: its arrow points to the side
            where it pointed there, so that it does not jump to and fro while the pose changes.
        force : ndarray, shape (3,), optional
            That acts on the tool, N, in the world.

        Raises
        ------
        ArgumentError
            A configuration of another mechanism.
        """
        self._check(configuration)
        options = options or SceneOptions()
        ellipsoids = find_ellipsoids(configuration, _ellipsoids_of(options))
        directions = directions_after(directions or {}, ellipsoids)
        placements = self._placements(configuration)
        pose = DrawnPose(
            configuration,
            ellipsoids,
            directions,
            placements,
            options.scale,
            find_solids(configuration, solids_of(options)),
            np.zeros(3) if force is None else force,
        )
        layers = list(self._layers(options))
        drawings = [layer.draw(pose) for layer in layers]
        transforms = read_only(np.concatenate([drawing.transforms for drawing in drawings]))
        blocks = _blocks(transforms, drawings)
        drawn = zip(layers, drawings, blocks, strict=True)
        return Scene(tuple(item for triple in drawn for item in _items(*triple)), directions)

    def _check(self, configuration: Configuration) -> None:
        theirs = configuration.mechanism
        if theirs is not self.mechanism and theirs != self.mechanism:
            raise ArgumentError(
                f"a configuration of {self.mechanism.name!r} is wanted, with its parameters; got "
                f"one of {theirs.name!r}"
            )

    def _placements(self, configuration: Configuration) -> Array:
        bodies = self._anatomy.bodies.placements(configuration.q)
        return np.concatenate([bodies, self._anatomy.tool_pose(configuration).homogeneous[None]])

    def _layers(self, options: SceneOptions) -> Iterator[Layer]:
        yield from self._always
        if options.names:
            yield self._names
        for kind in _ellipsoids_of(options):
            yield self._ellipsoids[kind]
        for solid in solids_of(options):
            yield self._solids[solid]


def _ellipsoids_of(options: SceneOptions) -> tuple[ToolQuantity, ...]:
    return tuple(kind for kind in _DRAWN_ELLIPSOIDS if getattr(options, kind))


def solids_of(options: SceneOptions) -> tuple[SolidKind, ...]:
    """Return the polytopes that are chosen."""
    return tuple(kind for kind in QUANTITY_OF if getattr(options, f"{kind}_polytope"))


def _blocks(transforms: Array, drawings: list[Drawing]) -> Iterator[Array]:
    start = 0
    for drawing in drawings:
        stop = start + len(drawing.transforms)
        yield transforms[start:stop]
        start = stop


def _items(layer: Layer, drawing: Drawing, transforms: Array) -> Iterator[Item]:
    shapes = drawing.shapes
    visible = drawing.visible.tolist()
    for number, (part, transform) in enumerate(zip(layer.parts, transforms, strict=True)):
        shape = shapes.get(number, part.shape)
        yield Item(part.name, shape, part.colour, transform, visible[number], part.on_top)
