"""Report: everything that is known at one pose, as plain data with names and units.

The structs say what there is, and are what ``pmjac report --json`` writes: their attributes
are its keys. `make_report` in `report_maker` fills them.
"""

from __future__ import annotations

import json
import re

import msgspec

from pmjac_pin.model.tool_rows import ToolRows, checked_axes
from pmjac_pin.words.labelled import LabelledMatrix

Vector = tuple[float, ...]


class Quantity(msgspec.Struct, frozen=True):
    """A number with its unit."""

    name: str
    value: float
    unit: str


class ParameterValue(msgspec.Struct, frozen=True):
    """A parameter of the mechanism."""

    name: str
    value: float
    unit: str
    meaning: str
    default: float


class JointValue(msgspec.Struct, frozen=True):
    """The value of one degree of freedom; its role is "actuated" or "passive"."""

    name: str
    role: str
    value: float
    unit: str


class BeyondLimits(msgspec.Struct, frozen=True):
    """A joint outside its limits."""

    name: str
    role: str
    value: float
    lower: float
    upper: float
    unit: str


class Dimensions(msgspec.Struct, frozen=True):
    """The sizes in the lecture's letters.

    Attributes
    ----------
    n, m_p : int
        Actuated and passive degrees of freedom.
    p, m : int
        Loop equations, and the independent ones that K and K* show.
    mobility : int or None
        None where no pose near home closes.
    nq, nv : int
    """

    n: int
    m_p: int
    p: int
    m: int
    mobility: int | None
    nq: int
    nv: int


class ToolPose(msgspec.Struct, frozen=True):
    """The tool in the world: position in m, rotation matrix row by row."""

    position: Vector
    rotation: tuple[Vector, ...]


class Matrices(msgspec.Struct, frozen=True, kw_only=True):
    """The lecture's matrices; None from `passive_rates` on where J_eq does not exist."""

    K: LabelledMatrix
    K_star: LabelledMatrix
    Jv: LabelledMatrix
    Jv_star: LabelledMatrix
    Jw: LabelledMatrix
    Jw_star: LabelledMatrix
    passive_rates: LabelledMatrix | None = None
    Jv_eq: LabelledMatrix | None = None
    Jw_eq: LabelledMatrix | None = None
    gv_eq: LabelledMatrix | None = None
    gw_eq: LabelledMatrix | None = None


class SingularValues(msgspec.Struct, frozen=True):
    """Singular values, descending; `unit` is None where rows or columns mix units."""

    values: Vector
    unit: str | None


class SingularityReport(msgspec.Struct, frozen=True, kw_only=True):
    """What `Singularity` says, motions by the joints' names.

    Attributes
    ----------
    kind : str
    singular_values : tuple of float
        Of the dimensionless K* on all rows, relative to the size of [K K*].
    smallest : float
        The one of them that decides; infinite without loops.
    condition, tolerance : float
    characteristic_length : float
        In m: what makes radians and metres comparable.
    rank, generic_rank : int
        Of K*, here and in general.
    constraint_rank, generic_constraint_rank : int
        Of [K K*].
    tool_rows : tuple of str
        The rows of the tool's twist that are judged, of vx, vy, vz, wx, wy and wz.
    tool_axes : str
        Their axes: LOCAL_WORLD_ALIGNED, the world's, or LOCAL, the tool's own.
    tool_rank, generic_tool_rank : int
        Dimension of the tool twists that the loops allow, on these rows.
    idle, gained, lost : int
    free_motions : tuple of dict
        Passive rates that come free here with the motors locked: a basis, the idle ones left out.
    idle_motions : tuple of dict
        A basis of the passive rates that are free at every pose.
    forbidden_rates : tuple of dict
        Orthonormal motor rates that the loops do not allow here.
    """

    kind: str
    singular_values: Vector
    smallest: float
    condition: float
    tolerance: float
    characteristic_length: float
    rank: int
    generic_rank: int
    constraint_rank: int
    generic_constraint_rank: int
    tool_rows: tuple[str, ...]
    tool_axes: str
    tool_rank: int
    generic_tool_rank: int
    idle: int
    gained: int
    lost: int
    free_motions: tuple[dict[str, float], ...]
    idle_motions: tuple[dict[str, float], ...]
    forbidden_rates: tuple[dict[str, float], ...]

    @property
    def judged(self) -> ToolRows:
        """The rows of the tool's twist that are judged, with their axes."""
        return ToolRows(self.tool_rows, checked_axes(self.tool_axes))


class EllipsoidReport(msgspec.Struct, frozen=True):
    """Principal values, descending, and the unit direction of each, in the report's frame."""

    unit: str
    rank: int
    radii: Vector
    directions: tuple[Vector, ...]


class Report(msgspec.Struct, frozen=True, kw_only=True):
    """What is known of a mechanism at one pose.

    Attributes
    ----------
    mechanism, description : str
    notes : tuple of str
        What the reader of a file of another format decided.
    parameters : tuple of ParameterValue
    dimensions : Dimensions
    pose : str or None
        The named pose; None where motor values were asked for.
    start : str or None
        The named pose from which the motors were walked to those values.
    frame : str
        Of the tool's twist, with Pinocchio's meaning.
    joints : tuple of JointValue
        Motors first.
    limits_violated : tuple of BeyondLimits
        The joints outside their limits: the loops close, but the machine cannot be there.
    iterations : int
        Newton iterations that closed the loops.
    residual : tuple of Quantity
        The p loop equations.
    residual_norm : float
        Euclidean norm of the gaps of all loops, m.
    tool : ToolPose
    matrices : Matrices
    det_K_star : Quantity or None
        None where K* is not square.
    singular_values : dict of str to SingularValues
        Of "K_star" as shown, of "Jv_eq" and "Jw_eq"; None where J_eq does not exist.
    singularity : SingularityReport
    ellipsoids : dict of str to EllipsoidReport
        "velocity", "angular", "force"; None where J_eq does not exist.
    refusal : str or None
        Why J_eq does not exist here.
    """

    mechanism: str
    description: str
    notes: tuple[str, ...]
    parameters: tuple[ParameterValue, ...]
    dimensions: Dimensions
    pose: str | None
    start: str | None
    frame: str
    joints: tuple[JointValue, ...]
    limits_violated: tuple[BeyondLimits, ...]
    iterations: int
    residual: tuple[Quantity, ...]
    residual_norm: float
    tool: ToolPose
    matrices: Matrices
    det_K_star: Quantity | None
    singular_values: dict[str, SingularValues | None]
    singularity: SingularityReport
    ellipsoids: dict[str, EllipsoidReport | None]
    refusal: str | None


def to_json(report: msgspec.Struct) -> str:
    """Write a report, or a diagnosis, as strict JSON in ASCII, one line for each of its attributes.

    JSON knows no infinity: infinite numbers become null. There are three: the radii of the
    force ellipsoid in directions that the structure bears by itself, and the singularity's
    `smallest` (no loops) and `condition` (singular).
    """
    lines = (
        f"{_json(field.encode_name)}: {_json(getattr(report, field.name))}"
        for field in msgspec.structs.fields(report)
    )
    return "{\n" + ",\n".join(lines) + "\n}"


def _json(value: object) -> str:
    # Units have superscripts, and a pipe may be unable to carry them. In JSON they can only
    # stand in strings, where an escape means the same.
    encoded = msgspec.json.encode(value).decode()
    return re.sub("[^\x00-\x7f]", lambda match: json.dumps(match[0])[1:-1], encoded)
