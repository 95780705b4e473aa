"""Readers of the formats that people have closed chains in; each gives a `ForeignModel`."""
