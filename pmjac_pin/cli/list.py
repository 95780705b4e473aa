"""``pmjac list``."""

from __future__ import annotations

from msgspec.structs import asdict

from pmjac_pin.cli.output import Json, Output
from pmjac_pin.files.catalog import list_mechanisms
from pmjac_pin.files.catalogue_numbers import MechanismNumbers, kept_numbers
from pmjac_pin.words.catalogue_table import catalogue_table, numbers_of, poses_table


def list_command(*, json: Json = False) -> Output:
    """Show the mechanisms that come with the library, and their poses."""
    kept = kept_numbers()
    mechanisms = [kept.get(name) or _computed(name) for name in list_mechanisms()]
    if json:
        return {one.name: asdict(one) for one in mechanisms}
    return [catalogue_table(mechanisms), poses_table(mechanisms)]


def _computed(name: str) -> MechanismNumbers:
    from pmjac_pin.loading import load  # noqa: PLC0415 (reads models)

    return numbers_of(load(name))
