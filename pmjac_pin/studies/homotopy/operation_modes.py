"""OperationModes: which solutions hang together while the motors move.

The solutions of a mechanism over all its motor values are a variety whose irreducible components
of full dimension are its operation modes: a real machine can pass from one to another only where
they meet, at a singularity. Over a random line of motor values each of them is one irreducible
curve; `monodromy` finds which points are on the same, and the trace says whether a set is whole.

References
----------
.. [1] J. Schadlbauer, D. R. Walter, M. L. Husty: The 3-RPS parallel manipulator from an algebraic
   viewpoint. Mechanism and Machine Theory 75 (2014).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from pmjac_pin.errors import ArgumentError
from pmjac_pin.studies.evidence import Evidence
from pmjac_pin.studies.homotopy.complex_modes import ComplexModes
from pmjac_pin.studies.homotopy.curve import Curve, machine_plane, place_of
from pmjac_pin.studies.homotopy.machines import Line, Machine
from pmjac_pin.studies.homotopy.monodromy import STRAIGHT, PlaneSection, grown_whole
from pmjac_pin.studies.homotopy.polynomial_loops import PolynomialLoops
from pmjac_pin.values.arrays import Complex, Index


@dataclass(frozen=True, eq=False)
class OperationModes:
    """The operation modes of a mechanism.

    Attributes
    ----------
    sizes : tuple of int
        How many of the solutions, complex ones too, belong to each; most first.
    labels : tuple of int
        For each solution of the random machine, the index of its operation mode.
    bends : tuple of float
        How far the trace of each one's points is from a straight line, relative to its terms.
    evidence : Evidence
        What it rests on that these sets are whole and that no finer ones are.
    key : int
        Of the homotopy whose solutions they are.
    """

    sizes: tuple[int, ...]
    labels: tuple[int, ...]
    bends: tuple[float, ...]
    evidence: Evidence
    key: int = 0

    def of(self, modes: ComplexModes) -> tuple[int, ...]:
        """Return the index of the operation mode of each of `modes.real`.

        Raises
        ------
        ArgumentError
            They are no `ComplexModes` of the same homotopy.
        """
        if getattr(modes, "key", None) != self.key:
            raise ArgumentError("operation modes are known of the same homotopy's ComplexModes")
        return tuple(self.labels[index] for index in modes.generic)

    def __len__(self) -> int:
        return len(self.sizes)


def find_operation_modes(
    loops: PolynomialLoops,
    machine: Machine,
    solutions: Complex,
    rng: np.random.Generator,
    most_rounds: int,
) -> OperationModes:
    """Find the operation modes; see `ParameterHomotopy.operation_modes`."""
    both = np.vstack([twin for one in solutions for twin in loops.twins(one)] or [solutions])
    owner = np.repeat(np.arange(len(solutions)), len(both) // max(1, len(solutions)))
    curve = Curve(Line(loops, machine, machine.near(rng)))
    here = machine_plane(0.0, loops.count, len(both))
    points = np.hstack([both, np.zeros((len(both), 1))])
    section, places = _led_into(curve, points, here, rng)
    section, labels, bends = grown_whole(section, PlaneSection.components, rng, most_rounds)
    return _sorted(owner, places, labels, bends, len(solutions))


def _led_into(
    curve: Curve, points: Complex, here: Complex, rng: np.random.Generator
) -> tuple[PlaneSection, Index]:
    """Return a section with a random plane that the points were led into, and where they are."""
    section = PlaneSection.through(curve, points[0], rng)
    moved, arrived = curve.walk(points, here, section.planes(count=len(points)))
    section = section.with_points(moved[arrived])
    places = np.full(len(points), -1)
    for index in np.flatnonzero(arrived):
        if (place := place_of(moved[index], section.points)) is not None:
            places[index] = place
    return section, places


def _sorted(
    owner: Index, places: Index, labels: Index, bends: list[float], count: int
) -> OperationModes:
    """Return the operation modes of solutions, of which each may own several points."""
    sets = labels.max(initial=-1) + 1
    met = places >= 0
    pairs = (np.ones(int(met.sum())), (owner[met], count + labels[places[met]]))
    graph = coo_array(pairs, shape=(count + sets, count + sets))
    _, parts = connected_components(graph, directed=False)
    found, sizes = np.unique(parts[:count], return_counts=True)
    order = found[np.argsort(-sizes, kind="stable")]
    own = [
        max((bends[i] for i in range(sets) if parts[count + i] == one), default=np.inf)
        for one in order
    ]
    return OperationModes(
        sizes=tuple(int(size) for size in np.sort(sizes)[::-1]),
        labels=tuple(int(np.flatnonzero(order == part)[0]) for part in parts[:count]),
        bends=tuple(float(bend) for bend in own),
        evidence=_trace_evidence(own),
    )


def _trace_evidence(bends: list[float]) -> Evidence:
    worst = max(bends, default=np.inf)
    if worst < STRAIGHT:
        sets = "its one set" if len(bends) == 1 else f"each of the {len(bends)} sets"
        return Evidence("tolerance", f"the trace of {sets} of points is straight to {worst:.1g}")
    bent = f"the trace of a set of points is bent by {worst:.1g}: it is not whole"
    return Evidence("nothing", bent)
