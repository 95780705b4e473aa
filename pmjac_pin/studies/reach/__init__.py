"""Reach: which motor values put a tool at a target, and all of them."""
