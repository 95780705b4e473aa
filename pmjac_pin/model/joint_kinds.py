"""The kinds of joint there are, each an entry of one table, and which one a joint is of."""

from __future__ import annotations

import numpy as np
import pinocchio as pin

from pmjac_pin.errors import ArgumentError, enumerated, quoted, unknown_name
from pmjac_pin.model.joint_kind import JointKind
from pmjac_pin.model.loop_spec import (
    FrameLoop,
    PlanarLoop,
    PrismaticLoop,
    RevoluteLoop,
    SphericalLoop,
)

_Z, _PLANE, _ALL = (2,), (0, 1), (0, 1, 2)
_PITCH = 0.3  # m/rad, for what is tried
_UNBOUNDED = "evoluteUnboundedUnaligned"

_TABLE = (
    JointKind("fixed", "", None, (), (), FrameLoop),
    JointKind(
        "revolute", "R([XYZ]|evoluteUnaligned)", pin.JointModelRZ, (), _Z, RevoluteLoop, angle=True
    ),
    JointKind("continuous", f"R(UB[XYZ]|{_UNBOUNDED})", pin.JointModelRUBZ, (), _Z, RevoluteLoop),
    JointKind("prismatic", "P([XYZ]|rismaticUnaligned)", pin.JointModelPZ, _Z, (), PrismaticLoop),
    JointKind(
        "helical", "H([XYZ]|elicalUnaligned)", pin.JointModelHZ, _Z, _Z, angle=True, screw=True
    ),
    JointKind("spherical", "Spherical", pin.JointModelSpherical, (), _ALL, SphericalLoop),
    JointKind("planar", "Planar", pin.JointModelPlanar, _PLANE, _Z, PlanarLoop),
    JointKind("translation", "Translation", pin.JointModelTranslation, _ALL),
    JointKind("free", "FreeFlyer", pin.JointModelFreeFlyer, _ALL, _ALL, title="floating"),
    JointKind("universal", "Universal", None, (), _PLANE, angle=True),
    JointKind("spherical_zyx", "SphericalZYX", None, (), _ALL, angle=True),
)
#: The kinds that are known, by name; `register` adds to them. The first that reads a joint counts.
JOINT_KINDS = {kind.name: kind for kind in _TABLE}


def register(kind: JointKind) -> None:
    """Let models have joints of a kind.

    Raises
    ------
    ArgumentError
        Pinocchio's joint is not read as the kind, or moves otherwise than the kind says.
    """
    if not kind.in_turn:
        _check_kind(kind)
    JOINT_KINDS[kind.name] = kind


def _check_kind(kind: JointKind) -> None:
    if not kind.angle and kind.turns not in (0, 1, 3):
        raise ArgumentError(
            f"a {kind.name} joint turns about {kind.turns} axes: about z, any way, or by angles "
            "one after the other (`angle=True`) is what a kind of joint can say"
        )
    model = pin.Model()
    model.addJoint(0, kind.built(_PITCH), pin.SE3.Identity(), kind.name)
    if (model.nq, model.nv) != (kind.nq, kind.nv) or not kind.reads(model.joints[1]):
        raise ArgumentError(
            f"Pinocchio's joint is no {kind.name} one: its sizes or its name differ"
        )
    data, q = model.createData(), pin.neutral(model)
    q = pin.integrate(model, q, np.linspace(0.3, 0.9, kind.nv))
    pin.computeJointJacobians(model, data, q)
    twists = pin.getJointJacobian(model, data, 1, pin.LOCAL).reshape(6, -1)
    place = data.oMi[1].copy()
    pin.forwardKinematics(model, data, np.array(kind.entries(place, _PITCH)))
    if not (np.allclose(twists, kind.twists(_PITCH)) and data.oMi[1].isApprox(place)):
        wanted = "slides along its axes and then turns about them, as they have moved"
        raise ArgumentError(f"a {kind.name} joint {wanted}; Pinocchio's moves in another way")


def kind_named(name: str) -> JointKind:
    """Return a kind by its name.

    Raises
    ------
    UnknownNameError

    Examples
    --------
    >>> kind_named("helical").screw
    True
    """
    if name not in JOINT_KINDS:
        raise unknown_name("kind of joint", name, tuple(JOINT_KINDS))
    return JOINT_KINDS[name]


def kind_of(joint: pin.JointModel) -> JointKind | None:
    """Return the kind of one of Pinocchio's joints; None for one that is Pinocchio's alone.

    A screw without a pitch turns.
    """
    kind = next((kind for kind in JOINT_KINDS.values() if kind.reads(joint)), None)
    if kind is not None and kind.screw and not pitch_of(joint):
        return kind_named("revolute")
    return kind


def pitch_of(joint: pin.JointModel) -> float:
    """Return how far a joint slides as it turns, m/rad; 0 for one that is no screw."""
    own = joint.extract() if isinstance(joint, pin.JointModel) else joint
    return float(getattr(own, "pitch", 0.0))


def known_kind(joint: pin.JointModel, name: str, *, in_turn: bool = False) -> JointKind:
    """Return the kind of a joint whose motion is known here, not to Pinocchio alone.

    Parameters
    ----------
    joint : pin.JointModel
    name : str
        For messages.
    in_turn : bool
        Those that turn by several angles, one after the other, will do.

    Raises
    ------
    ArgumentError
        The joint is of no such kind; the message lists those that are known.
    """
    kind = kind_of(joint)
    if kind is not None and (in_turn or not kind.in_turn):
        return kind
    kinds = [one for one in JOINT_KINDS.values() if one.nv and (in_turn or not one.in_turn)]
    known = enumerated([one.name for one in kinds])
    written = f"joint {quoted(name)} is a {joint.shortname()}"
    raise ArgumentError(f"{written}, which cannot be taken apart; known kinds are: {known}")
