"""Builds the kernel that runs tapes: with the C compiler that there is, or not at all.

Without it the package computes the same with NumPy, slower.
"""

from __future__ import annotations

import hashlib
import os
import shlex
import subprocess
import sysconfig
from pathlib import Path
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface

FOLDER = Path("pmjac_pin", "algebra")
SOURCE, BUILT = "tape_kernel.c", "_tape_kernel.so"
# No function's error number is asked for, and no exception is trapped: else roots stay scalar.
OPTIONS = ("-std=c99", "-O3", "-fno-math-errno", "-fno-trapping-math", "-fPIC", "-shared")


def build(source: Path, target: Path) -> str:
    """Compile the kernel; return what went wrong, "" where nothing did."""
    digest = hashlib.sha256(source.read_bytes()).hexdigest()
    compiler = shlex.split(os.environ.get("CC", "cc"))
    draft = target.with_suffix(f".{os.getpid()}")
    command = [*compiler, *OPTIONS, f'-DSOURCE="{digest}"', str(source), "-o", str(draft), "-lm"]
    failed = ""
    # An older compiler knows the kinds of processors by no such names: then one version does.
    for more in ((), ("-DFOR_EACH_PROCESSOR=",)):
        try:
            done = subprocess.run([*command, *more], capture_output=True, text=True, check=False)
        except OSError as error:
            return str(error)
        if not done.returncode:
            draft.replace(target)
            return ""
        failed = done.stderr
    return failed


class CustomBuildHook(BuildHookInterface):  # type: ignore[type-arg]
    """Puts the kernel beside its source, into the wheel or into the folder of an editable one."""

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """Build it; a wheel that has it is for this platform."""
        folder = Path(self.root) / FOLDER
        if failed := build(folder / SOURCE, folder / BUILT):
            self.app.display_warning(f"no kernel is built, NumPy does its work: {failed}")
            return
        if version != "editable":
            build_data["artifacts"].append(str(FOLDER / BUILT))
            platform = sysconfig.get_platform().replace("-", "_").replace(".", "_")
            build_data["pure_python"] = False
            build_data["tag"] = f"py3-none-{platform}"
