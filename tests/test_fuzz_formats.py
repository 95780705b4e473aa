"""Two thousand mutilated files of every format: each is read or refused in one line."""

from __future__ import annotations

import looped
import mjcf_models
import numpy as np
import pinocchio as pin
import pytest
from mutations import mutations
from test_sdf import SEEDS
from test_vocabulary import GEARS, MJCF, OLD_SDF, SDF

import pmjac_pin as pj
from pmjac_pin.files.catalog import find_model_file
from pmjac_pin.files.source import read_source

YAML = (
    "closed_loop: [[coupler, pin]]\ntype: [3d]\nname_mot: [theta]\njoint_name: [phi1, phi2]\n"
    "joint_type: [SPHERICAL, UJOINT_XY]\nfree_flyer: false\n"
)
MACHINES = (
    looped.two_parents(),
    looped.with_drake(looped.ball_constraint() + looped.loop_joint() + looped.gazebo_joint()),
    looped.with_element(looped.constraint_element() + looped.mimic_plugin()),
    GEARS,
)
MODEL = find_model_file("four_bar").read_text().replace("four_bar.urdf", "robot.urdf")
CUT = (find_model_file("four_bar").parent.parent / "urdf" / "four_bar.urdf").read_text()
OPTIONS = {"actuated": ["theta1"], "tool": looped.TOOL}
# The file that is mutilated, its texts, the file beside it, and what is told of the whole.
FORMATS = {
    "toml": ("robot.toml", (MODEL,), ("robot.urdf", CUT), {}),
    "urdf of a model": ("robot.urdf", (CUT,), ("robot.toml", MODEL), {}),
    "urdf": ("robot.urdf", MACHINES, None, OPTIONS),
    "extended urdf": ("robot.urdf", MACHINES[:1], ("robot.yaml", YAML), {"tool": looped.TOOL}),
    "yaml": ("robot.yaml", (YAML,), ("robot.urdf", MACHINES[0]), {"tool": looped.TOOL}),
    "sdf": ("robot.sdf", (SDF, OLD_SDF, SEEDS), None, {"actuated": ["i"], "tool": "b"}),
    "mjcf": ("robot.xml", (MJCF, *mjcf_models.MODELS.values()), None, {"tool": "world"}),
}
COUNT = 2000
LONGEST = 600  # characters of a message without its path


@pytest.mark.slow
@pytest.mark.parametrize("name", FORMATS)
def test_mutilated_files_are_read_or_refused(tmp_path, name):
    changed, texts, beside, options = FORMATS[name]
    read = changed
    if beside is not None:
        (tmp_path / beside[0]).write_text(beside[1])
        read = next(file for file in ("robot.toml", "robot.urdf") if file in (changed, beside[0]))
    count = 0
    for seed, text in enumerate(texts):
        rng = np.random.default_rng([seed, *name.encode()])
        for wrong in mutations(text.replace("><", ">\n<"), rng, -(-COUNT // len(texts))):
            (tmp_path / changed).write_text(wrong, encoding="utf-8", errors="replace")
            count += 1
            try:
                found = read_source(tmp_path / read, **options)
                pin.buildModelFromXML(found.urdf.kinematic_xml())
            except pj.PmjacError as error:
                assert isinstance(error, pj.UnknownNameError) or str(tmp_path) in str(error)
                said = str(error).replace(str(tmp_path), "")
                assert "\n" not in said
                assert len(said) < LONGEST
    assert count >= COUNT
