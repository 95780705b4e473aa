"""The errors of this library: one base class, so that one ``except`` catches them all.

Each child is also the builtin that fits, so that code which knows nothing of this library
still catches it, and keeps its numbers as attributes. All of them survive pickling, as they
must to come back from a worker process.
"""

from __future__ import annotations

import difflib
import reprlib
from collections.abc import Iterable, Sequence
from typing import Any

_LONGEST_NAME = 200  # characters: near matches of longer ones take for ever
_MOST_NAMES = 12  # listed in one message
_LONGEST_LIST = 400  # characters of them
_LONGEST_QUOTE = 200  # characters of what somebody gave
_NOT_PICKLED = ("built_of", "source")


class PmjacError(Exception):
    """Base class of every error that this library raises.

    Parameters
    ----------
    message : str
        One sentence: what was given, what is wrong, what would be right.
    **details
        Set as attributes, e.g. ``residual_norm`` or ``tolerance``.

    Attributes
    ----------
    built_of : tuple or None
        The Pinocchio model, the spec and the parameters' values of a mechanism whose home pose
        does not assemble, for `check`; not pickled.
    source : Source or None
        What the file says, as far; not pickled.
    """

    built_of: Any = None
    source: Any = None

    def __init__(self, message: str, **details: Any) -> None:
        super().__init__(message)
        self.__dict__.update(details)

    def __reduce__(self) -> tuple[Any, ...]:
        known = {name: value for name, value in self.__dict__.items() if name not in _NOT_PICKLED}
        return (type(self), self.args, known)

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


class NoMotorsError(ModelFileError):
    """A file does not say which joints are motors, and nobody else does.

    Attributes
    ----------
    candidates : tuple of str
        Joints that may be: those of one degree of freedom or, where there are none, others.
    """

    candidates: Any = ()


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
    """A value outside its joint's limits: a motor's, or with ``enforce_limits="all"`` any joint's.

    Attributes
    ----------
    joint : str
    value, lower, upper : float
    unit : {"m", "rad"}
    """

    joint: str
    value: float
    lower: float
    upper: float
    unit: str


class ClosureError(PmjacError, RuntimeError):
    """The loops cannot be closed at the values asked for.

    Attributes
    ----------
    residual_norm : float
        The smallest gap found at the values asked for, in m.
    q : ndarray, shape (nq,)
        The configuration of that gap: open, unless another assembly mode closes there.
    actuated : ndarray, shape (n,), or None
        The motor values asked for, where motor values were.
    reached : Configuration or None
        The last closed pose of the path towards them, where there was a path.
    share : float
        The share of the path up to there, 0 to 1.
    loop : str or None
        The loop that stays open most, where a pose does not assemble.
    singular_value : float or None
        Of K* at `reached`, relative to the size of [K K*]: what stopped the path, when small.
    ties : str
        How the loops tie motors to each other where the path began, in words; "" where all of
        them may move at will.
    """

    residual_norm: float
    q: Any
    actuated: Any = None
    reached: Any = None
    share: float = 0.0
    loop: str | None = None
    singular_value: float | None = None
    ties: str = ""


class NoJacobianError(PmjacError, ArithmeticError):
    """There is no equivalent Jacobian: base of the four reasons below."""


class NoEquilibriumError(PmjacError, ArithmeticError):
    """A load drives what neither motors nor loops hold."""


class EffortLimitError(NoEquilibriumError):
    """No efforts within the motors' limits balance a load.

    Attributes
    ----------
    lacking : dict of str to float
        By motor, how much more than its limit it takes, N or N m: of a motor that no other
        relieves, or of several that share the load so that all are beyond by the same factor.
    """

    lacking: dict[str, float]


class NoGradientError(PmjacError, ArithmeticError):
    """A measure has no gradient here: singular values are equal, or zero."""


class NoInertiaError(PmjacError, ArithmeticError):
    """Motors move what has no mass: forces accelerate it beyond bounds."""


class SingularError(NoJacobianError):
    """The equivalent Jacobian does not exist here, because K* drops below its generic rank.

    Attributes
    ----------
    singular_value : float
        The singular value of the dimensionless K* that vanishes, relative to the Frobenius
        norm of [K K*].
    tolerance : float
        What it counts as zero up to.
    free_motion : dict of str to float
        The passive rates of the motion that comes free with all motors locked, by name.
    """

    singular_value: float
    tolerance: float
    free_motion: dict[str, float]


class IdleMotionError(NoJacobianError):
    """The tool is moved by a passive motion that no motor commands, at every pose.

    Attributes
    ----------
    idle_motion : dict of str to float
        The passive rates of that motion, by name, the largest 1.
    """

    idle_motion: dict[str, float]


class NoToolError(NoJacobianError):
    """The mechanism has no tool, whose twist J_eq would give.

    Attributes
    ----------
    frames : tuple of str
        What may be named as one, ends of chains first.
    """

    frames: Any


class ForbiddenRatesError(NoJacobianError):
    """The loops forbid some motor rates, so that the motors cannot be moved at will.

    Attributes
    ----------
    forbidden_rates : ndarray, shape (n, k)
        Orthonormal columns: the directions of motor rates that the loops do not allow.
    """

    forbidden_rates: Any


class OutputError(PmjacError, OSError):
    """A file cannot be written: no right to, no space, or no place for one."""


class WorkerError(PmjacError, RuntimeError):
    """A process that computes for this one has ended before it has answered."""


class MissingDependencyError(PmjacError, ImportError):
    """An optional package is needed and not installed."""


class Interrupted(KeyboardInterrupt):
    """Somebody interrupts what computes many poses, by Ctrl-C for one; what is done is kept.

    No `PmjacError`: ``except KeyboardInterrupt`` catches it, and nothing that means errors does.

    Attributes
    ----------
    done : ManyClosed, ManyJacobians, ManyEllipsoids, ManyMeasures, ManyInGrid, Trajectory, Dataset
        What would have been returned; what is not done has the status NOT_DONE, and NaN, or is left
        out of a trajectory.
    """

    def __init__(self, message: str, done: Any = None) -> None:
        super().__init__(message)
        self.done = done


def shortened(text: str, most: int = _LONGEST_QUOTE) -> str:
    """Return text on one line: as it is, or where it is long its beginning and its end.

    Examples
    --------
    >>> shortened("models/four_bar.toml")
    'models/four_bar.toml'
    >>> shortened("the quick brown fox jumps over the lazy dog", 20)
    'the quick...lazy dog'
    """
    if len(text) > most:
        half = (most - 3) // 2
        text = f"{text[: most - 3 - half]}...{text[len(text) - half :]}"
    return " ".join(text.splitlines())


def quoted(value: object) -> str:
    """Return how messages show what somebody gave: its repr, shortened.

    Examples
    --------
    >>> quoted("theta1"), quoted([1, 2]), quoted(range(10**9))
    ("'theta1'", '[1, 2]', 'range(0, 1000000000)')
    """
    try:
        return shortened(_SHORT_REPR.repr(value))
    except Exception:  # whatever the repr of somebody's class raises
        return f"a {shortened(type(value).__name__)}"


def _short_repr() -> reprlib.Repr:
    short = reprlib.Repr()
    short.maxstring = short.maxother = short.maxlong = _LONGEST_QUOTE
    return short


_SHORT_REPR = _short_repr()


def did_you_mean(name: object, candidates: Iterable[str]) -> str:
    """Return ``"; did you mean 'x'?"``, or the first of what there is when nothing is near."""
    known, given = tuple(candidates), (name if isinstance(name, str) else "")[:_LONGEST_NAME]
    same = [other for other in known if other.lower() == given.lower()]
    near = same or difflib.get_close_matches(given, known, n=2, cutoff=0.6)
    if near:
        return f"; did you mean {' or '.join(map(quoted, near))}?"
    return f"; there are: {enumerated(known)}" if known else "; there are none"


def enumerated(names: Sequence[str], most: int = _MOST_NAMES) -> str:
    """Return names joined by commas: the first of them, and how many more there are.

    Examples
    --------
    >>> enumerated(["l1", "l2"]), enumerated([str(number) for number in range(100)])
    ('l1, l2', '0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11 and 88 more')
    """
    shown: list[str] = []
    for name in names[:most]:
        if shown and sum(map(len, shown)) + len(name) > _LONGEST_LIST:
            break
        shown.append(shortened(name))
    more = f" and {len(names) - len(shown)} more" if len(names) > len(shown) else ""
    return ", ".join(shown) + more


def unknown_name(kind: str, name: object, candidates: Sequence[str]) -> UnknownNameError:
    """Build the error for a name that does not exist.

    Examples
    --------
    >>> print(unknown_name("joint", "thet1", ["theta1", "phi1"]))
    unknown joint 'thet1'; did you mean 'theta1'?
    """
    message = f"unknown {kind} {quoted(name)}{did_you_mean(name, candidates)}"
    return UnknownNameError(message, name=name, candidates=tuple(candidates))
