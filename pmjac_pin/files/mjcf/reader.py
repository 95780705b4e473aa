"""MJCF, MuJoCo's format: bodies, joints and equality constraints, as a cut tree and its loops.

MuJoCo itself reads the file, but for the words that nobody here looks for; of what it makes of it
the bodies, joints, sites and constraints are read, and actuators (which joints are motors), the
keyframe "home", inertias and simple geoms for a picture. A joint's value is MuJoCo's qpos, and the
loops are closed at qpos0.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from pmjac_pin.files.foreign_model import ForeignModel
from pmjac_pin.files.mjcf.actuators import read_motors
from pmjac_pin.files.mjcf.bodies import body_notes, read_bodies
from pmjac_pin.files.mjcf.couplings import equations, read_couplings
from pmjac_pin.files.mjcf.equality import active_equalities, read_closures, straight_tendons
from pmjac_pin.files.mjcf.file import read_mujoco
from pmjac_pin.files.mjcf.guards import check_mjcf
from pmjac_pin.files.mjcf.home import read_home
from pmjac_pin.files.mjcf.kept import Kept, kept
from pmjac_pin.files.mjcf.masses import inertias
from pmjac_pin.files.mjcf.mujoco import compiled
from pmjac_pin.files.mjcf.names import Names
from pmjac_pin.files.mjcf.tree import MjcfTree
from pmjac_pin.files.text_file import at_file
from pmjac_pin.files.unread_springs import spring_notes
from pmjac_pin.files.urdf.locking import lock_joints
from pmjac_pin.files.urdf.robot import Urdf


def read_mjcf(path: Path, root: Path | None = None) -> ForeignModel:
    """Read an MJCF file, and the files in its folder that it includes or attaches.

    The world, bodies and sites become links, and joints keep their names; what has none is
    called after its body: "arm_body", "arm_hinge", "arm_site". The points at which a <connect>
    or <weld> holds are links "arm_at_rod" and "rod_at_arm". <connect> becomes a point loop,
    <weld> a frame loop, a <tendon> from a site straight to another a distance loop, and a linear
    <joint> or <tendon> of two joints a joint loop; one of a single joint fixes that. Motors are
    the joints that actuators move, balls and free ones only where several move them any way. The
    home pose is the keyframe "home", or else qpos0; values outside their joint's range start at
    its end.

    Parameters
    ----------
    path : Path
    root : Path, optional
        A folder above the model's, below which these files may be instead.

    Raises
    ------
    ModelFileError
        The message starts with the file's path and names the element at fault; or MuJoCo is not
        installed.
    """
    file = read_mujoco(path, root)
    with at_file(str(path)):
        found = kept(file)
        check_mjcf(found.file)
        return _model_of_kept(found, path)


def _model_of_kept(kept: Kept, path: Path) -> ForeignModel:
    found = compiled(kept.file)
    name, names = kept.file.root.get("model") or path.stem, Names(found.model)
    bodies = read_bodies(found, names)
    joints = {joint.name: joint for body in bodies for joint in body.joints}
    active, left_out = active_equalities(found)
    straight = straight_tendons(found, active["tendon"])
    geared = {**active, "tendon": sorted(set(active["tendon"]) - set(straight))}
    couplings, held = read_couplings(equations(found, geared, names.joints), joints)
    counted = {joint for loop in couplings for joint in loop.joints} | set(held)
    tree = MjcfTree(name, bodies, names, counted)
    closing = sorted([*active["connect"], *active["weld"], *straight])
    closures = read_closures(found, closing, names, tree)
    moving = {body.name for body in bodies if body.joints}
    masses, mass_notes = inertias(found, names, moving, kept.total_mass)
    for body, inertia in masses.items():
        tree.urdf.inertial(body, inertia)
    motors, idle = read_motors(found.model, names.joints, joints, held)
    home, moved = read_home(found.model, joints.values(), held)
    fixed = [f"joint {joint!r} is held at {held[joint]:g}" for joint in held]
    sprung = np.flatnonzero(found.model.jnt_stiffness)
    springs = spring_notes(names.joints[joint] for joint in sprung.tolist())
    left_out = [*body_notes(found.model, names), *kept.notes, *left_out]
    return ForeignModel(
        name=name,
        urdf=lock_joints(Urdf.of(tree.urdf.robot, str(path)), held),
        loops=(*closures, *couplings),
        spherical=tuple(joint.name for joint in joints.values() if joint.kind == "ball"),
        armature={
            names.joints[joint]: armature
            for joint, armature in found.rotors.items()
            if names.joints[joint] not in held
        },
        home=home,
        actuated=motors,
        notes=(*left_out, *fixed, *idle, *moved, *springs, *mass_notes),
        unread=kept.unread,
    )
