"""Builds the kernels, which run tapes, and the description that a package index shows.

The kernels with the C compiler that there is (that of PyPI, ziglang, where the build sees it), or
not at all: without them the package computes the same with NumPy and Pinocchio, slower.
"""

from __future__ import annotations

import hashlib
import os
import re
import runpy
import subprocess
import sysconfig
from concurrent.futures import ThreadPoolExecutor
from itertools import product
from pathlib import Path
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface
from hatchling.metadata.plugin.interface import MetadataHookInterface

PACKAGE = Path("pmjac_pin")
# By its file: the package needs more than there is when it is built.
COMPILERS = runpy.run_path(str(Path(__file__).parent / PACKAGE / "algebra" / "c_compilers.py"))
LANES, TAPES = Path("algebra", "lanes.h"), Path("algebra", "tape_kernel.c")
PROGRAMS = (Path("algebra", "lane_programs.h"), TAPES, LANES)
VALUES, PATHS = Path("algebra", "singular_values.c"), Path("closing", "path_kernel.c")
STARTS, WALK = Path("closing", "starts.h"), Path("closing", "walk.h")
MANY_PATHS = Path("closing", "many_paths.c")
RATES, RADII = Path("batches", "many_rates.c"), Path("rates", "many_radii.c")
CURVES = Path("studies", "homotopy", "curve_kernel.c")
MODES, INTERVALS = Path("studies", "modes"), Path("algebra", "interval_tape.c")
DESCENT = MODES / "descent_kernel.c"
PRUNING = (MODES / "pruning_kernel.c", MODES / "boxes_in_lanes.h", MODES / "narrowing.h")
#: What is compiled, and what it includes, by what is built of it.
KERNELS = {
    "algebra/_tape_kernel.so": (TAPES, LANES),
    "algebra/_singular_values.so": (VALUES, LANES),
    "closing/_path_kernel.so": (PATHS, STARTS, WALK, *PROGRAMS),
    "closing/_many_paths.so": (MANY_PATHS, PATHS, STARTS, WALK, *PROGRAMS),
    "batches/_many_rates.so": (RATES, *PROGRAMS),
    "rates/_many_radii.so": (RADII, VALUES, LANES),
    "studies/homotopy/_curve_kernel.so": (CURVES, TAPES, LANES),
    "studies/modes/_descent_kernel.so": (DESCENT, *PROGRAMS),
    "studies/modes/_pruning_kernel.so": (*PRUNING, INTERVALS, TAPES, LANES),
}
# No function's error number is asked for, and no exception is trapped: else roots stay scalar. No
# product is added to unrounded, which -std=c99 tells GCC alone.
OPTIONS = (
    "-std=c99", "-O3", "-fno-math-errno", "-fno-trapping-math", "-ffp-contract=off",
    "-fPIC", "-shared",
)  # fmt: skip


def build(target: Path, source: Path, *included: Path) -> str:
    """Compile a kernel; return what went wrong, "" where nothing did."""
    text = b"".join(path.read_bytes() for path in (source, *included))
    digest = hashlib.sha256(text).hexdigest()
    draft = target.with_suffix(f".{os.getpid()}")
    options = [*OPTIONS, f'-DSOURCE="{digest}"', str(source), "-o", str(draft), "-lm"]
    failed: dict[str, str] = {}
    # An older one knows the kinds of processors by no such names: then one version does.
    for compiler, more in product(COMPILERS["c_compilers"](), ((), ("-DFOR_EACH_PROCESSOR=",))):
        command = [*compiler.command, *compiler.portable, *options, *more]
        try:
            done = subprocess.run(command, capture_output=True, text=True, check=False)
        except OSError as error:
            failed[" ".join([*compiler.command, *more])] = str(error)
            continue
        if not done.returncode:
            draft.replace(target)
            return ""
        failed[" ".join([*compiler.command, *more])] = done.stderr
    told = "\n".join(f"{command}: {why}" for command, why in failed.items())
    return told or f"no C compiler: none is called {', '.join(COMPILERS['NAMES'])}"


def build_all(package: Path) -> str:
    """Compile all kernels, as many at a time as there are cores; return as `build`."""

    def one(built: str) -> str:
        return build(package / built, *(package / source for source in KERNELS[built]))

    with ThreadPoolExecutor(os.cpu_count()) as pool:
        return next(filter(None, pool.map(one, reversed(KERNELS))), "")  # the longest first


class CustomBuildHook(BuildHookInterface):  # type: ignore[type-arg]
    """Puts the kernels beside their sources, into the wheel or the folder of an editable one."""

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """Build them; a wheel that has them is for this platform."""
        if failed := build_all(Path(self.root) / PACKAGE):
            self.app.display_warning(f"no kernel is built, NumPy does its work: {failed}")
            return
        if version != "editable":
            build_data["artifacts"] += [str(PACKAGE / built) for built in KERNELS]
            platform = sysconfig.get_platform().replace("-", "_").replace(".", "_")
            build_data["pure_python"] = False
            build_data["tag"] = f"py3-none-{platform}"


_LINK = re.compile(r"(!?)\[([^]]*)\]\((?![a-z]+:|#)([^)]+)\)")  # to a file beside the README


def described(readme: str, repository: str | None) -> str:
    """Return a README whose links lead somewhere from anywhere.

    Links to files lead to the repository; where no address of it is known, files are named only.
    """

    def linked(match: re.Match[str]) -> str:
        picture, words, path = match.groups()
        if repository:
            return f"{picture}[{words}]({repository}/{'raw' if picture else 'blob'}/HEAD/{path})"
        if picture:
            return f"*Picture: {words} (`{path}`)*"
        return f"`{path}`" if words == path else f"{words} (`{path}`)"

    return _LINK.sub(linked, readme)


class CustomMetadataHook(MetadataHookInterface):
    """Makes the long description: the README, as it can be read without the files beside it."""

    def update(self, metadata: dict[str, Any]) -> None:
        """Add it to the metadata; the address of the repository is that of [project.urls]."""
        readme = Path(self.root, "README.md").read_text(encoding="utf-8")
        repository = metadata.get("urls", {}).get("Repository")
        text = described(readme, repository)
        metadata["readme"] = {"content-type": "text/markdown", "text": text}
