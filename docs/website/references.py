"""A Sphinx extension: where names in docstrings lead.

A name in single backticks leads to its page, where it has one; else it stays a plain literal. What
starts with the name of something public has to have one, so that no docstring names a method that
is gone. Types in signatures are known by the module that defines them: they lead to their public
names, and those from elsewhere nowhere, since nothing is fetched from the network.
"""

from __future__ import annotations

from typing import Any

from docutils import nodes
from sphinx.addnodes import pending_xref
from sphinx.application import Sphinx
from sphinx.environment import BuildEnvironment

import pmjac_pin as pj

PUBLIC = frozenset(pj.__all__)


def public_name(target: str) -> str | None:
    """Return a name as the site knows it, None where it claims to be nothing public."""
    parts = target.removesuffix("()").split(".")
    if parts[0] in PUBLIC:
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


def setup(app: Sphinx) -> dict[str, bool]:
    """Register it."""
    app.connect("missing-reference", resolved)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
