"""Evidence: every answer of a study says in the same words what it rests on."""

from __future__ import annotations

import json
import tempfile
from functools import partial
from typing import get_args, get_type_hints

import pytest
from mechanisms import homotopy_of, loaded, mostly_slow

import pmjac_pin as pj
from pmjac_pin.cli import main

KINDS = get_args(get_type_hints(pj.Evidence)["kind"])


def table_around(machine, theta):
    joint = machine.passive[-1]
    ends = sorted(machine.close(theta + s).joint_values[joint] for s in (-0.1, 0.1))
    return pj.transmission_table(machine, {joint: ends})


def motors_to_and_fro(machine, theta):
    return pj.follow(machine, [theta, theta + 0.02, theta])


def exported(machine):
    with tempfile.TemporaryDirectory() as folder:
        return pj.export(machine, to="mjcf", file=f"{folder}/machine.xml")


def slice_of_five_bar(study, **choices):
    """Slices need two motors."""
    bar = loaded("five_bar")
    window = {
        name: (value - 0.2, value + 0.2)
        for name, value in zip(bar.actuated, bar.home.actuated, strict=True)
    }
    return study(bar, bar.actuated, window=window, cells=5, **choices)


STUDIES = {
    pj.AssemblyModes: lambda machine, theta: pj.assembly_modes(machine, theta, rng=0),
    pj.Certificate: lambda machine, theta: pj.certify(machine.close(theta)),
    pj.ComplexModes: lambda machine, theta: homotopy_of(machine.name).at(theta),
    pj.Diagnosis: lambda machine, theta: pj.check(machine),
    pj.OperationModes: lambda machine, theta: homotopy_of(machine.name).operation_modes(),
    pj.ParameterHomotopy: lambda machine, theta: homotopy_of(machine.name),
    pj.Proof: pj.prove,
    pj.NearestSingularity: lambda machine, theta: pj.nearest_singularity(
        machine.home, starts=1, rng=0
    ),
    pj.SingularityFree: lambda machine, theta: pj.singularity_free(machine.home),
    pj.Trajectory: motors_to_and_fro,
    pj.Reached: lambda machine, theta: pj.reach(machine, machine.close(theta).tool_pose()),
    pj.WorkingModes: lambda machine, theta: pj.working_modes(
        machine, machine.close(theta).tool_pose(), rng=0
    ),
    pj.SingularityLocus: lambda *_: slice_of_five_bar(pj.singularity_locus, kinds=["gain"]),
    pj.Workspace: lambda *_: slice_of_five_bar(pj.workspace),
    pj.Exported: lambda machine, theta: exported(machine),
    pj.TransmissionTable: lambda machine, theta: table_around(machine, theta + 0.6),
}


def test_every_answer_that_is_exported_is_tried():
    """Those whose class is defined in a study: none that asks, or is a part of an answer."""
    own = {one for one in map(partial(getattr, pj), pj.__all__) if isinstance(one, type)}
    found = {one for one in own if one.__module__.startswith("pmjac_pin.studies.")}
    silent = {pj.Budget, pj.Program, pj.Transmission, pj.Geared, pj.TransmissionMap}
    parts = {pj.Event, pj.PathBranch, pj.Homecoming, pj.LocusCurve, pj.LocusPoint, pj.Task}
    assert found - {pj.Evidence} - silent - parts == set(STUDIES)


@pytest.mark.parametrize("name", mostly_slow(["four_bar", "slider_crank"], ("four_bar",)))
@pytest.mark.parametrize("kind", STUDIES, ids=lambda kind: kind.__name__)
def test_what_an_answer_rests_on(kind, name):
    machine = loaded(name)
    answer = STUDIES[kind](machine, machine.home.actuated)
    evidence = answer.evidence
    assert isinstance(answer, kind)
    assert type(evidence) is pj.Evidence
    assert evidence.kind in KINDS
    assert str(evidence) == f"{evidence.kind}: {evidence.statement}"
    assert not evidence.statement.startswith(KINDS)
    assert not evidence.statement.endswith(".")
    assert evidence.kind != "statistics" or evidence.confidence


@pytest.mark.parametrize("parameters", [{}, {"l1": 100.0}], ids=["closes", "open"])
def test_the_command_and_its_json_say_it_in_the_same_words(parameters, capsys):
    evidence = pj.check("four_bar", parameters=parameters).evidence
    given = [f"--set={name}={value}" for name, value in parameters.items()]
    main(["check", "four_bar", *given, "--json"])
    assert json.loads(capsys.readouterr().out)["evidence"] == {
        "kind": evidence.kind,
        "statement": evidence.statement,
        "unseen": None,
        "confidence": None,
    }
    main(["check", "four_bar", *given])
    shown = " ".join(capsys.readouterr().out.split())
    assert f"Mobility and ranks rest on {evidence}." in shown


def test_an_answer_of_yes_or_no_is_true_where_it_is_proven():
    machine = loaded("four_bar")
    folding = pj.load("four_bar", {"l0": 4.0, "l1": 1.0, "l2": 2.0, "l3": 3.0})
    answers = [
        *(pj.prove(machine, [0.9], budget=pj.Budget(boxes=boxes)) for boxes in (1, 1000)),
        *map(pj.certify, (machine.home, folding.close([3.1415926]))),
    ]
    assert [bool(answer) for answer in answers] == [False, True, True, False]
    for answer in answers:
        assert answer.evidence.kind == ("proof" if answer else "nothing")
        assert bool(answer.failed) is not bool(answer)
