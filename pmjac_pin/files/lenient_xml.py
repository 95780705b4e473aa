"""XML that the parsers of robots read though it is not well-formed, made so.

TinyXML, which URDF and MJCF are read with elsewhere, knows nothing of namespaces, takes blank
lines before the declaration, and two hyphens within a comment.
"""

from __future__ import annotations

import re

_LATE_DECLARATION = re.compile(r"\A(\s++)<\?xml\s[^>]*+>")
_ROOT_ELEMENT = re.compile(r"\A(?:\s++|<\?.*?\?>|<!--.*?-->)*+<[^\s/>!?]++", re.DOTALL)
_PREFIX = re.compile(r"""<([A-Za-z_][\w.-]*+):|\s([A-Za-z_][\w.-]*+):[\w.-]++\s*+=\s*+["']""")
_RESERVED_PREFIXES = ("xml", "xmlns")
_COMMENT = "<!--"
_SPANS = {_COMMENT: "-->", "<![CDATA[": "]]>", "<?": "?>"}  # beside tags
_TAG = re.compile(r"""[^<>"']*+(?:"[^"]*+"[^<>"']*+|'[^']*+'[^<>"']*+)*+>""")


def without_late_declaration(text: str) -> str:
    r"""Return XML without its declaration where that does not stand at its very start.

    Examples
    --------
    >>> without_late_declaration('\n<?xml version="1.0"?><robot/>')
    '\n<robot/>'
    """
    return _LATE_DECLARATION.sub(r"\1", text, count=1)


def with_prefixes_bound(text: str) -> str:
    """Return XML whose root binds the prefixes that nobody does, each to its own name.

    Examples
    --------
    >>> with_prefixes_bound("<robot><drake:mimic/></robot>")
    '<robot xmlns:drake="drake"><drake:mimic/></robot>'
    """
    if (start := _ROOT_ELEMENT.match(text)) is None:
        return text
    root = text[start.end() : text.find(">", start.end())]
    found = {one or other for one, other in _PREFIX.findall(text)}
    unbound = [
        name for name in sorted(found - {*_RESERVED_PREFIXES}) if f"xmlns:{name}" not in root
    ]
    bound = "".join(f' xmlns:{name}="{name}"' for name in unbound)
    return text[: start.end()] + bound + text[start.end() :]


def with_plain_comments(text: str) -> str:
    r"""Return XML with nothing in its comments but their ends of lines.

    A comment ends where the first ``-->`` is, whatever hyphens it holds. Nothing else is touched:
    what looks like one within a tag, CDATA or a processing instruction is none.

    Examples
    --------
    >>> with_plain_comments("<a><!-- b -- c ---><b d='<!-- -->'/></a>")
    "<a><b d='<!-- -->'/></a>"
    """
    pieces, at = [], 0
    while (start := text.find("<", at)) >= 0:
        opening = next((opening for opening in _SPANS if text.startswith(opening, start)), "<")
        end = _end(text, start + len(opening), _SPANS.get(opening))
        if end is None:
            break  # what does not end is no XML for anybody
        if opening == _COMMENT:
            pieces += [text[at:start], "\n" * text.count("\n", start, end)]
        else:
            pieces.append(text[at:end])
        at = end
    return "".join([*pieces, text[at:]])


def _end(text: str, start: int, closing: str | None) -> int | None:
    """Return where a span ends; a tag, whose quotes may hold anything, where nothing closes it."""
    if closing is None:
        found = _TAG.match(text, start)
        return found.end() if found else None
    place = text.find(closing, start)
    return None if place < 0 else place + len(closing)
