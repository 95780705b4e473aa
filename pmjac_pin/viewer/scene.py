"""The scene: everything that is to be seen of a configuration, as plain data.

Nothing here draws. A scene is a list of items, each a unit shape, a colour and a transform; the
names are the same at all poses of one mechanism under one set of options, so that a viewer makes
the items once and then only moves them.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pmjac_pin.configuration import Configuration
from pmjac_pin.errors import ArgumentError
from pmjac_pin.mechanism import Mechanism
from pmjac_pin.read_only import read_only
from pmjac_pin.viewer.anatomy import Anatomy
from pmjac_pin.viewer.ellipsoids import EllipsoidLayer, Kind, find_jacobian
from pmjac_pin.viewer.free_motion import NEAR_SINGULAR, FreeMotionLayer
from pmjac_pin.viewer.joints import (
    anchor_layer,
    closure_layer,
    joint_layer,
    motor_names,
    rail_layer,
    tool_layer,
)
from pmjac_pin.viewer.layers import Drawing, Layer, Pose
from pmjac_pin.viewer.links import link_layer
from pmjac_pin.viewer.shapes import Array, Box, Cone, Cylinder, Item, Shape, Sphere, Text

__all__ = [
    "NEAR_SINGULAR",
    "Box",
    "Cone",
    "Cylinder",
    "Item",
    "Scene",
    "SceneMaker",
    "SceneOptions",
    "Shape",
    "Sphere",
    "Text",
    "scene",
]

_KINDS: tuple[Kind, ...] = ("linear", "angular", "force")


@dataclass(frozen=True, slots=True)
class SceneOptions:
    """What is drawn beside links, joints, loop closures and free motions.

    Attributes
    ----------
    linear, angular, force : bool
        The ellipsoids at the tool.
    scale : float
        Of the ellipsoids, relative to the automatic one; positive.
    frames : bool
        The tool's frame.
    labels : bool
        All text: the motors' names, the values of the ellipsoids' axes.
    names : bool
        The motors' names.
    """

    linear: bool = True
    angular: bool = False
    force: bool = False
    scale: float = 1.0
    frames: bool = True
    labels: bool = True
    names: bool = True

    def __post_init__(self) -> None:
        if not 0.0 < self.scale < math.inf:
            raise ArgumentError(f"scale must be a positive number, got {self.scale!r}")


@dataclass(frozen=True, eq=False, slots=True)
class Scene:
    """What is to be seen of one configuration.

    Attributes
    ----------
    items : tuple of Item
        In an order that depends on mechanism and options only.
    centre : ndarray, shape (3,)
    radius : float
        The ball, in m, that holds all visible items here: what a camera frames at first. It
        changes with the pose.
    """

    items: tuple[Item, ...]
    centre: Array
    radius: float


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
            closure_layer(anatomy),
            FreeMotionLayer(anatomy),
        )
        self._tool = tool_layer(anatomy)
        self._names = motor_names(anatomy)
        self._ellipsoids: dict[Kind, EllipsoidLayer] = {
            kind: EllipsoidLayer(anatomy, kind) for kind in _KINDS
        }

    def scene(self, configuration: Configuration, options: SceneOptions | None = None) -> Scene:
        """Return what is to be seen of a configuration.

        Parameters
        ----------
        configuration : Configuration
            Of this mechanism.
        options : SceneOptions, optional

        Raises
        ------
        ArgumentError
            A configuration of another mechanism.
        """
        self._check(configuration)
        options = options or SceneOptions()
        jacobian = find_jacobian(configuration) if _ellipsoids_of(options) else None
        pose = Pose(configuration, jacobian, self._placements(configuration), options.scale)
        layers = list(self._layers(options))
        drawings = [layer.draw(pose) for layer in layers]
        transforms = read_only(np.concatenate([drawing.transforms for drawing in drawings]))
        visible = np.concatenate([drawing.visible for drawing in drawings])
        items = tuple(
            item
            for layer, drawing, block in zip(
                layers, drawings, _blocks(transforms, drawings), strict=True
            )
            for item in _items(layer, drawing, block)
        )
        centre, radius = _frame(items, transforms, visible)
        if not options.labels:
            items = tuple(item for item in items if not isinstance(item.shape, Text))
        return Scene(items, centre, radius)

    def _check(self, configuration: Configuration) -> None:
        theirs = configuration.mechanism
        if theirs is not self.mechanism and theirs != self.mechanism:
            raise ArgumentError(
                f"a configuration of {self.mechanism.name!r} is wanted, with its parameters; got "
                f"one of {theirs.name!r}"
            )

    def _placements(self, configuration: Configuration) -> Array:
        bodies = self._anatomy.bodies.placements(configuration.q)
        return np.concatenate([bodies, configuration.tool_pose.homogeneous[None]])

    def _layers(self, options: SceneOptions) -> Iterator[Layer]:
        yield from self._always
        if options.frames:
            yield self._tool
        if options.labels and options.names:
            yield self._names
        for kind in _ellipsoids_of(options):
            yield self._ellipsoids[kind]


def scene(configuration: Configuration, options: SceneOptions | None = None) -> Scene:
    """Return what is to be seen of a configuration.

    For many configurations of one mechanism a `SceneMaker` is much faster.

    Parameters
    ----------
    configuration : Configuration
    options : SceneOptions, optional

    Examples
    --------
    >>> import pmjac_pin as pj
    >>> drawn = scene(pj.load("four_bar").home)
    >>> next(item.colour for item in drawn.items if item.name == "motors/theta1/pin")
    (0.84, 0.37, 0.0, 1.0)
    """
    return SceneMaker(configuration.mechanism).scene(configuration, options)


def _ellipsoids_of(options: SceneOptions) -> tuple[Kind, ...]:
    return tuple(kind for kind in _KINDS if getattr(options, kind))


def _blocks(transforms: Array, drawings: list[Drawing]) -> Iterator[Array]:
    start = 0
    for drawing in drawings:
        stop = start + len(drawing.transforms)
        yield transforms[start:stop]
        start = stop


def _items(layer: Layer, drawing: Drawing, transforms: Array) -> Iterator[Item]:
    texts = drawing.texts
    visible = drawing.visible.tolist()
    for number, (part, transform) in enumerate(zip(layer.parts, transforms, strict=True)):
        shape = Text(texts[number]) if number in texts else part.shape
        yield Item(part.name, shape, part.colour, transform, visible[number])


def _frame(
    items: tuple[Item, ...], transforms: Array, visible: NDArray[np.bool_]
) -> tuple[Array, float]:
    """Return centre and radius of a ball about all visible items."""
    half = np.array([item.shape.half_extents for item in items])[visible]
    round_axes = np.array([item.shape.round_axes for item in items])[visible]
    shown = transforms[visible]
    centres = shown[:, :3, 3]
    reach = (np.abs(shown[:, :3, :3]) @ half[:, :, None])[:, :, 0]
    centre = 0.5 * ((centres - reach).min(axis=0) + (centres + reach).max(axis=0))
    x, y, z = (np.linalg.norm(shown[:, :3, :3], axis=1) * half).T
    across = np.where(round_axes > 0, np.maximum(x, y), np.hypot(x, y))
    radii = np.where(round_axes == 3, np.maximum(across, z), np.hypot(across, z))
    radius = float((np.linalg.norm(centres - centre, axis=1) + radii).max())
    return read_only(centre), radius
