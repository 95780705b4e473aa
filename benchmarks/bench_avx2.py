"""Many poses at once as `bench_batch.py` has them, by kernels and programs for AVX2 alone.

The kernels of the package have a version for each kind of processor (x86-64-v2 to v4), and take the
widest that there is. Here they are built anew for x86-64-v3 in a copy of the package, and so are
compiled programs.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

HERE = Path(__file__).resolve().parent
PROCESSOR = "-march=x86-64-v3"
RUN = f"""
import runpy
from pathlib import Path
import pmjac_pin
from pmjac_pin.algebra import compiled_programs
if Path(pmjac_pin.__file__).parents[1] != Path.cwd():
    raise SystemExit("not the copy: " + pmjac_pin.__file__)
compiled_programs._OF_PROCESSOR = (({PROCESSOR!r},),)
runpy.run_path({str(HERE / "bench_batch.py")!r}, run_name="__main__")
"""


def build(package: Path) -> None:
    """Build the kernels of a copy of the package."""
    sys.path.insert(0, str(HERE.parent))
    import hatch_build  # noqa: PLC0415  beside the package

    hatch_build.OPTIONS += (PROCESSOR, "-DFOR_EACH_PROCESSOR=")
    for built, sources in hatch_build.KERNELS.items():
        if failed := hatch_build.build(package / built, *(package / name for name in sources)):
            raise SystemExit(failed)


def main() -> None:
    with tempfile.TemporaryDirectory() as folder:
        package = Path(shutil.copytree(HERE.parent / "pmjac_pin", Path(folder, "pmjac_pin")))
        for name in ("models", "urdf"):
            shutil.copytree(HERE.parent / name, Path(folder, name))
        build(package)
        paths = os.pathsep.join([folder, str(HERE)])
        environment = {**os.environ, "PYTHONPATH": paths, "XDG_CACHE_HOME": folder}
        subprocess.run([sys.executable, "-c", RUN], env=environment, cwd=folder, check=True)


if __name__ == "__main__":
    main()
