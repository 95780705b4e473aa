"""SDFormat: a model whose joints may close loops, as a cut tree and its loops.

Read are the links, joints and frames of one model, SDFormat 1.4 to 1.12. Every link and every
joint is placed where it is with all joints at zero, so that all loops are closed there, to
rounding. Visuals are kept for a picture, sensors are left out.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Sequence
from pathlib import Path

from pmjac_pin.errors import ModelFileError
from pmjac_pin.files.foreign_model import ForeignModel
from pmjac_pin.files.sdf.couplings import coupled_links, coupling, read_mimics, refuse_idle_mimics
from pmjac_pin.files.sdf.frames import WORLD
from pmjac_pin.files.sdf.joints import SdfJoint, assumed_axes, freedom_names
from pmjac_pin.files.sdf.model import SdfModel, read_model
from pmjac_pin.files.sdf.tree import SdfTree
from pmjac_pin.files.spanning_tree import SpanningTree, spanning_tree
from pmjac_pin.files.text_file import at_file, read_text
from pmjac_pin.files.unread_springs import spring_notes, sprung_joints
from pmjac_pin.files.urdf.robot import Urdf
from pmjac_pin.files.urdf.rotors import lost_rotors
from pmjac_pin.files.xml_text import parse_xml

MAXIMAL_SDF = 20_000_000  # bytes


def read_sdf(path: Path, motors: Collection[str] = ()) -> ForeignModel:
    """Read an SDFormat file with one model.

    Of several joints with the same child the first in the file stays in the tree, and the others
    become loops of their kind: revolute, prismatic, spherical, universal or frame; a screw is cut
    behind its hub. Where no joint
    holds a link to the world, the canonical link, or else the first that is no joint's child, is
    held at its pose in the file. Links that no joint joins to it are left out.

    Parameters
    ----------
    path : Path
    motors : collection of str, optional
        Joints that stay in the tree before others do.

    Returns
    -------
    ForeignModel
        With `actuated` where no loop closes and no motors are given: every joint of one degree
        of freedom that follows no other.

    Raises
    ------
    ModelFileError
        The message starts with the file's path and names the element at fault.
    """
    text = read_text(path, MAXIMAL_SDF)
    with at_file(str(path)):
        model = _foreign_model(read_model(parse_xml(text)), path, motors)
        return model if motors else model.with_open_chain()


def _foreign_model(model: SdfModel, path: Path, motors: Collection[str]) -> ForeignModel:
    gearboxes = [joint for joint in model.joints if joint.kind == "gearbox"]
    joints = [joint for joint in model.joints if joint.kind != "gearbox"]
    for gearbox in gearboxes:
        refuse_idle_mimics(gearbox)
    mimics = read_mimics(joints, model.element)
    coupled = {name for loop in mimics for name in loop.joints}
    graph = _graph(model, joints, gearboxes, {*motors, *coupled})
    _refuse_cut(graph, joints, coupled)
    tree = _tree(model, graph, joints, coupled)
    kept = [joints[branch.joint] for branch in graph.branches]
    moving = {name for joint in kept for name in freedom_names(joint)}
    couplings = [
        coupling(gearbox, kept) for gearbox in gearboxes if gearbox.child not in graph.apart
    ]
    return ForeignModel(
        name=model.name or path.stem,
        urdf=Urdf.of(tree.urdf.robot, str(path)),
        # Of couplings, those of joints that are in the tree: the others' links are left out.
        loops=(*tree.loops, *couplings, *(loop for loop in mimics if set(loop.joints) <= moving)),
        spherical=tuple(tree.spherical),
        helical=tree.helical,
        armature={n: inertia for n, inertia in _armatures(joints).items() if n in tree.moving},
        home=tree.home,
        notes=(
            *(*model.notes, *assumed_axes(joints), *_notes(graph, joints, tree)),
            *spring_notes(sprung_joints(model.element)),
        ),
        unread=model.unread,
    )


def _tree(
    model: SdfModel, graph: SpanningTree, joints: Sequence[SdfJoint], coupled: Collection[str]
) -> SdfTree:
    """Return the cut tree with its loops, and what of the links belongs to it."""
    tree = SdfTree(model, coupled)
    if graph.root != WORLD:
        tree.urdf.fixed(WORLD, graph.root, model.links[graph.root])
    for branch in graph.branches:
        tree.add(joints[branch.joint], branch)
    for number in graph.cut:
        tree.cut(joints[number])
    for number, tie in enumerate(model.ties, start=1):
        if not set(tie.links) & set(graph.apart):
            tree.tie(tie, number)
    for link, inertia in model.inertias.items():
        if link not in graph.apart:
            tree.urdf.inertial(link, inertia)
    for visual in model.visuals:
        if visual.link not in graph.apart:
            tree.urdf.visual(visual.link, visual.placement, visual.shape, visual.rgba)
    for name, (link, _) in model.frames.items():
        if link not in graph.apart:
            tree.add_frame(name)
    return tree


def _armatures(joints: Iterable[SdfJoint]) -> dict[str, float]:
    return {joint.name: joint.armature for joint in joints if joint.armature}


def _refuse_cut(graph: SpanningTree, joints: Sequence[SdfJoint], coupled: Collection[str]) -> None:
    for joint in (joints[number] for number in graph.cut):
        if set(freedom_names(joint)) & set(coupled):
            why = f"another such joint holds link {joint.child!r}, or it is the base"
            got = f"joint {joint.name!r} is coupled by <mimic>, and would have to be cut"
            raise ModelFileError(f"{got}, since {why}")


def _graph(
    model: SdfModel,
    joints: Sequence[SdfJoint],
    gearboxes: Sequence[SdfJoint],
    motors: Collection[str],
) -> SpanningTree:
    """Return the tree, with motors and the joints that gearboxes couple in it before others."""
    pairs = [pair for gearbox in gearboxes for pair in coupled_links(gearbox)]
    first = [
        number
        for number, joint in enumerate(joints)
        if {joint.name, *freedom_names(joint)} & set(motors) or {joint.parent, joint.child} in pairs
    ]
    links = [link for link in model.links if link != WORLD or model.root == WORLD]
    return spanning_tree(links, [(item.parent, item.child) for item in joints], model.root, first)


def _notes(graph: SpanningTree, joints: Sequence[SdfJoint], tree: SdfTree) -> Iterator[str]:
    if graph.root != WORLD:
        yield f"no joint holds the model to the world; link {graph.root!r} is held at its pose"
    if graph.apart:
        yield f"left out, since no joint joins them to the rest: {', '.join(graph.apart)}"
    above = {branch.below: joints[branch.joint].name for branch in graph.branches}
    for branch in graph.branches:
        if branch.turned:
            turned = f"joint {joints[branch.joint].name!r} carries its parent {branch.below!r}"
            yield f"{turned}, which hangs on nothing else"
    for joint in (joints[number] for number in graph.cut):
        other = f"joint {above[joint.child]!r}" if joint.child in above else "the base"
        cut = f"joint {joint.name!r} is cut into a loop of kind {joint.kind}, without its limits"
        if joint.kind == "screw":
            cut = f"joint {joint.name!r} is cut behind its hub, which a frame loop holds"
        yield f"{cut}: {other} holds its child {joint.child!r} already"
    yield from lost_rotors(_armatures(joints[number] for number in graph.cut), tree.moving)
    for name, value in tree.home.items():
        yield f"the file has joint {name!r} at 0, outside its limits: home starts at {value:g}"
