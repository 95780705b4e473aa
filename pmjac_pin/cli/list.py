"""``pmjac list``."""

from __future__ import annotations

from pmjac_pin.cli.output import Output
from pmjac_pin.files.catalog import list_mechanisms
from pmjac_pin.loading import load
from pmjac_pin.words.catalogue_table import catalogue_table, poses_table


def list_command() -> Output:
    """Show the mechanisms that come with the library, and their poses."""
    mechanisms = [load(name) for name in list_mechanisms()]
    return [catalogue_table(mechanisms), poses_table(mechanisms)]
