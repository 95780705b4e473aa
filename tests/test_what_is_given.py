"""What is no mechanism, no pose, no name: each public function says so in an error of ours."""

from __future__ import annotations

import contextlib

import numpy as np
import pytest

import pmjac_pin as pj

BAD = (
    None, True, 3, -1.0, 1e308, 1e-320, np.nan, np.inf, "x" * 5000, "", "\ud800", "~nosuch", "\0",
    b"x", [], [None], ["a"], [1, 2, 3], {}, {"a": 1}, object(), np.array([object()]), 10**400,
    np.zeros((2, 3, 4)), np.array("a"), float, 1 + 2j, {1: 2}, {"theta1": "x"}, range(3),
)  # fmt: skip
#: Those that take nothing at all, three numbers, or the names of a mapping.
ANSWERED = {
    "parameters", "locked", "guess", "directions", "section", "actuated", "springs", "driven_by",
    "wrench",
}  # fmt: skip
RING = np.arange(18.0).reshape(6, 3)


#: What is no flag, no budget, and cannot be called; Python takes most of it for true.
NO_FLAGS = (
    np.eye(2), np.array([]), np.array([True]), 1, 0, 2.5, np.nan, 10**400, "no", b"x", [True], {},
    object(), 1 + 2j,
)  # fmt: skip


@pytest.fixture(scope="module")
def asked():
    """Public functions of one argument, by a name each; other arguments are good."""
    mechanism = pj.load("five_bar")
    home, many = mechanism.home, pj.batch(mechanism)
    report, jacobian = pj.report(home), home.jacobian()
    ellipsoid, heavy = jacobian.velocity_ellipsoid(), pj.load("ur5").home
    geared = pj.transmission(mechanism, ["phi1", "phi2"]).at(home)
    return {
        "load": pj.load,
        "parameters": lambda x: pj.load("five_bar", x),
        "actuated": lambda x: pj.load("five_bar", actuated=x if x is not None else 3),
        "tool": lambda x: pj.load("five_bar", tool=x if x is not None else 3),
        "tool_rows": lambda x: pj.load("five_bar", tool_rows=x if x is not None else 3),
        "locked": lambda x: pj.load("five_bar", locked=x),
        "close": mechanism.close,
        "guess": lambda x: mechanism.close([1.0, 1.0], guess=x),
        "pose": mechanism.pose,
        "configuration": mechanism.configuration,
        "with_tool": mechanism.with_tool,
        "rows": lambda x: mechanism.with_tool("tip2", rows=x if x is not None else 3),
        "frame": home.jacobian,
        "section": ellipsoid.section,
        "table": report.table,
        "recut": lambda x: pj.recut(mechanism, x),
        "values": lambda x: pj.assembly_modes(mechanism, x, rng=0),
        "modes": lambda x: pj.assembly_modes(x, [1.0, 1.0]),
        "prove": lambda x: pj.prove(x, [1.0, 1.0]),
        "certify": pj.certify,
        "program": pj.program,
        "batch": pj.batch,
        "many": many.close,
        "jacobians": many.jacobian,
        "report": pj.report,
        "plot": pj.plot,
        "planes": lambda x: pj.plot(home, planes=x if x is not None else 3),
        "homotopy": pj.parameter_homotopy,
        "stewart": lambda x: pj.stewart(x, RING, 1.0),
        "height": lambda x: pj.stewart(
            RING % 5, RING % 5, None if isinstance(x, int | float) else x
        ),
        "stroke": lambda x: pj.stewart(RING % 5, RING % 7, 2.0, stroke=x if x is not None else 3),
        "base": lambda x: pj.delta(x, 0.3, 0.7, 0.06),
        "arm": lambda x: pj.delta(0.2, x, 0.7, 0.06),
        "directions": lambda x: pj.delta(0.2, 0.3, 0.7, 0.06, directions=x),
        "motion": lambda x: home.motion(x if x is not None else "x"),
        "accelerated": lambda x: home.motion([1.0, 1.0], x if x is not None else "x"),
        "dynamics": lambda x: heavy.dynamics(x if x is not None else "x"),
        "efforts": heavy.dynamics().efforts,
        "driven": heavy.dynamics().accelerations,
        "wrench": lambda x: home.statics(x if x is not None else "x"),
        "springs": lambda x: home.statics(springs=x),
        "measure": jacobian.gradient,
        "measured": lambda x: jacobian.gradient("log det", x),
        "rates": lambda x: jacobian.velocity_polytope(x, ["vx", "vy"]),
        "forces": lambda x: jacobian.force_polytope([1.0, 1.0], x),
        "point": jacobian.velocity_polytope([1.0, 1.0], ["vx", "vy"]).contains,
        "transmission": lambda x: pj.transmission(mechanism, x),
        "driven_by": mechanism.driven_by,
        "at_joints": geared.transmission.at_joints,
        "geared": geared.motor_rates,
        "gains": geared.stiffness,
        "limits": geared.effort_limits,
    }


@pytest.mark.parametrize("bad", BAD, ids=lambda bad: repr(bad)[:20])
def test_what_is_none_is_told_in_an_error_of_ours(asked, bad):
    answered = []
    for name, ask in asked.items():
        try:
            ask(bad)
        except pj.PmjacError as error:
            assert len(str(error)) < 1200, name
            continue
        except TypeError:  # as NumPy says it
            continue
        answered.append(name)
    assert set(answered) <= ANSWERED, bad


@pytest.fixture(scope="module")
def flagged(tmp_path_factory):
    """Functions of one flag, budget or callable, by a name each; other arguments are good."""
    mechanism, new = pj.load("five_bar"), tmp_path_factory.mktemp("new") / "new.toml"
    home, many, motors = mechanism.home, pj.batch(mechanism), [1.0, 1.0]
    proof, over = pj.prove(mechanism, motors), {"theta1": [1.0]}
    drawn = {
        name: lambda x, name=name: pj.view(home, **{"open_browser": False, name: x})
        for name in ("open_browser", "linear", "angular", "force", "names")
    }
    return drawn | {
        "limits": lambda x: pj.assembly_modes(mechanism, motors, rng=0, limits=x),
        "proof": lambda x: pj.assembly_modes(mechanism, motors, rng=0, proof=x),
        "proven limits": lambda x: pj.prove(mechanism, motors, limits=x),
        "budget": lambda x: pj.prove(mechanism, motors, budget=x),
        "match": proof.match,
        "enforce_limits": lambda x: mechanism.close(motors, enforce_limits=x),
        "convert": lambda x: pj.convert("five_bar", new, force=x),
        "resume": lambda x: pj.sweep(mechanism, over, workers=1, resume=x),
        "swept": lambda x: pj.sweep(mechanism, over, workers=1, progress=x),
        "closed": lambda x: many.close([motors], progress=x),
        "jacobians": lambda x: many.jacobian([home.q], progress=x),
        "measures": lambda x: many.measures([home.q], progress=x),
        "singularity": lambda x: pj.equivalent_jacobian(home.split_jacobian(), x),
        "rates": lambda x: pj.equivalent_jacobian(home.split_jacobian(), loops=x),
    }


@pytest.mark.parametrize("bad", NO_FLAGS, ids=lambda bad: repr(bad)[:20])
def test_what_is_neither_true_nor_false_is_told_in_an_error_of_ours(flagged, bad):
    answered = []
    for name, ask in flagged.items():
        with contextlib.suppress(pj.PmjacError):
            ask(bad)
            answered.append(name)
    one_row = {"match"} if np.shape(bad) == (2, 2) and np.size(bad) else set()
    assert set(answered) <= one_row


@pytest.mark.parametrize("bad", [np.nan, -1, -1e-9, "a", None, True, [1], np.eye(2), 1 + 2j])
def test_what_is_no_budget_is_told_in_an_error_of_ours(bad):
    for name in ("boxes", "seconds"):
        with pytest.raises(pj.ArgumentError, match=name):
            pj.Budget(**{name: bad})


def test_numpys_own_flags_are_flags():
    mechanism = pj.load("five_bar")
    modes = pj.assembly_modes(mechanism, [1.0, 1.0], rng=0, proof=np.False_, limits=np.True_)
    assert modes.evidence.kind == "statistics"
