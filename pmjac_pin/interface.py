"""The public interface: what `import pmjac_pin` offers, by its names there."""

import importlib
from typing import TYPE_CHECKING, Any

from pmjac_pin.catalog import list_mechanisms
from pmjac_pin.certificates.certificate import Certificate, certify
from pmjac_pin.configuration import Configuration
from pmjac_pin.diagnosis import Diagnosis
from pmjac_pin.diagnosis_maker import check
from pmjac_pin.ellipse import Ellipse
from pmjac_pin.ellipsoid import Ellipsoid
from pmjac_pin.errors import (
    ArgumentError,
    ClosureError,
    ForbiddenRatesError,
    IdleMotionError,
    LimitError,
    MissingDependencyError,
    ModelFileError,
    NoJacobianError,
    OutputError,
    PmjacError,
    SingularError,
    UnknownNameError,
)
from pmjac_pin.homotopy.complex_modes import ComplexModes
from pmjac_pin.homotopy.operation_modes import OperationModes
from pmjac_pin.homotopy.parameter_homotopy import ParameterHomotopy, parameter_homotopy
from pmjac_pin.jacobian import EquivalentJacobian, SplitJacobian, equivalent_jacobian
from pmjac_pin.loading import load
from pmjac_pin.loop_spec import (
    CylindricalLoop,
    DistanceLoop,
    FrameLoop,
    JointLoop,
    PlanarLoop,
    PointLoop,
    PrismaticLoop,
    RevoluteLoop,
    SphericalLoop,
    UniversalLoop,
)
from pmjac_pin.mechanism import Mechanism
from pmjac_pin.modes.assembly_modes import AssemblyModes, Completeness
from pmjac_pin.modes.branch_and_prune import Budget
from pmjac_pin.modes.find import assembly_modes
from pmjac_pin.modes.proof import Proof, prove
from pmjac_pin.partition import Partition
from pmjac_pin.singularity import Singularity
from pmjac_pin.spec import MechanismSpec
from pmjac_pin.studies.convert import convert
from pmjac_pin.studies.recut import recut

if TYPE_CHECKING:
    from pmjac_pin.viewer.viewer import Viewer, view

__all__ = [
    "ArgumentError",
    "AssemblyModes",
    "Budget",
    "Certificate",
    "ClosureError",
    "Completeness",
    "ComplexModes",
    "Configuration",
    "CylindricalLoop",
    "Diagnosis",
    "DistanceLoop",
    "Ellipse",
    "Ellipsoid",
    "EquivalentJacobian",
    "ForbiddenRatesError",
    "FrameLoop",
    "IdleMotionError",
    "JointLoop",
    "LimitError",
    "Mechanism",
    "MechanismSpec",
    "MissingDependencyError",
    "ModelFileError",
    "NoJacobianError",
    "OperationModes",
    "OutputError",
    "ParameterHomotopy",
    "Partition",
    "PlanarLoop",
    "PmjacError",
    "PointLoop",
    "PrismaticLoop",
    "Proof",
    "RevoluteLoop",
    "SingularError",
    "Singularity",
    "SphericalLoop",
    "SplitJacobian",
    "UniversalLoop",
    "UnknownNameError",
    "Viewer",
    "assembly_modes",
    "certify",
    "check",
    "convert",
    "equivalent_jacobian",
    "list_mechanisms",
    "load",
    "parameter_homotopy",
    "prove",
    "recut",
    "view",
]


def __getattr__(name: str) -> Any:
    """Import the viewer when it is asked for: it brings a web server along."""
    if name in ("Viewer", "view"):
        viewer = importlib.import_module("pmjac_pin.viewer.viewer")
        return getattr(viewer, name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
