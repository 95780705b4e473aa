"""The assembly modes with names and units; ``pmjac modes --json`` writes what is told of them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pmjac_pin.closing.motor_values import MotorValues, motor_values
from pmjac_pin.configuration import Configuration
from pmjac_pin.mechanism import Mechanism
from pmjac_pin.rates.singularity import Singularity
from pmjac_pin.studies.certificates.certificate import Certificate, certify
from pmjac_pin.studies.homotopy.complex_modes import ComplexModes
from pmjac_pin.studies.homotopy.operation_modes import OperationModes
from pmjac_pin.studies.modes.assembly_modes import AssemblyModes
from pmjac_pin.studies.modes.names import pose_names
from pmjac_pin.studies.modes.recognition import Recognition
from pmjac_pin.values.encodable import encodable
from pmjac_pin.words.labelled_values import (
    LabelledJoint,
    Labels,
    Quantity,
    determinant,
    joint_values,
    labelled_motor_values,
    limits_told,
    parameters_told,
)
from pmjac_pin.words.plain import told


@dataclass(frozen=True, eq=False, kw_only=True)
class ModeReport:
    """What tells one assembly mode from the others.

    Attributes
    ----------
    configuration : Configuration
    number : int
        From 1, in the order in which the modes are always sorted.
    poses : tuple of str
        The named poses that it is.
    det_K_star : Quantity or None
        None where K* is not square.
    sign : int or None
        Of det K*, 0 at a singularity. None where K* is not square, or shows other loop equations
        than at home, so that signs cannot be compared.
    share : float
        The share of the random starts that led here.
    ways : int
        In how many ways its bodies fit: more than one where some turn over unseen.
    mirror_image : int or None
        Number of the mode that is its mirror image in the plane of the base.
    operation_mode : int or None
        Number of its operation mode, the one with most solutions first; None where it is unknown.
    certificate : Certificate
    """

    configuration: Configuration
    number: int
    poses: tuple[str, ...]
    det_K_star: Quantity | None
    sign: int | None
    share: float
    ways: int
    mirror_image: int | None
    operation_mode: int | None
    certificate: Certificate

    @property
    def singularity(self) -> Singularity:
        """The ranks here."""
        return self.configuration.singularity()

    def told(self) -> dict[str, object]:
        """Return it as plain data; `Mechanism.configuration` takes its q."""
        mode, certificate = self.configuration, self.certificate
        labels = Labels.of(mode.mechanism.problem.partition)
        return {
            **told(self, "number", "poses"),
            "tool": mode.tool_pose(),
            "joints": joint_values(mode, labels),
            "limits_violated": limits_told(mode, labels),
            **told(mode, "q", "residual_norm"),
            **told(self.singularity, "kind", "smallest"),
            **told(self, "det_K_star", "sign", "share", "ways", "mirror_image", "operation_mode"),
            "certificate": {
                "certified": bool(certificate),
                **told(certificate, "existence_radius", "uniqueness_radius", "evidence"),
            },
        }


@dataclass(frozen=True, eq=False, kw_only=True)
class ModesReport:
    """The assembly modes of a mechanism at given motor values.

    Attributes
    ----------
    mechanism : Mechanism
    motors : tuple of JointValue
    limits : bool
        Whether the joints had to be within their limits.
    found : AssemblyModes
    modes : tuple of ModeReport
    solutions : ComplexModes or None
        All complex solutions, where they were asked for.
    operation_modes : OperationModes or None
        Likewise.
    """

    mechanism: Mechanism
    motors: tuple[LabelledJoint, ...]
    limits: bool
    found: AssemblyModes
    modes: tuple[ModeReport, ...]
    solutions: ComplexModes | None
    operation_modes: OperationModes | None

    @property
    def name(self) -> str:
        """The mechanism's name."""
        return encodable(self.mechanism.name)

    def told(self) -> dict[str, object]:
        """Return all of it as plain data."""
        solutions = self.solutions
        return {
            "mechanism": self.name,
            "description": self.mechanism.spec.description,
            "parameters": parameters_told(self.mechanism),
            "characteristic_length": self.mechanism.characteristic_length,
            **told(self, "motors", "limits"),
            **told(self.found, "starts", "evidence"),
            "solutions": solutions and solutions_told(solutions, self.operation_modes),
            "modes": [mode.told() for mode in self.modes],
        }


def make_modes_report(
    mechanism: Mechanism,
    actuated: MotorValues,
    modes: AssemblyModes,
    *,
    limits: bool = True,
    solutions: ComplexModes | None = None,
    operation_modes: OperationModes | None = None,
) -> ModesReport:
    """Collect what is known of the assembly modes that were found.

    Parameters
    ----------
    mechanism : Mechanism
    actuated : array_like, shape (n,), or mapping of str to float
        The motor values, m or rad.
    modes : AssemblyModes
        Found at these; there may be none.
    limits : bool
        Whether the joints had to be within their limits.
    solutions : ComplexModes, optional
        At these motor values.
    operation_modes : OperationModes, optional
        Of the same homotopy.

    Examples
    --------
    >>> import pmjac_pin as pj
    >>> mechanism = pj.load("four_bar")
    >>> modes = pj.assembly_modes(mechanism, [0.9], rng=0)
    >>> [(m.number, m.poses, m.sign) for m in make_modes_report(mechanism, [0.9], modes).modes]
    [(1, (), -1), (2, ('home',), 1)]
    """
    values = motor_values(mechanism.spec, mechanism.coordinates, actuated)
    return ModesReport(
        mechanism=mechanism,
        motors=labelled_motor_values(values, Labels.of(mechanism.problem.partition)),
        limits=limits,
        found=modes,
        modes=_mode_reports(
            mechanism, modes, _operation_mode_numbers(modes, solutions, operation_modes)
        ),
        solutions=solutions,
        operation_modes=operation_modes,
    )


def solutions_told(
    found: ComplexModes, operation_modes: OperationModes | None
) -> dict[str, object]:
    """Return what is told of all complex solutions, and of how they hang together."""
    return {
        "count": found.count,
        "real": len(found.real),
        **told(found, "certified", "at_infinity", "singular"),
        "evidence": found.evidence,
        "operation_modes": operation_modes.sizes if operation_modes else (),
        "operation_evidence": operation_modes.evidence if operation_modes else None,
    }


def _operation_mode_numbers(
    modes: AssemblyModes, found: ComplexModes | None, operation_modes: OperationModes | None
) -> tuple[int | None, ...]:
    """Return the number of each mode's operation mode, from 1; None where it is unknown."""
    if found is None or operation_modes is None:
        return (None,) * len(modes)
    recognition, labels = Recognition(found.real), operation_modes.of(found)
    places = (recognition.index(mode) for mode in modes)
    return tuple(None if place is None else labels[place] + 1 for place in places)


def _mode_reports(
    mechanism: Mechanism, modes: AssemblyModes, numbers: tuple[int | None, ...]
) -> tuple[ModeReport, ...]:
    labels, names = Labels.of(mechanism.problem.partition), pose_names(mechanism, modes)
    rows = mechanism.home.split_jacobian().rows
    return tuple(
        ModeReport(
            configuration=mode,
            number=k + 1,
            poses=names[k],
            det_K_star=(det := determinant(mode.split_jacobian(), labels)),
            sign=_sign(mode, det, rows),
            share=modes.shares[k],
            ways=modes.ways[k],
            mirror_image=None if (image := modes.mirror_images[k]) is None else image + 1,
            operation_mode=numbers[k],
            certificate=certify(mode),
        )
        for k, mode in enumerate(modes)
    )


def _sign(mode: Configuration, det: Quantity | None, rows: NDArray[np.intp]) -> int | None:
    if det is None or not np.array_equal(mode.split_jacobian().rows, rows):
        return None
    return 0 if mode.singularity().is_singular else int(np.sign(det.value))
