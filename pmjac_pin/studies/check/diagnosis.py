"""Diagnosis: what `pmjac check` knows about a model, as plain data with names and units.

The structs are what ``pmjac check --json`` writes: their attributes are its keys. What needs
closed loops is None where the home pose does not assemble.
"""

from __future__ import annotations

from typing import Literal

import msgspec

from pmjac_pin.model.tool_rows import ToolRows, checked_axes
from pmjac_pin.studies.check.diagnosis_parts import BodyEntry, FreedomEntry, LoopEntry, Mobility
from pmjac_pin.studies.evidence import Evidence
from pmjac_pin.values.shown import Printed

Severity = Literal["ok", "note", "warning", "error"]
Rates = dict[str, float]


class Finding(msgspec.Struct, frozen=True):
    """One thing that the check found.

    Attributes
    ----------
    severity : {"ok", "note", "warning", "error"}
        "error": there is no J_eq, or a pose of the file does not exist; "warning": probably not
        what was meant; "note": good to know.
    code : str
        A short name that stays the same, for scripts.
    message : str
    advice : str
        What to do about it; empty where there is nothing to do.
    """

    severity: Severity
    code: str
    message: str
    advice: str = ""


class Failure(msgspec.Struct, frozen=True):
    """Why a pose, or the whole mechanism, could not be built.

    Attributes
    ----------
    code : str
        "open", "outside-limits" or "not-built".
    message : str
    loop : str or None
        The loop that stays open most.
    gap : float or None
        The smallest gap of all loops that was found, m.
    """

    code: str
    message: str
    loop: str | None = None
    gap: float | None = None


class DependentRow(msgspec.Struct, frozen=True):
    """A row of the loop equations that follows from others; from none where it is zero."""

    row: str
    follows_from: tuple[str, ...]


class Redundancy(msgspec.Struct, frozen=True):
    """Redundant rows in general, p − r = Σ (pᵢ − rᵢ) + (Σ rᵢ − r).

    Attributes
    ----------
    rows : int
        How many.
    inside, between : int
        Rows that follow from others of the same loop; and from other loops.
    dependent : tuple of DependentRow
        A choice of so many rows that follow from the rest.
    """

    rows: int
    inside: int
    between: int
    dependent: tuple[DependentRow, ...]


class FreeMotion(msgspec.Struct, frozen=True):
    """A passive motion that is possible with all motors locked.

    Attributes
    ----------
    rates : dict of str to float
        By degree of freedom, m/s or rad/s, largest 1.
    bodies : tuple of str
        What moves.
    felt : bool
        Whether the tool moves.
    tool_linear, tool_angular : float
        How fast, m/s and rad/s.
    """

    rates: Rates
    bodies: tuple[str, ...]
    felt: bool
    tool_linear: float
    tool_angular: float


class ActuationEntry(msgspec.Struct, frozen=True):
    """What the motors command in general: at home or, where that is singular, near it.

    Attributes
    ----------
    motors : int
    allowed_rates : tuple of dict
        They span the motor rates that the loops allow.
    forbidden_rates : tuple of dict
        Orthonormal motor rates that the loops forbid.
    sufficient : tuple of str
        Motors whose rates determine those of the others.
    idle : int
        Passive motions that are free at every pose.
    gained : int
        Those that come free at home only, a singularity.
    free_motions : tuple of FreeMotion
        They span the idle ones.
    felt : int
        Dimension of the tool twists that the free motions make.
    """

    motors: int
    allowed_rates: tuple[Rates, ...]
    forbidden_rates: tuple[Rates, ...]
    sufficient: tuple[str, ...]
    idle: int
    gained: int
    free_motions: tuple[FreeMotion, ...]
    felt: int


class PoseEntry(msgspec.Struct, frozen=True):
    """A named pose.

    Attributes
    ----------
    name : str
    gap_given : float
        How open it is in the file, m.
    moved : dict of str to float or None
        How far each degree of freedom had to move to close it.
    kind : str or None
        Of singularity; "regular" for none.
    smallest, condition : float or None
        The singular value of the dimensionless K* that decides, relative to the size of [K K*];
        and the largest over it. Infinite (null in JSON) without loops, or singular.
    failure : Failure or None
        Why it does not assemble.
    beyond : dict of str to str
        The joints that are outside their limits where it closes, and the words for it.
    """

    name: str
    gap_given: float
    moved: Rates | None
    kind: str | None
    smallest: float | None
    condition: float | None
    failure: Failure | None
    beyond: dict[str, str] = {}


class Diagnosis(Printed, msgspec.Struct, frozen=True, kw_only=True):
    """What there is to know about a model before its numbers are trusted; it prints as a page.

    Attributes
    ----------
    mechanism, description : str
    findings : tuple of Finding
        The worst first.
    failure : Failure or None
        Why the mechanism could not be built; the rest is then what was known by then.
    bodies : tuple of Body
    freedoms : tuple of Freedom
        Motors first.
    tool : tuple of str
        The frame, or the three whose origins span it.
    tool_rows : tuple of str
        The rows of its twist that are judged, of vx, vy, vz, wx, wy and wz.
    tool_axes : str
        Their axes: LOCAL_WORLD_ALIGNED, the world's, or LOCAL, the tool's own.
    tool_rank : int or None
        How many independent velocities the loops allow these rows in general.
    loops : tuple of LoopEntry
    mobility : Mobility
    evidence : Evidence
        What mobility and ranks rest on.
    redundancy : Redundancy or None
    actuation : ActuationEntry or None
    poses : tuple of PoseEntry
    characteristic_length : float
        In m: what makes radians and metres comparable.
    tolerance : float or None
        The gap in m that the model file calls closed.
    far : float or None
        How far from the world's origin the mechanism stands, m, where that costs digits.
    closed : float
        The gap in m up to which loops count as closed.
    rounding : float or None
        How far the loops stay open, m, at the poses near home, where none closes but for so little
        that rounded numbers are the cause.
    notes : tuple of str
        What the reader of another format decided, and what it does not know.
    unread : tuple of str
        Those of the notes that name what nobody reads.
    """

    mechanism: str
    description: str
    findings: tuple[Finding, ...] = ()
    failure: Failure | None
    bodies: tuple[BodyEntry, ...]
    freedoms: tuple[FreedomEntry, ...]
    tool: tuple[str, ...]
    tool_rows: tuple[str, ...]
    tool_axes: str
    tool_rank: int | None
    loops: tuple[LoopEntry, ...]
    mobility: Mobility
    evidence: Evidence
    redundancy: Redundancy | None
    actuation: ActuationEntry | None
    poses: tuple[PoseEntry, ...]
    characteristic_length: float
    tolerance: float | None
    far: float | None
    closed: float
    rounding: float | None = None
    notes: tuple[str, ...] = ()
    unread: tuple[str, ...] = ()

    @property
    def judged(self) -> ToolRows:
        """The rows of the tool's twist that are judged, with their axes."""
        return ToolRows(self.tool_rows, checked_axes(self.tool_axes))

    @property
    def severity(self) -> Severity:
        """The worst of all findings."""
        return self.findings[0].severity if self.findings else "ok"
