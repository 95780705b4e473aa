"""The command line: ``pmjac`` with list, report, modes, check, plot, view, reach and more.

Exit status 0; 1 where ``check`` finds an error in the model, ``follow`` stops on the way or
``reach`` does not get there; 2 with one line on stderr when something is wrong; 130 on Ctrl-C.
"""

from pmjac_pin.cli.process import main

__all__ = ["main"]
