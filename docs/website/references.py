"""A Sphinx extension: where names in docstrings lead.

A name in single backticks leads to its page, where it has one; else it stays a plain literal. What
starts with the name of something public has to have one, so that no docstring names a method that
is gone. Types in signatures are known by the module that defines them: they lead to their public
names, and those from elsewhere nowhere, since nothing is fetched from the network.

Stars and bars of formulas, J* and |x|, stay what they are.
"""

from __future__ import annotations

import inspect
import re
from typing import Any

from docutils import nodes
from sphinx.addnodes import pending_xref
from sphinx.application import Sphinx
from sphinx.environment import BuildEnvironment
from sphinx.transforms.post_transforms import SphinxPostTransform

import pmjac_pin as pj

PUBLIC = frozenset(pj.__all__)


def public_name(target: str) -> str | None:
    """Return a name as the site knows it, None where it claims to be nothing public."""
    parts = target.removesuffix("()").split(".")
    if parts[0] in PUBLIC and (len(parts) == 1 or inspect.isclass(getattr(pj, parts[0]))):
        return ".".join(["pmjac_pin", *parts])
    if parts[0] == "pj":
        return ".".join(["pmjac_pin", *parts[1:]])
    if parts[0] == "pmjac_pin" and parts[-1] in PUBLIC:
        return f"pmjac_pin.{parts[-1]}"
    return None


def resolved(
    app: Sphinx, env: BuildEnvironment, node: pending_xref, contnode: nodes.TextElement
) -> nodes.Node | None:
    """Return a link, or the words themselves; None, which is a warning, where neither is right."""
    if node.get("refdomain") != "py":
        return None
    name = public_name(node["reftarget"])
    if name is None:
        return contnode
    domain: Any = env.domains["py"]
    found = domain.resolve_xref(
        env, node["refdoc"], app.builder, "obj", name, _without_scope(node), contnode
    )
    return found if isinstance(found, nodes.Node) else None


def _without_scope(node: pending_xref) -> pending_xref:
    """Return the reference as it would stand outside any class and module."""
    free = node.deepcopy()
    free.attributes.pop("py:module", None)
    free.attributes.pop("py:class", None)
    return free


class WholeNames(SphinxPostTransform):
    """Takes no reference for the end of a longer name, as types in field lists are taken."""

    default_priority = 5  # before references are resolved

    def run(self, **kwargs: Any) -> None:
        """Forget that it may be."""
        for node in self.document.findall(pending_xref):
            node.attributes.pop("refspecific", None)


#: Literals, names and words that are emphasised, which stay; or a mark, which is escaped.
_MARK = re.compile(r"``.+?``|`[^`]+`|(?<![\w)*])\*{1,2}[A-Za-z][\w ]*\*{1,2}(?!\w)|([*|])")


def escaped(line: str) -> str:
    """Return a line of prose whose stars and bars start nothing."""
    return _MARK.sub(lambda found: "\\" + found[0] if found[1] else found[0], line)


def keep_formulas(
    _app: Sphinx, _what: str, _name: str, _value: object, _options: object, lines: list[str]
) -> None:
    """Escape the prose of a docstring; examples stay as they are."""
    example = False
    for number, line in enumerate(lines):
        example = line.lstrip().startswith(">>>") or (example and bool(line.strip()))
        if not example:
            lines[number] = escaped(line)


def without_private(
    _app: Sphinx, _what: str, _name: str, _value: object, _options: object, told: str, back: str
) -> tuple[str, str]:
    """Tell no parameters of what is not made by calling it."""
    return ("", "") if (told or "").startswith("(_") else (told, back)


def setup(app: Sphinx) -> dict[str, bool]:
    """Register it."""
    app.connect("missing-reference", resolved)
    app.connect("autodoc-process-docstring", keep_formulas, priority=400)  # before napoleon
    app.connect("autodoc-process-signature", without_private)
    app.add_post_transform(WholeNames)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
