"""The assembly modes as plain data with names and units: what ``pmjac modes --json`` writes."""

from __future__ import annotations

import msgspec
import numpy as np
from numpy.typing import ArrayLike

from pmjac_pin.closing.motor_values import MotorValues
from pmjac_pin.closing.motor_values import motor_values as given_values
from pmjac_pin.configuration import Configuration
from pmjac_pin.mechanism import Mechanism
from pmjac_pin.studies.certificates.certificate import certify
from pmjac_pin.studies.evidence import Evidence
from pmjac_pin.studies.homotopy.complex_modes import ComplexModes
from pmjac_pin.studies.homotopy.operation_modes import OperationModes
from pmjac_pin.studies.modes.assembly_modes import AssemblyModes
from pmjac_pin.studies.modes.names import pose_names
from pmjac_pin.values.encodable import encodable
from pmjac_pin.words.labelled_values import (
    Labels,
    beyond_limits,
    determinant,
    joint_values,
    motor_values,
    parameter_values,
    tool_pose,
    vector,
)
from pmjac_pin.words.report import (
    BeyondLimits,
    JointValue,
    ParameterValue,
    Quantity,
    ToolPose,
    Vector,
)
from pmjac_pin.words.solutions_report import (
    SolutionsReport,
    make_solutions_report,
    operation_mode_numbers,
)


class CertificateReport(msgspec.Struct, frozen=True):
    """Whether an exact solution is proven to be near: see `Certificate`.

    Attributes
    ----------
    certified : bool
    existence_radius : float
        A solution is no farther than this, rad; infinite where none is proven.
    uniqueness_radius : float
        No second one is nearer than this, rad.
    evidence : Evidence
    """

    certified: bool
    existence_radius: float
    uniqueness_radius: float
    evidence: Evidence


class ModeReport(msgspec.Struct, frozen=True, kw_only=True):
    """What tells one assembly mode from the others.

    Attributes
    ----------
    number : int
        From 1, in the order in which the modes are always sorted.
    poses : tuple of str
        The named poses that it is.
    tool : ToolPose
    joints : tuple of JointValue
        Motors first.
    limits_violated : tuple of BeyondLimits
        The joints outside their limits, where these were left aside.
    q : tuple of float
        Pinocchio's configuration vector: `Mechanism.configuration` takes it.
    residual_norm : float
        Euclidean norm of the gaps of all loops, m.
    kind : str
        Of the singularity here, "regular" where there is none.
    smallest : float
        The relative singular value of K* that decides; infinite without loops.
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
    certificate : CertificateReport
    """

    number: int
    poses: tuple[str, ...]
    tool: ToolPose
    joints: tuple[JointValue, ...]
    limits_violated: tuple[BeyondLimits, ...]
    q: Vector
    residual_norm: float
    kind: str
    smallest: float
    det_K_star: Quantity | None
    sign: int | None
    share: float
    ways: int
    mirror_image: int | None
    operation_mode: int | None
    certificate: CertificateReport


class ModesReport(msgspec.Struct, frozen=True, kw_only=True):
    """The assembly modes of a mechanism at given motor values.

    Attributes
    ----------
    mechanism, description : str
    parameters : tuple of ParameterValue
    characteristic_length : float
        In m: what makes radians and metres comparable in `smallest`.
    motors : tuple of JointValue
    limits : bool
        Whether the joints had to be within their limits.
    starts : int
        Random starts that were tried.
    evidence : Evidence
        What it rests on that no mode is missing.
    solutions : SolutionsReport or None
        All complex solutions, where they were asked for.
    modes : tuple of ModeReport
    """

    mechanism: str
    description: str
    parameters: tuple[ParameterValue, ...]
    characteristic_length: float
    motors: tuple[JointValue, ...]
    limits: bool
    starts: int
    evidence: Evidence
    solutions: SolutionsReport | None
    modes: tuple[ModeReport, ...]


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
    labels = Labels.of(mechanism)
    motors = given_values(mechanism.spec, mechanism.coordinates, actuated)
    numbers: tuple[int | None, ...] = (None,) * len(modes)
    if solutions is not None and operation_modes is not None:
        numbers = operation_mode_numbers(modes, solutions, operation_modes)
    return ModesReport(
        mechanism=encodable(mechanism.name),
        description=mechanism.spec.description,
        parameters=parameter_values(mechanism),
        characteristic_length=mechanism.characteristic_length,
        motors=motor_values(motors, labels),
        limits=limits,
        starts=modes.starts,
        evidence=modes.evidence,
        solutions=None if solutions is None else make_solutions_report(solutions, operation_modes),
        modes=_modes(mechanism, modes, labels, numbers),
    )


def _modes(
    mechanism: Mechanism, modes: AssemblyModes, labels: Labels, numbers: tuple[int | None, ...]
) -> tuple[ModeReport, ...]:
    names = pose_names(mechanism, modes)
    rows = mechanism.home.split_jacobian().rows
    found = zip(modes, names, modes.shares, modes.ways, modes.mirror_images, numbers, strict=True)
    return tuple(
        _mode(
            index,
            mode,
            rows,
            labels,
            poses=poses,
            share=share,
            ways=ways,
            mirror=mirror,
            operation=number,
        )
        for index, (mode, poses, share, ways, mirror, number) in enumerate(found, start=1)
    )


def _mode(
    number: int,
    mode: Configuration,
    rows: ArrayLike,
    labels: Labels,
    *,
    poses: tuple[str, ...],
    share: float,
    ways: int,
    mirror: int | None,
    operation: int | None,
) -> ModeReport:
    split, singularity = mode.split_jacobian(), mode.singularity()
    det = determinant(split, labels)
    sign = None
    if det is not None and np.array_equal(split.rows, rows):
        sign = 0 if singularity.is_singular else int(np.sign(det.value))
    return ModeReport(
        number=number,
        poses=poses,
        tool=tool_pose(mode),
        joints=joint_values(mode, labels),
        limits_violated=beyond_limits(mode, labels),
        q=vector(mode.q),
        residual_norm=mode.residual_norm,
        kind=singularity.kind,
        smallest=singularity.smallest,
        det_K_star=det,
        sign=sign,
        share=share,
        ways=ways,
        mirror_image=None if mirror is None else mirror + 1,
        operation_mode=operation,
        certificate=_certificate(mode),
    )


def _certificate(mode: Configuration) -> CertificateReport:
    found = certify(mode)
    radii = (found.existence_radius, found.uniqueness_radius)
    return CertificateReport(bool(found), *radii, found.evidence)
