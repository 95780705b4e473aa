# What `import pmjac_pin` offers, by its names there; each is imported when it is asked for.

from . import adapters as adapters
from .batches.batch import Batch as Batch
from .batches.batch import batch as batch
from .batches.results import ManyClosed as ManyClosed
from .batches.results import ManyEllipsoids as ManyEllipsoids
from .batches.results import ManyInGrid as ManyInGrid
from .batches.results import ManyJacobians as ManyJacobians
from .batches.results import ManyMeasures as ManyMeasures
from .batches.results import Status as Status
from .builders.delta import delta as delta
from .builders.stewart import stewart as stewart
from .configuration import Configuration as Configuration
from .errors import (
    ArgumentError as ArgumentError,
)
from .errors import (
    ClosureError as ClosureError,
)
from .errors import (
    EffortLimitError as EffortLimitError,
)
from .errors import (
    ForbiddenRatesError as ForbiddenRatesError,
)
from .errors import (
    IdleMotionError as IdleMotionError,
)
from .errors import (
    Interrupted as Interrupted,
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
    NoEquilibriumError as NoEquilibriumError,
)
from .errors import (
    NoGradientError as NoGradientError,
)
from .errors import (
    NoInertiaError as NoInertiaError,
)
from .errors import (
    NoJacobianError as NoJacobianError,
)
from .errors import (
    NoMotorsError as NoMotorsError,
)
from .errors import (
    NoToolError as NoToolError,
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
from .errors import (
    WorkerError as WorkerError,
)
from .files.catalog import list_mechanisms as list_mechanisms
from .loading import load as load
from .mechanism import Mechanism as Mechanism
from .model.loop_spec import (
    CylindricalLoop as CylindricalLoop,
)
from .model.loop_spec import (
    DistanceLoop as DistanceLoop,
)
from .model.loop_spec import (
    FrameLoop as FrameLoop,
)
from .model.loop_spec import (
    JointLoop as JointLoop,
)
from .model.loop_spec import (
    PlanarLoop as PlanarLoop,
)
from .model.loop_spec import (
    PointLoop as PointLoop,
)
from .model.loop_spec import (
    PrismaticLoop as PrismaticLoop,
)
from .model.loop_spec import (
    RevoluteLoop as RevoluteLoop,
)
from .model.loop_spec import (
    SphericalLoop as SphericalLoop,
)
from .model.loop_spec import (
    UniversalLoop as UniversalLoop,
)
from .model.spec import MechanismSpec as MechanismSpec
from .pictures.plot import plot as plot
from .pictures.slice_figure import plot_locus as plot_locus
from .pictures.slice_figure import plot_workspace as plot_workspace
from .pictures.transmission_figure import plot_transmission as plot_transmission
from .rates.allowed import AllowedJacobian as AllowedJacobian
from .rates.allowed import allowed_jacobian as allowed_jacobian
from .rates.dynamics import Dynamics as Dynamics
from .rates.elimination import equivalent_jacobian as equivalent_jacobian
from .rates.ellipse import Ellipse as Ellipse
from .rates.ellipsoid import Ellipsoid as Ellipsoid
from .rates.jacobian import (
    EquivalentJacobian as EquivalentJacobian,
)
from .rates.margins import JointMargin as JointMargin
from .rates.margins import Margins as Margins
from .rates.margins import ToolMargin as ToolMargin
from .rates.motion import Motion as Motion
from .rates.partition import Partition as Partition
from .rates.polytope import Polytope as Polytope
from .rates.screw import Screw as Screw
from .rates.singularity import Singularity as Singularity
from .rates.singularity_types import SingularityTypes as SingularityTypes
from .rates.split import (
    SplitJacobian as SplitJacobian,
)
from .rates.statics import Statics as Statics
from .studies.certificates.certificate import Certificate as Certificate
from .studies.certificates.certificate import certify as certify
from .studies.check.diagnosis import Diagnosis as Diagnosis
from .studies.check.diagnosis_maker import check as check
from .studies.convert import convert as convert
from .studies.evidence import Evidence as Evidence
from .studies.export.export import export as export
from .studies.export.exported import Exported as Exported
from .studies.follow.event import Event as Event
from .studies.follow.event import PathBranch as PathBranch
from .studies.follow.follow import follow as follow
from .studies.follow.homecoming import Homecoming as Homecoming
from .studies.follow.trajectory import Trajectory as Trajectory
from .studies.homotopy.complex_modes import ComplexModes as ComplexModes
from .studies.homotopy.operation_modes import OperationModes as OperationModes
from .studies.homotopy.parameter_homotopy import (
    ParameterHomotopy as ParameterHomotopy,
)
from .studies.homotopy.parameter_homotopy import (
    parameter_homotopy as parameter_homotopy,
)
from .studies.modes.assembly_modes import AssemblyModes as AssemblyModes
from .studies.modes.branch_and_prune import Budget as Budget
from .studies.modes.find import assembly_modes as assembly_modes
from .studies.modes.proof import Proof as Proof
from .studies.modes.proof import prove as prove
from .studies.program import Program as Program
from .studies.program import program as program
from .studies.reach.reach import reach as reach
from .studies.reach.reached import Reached as Reached
from .studies.reach.task import Task as Task
from .studies.reach.working_modes import WorkingModes as WorkingModes
from .studies.reach.working_modes import working_modes as working_modes
from .studies.recut import recut as recut
from .studies.singularities.free_ball import SingularityFree as SingularityFree
from .studies.singularities.free_ball import singularity_free as singularity_free
from .studies.singularities.locus import LocusCurve as LocusCurve
from .studies.singularities.locus import LocusPoint as LocusPoint
from .studies.singularities.locus import SingularityLocus as SingularityLocus
from .studies.singularities.nearest import nearest_singularity as nearest_singularity
from .studies.singularities.nearest_singularity import (
    NearestSingularity as NearestSingularity,
)
from .studies.singularities.singularity_locus import singularity_locus as singularity_locus
from .studies.sweep.sweep import sweep as sweep
from .studies.transmissions.map_maker import transmission_map as transmission_map
from .studies.transmissions.table_maker import transmission_table as transmission_table
from .studies.transmissions.transmission import Geared as Geared
from .studies.transmissions.transmission import Transmission as Transmission
from .studies.transmissions.transmission import transmission as transmission
from .studies.transmissions.transmission_map import TransmissionMap as TransmissionMap
from .studies.transmissions.transmission_table import (
    TransmissionTable as TransmissionTable,
)
from .studies.workspaces.find_workspace import workspace as workspace
from .studies.workspaces.workspace import Workspace as Workspace
from .viewer.static_scene import StaticScene as StaticScene
from .viewer.static_scene import static_scene as static_scene
from .viewer.viewer import Viewer as Viewer
from .viewer.viewer import view as view
from .words.labelled_matrix import LabelledMatrix as LabelledMatrix
from .words.progress_bar import progress_bar as progress_bar
from .words.report import Report as Report
from .words.report import report as report
