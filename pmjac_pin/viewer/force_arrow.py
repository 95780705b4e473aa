"""The force on the tool, as an arrow with its size."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from pmjac_pin.files.shapes import Cone, Cylinder, Text
from pmjac_pin.pictures.anatomy import Anatomy
from pmjac_pin.viewer.ellipsoids import LETTERS, radius_label
from pmjac_pin.viewer.items import Part, stretched_between
from pmjac_pin.viewer.layers import SPECK, Drawing, DrawnPose, lettering, specks, words
from pmjac_pin.viewer.palette import LOAD

# Shares of the mechanism's size.
_SHORTEST, _LONGEST = 0.12, 0.5
_RADIUS = 0.012


class ForceLayer:
    """Shaft, head and label of the force that acts on the tool; hidden where there is none.

    Parameters
    ----------
    anatomy : Anatomy
    largest : float
        N, of the slider: what is drawn longest.
    """

    def __init__(self, anatomy: Anatomy, largest: float) -> None:
        self._size, self._largest = anatomy.size, largest
        self.parts: Sequence[Part] = (
            Part("load/shaft", Cylinder(), LOAD, on_top=True),
            Part("load/head", Cone(), LOAD, on_top=True),
            words("load/label", "", LOAD),
        )

    def draw(self, pose: DrawnPose) -> Drawing:
        """Return them: the arrow begins at the tool."""
        size = float(np.linalg.norm(pose.force))
        transforms, visible = np.zeros((3, 4, 4)), np.full(3, size > 0.0)
        shapes = {}
        if size > 0.0:
            share = min(size / self._largest, 1.0)
            length = self._size * (_SHORTEST + share * (_LONGEST - _SHORTEST))
            way, radius = pose.force / size, np.array([_RADIUS * self._size])
            neck, tip = (pose.tool + part * length * way for part in (0.7, 1.0))
            transforms[:1], _ = stretched_between(pose.tool[None], neck[None], radius, 0.0)
            transforms[1:2], _ = stretched_between(neck[None], tip[None], 3.0 * radius, 0.0)
            beyond = tip + LETTERS * self._size * way
            transforms[2:] = lettering(beyond[None], LETTERS * self._size)
            shapes = {2: Text(radius_label(size, "N"))}
        specks(transforms, visible, pose.tool, SPECK * self._size)
        return Drawing(transforms, visible, shapes)
