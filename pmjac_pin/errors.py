"""The errors of this library: one base class, so that one ``except`` catches them all.

Each child is also the builtin that fits, so that code which knows nothing of this library
still catches it, and keeps its numbers as attributes. All of them survive pickling, as they
must to come back from a worker process.
"""

from __future__ import annotations

import difflib
from collections.abc import Iterable, Sequence
from typing import Any


class PmjacError(Exception):
    """Base class of every error that this library raises.

    Parameters
    ----------
    message : str
        One sentence: what was given, what is wrong, what would be right.
    **details
        Set as attributes, e.g. ``residual_norm`` or ``tolerance``.
    """

    def __init__(self, message: str, **details: Any) -> None:
        super().__init__(message)
        self.__dict__.update(details)

    def __str__(self) -> str:
        # KeyError, a base of UnknownNameError, would print the repr of the message.
        return str(self.args[0])


class ModelFileError(PmjacError, ValueError):
    """A model file or its URDF cannot be read or contradicts itself.

    Attributes
    ----------
    path : str
        The file at fault, where there is one.
    """

    path: str = ""


class UnknownNameError(PmjacError, KeyError):
    """A mechanism, joint, frame, pose or parameter that does not exist.

    Attributes
    ----------
    name : str
        The name as given.
    candidates : tuple of str
        The names that exist.
    """

    name: str
    candidates: tuple[str, ...]


class ArgumentError(PmjacError, ValueError):
    """A value of the wrong count, type or range."""


class LimitError(ArgumentError):
    """A motor value outside its joint's limits.

    Attributes
    ----------
    joint : str
    value, lower, upper : float
        In m or rad.
    """

    joint: str
    value: float
    lower: float
    upper: float


class ClosureError(PmjacError, RuntimeError):
    """The loops cannot be closed at the values asked for.

    Attributes
    ----------
    residual_norm : float
        The smallest gap found, in m.
    q : ndarray, shape (nq,)
        Where that was: the best configuration found. Its loops are open, unless
        the path was stopped by a singularity: then it is the last closed one.
    actuated : ndarray, shape (n,)
        The motor values of `q`.
    """

    residual_norm: float
    q: Any
    actuated: Any


class SingularError(PmjacError, ArithmeticError):
    """The equivalent Jacobian does not exist here, because K* drops below its generic rank.

    Attributes
    ----------
    singular_value : float
        The singular value of K*, relative to the largest, that vanishes.
    tolerance : float
        The relative tolerance below which it counts as zero.
    free_motion : dict of str to float
        The passive rates of the motion that comes free with all motors locked, by name.
    """

    singular_value: float
    tolerance: float
    free_motion: dict[str, float]


class IdleMotionError(SingularError):
    """The tool is moved by a passive motion that no motor commands, at every pose."""


class ForbiddenRatesError(SingularError):
    """The loops forbid some motor rates, so that the motors cannot be moved at will.

    Attributes
    ----------
    forbidden_rates : ndarray, shape (n, k)
        Orthonormal columns: the directions of motor rates that the loops do not allow.
    """

    forbidden_rates: Any


class MissingDependencyError(PmjacError, ImportError):
    """An optional package is needed and not installed."""


def did_you_mean(name: str, candidates: Iterable[str]) -> str:
    """Return ``"; did you mean 'x'?"``, or the list of what there is when nothing is near."""
    known = tuple(candidates)
    near = difflib.get_close_matches(name, known, n=2, cutoff=0.6)
    if near:
        return f"; did you mean {' or '.join(map(repr, near))}?"
    return f"; there are: {', '.join(known)}" if known else "; there are none"


def unknown_name(kind: str, name: str, candidates: Sequence[str]) -> UnknownNameError:
    """Build the error for a name that does not exist.

    Examples
    --------
    >>> print(unknown_name("joint", "thet1", ["theta1", "phi1"]))
    unknown joint 'thet1'; did you mean 'theta1'?
    """
    message = f"unknown {kind} {name!r}{did_you_mean(name, candidates)}"
    return UnknownNameError(message, name=name, candidates=tuple(candidates))
