"""MuJoCo's reading of a model: its MjSpec multiplies out what the file says, and compiles it.

It gets what `mjcf_kept` leaves, so that it opens no file; meshes become points without mass.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any
from xml.etree.ElementTree import Element, tostring

from pmjac_pin.errors import MissingDependencyError, ModelFileError, shortened
from pmjac_pin.files.mjcf.file import MjcfFile
from pmjac_pin.files.mjcf.names import Places, called
from pmjac_pin.files.xml_text import check_name

_LONGEST_ERROR = 300  # characters of one of MuJoCo's messages
_HEAVY = 1e30  # kg m², beside all that a file may say
_KNOWN_MASS = ("PLANE", "HFIELD", "SPHERE", "CAPSULE", "ELLIPSOID", "CYLINDER", "BOX")


@dataclass(frozen=True, eq=False)
class Compiled:
    """A model as MuJoCo has it.

    Attributes
    ----------
    model : mujoco.MjModel
        Its geoms that are `meshes` are points without mass.
    equalities : tuple of str
        How messages call each.
    meshes : frozenset of int
        The geoms that would need another file.
    unknown_mass : frozenset of int
        Bodies of which a mesh would make the mass.
    rotors : mapping of int to float
        Armatures of joints that have one, kg m² or kg.
    """

    model: Any
    equalities: tuple[str, ...]
    meshes: frozenset[int]
    unknown_mass: frozenset[int]
    rotors: Mapping[int, float]


def compiled(file: MjcfFile) -> Compiled:
    """Return what MuJoCo makes of a model that was checked.

    Raises
    ------
    ModelFileError
        MuJoCo is not installed, or refuses the model.
    """
    mujoco = _mujoco()
    root = file.root
    with _refusals(root):
        spec = mujoco.MjSpec.from_string(_line_by_line(root), include=dict(_attached_files(file)))
    labels = tuple(_equality_label(mujoco, equality) for equality in spec.equalities)
    _check_labels(mujoco, spec, labels)
    _check_values(spec)
    meshes = _without_meshes(mujoco, spec)
    rotors = [(joint, float(joint.armature)) for joint in spec.joints if joint.armature]
    for joint in spec.joints:
        joint.armature = _HEAVY  # the mass matrix, which nobody reads, must not be singular
    with _refusals(root):
        model = spec.compile()
    return Compiled(
        model=model,
        equalities=labels,
        meshes=frozenset(geom.id for geom, _ in meshes),
        unknown_mass=frozenset(geom.parent.id for geom, heavy in meshes if heavy),
        rotors={joint.id: armature for joint, armature in rotors},
    )


def _mujoco() -> Any:
    try:
        import mujoco  # noqa: PLC0415
    except ImportError:
        todo = 'pip install "pmjac_pin[mjcf]"'
        raise MissingDependencyError(
            f"MJCF is read by MuJoCo, which is not installed: {todo}"
        ) from None
    return mujoco


@contextmanager
def _refusals(root: Element) -> Iterator[None]:
    """Turn MuJoCo's errors into ours, with the element at fault instead of its line."""
    try:
        yield
    except Exception as error:  # MuJoCo has several kinds
        said = re.sub(r"^(XML )?(Error: )+", "", str(error)).strip()
        said, *rest = said.split("\nElement ")
        where = ""
        if rest and (element := _on_line(root, rest[-1])) is not None:
            where = f"{Places(root).of(element)}: "
            said = _with_attribute(said, element)
        raise ModelFileError(
            f"{where}MuJoCo refuses it: {shortened(said, _LONGEST_ERROR)}"
        ) from None


def _on_line(root: Element, place: str) -> Element | None:
    """Return what stands on the line that a message names; `_line_by_line` writes one on each."""
    line = int(found[1]) if (found := re.search(r"line (\d+)", place)) else 0
    elements = list(root.iter())
    return elements[line - 1] if 0 < line <= len(elements) else None


def _with_attribute(said: str, element: Element) -> str:
    """Return a message on a word with the attribute that has it."""
    if (word := re.fullmatch("invalid keyword: '(.*)'", said)) is None:
        return said
    keys = [f"`{key}` has the" for key, value in element.attrib.items() if value == word[1]]
    return " ".join([*keys[:1], said])


def _line_by_line(root: Element) -> str:
    """Return the XML with each element's start on a line of its own, in order."""
    for element in root.iter():
        if len(element):
            element.text = "\n"
        for child in element[:-1]:
            child.tail = "\n"
    return tostring(root, encoding="unicode")


def _attached_files(file: MjcfFile) -> Iterator[tuple[str, bytes]]:
    for name, attached in file.attached.items():
        yield name, tostring(attached.root)
        yield from _attached_files(attached)


def _equality_label(mujoco: Any, equality: Any) -> str:
    kind = equality.type.name.removeprefix("mjEQ_").lower()
    ends = {
        f"{end}{number}": name for end, number, name in _equality_ends(mujoco, equality) if name
    }
    return called(Element(kind, ends | ({"name": equality.name} if equality.name else {})))


def _equality_ends(mujoco: Any, equality: Any) -> list[tuple[str, int, str]]:
    """Return what an equality joins: the kind of thing, which of the two it is, and its name."""
    kinds = {mujoco.mjtEq.mjEQ_JOINT: "joint", mujoco.mjtEq.mjEQ_TENDON: "tendon"}
    sites = equality.objtype == mujoco.mjtObj.mjOBJ_SITE
    kind = kinds.get(equality.type, "site" if sites else "body")
    return [(kind, 1, equality.name1), (kind, 2, equality.name2)]


def _check_labels(mujoco: Any, spec: Any, labels: Sequence[str]) -> None:
    """Refuse names that do not exist, with what may be meant, which MuJoCo does not say."""
    known = {
        "body": [body.name for body in spec.bodies],
        "site": [site.name for site in spec.sites],
        "joint": [joint.name for joint in spec.joints],
        "tendon": [tendon.name for tendon in spec.tendons],
    }
    for label, equality in zip(labels, spec.equalities, strict=True):
        for kind, _, name in _equality_ends(mujoco, equality):
            if name:
                check_name(f"{label}: the {kind}", name, known[kind])
    for actuator in spec.actuators:
        where = called(Element("actuator", name=actuator.name))
        check_name(f"{where}: the joint", actuator.target, known["joint"])


def _check_values(spec: Any) -> None:
    """Refuse what MuJoCo passes over: a range that ends where it starts, and masses below zero.

    It would take the first for none; the others for those that are made up here.
    """
    for joint in spec.joints:
        lower, upper = joint.range
        if lower >= upper and (lower or upper) and int(joint.limited):
            what = f"`range` is {lower:g} to {upper:g}; the second is greater"
            raise ModelFileError(f"{called(Element('joint', name=joint.name))}: {what}")
    for body in spec.bodies:
        where = called(Element("body", name=body.name))
        if body.mass < 0.0:
            raise ModelFileError(f"{where}: the mass is {body.mass:g}; it must not be negative")
        if min(body.inertia) < 0.0:
            what = f"a moment of inertia is {min(body.inertia):g}, below zero"
            raise ModelFileError(f"{where}: {what}")


def _without_meshes(mujoco: Any, spec: Any) -> list[tuple[Any, bool]]:
    """Make points of the geoms that need another file; return each, and if it would have a mass."""
    known = [getattr(mujoco.mjtGeom, f"mjGEOM_{kind}") for kind in _KNOWN_MASS]
    height = mujoco.mjtGeom.mjGEOM_HFIELD
    found = []
    for geom in spec.geoms:
        if geom.type in known and not geom.meshname and geom.type != height:
            continue
        found.append((geom, geom.type != height and _counts(spec.compiler, geom)))
        geom.type, geom.meshname, geom.hfieldname = mujoco.mjtGeom.mjGEOM_SPHERE, "", ""
        geom.size, geom.mass, geom.fromto = [1.0] * 3, 0.0, [math.nan] * 6
    return found


def _counts(compiler: Any, geom: Any) -> bool:
    """Whether MuJoCo would add a geom to the mass of its body."""
    given, (low, high) = geom.parent.explicitinertial, compiler.inertiagrouprange
    from_geoms = {0: False, 1: True, 2: not given}[int(compiler.inertiafromgeom)]
    own = geom.density if math.isnan(geom.mass) else geom.mass
    return bool(from_geoms and low <= geom.group <= high and own != 0.0)
