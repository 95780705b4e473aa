"""Closed-chain mechanisms on Pinocchio: the equivalent Jacobian J_eq = J − J* K*⁻¹ K."""

import importlib

TYPE_CHECKING = False  # that of `typing` takes longer to import than all else here
if TYPE_CHECKING:
    from types import ModuleType
    from typing import Any

    from pmjac_pin.interface import *  # noqa: F403


def __getattr__(name: str) -> "Any":
    """Import the interface when something of it is asked for.

    So `import pmjac_pin` is quick, as the command line needs it to be, which has to end without a
    word when it is interrupted while everything else is imported.
    """
    if name.startswith("__") and name != "__all__":
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    interface = _interface()
    # What was imported on the way, such as `pmjac_pin.loading`, is an attribute by now.
    return globals()[name] if name in globals() else getattr(interface, name)


def __dir__() -> "list[str]":
    return sorted({*globals(), *_interface().__all__})


def _interface() -> "ModuleType":
    return importlib.import_module("pmjac_pin.interface")
