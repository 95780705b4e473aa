"""The catalogue's mechanisms by their numbers, kept beside them: none is assembled for a table.

``models/catalogue.json`` has them as `make readme` computed them, each with a digest of the files
it was computed from. What does not fit the files is not used.
"""

from __future__ import annotations

import hashlib
import tomllib
from typing import TypeAlias

import msgspec

from pmjac_pin.files.catalog import data_folder, find_model_file, find_urdf

#: The name of a mechanism ↦ its numbers.
Catalogue: TypeAlias = "dict[str, MechanismNumbers]"


class MechanismNumbers(msgspec.Struct, frozen=True):
    """What a table of mechanisms shows of one.

    Attributes
    ----------
    mobility : int or None
        nv − rank [K K*] in general; None where it is not known.
    freedoms : int
        nv, those of all joints.
    motors, loops, rows : int
        How many there are; rows are those of η.
    description : str
    poses : tuple of str
        By their names.
    """

    name: str
    mobility: int | None
    freedoms: int
    motors: int
    loops: int
    rows: int
    description: str
    poses: tuple[str, ...]


class _Kept(msgspec.Struct, frozen=True):
    digest: str
    numbers: MechanismNumbers


def kept_numbers() -> Catalogue:
    """Return the numbers of those mechanisms whose files are as they were."""
    path = data_folder() / "models" / "catalogue.json"
    try:
        kept = msgspec.json.decode(path.read_bytes(), type=dict[str, _Kept])
    except (OSError, msgspec.MsgspecError):
        return {}
    return {name: one.numbers for name, one in kept.items() if one.digest == _model_digest(name)}


def kept_text(catalogue: Catalogue) -> str:
    """Return ``models/catalogue.json`` with the numbers of the catalogue's mechanisms."""
    kept = {name: _Kept(_model_digest(name), numbers) for name, numbers in catalogue.items()}
    return msgspec.json.format(msgspec.json.encode(kept), indent=1).decode() + "\n"


def _model_digest(name: str) -> str:
    """Return a digest of a model file and of its URDF."""
    path = find_model_file(name)
    model = path.read_bytes()
    urdf = find_urdf(tomllib.loads(model.decode())["urdf"], path)
    return hashlib.sha256(model + urdf.read_bytes()).hexdigest()
