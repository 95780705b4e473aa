"""Closed-chain mechanisms on Pinocchio: the equivalent Jacobian J_eq = J − J* K*⁻¹ K."""

from pmjac_pin.catalog import list_mechanisms
from pmjac_pin.configuration import Configuration
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
    PmjacError,
    SingularError,
    UnknownNameError,
)
from pmjac_pin.jacobian import EquivalentJacobian, SplitJacobian, equivalent_jacobian
from pmjac_pin.loading import load
from pmjac_pin.mechanism import Mechanism
from pmjac_pin.partition import Partition
from pmjac_pin.singularity import Singularity
from pmjac_pin.spec import DistanceLoop, MechanismSpec, PointLoop

__all__ = [
    "ArgumentError",
    "ClosureError",
    "Configuration",
    "DistanceLoop",
    "Ellipse",
    "Ellipsoid",
    "EquivalentJacobian",
    "ForbiddenRatesError",
    "IdleMotionError",
    "LimitError",
    "Mechanism",
    "MechanismSpec",
    "MissingDependencyError",
    "ModelFileError",
    "NoJacobianError",
    "Partition",
    "PmjacError",
    "PointLoop",
    "SingularError",
    "Singularity",
    "SplitJacobian",
    "UnknownNameError",
    "equivalent_jacobian",
    "list_mechanisms",
    "load",
]
