"""Pickles that are read as they were written, or refused."""

from __future__ import annotations

import pickle
from hashlib import sha256
from typing import Any

from pmjac_pin.errors import ArgumentError, quoted

_DIGEST_SIZE = sha256().digest_size  # bytes, before the pickle
_PROTOCOL = 5


def sealed_pickle(contents: object) -> bytes:
    """Return a pickle behind its digest: `pickle` itself reads another digit as another number.

    Examples
    --------
    >>> unsealed(sealed_pickle({"length": 1.5}), "a length")
    {'length': 1.5}
    """
    said = pickle.dumps(contents, _PROTOCOL)
    return sha256(said).digest() + said


def unsealed(sealed: bytes, what: str) -> Any:
    """Return what was sealed.

    Parameters
    ----------
    sealed : bytes
    what : str
        What it is, for messages.

    Raises
    ------
    ArgumentError
        Not what was written.
    """
    if not isinstance(sealed, bytes):
        raise ArgumentError(f"the pickle of {what} holds bytes, got {quoted(sealed)}")
    said = memoryview(sealed)[_DIGEST_SIZE:]
    if sha256(said).digest() != sealed[:_DIGEST_SIZE]:
        raise ArgumentError(
            f"the pickle of {what} was changed on its way: its {len(said)} bytes do not have the "
            "digest that they were written with; pickle it again"
        )
    return pickle.loads(said)
