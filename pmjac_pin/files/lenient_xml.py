"""XML that the parsers of robots read though it is not well-formed, made so; or why it is not.

TinyXML, which URDF and MJCF are read with elsewhere, knows nothing of namespaces, takes blank
lines before the declaration, and two hyphens within a comment.
"""

from __future__ import annotations

import re
from xml.etree.ElementTree import ParseError

_LATE_DECLARATION = re.compile(r"\A(\s++)<\?xml\s[^>]*+>")
_ROOT = re.compile(r"\A(?:\s++|<\?.*?\?>|<!--.*?-->)*+<[^\s/>!?]++", re.DOTALL)
_PREFIX = re.compile(r"""<([A-Za-z_][\w.-]*+):|\s([A-Za-z_][\w.-]*+):[\w.-]++\s*+=\s*+["']""")
_RESERVED = ("xml", "xmlns")
_COMMENT, _END_OF_COMMENT = "<!--", "-->"


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
    if (start := _ROOT.match(text)) is None:
        return text
    root = text[start.end() : text.find(">", start.end())]
    found = {one or other for one, other in _PREFIX.findall(text)}
    unbound = [name for name in sorted(found - {*_RESERVED}) if f"xmlns:{name}" not in root]
    bound = "".join(f' xmlns:{name}="{name}"' for name in unbound)
    return text[: start.end()] + bound + text[start.end() :]


def why_not_well_formed(text: str, error: ParseError) -> str:
    """Return what is to be done, where a parser stopped within a comment; else nothing."""
    line, column = error.position
    before = "\n".join([*text.split("\n")[: line - 1], text.split("\n")[line - 1][:column]])
    opened = before.rfind(_COMMENT)
    if opened < 0 or _END_OF_COMMENT in before[opened:] or "--" not in before[opened + 4 :]:
        return ""
    return "; two hyphens side by side stand within a comment, where XML allows one"
