"""The six singularity types of Zlatanov, Fenton and Benhabib, counted on what loops allow.

With v = (θ̇, φ̇), the motions at a pose are {v : K θ̇ + K* φ̇ = 0}, and t = J θ̇ + J* φ̇ is what each
of them does to the tool. Five dimensions say all:

    a    of all motions,                      dim null [K K*]
    p    of those with θ̇ = 0,                 dim null K*
    r    of the tool's twists t,              rank of [J J*] on null [K K*]
    z    of those with θ̇ = 0 and t = 0,       dim null [K*; J*]
    a−p  of the motor rates that are possible; a−r of the motions with t = 0.

A type is present where its dimension is more (or, of what becomes impossible, less) than generic:

    RI    θ̇ ≠ 0 with t = 0        (a − r) − z  more
    RO    t ≠ 0 with θ̇ = 0        p − z        more
    RPM   φ̇ ≠ 0 with θ̇ = t = 0    z            more
    II    a θ̇ that is impossible  a − p        less
    IO    a t that is impossible  r            less
    IIM   more motions at all     a            more

So that, of the differences with their signs, IIM + II = RO + RPM and IIM + IO = RI + RPM.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, NamedTuple, TypeAlias

ZlatanovType: TypeAlias = Literal["RI", "RO", "RPM", "II", "IO", "IIM"]
GosselinAngelesType: TypeAlias = Literal["I", "II", "III"]

#: What each type is called.
TYPE_NAMES: dict[ZlatanovType, str] = {
    "RI": "redundant input",
    "RO": "redundant output",
    "RPM": "redundant passive motion",
    "II": "impossible input",
    "IO": "impossible output",
    "IIM": "increased instantaneous mobility",
}


class MotionDimensions(NamedTuple):
    """Dimensions of what the loops allow, at one pose or generically.

    Attributes
    ----------
    allowed : int
        Of all motions: a.
    locked : int
        Of those with all motors locked: p.
    tool : int
        Of the tool's twists on the judged rows: r.
    unfelt : int
        Of the motions with all motors locked that leave these rows at rest: z.
    twist : int
        Of the tool's twists on all six rows.
    """

    allowed: int
    locked: int
    tool: int
    unfelt: int
    twist: int

    def counts(self) -> dict[ZlatanovType, int]:
        """Return the dimension that decides each type; of what is possible, less than 0."""
        resting = self.allowed - self.tool
        return {
            "RI": resting - self.unfelt,
            "RO": self.locked - self.unfelt,
            "RPM": self.unfelt,
            "II": self.locked - self.allowed,
            "IO": -self.tool,
            "IIM": self.allowed,
        }


@dataclass(frozen=True, slots=True)
class SingularityTypes:
    """By how much what loops allow at a pose differs from what they allow generically.

    Attributes
    ----------
    here, generic : MotionDimensions
    motors : int

    Examples
    --------
    A slider-crank driven by its slider, at a dead point: the crank may turn while the slider, which
    cannot move, is locked.

    >>> here = MotionDimensions(allowed=1, locked=1, tool=1, unfelt=0, twist=1)
    >>> types = SingularityTypes(here, MotionDimensions(1, 0, 1, 0, 1), 1)
    >>> types.present, types.gosselin_angeles
    (('RO', 'II'), 'II')
    """

    here: MotionDimensions
    generic: MotionDimensions
    motors: int

    @property
    def counts(self) -> dict[ZlatanovType, int]:
        """The difference that decides each type, more than 0 where it is present.

        Less than 0 where what is impossible or at rest generically is not so here.
        """
        generic = self.generic.counts()
        return {name: count - generic[name] for name, count in self.here.counts().items()}

    @property
    def present(self) -> tuple[ZlatanovType, ...]:
        """The types that the pose has, in the order of `TYPE_NAMES`."""
        return tuple(name for name, count in self.counts.items() if count > 0)

    @property
    def gosselin_angeles(self) -> GosselinAngelesType | None:
        """The kind in the input-output equation A t + B θ̇ = 0, None where it sees none.

        "I" where motors can move with the tool at rest (RI), "II" where the tool can move with the
        motors at rest (RO), "III" where both are. A motion of passive joints alone (RPM) is in
        none of its matrices.
        """
        serial, parallel = self.counts["RI"] > 0, self.counts["RO"] > 0
        if serial and parallel:
            return "III"
        if serial:
            return "I"
        return "II" if parallel else None

    @property
    def constraint_singularity(self) -> bool:
        """Whether the tool gains a freedom that no motor can take away, were all joints motors.

        The wrenches that the legs' joints transmit whatever the motors do depend on each other: of
        all motions there are more, and of the tool's twists, all six rows.
        """
        return self.counts["IIM"] > 0 and self.here.twist > self.generic.twist

    @property
    def architecture_singularity(self) -> bool:
        """Whether the machine is singular at every pose: RO and II generically.

        The tool moves with all motors locked though there are enough of them: these are tied to
        each other at every pose, by the machine's dimensions or by where its motors are.
        """
        generic = self.generic
        possible = generic.allowed - generic.locked
        return generic.locked > generic.unfelt and possible < self.motors

    @property
    def in_words(self) -> str:
        """One sentence that names all of it."""
        names = [f"{TYPE_NAMES[name]} ({name})" for name in self.present]
        parts = [] if self.gosselin_angeles is None else [f"type {self.gosselin_angeles}"]
        parts += names
        if self.constraint_singularity:
            parts.append("a constraint singularity")
        if self.architecture_singularity:
            parts.append("an architecture singularity, as at every pose")
        return ", ".join(parts) or "none"
