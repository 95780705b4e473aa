"""The command line as a process: from its first moment to its last, Ctrl-C ends it silently.

Nothing is imported here but what Python has loaded by then: importing the rest takes a second,
and is what is interrupted most.
"""

import os
import signal
import sys

from pmjac_pin.cli.exit_status import INTERRUPTED

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Sequence


def main(argv: "Sequence[str] | None" = None) -> int:
    """Run the command line.

    Parameters
    ----------
    argv : sequence of str, optional
        The arguments; when None, those of the process, which is to end with this function.

    Returns
    -------
    int
        The exit status.
    """
    if argv is not None:
        return _run_argv(argv)
    # Where Ctrl-C is ignored, as in the background of a script, it stays so.
    if signal.getsignal(signal.SIGINT) is not signal.default_int_handler:
        return _run_argv(sys.argv[1:])
    signal.signal(signal.SIGINT, _leave)  # C code that is being imported may lose an exception
    from pmjac_pin.cli.running import import_commands  # noqa: PLC0415

    import_commands(sys.argv[1:])
    try:
        signal.signal(signal.SIGINT, signal.default_int_handler)
        status = _run_argv(sys.argv[1:])
    except KeyboardInterrupt:  # a second one
        status = INTERRUPTED
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # all is done; Python's end would show a traceback
    return status


def _run_argv(argv: "Sequence[str]") -> int:
    from pmjac_pin.cli.running import run_command  # noqa: PLC0415

    return run_command(argv)


def _leave(*_: object) -> None:
    """End at once: nothing has been begun."""
    os._exit(INTERRUPTED)
