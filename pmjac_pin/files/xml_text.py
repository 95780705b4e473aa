"""Reading XML that may be anything: its elements, its numbers, and one clear error for each.

A message names the element; the caller adds the file.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable
from xml.etree.ElementTree import Element, ParseError
from xml.parsers.expat.errors import (
    XML_ERROR_INVALID_TOKEN,
    XML_ERROR_MISPLACED_XML_PI,
    XML_ERROR_UNBOUND_PREFIX,
    codes,
)

from defusedxml.common import DefusedXmlException

from pmjac_pin.errors import ModelFileError, did_you_mean, quoted, shortened
from pmjac_pin.files.bounded_xml import bounded_tree
from pmjac_pin.files.lenient_xml import (
    with_plain_comments,
    with_prefixes_bound,
    without_late_declaration,
)
from pmjac_pin.values.checks import LARGEST

_MENDS = {
    codes[XML_ERROR_MISPLACED_XML_PI]: without_late_declaration,
    codes[XML_ERROR_UNBOUND_PREFIX]: with_prefixes_bound,
    codes[XML_ERROR_INVALID_TOKEN]: with_plain_comments,
}


def parse_xml(text: str) -> Element:
    """Parse XML without document types, entities, deep nesting or very many elements."""
    try:
        return _forgiven(text)
    except (ParseError, UnicodeError) as error:
        raise ModelFileError(f"not well-formed XML: {shortened(str(error))}") from None
    except DefusedXmlException:
        why = "it could open other files or grow without bound"
        raise ModelFileError(f"a <!DOCTYPE> is not read, since {why}; remove it") from None


def _forgiven(text: str) -> Element:
    """Parse XML, each kind of thing that the parsers of robots forgive mended once."""
    mends = dict(_MENDS)
    while True:
        try:
            return bounded_tree(text)
        except ParseError as error:
            if (mend := mends.pop(error.code, None)) is None:
                raise
            text = mend(text)


def only(where: str, parent: Element, tag: str) -> Element | None:
    """Return the child of that tag, if there is one; Pinocchio would ignore a second."""
    found = parent.findall(tag)
    if len(found) > 1:
        raise ModelFileError(f"{where} has {len(found)} <{tag.removeprefix('{*}')}>; give one")
    return found[0] if found else None


def numbers(
    where: str,
    element: Element | None,
    attribute: str,
    *,
    default: str | None = None,
    count: int = 1,
    least: float = -math.inf,
    largest: float = LARGEST,
) -> list[float]:
    """Return an attribute's numbers: finite, so many, and none of them beyond `largest`.

    `least` is 0 where none may be negative.
    """
    text = default if element is None else element.get(attribute, default)
    if text is None:
        raise ModelFileError(f"{where} has no `{attribute}`")
    values = numbers_in(f"{where}: `{attribute}`", text, count=count, largest=largest)
    if min(values) < least:
        raise ModelFileError(f"{where}: `{attribute}` is {min(values):g}; it must not be negative")
    return values


def numbers_in(what: str, text: str, *, count: int = 1, largest: float = LARGEST) -> list[float]:
    """Return the numbers of a text: finite, so many, and none of them beyond `largest`."""
    try:
        values = [float(word) for word in text.split()] if _is_plain_text(text) else []
    except ValueError:
        values = []
    if len(values) != count or not all(map(math.isfinite, values)):
        wanted = "a finite number" if count == 1 else f"{count} finite numbers"
        raise ModelFileError(f"{what} is {quoted(text)}, not {wanted}")
    if max(map(abs, values)) > largest:
        limit = f"of magnitude {largest:g} or less"
        raise ModelFileError(f"{what} is {quoted(text)}; numbers {limit} are read")
    return values


def check_name(what: str, name: str, known: Collection[str]) -> None:
    """Refuse a name that does not exist; `what` says who gives it, and of what kind it is."""
    if name not in known:
        raise ModelFileError(f"{what} {quoted(name)} does not exist{did_you_mean(name, known)}")


def written(values: Iterable[float]) -> str:
    """Write numbers so that reading them gives the same ones.

    Examples
    --------
    >>> written([0.1, -2, 1e-7])
    '0.1 -2.0 1e-07'
    """
    return " ".join(repr(float(value)) for value in values)


def label(element: Element) -> str:
    """Return how messages call a named element, e.g. ``"joint 'elbow'"``."""
    return f"{element.tag} {quoted(element.get('name'))}"


def _is_plain_text(text: str) -> bool:
    # float() also reads 1_0 and the digits of other scripts, which no parser of URDF does.
    return text.isascii() and "_" not in text
