"""Running a command: from the process's arguments to its output and exit status."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence

import numpy as np
from cyclopts import App, CycloptsError, Parameter, UnusedCliTokensError
from rich.console import Console

from pmjac_pin.cli.exit_status import INTERRUPTED
from pmjac_pin.cli.output import Output, Verdict
from pmjac_pin.errors import PmjacError, shortened
from pmjac_pin.words.terminal import complain, draw, new_console, one_line, write

#: The commands, and what is typed after each, for an example.
_COMMANDS = {
    "list": "",
    "report": "four_bar --at 1.2 --set l1=1.1,l2=2.9",
    "modes": "three_rps --from lecture_a -o modes.png",
    "check": "robot.urdf --actuated hip,knee --tool foot",
    "plot": "three_rps --from lecture_b -o ellipsoid.png",
    "demo": "-o figure.png",
    "view": "three_rps --from lecture_b",
    "convert": "robot.urdf -o robot.toml",
    "export": "three_rps --to mjcf -o three_rps.xml",
    "sweep": "map.toml --resume",
    "workspace": "five_bar --plane x,y --measure dexterity -o map.pdf",
    "locus": "five_bar --plane theta1,theta2 -o locus.pdf",
    "follow": "four_bar --waypoints way.csv --certified -o way_followed.csv",
    "reach": "five_bar --target x=0.2,y=0.4 --modes",
    "transmission": "humanoid_ankle --joints pitch,roll -o ankle.h -o ankle.png",
}

_WITH_NUMBERS = ("--at", "--rates", "--accelerations", "--wrench", "--target")
_OF_PYTHON = re.compile(r"; enforce_limits=False .*$")  # what a message says of its switch
_LONGEST_TYPED = 600  # characters of a message that quotes what was typed


def _version() -> str:
    import importlib.metadata  # noqa: PLC0415 (reads mail)

    try:
        return f"pmjac {importlib.metadata.version('pmjac_pin')}"
    except importlib.metadata.PackageNotFoundError:
        return "pmjac (not installed: run from its source folder)"


app = App(
    name="pmjac",
    help="Closed-chain mechanisms on Pinocchio: the equivalent Jacobian, with names and units.",
    help_epilogue=f"Example: pmjac report {_COMMANDS['report']}",
    version=_version,
    group_parameters="Options",
    result_action="return_value",
    suppress_keyboard_interrupt=False,
    default_parameter=Parameter(negative=(), show_default=False),
)
for _name, _typed in _COMMANDS.items():
    _example = f"Example: pmjac {_name} {_typed}".rstrip()
    app.command(f"pmjac_pin.cli.{_name}:{_name}_command", name=_name, help_epilogue=_example)


def import_commands(argv: Sequence[str]) -> None:
    """Import the command that these arguments name; all, which help tells of, where it is none."""
    for name in argv[:1] if set(argv[:1]) & set(_COMMANDS) else _COMMANDS:
        app[name]


def run_command(argv: Sequence[str]) -> int:
    """Run a command; return the exit status, 130 where it was interrupted."""
    try:
        import_commands(argv)
        return _run_app(argv)
    except BrokenPipeError:  # the reader, such as `head`, has seen enough
        return 0
    except KeyboardInterrupt:
        return INTERRUPTED
    except (PmjacError, CycloptsError, OSError) as error:
        complain(f"pmjac: {one_line(_message(error))}\n")
        return 2


def _run_app(argv: Sequence[str]) -> int:
    """Write nothing before all is computed, so that an error stands alone."""
    console = new_console()
    # Absurd lengths overflow on their way to an error; NumPy's warnings would stand beside it.
    with console.capture() as capture, np.errstate(all="ignore"):
        output = app(
            _with_values_joined(argv), console=console, exit_on_error=False, print_error=False
        )
        verdict = output if isinstance(output, Verdict) else Verdict(output, 0)
        written = _drawn(console, verdict.output)
    write(capture.get() if written is None else written)
    return verdict.status


def _drawn(console: Console, output: Output) -> str | None:
    """Draw blocks on the console; return what is text already."""
    if isinstance(output, Mapping):
        from pmjac_pin.words.plain import to_json  # noqa: PLC0415 (of all that is told of poses)

        return f"{to_json(output)}\n"
    if isinstance(output, str):
        return output
    draw(console, output or ())
    return None


def _with_values_joined(argv: Sequence[str]) -> list[str]:
    """Write ``--at -0.5,1`` as ``--at=-0.5,1``, which cannot be taken for an option.

    And so of the other options that take numbers.
    """
    tokens: list[str] = []
    for token in argv:
        if tokens and tokens[-1] in _WITH_NUMBERS and re.match(r"-[\d.]", token):
            tokens[-1] = f"{tokens[-1]}={token}"
        else:
            tokens.append(token)
    return tokens


def _message(error: Exception) -> str:
    if isinstance(error, UnusedCliTokensError):
        tokens = error.unused_tokens or []
        lists = any(re.search(r"\d", token) for token in tokens)
        hint = "; numbers are joined by commas, without blanks: --at 0.5,1,2" if lists else ""
        return f"unexpected argument {shortened(' '.join(map(repr, tokens)))}{hint}"
    if isinstance(error, PmjacError):
        return _OF_PYTHON.sub("; --beyond-limits takes it all the same", str(error))
    if isinstance(error, OSError) and error.strerror:
        return ": ".join(map(str, filter(None, (error.filename, error.strerror))))
    return shortened(str(error), _LONGEST_TYPED) if isinstance(error, CycloptsError) else str(error)
