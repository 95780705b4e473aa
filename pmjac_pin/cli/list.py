"""``pmjac list``."""

from __future__ import annotations

from pmjac_pin.cli.output import Output
from pmjac_pin.files.catalog import list_mechanisms
from pmjac_pin.files.catalogue_numbers import MechanismNumbers, kept_numbers
from pmjac_pin.words.catalogue_table import catalogue_table, numbers_of, poses_table


def list_command() -> Output:
    """Show the mechanisms that come with the library, and their poses."""
    kept = kept_numbers()
    mechanisms = [kept.get(name) or _computed(name) for name in list_mechanisms()]
    return [catalogue_table(mechanisms), poses_table(mechanisms)]


def _computed(name: str) -> MechanismNumbers:
    from pmjac_pin.loading import load  # noqa: PLC0415 (reads models)

    return numbers_of(load(name))
