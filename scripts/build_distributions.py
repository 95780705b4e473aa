"""Build what is released, and see that it is whole.

    make dist
    python scripts/build_distributions.py [FOLDER]    # with the extra `release`

Into the folder, dist where none is named, go the source distribution, and the wheel that is built
from it. The wheel has the kernels for this platform; auditwheel says from which Linux on they run,
and names it so. Then both are looked at by twine, and installed: the wheel as it is, and the source
distribution where there is no C compiler, so that NumPy does the kernels' work.
"""

from __future__ import annotations

import os
import platform
import subprocess
import sys
import tarfile
import tempfile
from collections.abc import Sequence
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
DIST = ROOT / "dist"
#: Used from a folder of its own, with warnings as errors.
USED = """
import pmjac_pin as pj
mechanism = pj.load("three_rps")
many = pj.batch(mechanism)
poses = many.close([[1.0, 1.05, 0.95]])
alone = mechanism.close([1.0, 1.05, 0.95])
assert abs(many.jacobian(poses.q).J_eq[0] - alone.jacobian().J_eq).max() < 1e-12
print(many.runs_on)
"""


def run(*command: str | Path, folder: Path = ROOT, **environment: str) -> str:
    """Run a program of this environment as a module, or another one by its path."""
    first, *rest = command
    program = [first] if isinstance(first, Path) else [sys.executable, "-m", first]
    paths = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    done = subprocess.run(
        [*program, *rest],
        cwd=folder,
        env={**os.environ, "NO_COLOR": "1", "PATH": paths, **environment},
        capture_output=True,
        text=True,
        check=False,
    )
    if done.returncode:
        raise SystemExit(f"{first} failed:\n{done.stdout}{done.stderr}")
    return done.stdout + done.stderr


def source_distribution(folder: Path) -> Path:
    """Build it, and return where it is."""
    run("hatchling", "build", "-t", "sdist", "-d", folder)
    (built,) = folder.glob("*.tar.gz")
    return built


def wheel(source: Path, folder: Path, **environment: str) -> Path:
    """Build the wheel of a source distribution, and return where it is."""
    with tempfile.TemporaryDirectory() as unpacked:
        with tarfile.open(source) as archive:
            archive.extractall(unpacked, filter="data")
        (inside,) = Path(unpacked).iterdir()
        run("hatchling", "build", "-t", "wheel", "-d", folder, folder=inside, **environment)
    (built,) = folder.glob("*.whl")
    return built


def for_many_linuxes(built: Path, folder: Path) -> Path:
    """Name a wheel after the oldest Linux that its kernels run on; elsewhere leave it as it is."""
    if not sys.platform.startswith("linux"):
        return built.rename(folder / built.name)
    # Not older, though no symbol asks for more: kernels choose by the processor when they are
    # loaded, which older systems' loaders cannot do, and auditwheel does not look for.
    oldest = f"manylinux_2_17_{platform.machine()}"
    run("auditwheel", "repair", "--plat", oldest, "--only-plat", "-w", folder, built)
    (named,) = folder.glob("*.whl")
    return named


def used(built: Path, what: Sequence[str] = ()) -> str:
    """Install a wheel into an environment of its own, and return what its batches run on."""
    with tempfile.TemporaryDirectory() as folder:
        environment = Path(folder) / "environment"
        python = environment / "bin" / "python"
        run("uv", "venv", "--quiet", "--python", sys.executable, environment)
        run("uv", "pip", "install", "--quiet", "--python", python, built, *what)
        return run(python, "-W", "error", "-c", USED, folder=Path(folder)).strip()


def main(into: Path) -> None:
    """Build, look at and use what is released."""
    into.mkdir(exist_ok=True)
    for old in (*into.glob("*.whl"), *into.glob("*.tar.gz")):
        old.unlink()
    source = source_distribution(into)
    with tempfile.TemporaryDirectory() as folder:
        built = wheel(source, Path(folder))
        if built.name.endswith("-any.whl"):
            raise SystemExit("no C compiler: the wheel has no kernels")
        released = for_many_linuxes(built, into)
    print(run("twine", "check", "--strict", source, released).strip())
    print(f"{released.name}: installed, its batches run on {used(released)}")
    with tempfile.TemporaryDirectory() as folder:
        plain = wheel(source, Path(folder), CC="no-compiler")
        print(f"{plain.name}: built without a C compiler, its batches run on {used(plain)}")


if __name__ == "__main__":
    main(Path(sys.argv[1]).resolve() if sys.argv[1:] else DIST)
