"""What reports tell of ranks and ellipsoids, as plain data: motions by the joints' names."""

from __future__ import annotations

from pmjac_pin.rates.ellipsoid import Ellipsoid
from pmjac_pin.rates.singularity import Singularity
from pmjac_pin.values.arrays import Array
from pmjac_pin.words.margin_tables import margins_told
from pmjac_pin.words.plain import told


def by_name(names: tuple[str, ...], columns: Array) -> list[dict[str, float]]:
    """Return motions, the columns of an array, by the names of the joints."""
    return [dict(zip(names, column, strict=True)) for column in columns.T.tolist()]


def singularity_told(found: Singularity, length: float) -> dict[str, object]:
    """Return what is told of the ranks at a pose, motions by the joints' names.

    `length`, in m, is what makes radians and metres comparable in it.
    """
    return {
        **told(found, "kind", "in_words"),
        "types": found.types.present,
        **told(
            found.types, "gosselin_angeles", "constraint_singularity", "architecture_singularity"
        ),
        **told(found, "singular_values", "smallest", "condition", "tolerance"),
        "characteristic_length": length,
        **told(found, "rank", "generic_rank", "constraint_rank", "generic_constraint_rank"),
        "tool_rows": found.tool_rows.names,
        "tool_axes": found.tool_rows.axes,
        **told(found, "tool_rank", "generic_tool_rank", "idle", "gained", "lost"),
        "free_motions": by_name(found.passive_names, found.free_motions),
        "idle_motions": by_name(found.passive_names, found.idle_motions),
        "forbidden_rates": by_name(found.actuated_names, found.forbidden_rates),
        "free_screws": [told(one, "direction", "point", "pitch") for one in found.free_screws],
        "lost_screws": [told(one, "direction", "point", "pitch") for one in found.lost_screws],
        "margins": margins_told(found.margins),
    }


def ellipsoid_told(ellipsoid: Ellipsoid) -> dict[str, object]:
    """Return what is told of an ellipsoid: `directions` has an axis in each of its rows."""
    return {
        **told(ellipsoid, "unit", "motor_unit", "rank", "radii"),
        "directions": ellipsoid.axes.T,
    }
