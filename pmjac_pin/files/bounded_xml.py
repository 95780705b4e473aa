"""A tree of XML elements that never grows beyond a limit, however large or deep the text is."""

from __future__ import annotations

import re
from xml.etree.ElementTree import Element, TreeBuilder

from defusedxml.ElementTree import DefusedXMLParser

from pmjac_pin.errors import ModelFileError

MAXIMAL_NESTING = 100  # elements within elements; a URDF has about ten
MAXIMAL_ELEMENTS = 100_000  # each takes a hundred times its text in memory, and checks take time
MAXIMAL_ATTRIBUTES = 1_000  # of one element
_PIECE = 1 << 20  # characters: what the parser is given before it may stop

# The parser tells of a tag once it has read all of it, so that long ones are looked at before.
_LONG_TAG = re.compile(rf"<[^!?<][^<]{{{4 * MAXIMAL_ATTRIBUTES},}}")
_VALUE = re.compile(r"""=\s*+["']""")


def bounded_tree(text: str) -> Element:
    """Parse XML without document types and entities.

    Raises
    ------
    ModelFileError
        More elements, deeper ones or more attributes than the limits allow.
    ParseError, DefusedXmlException
        No XML; a document type.
    """
    for tag in _LONG_TAG.finditer(text):
        if sum(1 for _ in _VALUE.finditer(tag[0])) > MAXIMAL_ATTRIBUTES:
            raise ModelFileError(f"an element has more than {MAXIMAL_ATTRIBUTES} attributes")
    parser = DefusedXMLParser(target=_BoundedBuilder(), forbid_dtd=True)
    for start in range(0, len(text), _PIECE):
        parser.feed(text[start : start + _PIECE])
    root: Element = parser.close()
    return root


class _BoundedBuilder(TreeBuilder):
    """Builds a tree, and refuses to go on beyond a limit."""

    def __init__(self) -> None:
        super().__init__()
        self._depth = self._count = 0

    def start(self, tag: str, attributes: dict[str, str], /) -> Element:
        self._depth += 1
        self._count += 1
        if self._depth > MAXIMAL_NESTING:
            raise ModelFileError(f"elements are nested more than {MAXIMAL_NESTING} deep")
        if self._count > MAXIMAL_ELEMENTS:
            raise ModelFileError(f"more than {MAXIMAL_ELEMENTS} elements are too many to be read")
        return super().start(tag, attributes)

    def end(self, tag: str, /) -> Element:
        self._depth -= 1
        return super().end(tag)
