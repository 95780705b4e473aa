"""Closed-chain mechanisms on Pinocchio: the equivalent Jacobian J_eq = J − J* K*⁻¹ K.

`__init__.pyi` lists the public names; each is imported when it is asked for.
"""

TYPE_CHECKING = False  # that of `typing` takes longer to import than all else here
if TYPE_CHECKING:
    from typing import Any

_attached: "tuple[Any, Any, list[str]] | None" = None


def __getattr__(name: str) -> "Any":
    """Import what is asked for.

    So `import pmjac_pin` is quick, as the command line needs it to be, which has to end without a
    word when it is interrupted while everything else is imported.
    """
    if name == "__all__":
        return _lazy()[2]
    if name.startswith("_"):
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    try:
        return _lazy()[0](name)
    except OSError as error:  # no file descriptor may be left to read a module by
        from pmjac_pin.errors import PmjacError  # noqa: PLC0415

        if isinstance(error, PmjacError):
            raise
        raise PmjacError(f"pmjac_pin.{name} cannot be imported: {error.strerror}") from error


def __dir__() -> "list[str]":
    modules = ("__name__", "__doc__", "__file__", "__path__")  # what tools ask a module for
    return sorted({*modules, *_lazy()[2]})


def _lazy() -> "tuple[Any, Any, list[str]]":
    """Return how names are looked up, and which there are."""
    global _attached  # noqa: PLW0603
    if _attached is None:
        from lazy_loader import attach_stub  # noqa: PLC0415

        _attached = attach_stub(__name__, __file__)
    return _attached
