"""Jacobians, ellipsoids and singularities as each shows itself."""

from __future__ import annotations

from collections.abc import Iterator

from pmjac_pin.rates.allowed import AllowedJacobian
from pmjac_pin.rates.ellipsoid import Ellipsoid
from pmjac_pin.rates.jacobian import EquivalentJacobian
from pmjac_pin.rates.singularity import Singularity
from pmjac_pin.rates.split import SplitJacobian
from pmjac_pin.words.blocks import Block, Heading, Paragraph
from pmjac_pin.words.matrices import matrices_of
from pmjac_pin.words.singularity_tables import singularity_blocks
from pmjac_pin.words.tables import (
    ALLOWED_TITLES,
    LEGEND,
    TITLES,
    ellipsoid_table,
    motors_told,
    titled_matrices,
)


def jacobian_blocks(jacobian: SplitJacobian) -> Iterator[Block]:
    """Show J_eq, or what there is before the passive rates are eliminated."""
    yield Heading(f"Frame of the tool's twist: {jacobian.frame}")
    if not jacobian.partition.units:
        yield Paragraph(f"{jacobian!r}: matrices from elsewhere, without names and units.")
        return
    yield Paragraph(LEGEND)
    yield from titled_matrices(matrices_of(jacobian), _titles(jacobian))


def _titles(jacobian: SplitJacobian) -> dict[str, str]:
    if isinstance(jacobian, AllowedJacobian):
        return ALLOWED_TITLES
    if isinstance(jacobian, EquivalentJacobian):
        return {name: TITLES[name] for name in ("Jv_eq", "Jw_eq")}
    return {name: TITLES[name] for name in ("K", "K_star", "Jv", "Jv_star", "Jw", "Jw_star")}


def principal_blocks(ellipsoid: Ellipsoid) -> Iterator[Block]:
    """Show the radii and the directions of an ellipsoid."""
    yield Heading(f"Ellipsoid of rank {ellipsoid.rank}{motors_told(ellipsoid)}")
    yield ellipsoid_table("", ellipsoid)


def rank_blocks(singularity: Singularity) -> Iterator[Block]:
    """Show the ranks at a pose and the motions that are free there."""
    yield Heading(f"Singularity: {singularity.kind}")
    yield from singularity_blocks(singularity)
