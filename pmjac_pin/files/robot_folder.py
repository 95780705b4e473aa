"""Robot folders: the URDF that a folder, or the YAML file of an extended URDF, stands for."""

from __future__ import annotations

from pathlib import Path

from pmjac_pin.errors import ModelFileError, enumerated
from pmjac_pin.files.user_path import is_file, shown_path

YAML = (".yaml", ".yml")
_SAY_MORE = (".toml", ".sdf", ".world")  # than a URDF beside them: they may hold its loops
_MOST_ENTRIES = 10_000  # of a folder: what is larger is no robot's


def urdf_of(path: Path) -> Path:
    """Return the URDF in a folder, or that of a YAML file.

    In a folder the one of its name, or ``robot.urdf``, or the only one.

    Raises
    ------
    ModelFileError
        There is none; there are several, or files that may say more, and it is not clear which is
        meant; a YAML file that no URDF is read with.
    """
    return _of_yaml(path) if path.suffix.lower() in YAML else _in_folder(path, path.name)


def _of_yaml(path: Path) -> Path:
    from pmjac_pin.files.urdf.extended_urdf import closure_yaml_beside  # noqa: PLC0415

    found = _in_folder(path.parent, path.stem)
    beside = closure_yaml_beside(found)
    if is_file(path) and (beside is None or not beside.samefile(path)):
        message = (
            f"{shown_path(path)}: {found.name} is not read with this file; name it "
            f"{found.stem}.yaml or robot.yaml"
        )
        raise ModelFileError(message, path=str(path))
    return found


def _in_folder(folder: Path, name: str) -> Path:
    files = _files(folder)
    urdfs = [file for file in files if file.suffix.lower() == ".urdf"]
    others = [file for file in files if file.suffix.lower() in _SAY_MORE]
    named = [urdf for stem in (name, "robot") for urdf in urdfs if urdf.stem == stem]
    where = shown_path(folder)
    if not urdfs:
        told = f"; there are: {enumerated([file.name for file in files])}" if files else ""
        raise ModelFileError(f"{where}: there is no URDF in this folder{told}", path=str(folder))
    if others or not (named or len(urdfs) == 1):
        told = enumerated([file.name for file in (*others, *urdfs)])
        raise ModelFileError(f"{where}: which file is meant? There are: {told}", path=str(folder))
    return (named or urdfs)[0]


def _files(folder: Path) -> list[Path]:
    found = []
    try:
        for count, entry in enumerate(folder.iterdir()):
            if count > _MOST_ENTRIES:
                message = f"{shown_path(folder)}: more than {_MOST_ENTRIES} files"
                raise ModelFileError(message, path=str(folder))
            found.append(entry)
    except OSError as error:
        message = f"{shown_path(folder)}: {error.strerror}"
        raise ModelFileError(message, path=str(folder)) from None
    return sorted(found)
