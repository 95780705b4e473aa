"""Names as text that any encoding of Unicode can write."""

from __future__ import annotations


def encodable(name: str) -> str:
    """Return a name as text: it may be that of a file, which may hold bytes that are none."""
    return name.encode("utf-8", "backslashreplace").decode()
