"""The area that annuli share, in closed form: arcs of circles, by Green's theorem."""

import numpy as np


def shared_area(annuli):
    """Area of the intersection of annuli ((x, y), inner, outer), of one piece or several."""
    circles = [(np.array(c, dtype=float), outer, 1.0) for c, _, outer in annuli]
    circles += [(np.array(c, dtype=float), inner, -1.0) for c, inner, _ in annuli if inner > 0.0]
    return sum(
        side * _swept(centre, radius, begin, end)
        for k, (centre, radius, side) in enumerate(circles)
        for begin, end in _arcs(k, circles)
    )


def _arcs(k, circles):
    """Arcs of a circle on which all others allow to be."""
    centre, radius, _ = circles[k]
    others = [one for j, one in enumerate(circles) if j != k]
    angles = sorted(angle for one in others for angle in _meetings(centre, radius, *one[:2]))
    angles = angles or [0.0]
    for begin, end in zip(angles, [*angles[1:], angles[0] + 2.0 * np.pi], strict=True):
        middle = 0.5 * (begin + end)
        place = centre + radius * np.array([np.cos(middle), np.sin(middle)])
        if all(s * (r - np.linalg.norm(place - c)) >= 0.0 for c, r, s in others):
            yield begin, end


def _meetings(centre, radius, other, its_radius):
    away = other - centre
    distance = np.linalg.norm(away)
    if distance == 0.0:
        return []
    cosine = (radius**2 + distance**2 - its_radius**2) / (2.0 * radius * distance)
    if abs(cosine) >= 1.0:
        return []
    towards = np.arctan2(away[1], away[0])
    return [np.remainder(towards + s * np.arccos(cosine), 2.0 * np.pi) for s in (1.0, -1.0)]


def _swept(centre, radius, begin, end):
    """½ ∫ (x dy − y dx) along an arc."""
    x, y = centre
    chord = x * (np.sin(end) - np.sin(begin)) - y * (np.cos(end) - np.cos(begin))
    return 0.5 * radius * (radius * (end - begin) + chord)
