"""MJCF, MuJoCo's format: bodies, joints and equality constraints, as a cut tree and its loops.

Of everything else only actuators (which joints are motors), the keyframe "home", inertias and
simple geoms (for their masses and a picture) are read. A joint's value is MuJoCo's qpos, and the
loops are closed at qpos0.
"""

from __future__ import annotations

from pathlib import Path
from xml.etree.ElementTree import Element

from pmjac_pin.formats.foreign_model import ForeignModel
from pmjac_pin.formats.mjcf_actuators import read_motors
from pmjac_pin.formats.mjcf_bodies import read_bodies
from pmjac_pin.formats.mjcf_couplings import read_couplings
from pmjac_pin.formats.mjcf_defaults import Defaults
from pmjac_pin.formats.mjcf_equality import active_equalities, read_closures
from pmjac_pin.formats.mjcf_file import read_mujoco
from pmjac_pin.formats.mjcf_frames import Compiler
from pmjac_pin.formats.mjcf_home import read_home
from pmjac_pin.formats.mjcf_masses import MassRules, inertias
from pmjac_pin.formats.mjcf_names import WORLD, Names
from pmjac_pin.formats.mjcf_tree import MjcfTree
from pmjac_pin.formats.mjcf_vocabulary import MJCF_WORDS
from pmjac_pin.text_file import at_file
from pmjac_pin.urdf import Urdf
from pmjac_pin.urdf_locking import lock_joints


def read_mjcf(path: Path) -> ForeignModel:
    """Read an MJCF file, and the files in its folder that it includes.

    The world, bodies and sites become links, and joints keep their names; what has none is
    called after its body: "arm_body", "arm_hinge", "arm_site". The points at which a <connect>
    or <weld> holds are links "arm_at_rod" and "rod_at_arm". <connect> becomes a point loop,
    <weld> a frame loop, and a linear <joint> a joint loop; a <joint> of one joint fixes that.
    Motors are the hinges and slides that actuators move. The home pose is the keyframe "home",
    or else qpos0; values outside their joint's range start at its end.

    Raises
    ------
    ModelFileError
        The message starts with the file's path and names the element at fault.
    """
    root = read_mujoco(path)
    with at_file(str(path)):
        return _foreign_model(root, path)


def _foreign_model(root: Element, path: Path) -> ForeignModel:
    unread = MJCF_WORDS.unread(root)
    name = root.get("model") or path.stem
    compiler, defaults, names = Compiler.of(root), Defaults(root), Names(root)
    bodies, notes = read_bodies(root, compiler, defaults, names)
    joints = {joint.name: joint for body in bodies for joint in body.joints}
    equalities, left_out = active_equalities(root, defaults)
    couplings, held = read_couplings(equalities, joints)
    counted = {joint for loop in couplings for joint in loop.joints} | set(held)
    tree = MjcfTree(name, bodies, names, counted)
    closures = read_closures(equalities, compiler, bodies, tree)
    masses, mass_notes = inertias(
        {body.name: body.mass for body in bodies if body.name != WORLD},
        {body.name for body in bodies if body.joints},
        MassRules.of(root),
    )
    for body, inertia in masses.items():
        tree.urdf.inertial(body, inertia)
    motors, idle = read_motors(root, joints, held)
    home, moved = read_home(root, bodies, held)
    notes += [*left_out, *(f"joint {joint!r} is held at {held[joint]:g}" for joint in held)]
    return ForeignModel(
        name=name,
        urdf=lock_joints(Urdf.of(tree.urdf.robot, str(path)), held),
        loops=(*closures, *couplings),
        spherical=tuple(joint.name for joint in joints.values() if joint.kind == "ball"),
        home=home,
        actuated=motors,
        notes=(*notes, *idle, *moved, *mass_notes),
        unread=unread,
    )
