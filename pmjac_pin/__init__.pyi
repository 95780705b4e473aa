# What `import pmjac_pin` offers, by its names there; each is imported when it is asked for.

from .catalog import list_mechanisms as list_mechanisms
from .certificates.certificate import Certificate as Certificate
from .certificates.certificate import certify as certify
from .configuration import Configuration as Configuration
from .diagnosis import Diagnosis as Diagnosis
from .diagnosis_maker import check as check
from .ellipse import Ellipse as Ellipse
from .ellipsoid import Ellipsoid as Ellipsoid
from .errors import (
    ArgumentError as ArgumentError,
)
from .errors import (
    ClosureError as ClosureError,
)
from .errors import (
    ForbiddenRatesError as ForbiddenRatesError,
)
from .errors import (
    IdleMotionError as IdleMotionError,
)
from .errors import (
    LimitError as LimitError,
)
from .errors import (
    MissingDependencyError as MissingDependencyError,
)
from .errors import (
    ModelFileError as ModelFileError,
)
from .errors import (
    NoJacobianError as NoJacobianError,
)
from .errors import (
    OutputError as OutputError,
)
from .errors import (
    PmjacError as PmjacError,
)
from .errors import (
    SingularError as SingularError,
)
from .errors import (
    UnknownNameError as UnknownNameError,
)
from .homotopy.complex_modes import ComplexModes as ComplexModes
from .homotopy.operation_modes import OperationModes as OperationModes
from .homotopy.parameter_homotopy import (
    ParameterHomotopy as ParameterHomotopy,
)
from .homotopy.parameter_homotopy import (
    parameter_homotopy as parameter_homotopy,
)
from .jacobian import (
    EquivalentJacobian as EquivalentJacobian,
)
from .jacobian import (
    SplitJacobian as SplitJacobian,
)
from .jacobian import (
    equivalent_jacobian as equivalent_jacobian,
)
from .loading import load as load
from .loop_spec import (
    CylindricalLoop as CylindricalLoop,
)
from .loop_spec import (
    DistanceLoop as DistanceLoop,
)
from .loop_spec import (
    FrameLoop as FrameLoop,
)
from .loop_spec import (
    JointLoop as JointLoop,
)
from .loop_spec import (
    PlanarLoop as PlanarLoop,
)
from .loop_spec import (
    PointLoop as PointLoop,
)
from .loop_spec import (
    PrismaticLoop as PrismaticLoop,
)
from .loop_spec import (
    RevoluteLoop as RevoluteLoop,
)
from .loop_spec import (
    SphericalLoop as SphericalLoop,
)
from .loop_spec import (
    UniversalLoop as UniversalLoop,
)
from .mechanism import Mechanism as Mechanism
from .modes.assembly_modes import AssemblyModes as AssemblyModes
from .modes.assembly_modes import Completeness as Completeness
from .modes.branch_and_prune import Budget as Budget
from .modes.find import assembly_modes as assembly_modes
from .modes.proof import Proof as Proof
from .modes.proof import prove as prove
from .partition import Partition as Partition
from .singularity import Singularity as Singularity
from .spec import MechanismSpec as MechanismSpec
from .studies.convert import convert as convert
from .studies.recut import recut as recut
from .viewer.viewer import Viewer as Viewer
from .viewer.viewer import view as view
