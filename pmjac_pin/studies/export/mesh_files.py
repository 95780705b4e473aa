"""Where the file of a mesh is, and what a file in another folder calls it."""

from __future__ import annotations

import os
from pathlib import Path

from pmjac_pin.files.user_path import is_file, real
from pmjac_pin.studies.export.plain_machine import PlainShape

_IN_A_PACKAGE = "package://"


def mesh_file(shape: PlainShape) -> Path | None:
    """Return the file of a mesh; None where there is none.

    ``package://NAME/PATH`` is looked for in the folder NAME that the URDF is in or below, and
    beside the URDF where the name is empty.
    """
    named, folder = shape.shape.get("filename", ""), real(Path(shape.file)).parent
    if not named.startswith(_IN_A_PACKAGE):
        places = [folder / named.removeprefix("file://")]
    else:
        package, _, path = named.removeprefix(_IN_A_PACKAGE).partition("/")
        places = [above / path for above in (folder, *folder.parents) if above.name == package]
        places += [] if package else [folder / path]
    return next((place for place in places if named and is_file(place)), None)


def mesh_path(shape: PlainShape, folder: Path) -> str:
    """Return a mesh's path from a folder; what the URDF calls it where there is no such file."""
    if (file := mesh_file(shape)) is None:
        return shape.shape.get("filename", "")
    return Path(os.path.relpath(file, real(folder))).as_posix()
