"""The catalogue: where model files and URDFs are, in a checkout and in an installed wheel."""

from __future__ import annotations

import os
from pathlib import Path

from pmjac_pin.errors import (
    ArgumentError,
    ModelFileError,
    UnknownNameError,
    did_you_mean,
    quoted,
    shortened,
)
from pmjac_pin.files.text_file import at_file
from pmjac_pin.files.user_path import followed_link, is_file, is_folder, shown_path, user_path

SUFFIXES = (".toml", ".urdf", ".yaml", ".sdf", ".world", ".xml", ".mjcf")  # of a mechanism
_EXAMPLE_ROBOTS = "example-robot-data:"
_LONGEST_PLACES = 300  # characters of all places in which a URDF was looked for


def list_mechanisms() -> tuple[str, ...]:
    """Return the names of the mechanisms that come with the library.

    Examples
    --------
    >>> import pmjac_pin as pj
    >>> "three_rps" in pj.list_mechanisms()
    True
    """
    return tuple(sorted(path.stem for path in (data_folder() / "models").glob("*.toml")))


def find_model_file(name_or_path: str | Path) -> Path:
    """Return the model file that a name of the catalogue or a path stands for.

    Anything with a separator or one of `SUFFIXES` is a path; so is every Path.

    Raises
    ------
    UnknownNameError
        A name that is not in the catalogue.
    ArgumentError
        Neither a name nor a path.
    """
    if not isinstance(name_or_path, str | Path):
        wanted = "the name of a mechanism or the path of a model file"
        raise ArgumentError(f"{wanted} expected, got {quoted(name_or_path)}")
    path = user_path(name_or_path)
    separated = {"/", os.sep} & set(str(name_or_path))
    if isinstance(name_or_path, Path) or path.suffix.lower() in SUFFIXES or separated:
        return path
    own = data_folder() / "models" / f"{path.name}.toml"
    if path.name and is_file(own):
        return own
    names = list_mechanisms()
    hint = did_you_mean(path.name, names)
    if is_file(path):
        hint = f"; for the file of this name write './{path.name}'"
    elif path.name and is_folder(path):
        hint = f"; for the folder of this name write './{path.name}'"
    raise UnknownNameError(
        f"unknown mechanism {quoted(str(name_or_path))}{hint}",
        name=str(name_or_path),
        candidates=names,
    )


def find_urdf(urdf: str, model_file: Path) -> Path:
    """Return the URDF that a model file names.

    It is looked for beside the model file, then in the folder ``urdf`` beside the model
    file's folder, and likewise where the model file is a link to. What starts with
    ``example-robot-data:`` is inside that package's ``robots`` folder.

    Raises
    ------
    ModelFileError
        No such file; the message lists where it was looked for.
    """
    if urdf.startswith(_EXAMPLE_ROBOTS):
        places = [_example_robots(model_file) / urdf.removeprefix(_EXAMPLE_ROBOTS)]
    else:
        given = _urdf_path(urdf, model_file)
        folders = dict.fromkeys(file.parent for file in (model_file, followed_link(model_file)))
        places = [
            place / given
            for folder in folders
            for place in (folder, folder.absolute().parent / "urdf")
        ]
    for place in places:
        if is_file(place):
            return place
    looked = " nor ".join(shortened(str(place), _LONGEST_PLACES // len(places)) for place in places)
    neither = "neither" if len(places) > 1 else "no"
    message = f"the URDF {quoted(urdf)} does not exist: {neither} {looked}"
    raise ModelFileError(f"{shown_path(model_file)}: {message}", path=str(model_file))


def _urdf_path(urdf: str, model_file: Path) -> Path:
    with at_file(str(model_file)):
        return user_path(urdf)


def data_folder() -> Path:
    """Return the folder that holds ``models`` and ``urdf``: the wheel's, or the checkout's."""
    package = Path(__file__).resolve().parent.parent
    return package / "data" if (package / "data").is_dir() else package.parent


def _example_robots(model_file: Path) -> Path:
    import importlib.metadata  # noqa: PLC0415 (reads mail)

    try:
        package = importlib.metadata.distribution("example-robot-data")
    except importlib.metadata.PackageNotFoundError:
        message = f"{model_file}: its URDF needs: pip install example-robot-data"
        raise ModelFileError(message, path=str(model_file)) from None
    return Path(str(package.locate_file("cmeel.prefix/share/example-robot-data/robots")))
