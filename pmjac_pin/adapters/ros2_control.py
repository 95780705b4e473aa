"""For ros2_control: a transmission as a plugin in C++, around the C header of its table."""

from __future__ import annotations

from pathlib import Path
from string import Template

from pmjac_pin.algebra.program_text import C_WORDS, function_name, in_comment
from pmjac_pin.errors import ArgumentError, quoted
from pmjac_pin.studies.transmissions.transmission_table import TransmissionTable
from pmjac_pin.values.checks import check_kind

_PLUGIN_SOURCE = Path(__file__).with_name("ros2_control.cpp")


def source(table: TransmissionTable, header: str, name: str | None = None) -> str:
    """Return a C++ file: a ``transmission_interface::Transmission`` and its loader.

    Position, velocity and effort, both ways, at the pose of the positions: θ̇ = R ẋ, τ_x = Rᵀ τ.
    Actuators have a `mechanical_reduction`, joints an `offset`, as in ros2_control.

    Parameters
    ----------
    table : TransmissionTable
    header : str
        The file of `table.c(name)`, as it is included.
    name : str, optional
        What the names in the header begin with; by default the mechanism's.

    Raises
    ------
    ArgumentError
        A name that C does not allow, or a header that cannot be included.

    Examples
    --------
    >>> import pmjac_pin as pj
    >>> from pmjac_pin.adapters import ros2_control
    >>> table = pj.transmission_table(pj.load("four_bar"), {"phi1": (2.2, 2.4)}, points=5)
    >>> text = ros2_control.source(table, "rocker.h", "rocker")
    >>> text.splitlines()[0]
    '// theta1 to phi1 for ros2_control: a plugin of type "rocker_transmission".'
    """
    check_kind(table, TransmissionTable)
    if not isinstance(header, str) or not header or set(header) & set('"\\\n'):
        raise ArgumentError(f"header is the name of a file to include; got {quoted(header)}")
    mechanism = table.transmission.by_motors.name
    prefix = function_name(mechanism if name is None else name, C_WORDS, name is None)
    return Template(_PLUGIN_SOURCE.read_text(encoding="utf-8")).substitute(
        type=f"{prefix}_transmission",
        name=prefix,
        NAME=prefix.upper(),
        header=header,
        count=len(table.joints),
        joints=in_comment(", ".join(table.joints)),
        motors=in_comment(", ".join(table.motors)),
    )
