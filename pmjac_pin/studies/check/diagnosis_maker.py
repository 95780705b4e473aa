"""From a mechanism, or as much of it as could be built, to its Diagnosis."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import msgspec

from pmjac_pin.errors import NoMotorsError, PmjacError
from pmjac_pin.files.foreign_model import links_from_the_ends
from pmjac_pin.loading import load
from pmjac_pin.mechanism import Mechanism
from pmjac_pin.studies.check.diagnosis import Diagnosis, Finding
from pmjac_pin.studies.check.findings import in_order
from pmjac_pin.studies.check.mechanism_diagnosis import of_mechanism, regular_pose
from pmjac_pin.studies.check.unbuilt_diagnosis import of_error
from pmjac_pin.studies.check.undriven import commanding, undriven


def check(source: str | Path | Mechanism | PmjacError, **options: Any) -> Diagnosis:
    """Check a model: what it is made of, what its loops do, and what is wrong with it.

    Parameters
    ----------
    source : str, Path, Mechanism or PmjacError
        A name or a path as `load` takes it; a mechanism; or the error that `load` or
        `Mechanism.from_pinocchio` raised because the mechanism could not be built.
    **options
        Of `load`, where `source` is a name or a path.

    Returns
    -------
    Diagnosis
        `findings`, the worst first, and the facts that they rest on. Also where the home pose
        does not assemble, or nobody names motors, which are findings then.

    Raises
    ------
    ModelFileError, UnknownNameError, ArgumentError
        There is nothing to check: a file that cannot be read, names that do not exist.
    NoToolError
        The mechanism has no tool, and its model no link that could be one.

    Examples
    --------
    >>> import pmjac_pin as pj
    >>> diagnosis = pj.check("four_bar")
    >>> diagnosis.severity, diagnosis.mobility.mobility, diagnosis.mobility.gruebler
    ('note', 1, 0)
    >>> [finding.code for finding in pj.check("four_bar", parameters={"l1": 100}).findings][0]
    'home-open'
    """
    if isinstance(source, Mechanism):
        return _diagnosed(source)
    if isinstance(source, PmjacError):
        return of_error(source)
    try:
        mechanism = load(source, **options)
    except NoMotorsError as error:
        return _undriven(source, error.candidates, options)
    except PmjacError as error:
        if error.source is not None and error.source.spec.tool.is_none:
            tool = links_from_the_ends(error.source.urdf)[0]
            return _without_tool(check(source, **{**options, "tool": tool}))
        return of_error(error)
    return _diagnosed(mechanism)


def _undriven(
    source: str | Path, candidates: tuple[str, ...], options: dict[str, Any]
) -> Diagnosis:
    """Return what is known whichever of these joints are motors: one of them stands for all."""
    given = {**options, "actuated": candidates[:1]}
    try:
        mechanism = load(source, **given)
    except PmjacError:
        return undriven(check(source, **given), candidates, ())
    if mechanism.problem.partition.isolated:
        return undriven(_diagnosed(mechanism), candidates, ())
    return undriven(
        _diagnosed(mechanism), *commanding(mechanism, regular_pose(mechanism), candidates)
    )


def _diagnosed(mechanism: Mechanism) -> Diagnosis:
    """Return the diagnosis, by the end of the longest chain where no frame is the tool."""
    if not mechanism.spec.tool.is_none:
        return of_mechanism(mechanism)
    if not mechanism.possible_tools:
        mechanism.need_tool()
    tool = mechanism.possible_tools[0]
    return _without_tool(of_mechanism(mechanism.with_tool(tool)))


def _without_tool(diagnosis: Diagnosis) -> Diagnosis:
    """Say of a diagnosis that nobody has named the tool that it takes."""
    [tool] = diagnosis.tool
    message = f"No frame is named as the tool; what is said of one here is of {tool!r}."
    advice = "Name it with `tool`: that link ends the longest chain."
    untold = Finding("warning", "no-tool", message, advice)
    return msgspec.structs.replace(diagnosis, findings=in_order([untold, *diagnosis.findings]))
