"""Colours: those of Okabe and Ito, which colour-blind readers can tell apart."""

from __future__ import annotations

from pmjac_pin.files.shapes import Colour

_ORANGE = (0.90, 0.62, 0.0)
_SKY = (0.34, 0.71, 0.91)
_YELLOW = (0.94, 0.89, 0.26)
_GREEN = (0.0, 0.62, 0.45)
_BLUE = (0.0, 0.45, 0.70)
_VERMILION = (0.84, 0.37, 0.0)
_PURPLE = (0.80, 0.47, 0.65)

GROUND: Colour = (0.45, 0.45, 0.45, 1.0)
LINK: Colour = (*_BLUE, 1.0)
JOINT: Colour = (0.15, 0.15, 0.15, 1.0)
MOTOR: Colour = (*_VERMILION, 1.0)
FIRST_ANCHOR: Colour = (*_ORANGE, 1.0)
SECOND_ANCHOR: Colour = (*_PURPLE, 0.5)
GAP: Colour = (0.85, 0.0, 0.0, 1.0)
ROD: Colour = (*_PURPLE, 1.0)
GEAR: Colour = (0.55, 0.5, 0.05, 1.0)
WHEEL: Colour = (*_YELLOW, 0.6)
FREE: Colour = (*_GREEN, 1.0)
WORDS: Colour = (0.0, 0.0, 0.0, 1.0)
AXIS_COLOURS: tuple[Colour, Colour, Colour] = (
    (0.85, 0.1, 0.1, 1.0),
    (0.1, 0.6, 0.1, 1.0),
    (0.1, 0.2, 0.9, 1.0),
)

# Of the ellipsoids: the surface, and the arrows in a darker shade.
SURFACE: dict[str, Colour] = {
    "linear": (*_SKY, 0.35),
    "angular": (*_PURPLE, 0.35),
    "force": (*_ORANGE, 0.3),
}
PRINCIPAL: dict[str, Colour] = {
    "linear": (0.0, 0.28, 0.45, 1.0),
    "angular": (0.5, 0.18, 0.36, 1.0),
    "force": (0.55, 0.35, 0.0, 1.0),
}


# Of the polytopes: faces and edges.
SOLID: dict[str, Colour] = {"velocity": (*_BLUE, 0.14), "force": (*_VERMILION, 0.12)}
SOLID_EDGE: dict[str, Colour] = {
    "velocity": (0.0, 0.36, 0.56, 1.0),
    "force": (0.62, 0.27, 0.0, 1.0),
}
LOAD: Colour = (0.6, 0.0, 0.5, 1.0)


def hexadecimal(colour: Colour) -> str:
    """Return a colour as a page writes it, without its opacity.

    Examples
    --------
    >>> hexadecimal((1.0, 0.5, 0.0, 1.0))
    '#ff8000'
    """
    return "#" + "".join(f"{round(255 * part):02x}" for part in colour[:3])
