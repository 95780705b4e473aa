"""Every single misspelling of an element's or attribute's name in an XML file."""

from __future__ import annotations

from xml.etree.ElementTree import Element, fromstring, tostring


def slips(name):
    """The names with a letter left out, a letter doubled, or two neighbours swapped."""
    prefix, _, local = name.rpartition("}")
    space = f"{prefix}}}" if prefix else ""
    dropped = (local[:k] + local[k + 1 :] for k in range(len(local)))
    doubled = (local[:k] + local[k] + local[k:] for k in range(len(local)))
    swapped = (local[:k] + local[k + 1] + local[k] + local[k + 2 :] for k in range(len(local) - 1))
    found = dict.fromkeys((*dropped, *doubled, *swapped))
    return [space + slip for slip in found if slip and slip != local]


def misspelt(text):
    """Yield (what was done, the file) for each slip in each name of a kind of place, once.

    A kind of place is an element's tag within its parent's, and an attribute of such a one.
    """
    root = fromstring(text)
    seen = set()
    for element, place in list(places(root)):
        tag, attributes = element.tag, element.attrib
        if place not in seen and element is not root:
            for slip in slips(tag):
                element.tag = slip
                yield f"{place} as {slip}", tostring(root, encoding="unicode")
            element.tag = tag
        for attribute in attributes:
            if (place, attribute) not in seen:
                for slip in slips(attribute):
                    element.attrib = {
                        slip if key == attribute else key: value
                        for key, value in attributes.items()
                    }
                    yield f"{place}@{attribute} as {slip}", tostring(root, encoding="unicode")
                element.attrib = attributes
        seen |= {place, *((place, attribute) for attribute in attributes)}


def places(root: Element):
    """Yield each element with its and its parent's tag, in file order."""
    waiting = [(root, root.tag)]
    while waiting:
        element, place = waiting.pop()
        yield element, place
        waiting += [(child, f"{element.tag}/{child.tag}") for child in reversed(element)]
