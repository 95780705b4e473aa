"""The tables of docs/export.md are what the formats have: each cell is read in a file."""

from __future__ import annotations

import re
from collections import Counter
from pathlib import Path
from xml.etree.ElementTree import parse

import numpy as np
import pinocchio as pin
import pytest
import yaml
from exported import FORMATS, hinged, path_of
from mechanisms import mostly_slow
from test_recut import KINDS

import pmjac_pin as pj

PAGE = (Path(__file__).parents[1] / "docs" / "export.md").read_text()
XML = FORMATS[:-1]
LOOPS = {str(kind.__struct_config__.tag): kind for kind in KINDS}
JOINTS = {
    "revolute": (pin.JointModelRZ, 0.1),
    "continuous": (pin.JointModelRUBZ, 0.1),
    "prismatic": (pin.JointModelPZ, 0.1),
    "helical": (lambda: pin.JointModelHZ(0.2), 0.1),
    "spherical": (pin.JointModelSpherical, (0.1, 0.2, 0.3)),
    "planar": (pin.JointModelPlanar, (0.1, 0.2, 0.3)),
    "translation": (pin.JointModelTranslation, (0.1, 0.2, 0.3)),
    "free": (pin.JointModelFreeFlyer, (0.1, 0.2, 0.3, 0.4, 0.5, 0.6)),
    "universal": (lambda: pin.JointModelUniversal(*np.eye(3)[:2]), (0.1, 0.2)),
    "spherical_zyx": (pin.JointModelSphericalZYX, (0.1, 0.2, 0.3)),
}


def table(first):
    """Rows of the table whose first column is called so: name and cells, without backquotes."""
    head, _, rest = PAGE.partition(f"| {first} | ")[2].partition("\n")
    assert [cell.strip(" `") for cell in head.strip(" |").split("|")] == list(FORMATS)
    rows = [line.strip("| ").split("|") for line in rest.split("\n\n")[0].splitlines()[1:]]
    return {
        row[0].strip(" `"): dict(
            zip(FORMATS, (c.replace("`", "").strip() for c in row[1:]), strict=True)
        )
        for row in rows
    }


def times(tags):
    """Tags with how often each is there."""
    return " + ".join(
        tag if count == 1 else f"{count} {tag}" for tag, count in Counter(tags).items()
    )


def loops_in(exported, to):
    """What closes the loop in a file."""
    if added := [word for note in exported.notes for word in ("rod", "welded") if word in note]:
        return {"rod": "rod", "welded": "hub"}[added[0]]
    root = parse(exported.paths[0]).getroot()
    match to:
        case "mjcf":
            return times(element.tag for element in root.iterfind("equality/*"))
        case "sdf":
            return times(
                joint.get("type")
                for joint in root.iterfind("model/joint")
                if {joint.get("name")} & {"hand-wall", "wall-hand"}
            )
        case "extended-urdf":
            return times(yaml.safe_load(exported.paths[1].read_text())["type"])
        case "urdf-plus":
            return times(
                e.get("type") for tag in ("loop", "constraint") for e in root.iterfind(tag)
            )


@pytest.mark.parametrize("kind", mostly_slow(LOOPS, ("universal",)))
def test_loops(kind, tmp_path):
    mechanism = hinged(LOOPS[kind], ("hand", "wall"))
    row = table("loop")[kind]
    for to in XML:
        exported = pj.export(mechanism, to=to, file=path_of(tmp_path, to), force=True)
        assert row[to] == loops_in(exported, to), to
        for path in exported.paths:
            path.unlink()
    assert row["toml"] == kind


def moving(kind, driven):
    """A body that moves so, with a hinge on it."""
    make, value = JOINTS[kind]
    model = pin.Model()
    wide, none = np.full(make().nq, 1e6), np.full(make().nv, 1e6)
    place = pin.SE3(pin.exp3(np.array([0.3, 0.2, 0.1])), np.array([0.1, 0.2, 0.3]))
    base = model.addJoint(0, make(), place, "base", none, none, -wide, wide)
    one = np.ones(1)
    arm = model.addJoint(base, pin.JointModelRY(), place, "arm", one, one, -one, one)
    model.addFrame(pin.Frame("tool", arm, 0, place, pin.FrameType.OP_FRAME))
    motors = ["base", "arm"] if driven else ["arm"]
    return pj.Mechanism.from_pinocchio(model, [], motors, "tool", home={"base": value}, name=kind)


def joints_in(exported, to):
    """The types of the joints that the base became."""
    root = parse(exported.paths[1 if to == "toml" else 0]).getroot()
    paths = {"mjcf": ".//body/joint", "sdf": "model/joint"}
    kinds = []
    for joint in root.iterfind(paths.get(to, "joint")):
        name, kind = joint.get("name"), joint.get("type")
        if name.startswith("base") and kind != "fixed":
            kinds.append(kind)
    if to == "extended-urdf":
        closures = yaml.safe_load(exported.paths[1].read_text())
        kinds = closures["joint_type"] or kinds
    if to == "toml":
        spec = pj.load(exported.paths[0]).spec
        beside = ["spherical"] * len(spec.spherical) + ["helical"] * len(spec.helical)
        kinds = beside or kinds
    geared = {"mjcf": "equality/joint", "sdf": "model/joint/axis/mimic"}.get(to, "joint/mimic")
    return times(kinds) + ", geared" * (root.find(geared) is not None)


@pytest.mark.parametrize("kind", mostly_slow(JOINTS, ("helical",)))
def test_joints(kind, tmp_path):
    row = table("joint")[kind]
    for driven in (False, True):
        for to in FORMATS:
            cell = re.fullmatch(r"(.*?)(; as a motor refused)?", row[to])
            path = path_of(tmp_path, to)
            if cell[1] == "refused" or (cell[2] and driven):
                with pytest.raises(pj.ArgumentError, match="would do"):
                    pj.export(moving(kind, driven), to=to, file=path)
                continue
            exported = pj.export(moving(kind, driven), to=to, file=path)
            assert joints_in(exported, to) == cell[1], to
            for made in exported.paths:
                made.unlink()


def test_all_kinds_are_in_the_tables():
    assert set(table("joint")) == set(JOINTS)
    assert set(table("loop")) == set(LOOPS)
