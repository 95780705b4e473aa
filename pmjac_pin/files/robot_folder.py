"""Robot folders: the URDF that a folder, or the YAML file of an extended URDF, stands for."""

from __future__ import annotations

from pathlib import Path

from pmjac_pin.errors import ModelFileError, enumerated
from pmjac_pin.files.user_path import is_file, is_folder, shown_path

_YAML = (".yaml", ".yml")
_MOST_ENTRIES = 10_000  # of a folder: what is larger is no robot's


def urdf_of(path: Path) -> Path:
    """Return the URDF in a folder, or beside a YAML file; any other path as it is.

    That of the folder's or the YAML file's own name, or ``robot.urdf``, or the only one.

    Raises
    ------
    ModelFileError
        There is none, or several and none of such a name.
    """
    folder, name = path, path.name
    if path.suffix.lower() in _YAML:
        folder, name = path.parent, path.stem
    elif not is_folder(path):
        return path
    for wanted in (name, "robot"):
        if is_file(found := folder / f"{wanted}.urdf"):
            return found
    urdfs = _urdfs(folder)
    if len(urdfs) == 1:
        return urdfs[0]
    where = shown_path(path)
    if not urdfs:
        raise ModelFileError(f"{where}: there is no URDF in this folder", path=str(path))
    told = enumerated([found.name for found in urdfs])
    raise ModelFileError(f"{where}: which URDF is meant? There are: {told}", path=str(path))


def _urdfs(folder: Path) -> list[Path]:
    found = []
    try:
        for count, entry in enumerate(folder.iterdir()):
            if entry.suffix.lower() == ".urdf":
                found.append(entry)
            if count > _MOST_ENTRIES:
                break
    except OSError as error:
        message = f"{shown_path(folder)}: {error.strerror}"
        raise ModelFileError(message, path=str(folder)) from None
    return sorted(found)
