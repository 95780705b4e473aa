"""For JAX: η, K, K* and J_eq of q as a function to compile, map and differentiate.

In waves: of straight-line code, XLA would take minutes to compile some thousands of statements.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Literal

import numpy as np

from pmjac_pin.adapters import importing
from pmjac_pin.algebra.array_program import ArrayProgram
from pmjac_pin.errors import ArgumentError, quoted
from pmjac_pin.studies.program import Program
from pmjac_pin.values.checks import check_kind

with importing("jax"):
    import jax
    import jax.numpy as jnp

_IN_JAX: Any = {
    "+": jnp.add, "-": jnp.subtract, "*": jnp.multiply, "/": jnp.divide, "neg": jnp.negative,
    "sin": jnp.sin, "cos": jnp.cos, "sqrt": jnp.sqrt, "abs": jnp.abs, "max": jnp.maximum,
    "copysign": jnp.copysign, "atan2": jnp.arctan2, "round": jnp.rint,
}  # fmt: skip


def function(
    program: Program, dtype: Literal["float64", "float32"] = "float64"
) -> Callable[..., dict[str, Any]]:
    """Return a program as a function of JAX: q (..., nq) ↦ arrays (..., *shape) by name.

    Where the program has parameters, (..., k), they are its second argument; by default those of
    the mechanism.

    As of the program, whether J_eq exists is for the caller to ask: η = 0, `sigma` > 0, and so on.
    Quaternions, and cosines with their sines, are taken as they are: of length 1.

    Parameters
    ----------
    program : Program
        Of `pmjac_pin.program`.
    dtype : {"float64", "float32"}
        What is computed in. JAX has doubles where it was told so, and single precision otherwise.

    Raises
    ------
    ArgumentError
        No program; doubles, where JAX would make single precision of them.

    Examples
    --------
    >>> import jax, pmjac_pin as pj
    >>> from pmjac_pin.adapters.jax import function
    >>> jax.config.update("jax_enable_x64", True)
    >>> bar = pj.load("four_bar")
    >>> jax.jit(function(pj.program(bar)))(bar.home.q)["J_eq"].shape
    (6, 1)
    """
    check_kind(program, Program)
    if dtype not in ("float64", "float32"):
        raise ArgumentError(f"dtype must be 'float64' or 'float32'; got {quoted(dtype)}")
    if dtype == "float64" and not jax.config.jax_enable_x64:
        told = 'jax.config.update("jax_enable_x64", True)'
        raise ArgumentError(f"JAX computes in single precision: {told}, or dtype='float32'")
    shapes = {name: array.shape for name, array in program.outputs.items()}
    terms = [x for array in program.outputs.values() for x in array.ravel()]
    waves = ArrayProgram.of(program.recording, terms)
    ends = np.cumsum([*map(np.prod, shapes.values())])
    constants, count = waves.constants.astype(dtype), waves.constants.size

    def at(q: Any, parameters: Any = None) -> dict[str, Any]:
        given = _together(program, q, parameters, dtype)
        end = count + given.shape[-1]
        known = jnp.zeros((*given.shape[:-1], waves.size), dtype=dtype)
        known = known.at[..., :count].set(constants).at[..., count:end].set(given)
        for operation, places in waves.steps:
            found = _IN_JAX[operation](*(known[..., place] for place in places))
            known = known.at[..., end : (end := end + found.shape[-1])].set(found)
        parts = jnp.split(known[..., waves.outputs], ends[:-1], axis=-1)
        return {
            name: part.reshape(*given.shape[:-1], *shape)
            for (name, shape), part in zip(shapes.items(), parts, strict=True)
        }

    return at


def _together(program: Program, q: Any, parameters: Any, dtype: str) -> Any:
    """Return the inputs in a row: q, and the parameters of each pose, or of all."""
    rows = [q, program.own_parameters if parameters is None else parameters]
    given = [jnp.asarray(row, dtype=dtype) for row in rows]
    wanted = (program.mechanism.nq, len(program.parameters))
    if (found := tuple(row.shape[-1] if row.ndim else -1 for row in given)) != wanted:
        raise ArgumentError(f"q and parameters have {wanted} entries; got {found}")
    leading = jnp.broadcast_shapes(*(row.shape[:-1] for row in given))
    whole = [jnp.broadcast_to(row, (*leading, row.shape[-1])) for row in given]
    return jnp.concatenate(whole, axis=-1)
