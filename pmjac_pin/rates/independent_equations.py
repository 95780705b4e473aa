"""Independent equations: combinations of rows that say all that the rows say, and none twice.

For solvers, which refuse equations that repeat or, on open loops, contradict each other.
"""

from __future__ import annotations

from pmjac_pin.errors import SingularError
from pmjac_pin.rates.factorisation import Factorisation
from pmjac_pin.rates.partition import Partition
from pmjac_pin.values.arrays import Array


def independent_loops(partition: Partition, constraint_jacobian: Array, of: str) -> Array:
    """Return combinations (r, p) of the rows of η, in m, r the generic rank of [K K*].

    Parameters
    ----------
    partition : Partition
    constraint_jacobian : ndarray, shape (p, nv)
        ∂η/∂v.
    of : str
        The mechanism's name, for the message.

    Raises
    ------
    SingularError
        The rows lose rank.
    """
    factors = partition.factorise_all(constraint_jacobian)
    leading = leading_rows(factors, partition.constraint_rank, f"the loops of {of!r}")
    return leading * partition.row_scale


def leading_rows(factors: Factorisation, rank: int, of: str) -> Array:
    """Return orthonormal combinations (rank, p) of the rows of a matrix, its largest first.

    Parameters
    ----------
    factors : Factorisation
        Of the matrix, shape (p, k).
    rank : int
        How many there are generically.
    of : str
        What the rows are of, for the message.

    Raises
    ------
    SingularError
        The rows lose rank.
    """
    if factors.rank < rank:
        raise SingularError(f"{of} are singular at this q")
    return factors.left[:, :rank].T
