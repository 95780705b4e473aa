"""The command line: ``pmjac`` with list, report, modes, check, plot, demo, view and convert.

Exit status 0; 1 where ``check`` finds an error in the model; 2 with one line on stderr when
something is wrong; 130 on Ctrl-C.
"""

from __future__ import annotations

import importlib.metadata
import re
import sys
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, TypeAlias

import numpy as np
from cyclopts import App, CycloptsError, Parameter, UnusedCliTokensError

from pmjac_pin.blocks import Block, Verbatim
from pmjac_pin.catalog import list_mechanisms
from pmjac_pin.catalogue_table import catalogue_table, poses_table
from pmjac_pin.configuration import Configuration
from pmjac_pin.convert import convert
from pmjac_pin.demo import FIGURE, demo_blocks, run_demo
from pmjac_pin.diagnosis_maker import check
from pmjac_pin.diagnosis_tables import diagnosis_blocks
from pmjac_pin.errors import ArgumentError, LimitError, PmjacError
from pmjac_pin.loading import load
from pmjac_pin.mechanism import Mechanism
from pmjac_pin.mode_sheet import modes_figure
from pmjac_pin.modes_report import make_modes_report
from pmjac_pin.modes_tables import modes_blocks
from pmjac_pin.plotting import save_figure
from pmjac_pin.pose_figure import save_pose_figure
from pmjac_pin.report import to_json
from pmjac_pin.report_maker import make_report
from pmjac_pin.tables import report_blocks
from pmjac_pin.terminal import draw, new_console, one_line, write

#: What a command returns: text as it is, or blocks to be drawn.
Output: TypeAlias = "str | Iterable[Block] | None"


@dataclass(frozen=True, slots=True)
class _Verdict:
    """What a command returns together with the exit status."""

    output: Output
    status: int


_EXAMPLE = "Example: pmjac report four_bar --at 1.2 --set l1=1.1,l2=2.9"


def _version() -> str:
    try:
        return f"pmjac {importlib.metadata.version('pmjac_pin')}"
    except importlib.metadata.PackageNotFoundError:
        return "pmjac (not installed: run from its source folder)"


app = App(
    name="pmjac",
    help="Closed-chain mechanisms on Pinocchio: the equivalent Jacobian, with names and units.",
    help_epilogue=_EXAMPLE,
    version=_version,
    group_parameters="Options",
    result_action="return_value",
    suppress_keyboard_interrupt=False,
    default_parameter=Parameter(negative=(), show_default=False),
)

Name: TypeAlias = Annotated[
    str,
    Parameter(help="A name that pmjac list shows, or the path of a model file, URDF, MJCF or SDF."),
]
At: TypeAlias = Annotated[str | None, Parameter(help="Motor values, m or rad, such as 0.5,1,2.")]
From: TypeAlias = Annotated[
    str | None,
    Parameter(name="--from", help="The pose to show or, with --at, to walk from (default: home)."),
]
Frame: TypeAlias = Annotated[
    str, Parameter(help="Of the twist: LOCAL, WORLD or LOCAL_WORLD_ALIGNED (default).")
]
Settings: TypeAlias = Annotated[
    list[str] | None,
    Parameter(name="--set", help="Parameters, such as l1=1.2,l2=3; may be repeated."),
]
Actuated: TypeAlias = Annotated[
    str | None, Parameter(help="The motors, such as a,b, instead of those that the file tells.")
]
ToolFrame: TypeAlias = Annotated[
    str | None, Parameter(name="--tool", help="The tool's frame, instead of the file's.")
]
Locked: TypeAlias = Annotated[
    str | None, Parameter(help="Joints to hold at their home values, such as spring1,spring2.")
]
Tolerance: TypeAlias = Annotated[
    float | None, Parameter(help="Gap in m that counts as closed, where numbers are rounded.")
]


@app.command(name="list")
def list_command() -> Output:
    """Show the mechanisms that come with the library, and their poses."""
    mechanisms = [load(name) for name in list_mechanisms()]
    return [catalogue_table(mechanisms), poses_table(mechanisms)]


@app.command(name="report")
def report_command(
    mechanism: Name,
    /,
    *,
    at: At = None,
    from_: From = None,
    frame: Frame = "LOCAL_WORLD_ALIGNED",
    set_: Settings = None,
    actuated: Actuated = None,
    tool: ToolFrame = None,
    locked: Locked = None,
    tolerance: Tolerance = None,
    json: Annotated[bool, Parameter(help="Write JSON: all digits, SI units.")] = False,
) -> Output:
    """Show all that is known at one pose, as tables or as JSON."""
    loaded = _load(mechanism, set_, actuated, tool, locked, tolerance)
    configuration, names = _configuration(loaded, at, from_)
    report = make_report(configuration, frame.upper(), **names)
    return f"{to_json(report)}\n" if json else report_blocks(report)


@app.command(name="modes")
def modes_command(
    mechanism: Name,
    /,
    *,
    at: At = None,
    from_: Annotated[
        str | None,
        Parameter(name="--from", help="In place of --at: a pose with these motor values."),
    ] = None,
    set_: Settings = None,
    actuated: Actuated = None,
    tool: ToolFrame = None,
    locked: Locked = None,
    tolerance: Tolerance = None,
    no_limits: Annotated[bool, Parameter(help="Let joints go beyond their limits.")] = False,
    seed: Annotated[int, Parameter(help="Of the random starts (default: 0).")] = 0,
    unseen: Annotated[
        float, Parameter(help="Largest share of starts that may lead elsewhere (default: 0.002).")
    ] = 2e-3,
    confidence: Annotated[float, Parameter(help="Of that bound (default: 0.99).")] = 0.99,
    most_starts: Annotated[
        int, Parameter(help="Starts after which to give up on it (default: 200000).")
    ] = 200_000,
    no_proof: Annotated[bool, Parameter(help="Leave it at the search's statistics.")] = False,
    json: Annotated[bool, Parameter(help="Write JSON: all digits, SI units.")] = False,
    output: Annotated[
        Path | None,
        Parameter(name=["--output", "-o"], help="Draw the modes, too: a .png, .pdf or .svg."),
    ] = None,
) -> Output:
    """Find all closed poses at these motor values, and say what is known of their number."""
    machine = _load(mechanism, set_, actuated, tool, locked, tolerance)
    values = _motor_values(machine, at, from_)
    modes = machine.assembly_modes(
        values,
        rng=seed,
        limits=not no_limits,
        unseen=unseen,
        confidence=confidence,
        most_starts=most_starts,
        proof=not no_proof,
    )
    report = make_modes_report(machine, values, modes, limits=not no_limits)
    drawn: list[Block] = []
    if output is not None:
        save_figure(modes_figure(modes, report), output)
        drawn = [Verbatim(str(output))]
    return f"{to_json(report)}\n" if json else [*modes_blocks(report), *drawn]


@app.command(name="check")
def check_command(
    mechanism: Name,
    /,
    *,
    set_: Settings = None,
    actuated: Actuated = None,
    tool: ToolFrame = None,
    locked: Locked = None,
    tolerance: Tolerance = None,
    json: Annotated[bool, Parameter(help="Write JSON: all digits, SI units.")] = False,
) -> _Verdict:
    """Show what a model is made of and what is wrong with it; exit status 1 for an error."""
    options = _options(actuated, tool, locked, tolerance)
    diagnosis = check(mechanism, parameters=_parameters(set_ or ()), **options)
    output: Output = f"{to_json(diagnosis)}\n" if json else diagnosis_blocks(diagnosis)
    return _Verdict(output, 1 if diagnosis.severity == "error" else 0)


@app.command(name="plot")
def plot_command(
    mechanism: Name,
    /,
    *,
    output: Annotated[
        Path, Parameter(name=["--output", "-o"], help="The file: .png, .pdf or .svg.")
    ],
    at: At = None,
    from_: From = None,
    frame: Frame = "LOCAL_WORLD_ALIGNED",
    set_: Settings = None,
    actuated: Actuated = None,
    tool: ToolFrame = None,
    locked: Locked = None,
    tolerance: Tolerance = None,
) -> Output:
    """Draw the velocity ellipsoid at one pose and its sections; print the file's path."""
    loaded = _load(mechanism, set_, actuated, tool, locked, tolerance)
    configuration, names = _configuration(loaded, at, from_)
    report = make_report(configuration, frame.upper(), **names)
    ellipsoid = configuration.jacobian(frame.upper()).velocity_ellipsoid()
    save_pose_figure(report, ellipsoid, output)
    return [Verbatim(str(output))]


@app.command(name="demo")
def demo_command(
    *,
    output: Annotated[
        Path | None,
        Parameter(name=["--output", "-o"], help="The figure (default: three_rps_lecture_b.png)."),
    ] = None,
) -> Output:
    """Work through the lecture's pose B of the 3-RPS and draw its figure."""
    return demo_blocks(run_demo(output or FIGURE))


@app.command(name="view")
def view_command(
    mechanism: Name,
    /,
    *,
    at: At = None,
    from_: From = None,
    set_: Settings = None,
    actuated: Actuated = None,
    tool: ToolFrame = None,
    locked: Locked = None,
    tolerance: Tolerance = None,
    port: Annotated[
        int | None, Parameter(help="The first port to try (default: 7000); 0 for any.")
    ] = None,
    no_browser: Annotated[bool, Parameter(help="Do not open a browser.")] = False,
) -> Output:
    """Show a live page with sliders, on this machine only, until Ctrl-C."""
    configuration, _ = _configuration(
        _load(mechanism, set_, actuated, tool, locked, tolerance), at, from_
    )
    # Imported when needed: it brings a web server along.
    from pmjac_pin.viewer.serving import serve_until_interrupted  # noqa: PLC0415

    serve_until_interrupted(configuration, port, open_browser=not no_browser)
    return None


@app.command(name="convert")
def convert_command(
    mechanism: Name,
    /,
    *,
    output: Annotated[
        Path, Parameter(name=["--output", "-o"], help="The new model file, such as mine.toml.")
    ],
    actuated: Actuated = None,
    tool: ToolFrame = None,
    locked: Locked = None,
    tolerance: Tolerance = None,
    force: Annotated[bool, Parameter(help="Replace files that exist.")] = False,
) -> Output:
    """Write a model file and its URDF from any format; print their paths."""
    options = _options(actuated, tool, locked, tolerance)
    written = convert(mechanism, output, force=force, **options)
    return "".join(f"{one_line(str(path))}\n" for path in written)


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command line.

    Parameters
    ----------
    argv : sequence of str, optional
        The arguments; the process's own when None.

    Returns
    -------
    int
        The exit status.
    """
    try:
        return _run(sys.argv[1:] if argv is None else argv)
    except BrokenPipeError:  # the reader, such as `head`, has seen enough
        return 0
    except KeyboardInterrupt:
        return 130
    except (PmjacError, CycloptsError, OSError) as error:
        if sys.stderr is not None:
            print(f"pmjac: {one_line(_message(error))}", file=sys.stderr)  # noqa: T201
        return 2


def _run(argv: Sequence[str]) -> int:
    """Write nothing before all is computed, so that an error stands alone."""
    console = new_console()
    # Absurd lengths overflow on their way to an error; NumPy's warnings would stand beside it.
    with console.capture() as capture, np.errstate(all="ignore"):
        output = app(_joined(argv), console=console, exit_on_error=False, print_error=False)
        verdict = output if isinstance(output, _Verdict) else _Verdict(output, 0)
        output = verdict.output
        if output is not None and not isinstance(output, str):
            draw(console, output)
    write(output if isinstance(output, str) else capture.get())
    return verdict.status


def _joined(argv: Sequence[str]) -> list[str]:
    """Write ``--at -0.5,1`` as ``--at=-0.5,1``, which cannot be taken for an option."""
    tokens: list[str] = []
    for token in argv:
        if tokens and tokens[-1] == "--at" and re.match(r"-[\d.]", token):
            tokens[-1] = f"--at={token}"
        else:
            tokens.append(token)
    return tokens


def _message(error: Exception) -> str:
    if isinstance(error, UnusedCliTokensError):
        tokens = error.unused_tokens or []
        lists = any(re.search(r"\d", token) for token in tokens)
        hint = "; numbers are joined by commas, without blanks: --at 0.5,1,2" if lists else ""
        return f"unexpected argument {' '.join(map(repr, tokens))}{hint}"
    if isinstance(error, LimitError):
        limits = f"[{error.lower:g}, {error.upper:g}]"
        return f"motor {error.joint!r} = {error.value:g} is outside its limits {limits}"
    if isinstance(error, OSError) and error.strerror:
        return ": ".join(map(str, filter(None, (error.filename, error.strerror))))
    return str(error)


def _load(name: str, settings: Iterable[str] | None, *model: str | float | None) -> Mechanism:
    return load(name, _parameters(settings or ()), **_options(*model))


def _options(actuated: Any, tool: Any, locked: Any, tolerance: Any) -> dict[str, Any]:
    """Return the options of `load` that the command line gave."""
    held = () if locked is None else _split(locked)
    return {"actuated": _split(actuated), "tool": tool, "locked": held, "tolerance": tolerance}


def _split(names: str | None) -> list[str] | None:
    return None if names is None else [name.strip() for name in names.split(",")]


def _configuration(
    mechanism: Mechanism, at: str | None, pose: str | None
) -> tuple[Configuration, dict[str, str | None]]:
    """Return the configuration asked for, and which pose it is or was reached from."""
    start = "home" if pose is None else pose
    if at is None:
        return mechanism.pose(start), {"pose": start, "start": None}
    return mechanism.close(_numbers(at), guess=start), {"pose": None, "start": start}


def _motor_values(mechanism: Mechanism, at: str | None, pose: str | None) -> Sequence[float]:
    if at is None:
        values: list[float] = mechanism.pose("home" if pose is None else pose).actuated.tolist()
        return values
    if pose is not None:
        raise ArgumentError("--at and --from both give motor values; take one of them")
    return _numbers(at)


def _numbers(text: str) -> list[float]:
    try:
        return [float(item) for item in text.split(",")]
    except ValueError:
        message = f"--at takes numbers joined by commas, such as 0.5,1,2; got {text!r}"
        raise ArgumentError(message) from None


def _parameters(settings: Iterable[str]) -> dict[str, float]:
    parameters: dict[str, float] = {}
    for item in (item for setting in settings for item in setting.split(",")):
        name, _, value = map(str.strip, item.partition("="))
        if name in parameters:
            raise ArgumentError(f"--set gives {name!r} twice")
        try:
            parameters[name] = float(value)
        except ValueError:
            message = f"--set takes NAME=NUMBER, such as l1=1.2; got {item!r}"
            raise ArgumentError(message) from None
    return parameters
