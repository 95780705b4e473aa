"""Many poses at once, beside tight C++ on Pinocchio's library, in the same run, one core each.

Both close, give J_eq, and the singular values of its linear and angular rows, at the same targets.
The peer is `peer.cpp`: it takes nothing but Newton's method, and certifies nothing. It needs g++,
and the headers of Pinocchio, of Boost (in Pinocchio's wheel) and of Eigen (`pip install
cmeel-eigen`); where they are not found, this says so.
"""

from __future__ import annotations

import ctypes
import shutil
import statistics
import subprocess
import tempfile
from pathlib import Path

import numpy as np
import pinocchio as pin
from bench_batch import MANY, NAMES, ROUNDS, at_once, compiled, machine, seconds, targets

import pmjac_pin as pj

PREFIX = Path(pin.__file__).parents[4]
INCLUDE = PREFIX / "include"
SINGLE = 2_000


def build(folder: Path) -> ctypes.CDLL:
    built = folder / "peer.so"
    # All of it for this processor: nothing of the library that was built for any is linked.
    options = ["-std=c++17", "-O3", "-DNDEBUG", "-march=native", "-fPIC", "-shared", "-w"]
    options += ["-DBOOST_MPL_LIMIT_LIST_SIZE=30", "-DBOOST_MPL_CFG_NO_PREPROCESSED_HEADERS"]
    where = [f"-I{INCLUDE}", f"-I{INCLUDE / 'eigen3'}", f"-L{PREFIX / 'lib'}"]
    source = Path(__file__).with_name("peer.cpp")
    libraries = ["-lboost_serialization", f"-Wl,-rpath,{PREFIX / 'lib'}"]
    print("compiling the peer takes a minute or more", flush=True)
    command = ["g++", *options, *where, str(source), "-o", str(built), *libraries]
    subprocess.run(command, check=True)
    return ctypes.CDLL(str(built))


class Peer:
    """One mechanism of loops between points, of hinges and of rods."""

    def __init__(self, library: ctypes.CDLL, mechanism: pj.Mechanism, folder: Path) -> None:
        self._library, self._mechanism = library, mechanism
        model = mechanism.model
        text = folder / f"{mechanism.name}.txt"
        model.saveToText(str(text))
        loops = mechanism.spec.loops
        frames = [model.getFrameId(name) for loop in loops for name in loop.frames]
        rods = [
            loop.rows(mechanism.parameters)[0].length if isinstance(loop, pj.DistanceLoop) else 0.0
            for loop in loops
        ]
        axes = [
            component
            for loop in loops
            for component in (loop.axis if isinstance(loop, pj.RevoluteLoop) else (0.0, 0.0, 0.0))
        ]
        columns = mechanism.problem.partition.actuated
        library.peer_make.restype = ctypes.c_void_p
        self._peer = ctypes.c_void_p(
            library.peer_make(
                str(text).encode(),
                len(loops),
                (ctypes.c_int * len(frames))(*frames),
                (ctypes.c_double * len(rods))(*rods),
                (ctypes.c_double * len(axes))(*axes),
                len(columns),
                (ctypes.c_int * len(columns))(*columns.tolist()),
                model.getFrameId(mechanism.spec.tool.names[0]),
                mechanism.home.q.ctypes.data_as(ctypes.c_void_p),
            )
        )

    def run(self, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        count, motors = values.shape
        moves = np.ascontiguousarray(values - self._mechanism.home.actuated)
        J_eq, radii = np.empty((count, 6, motors)), np.empty((count, 2, 3))
        pointers = (array.ctypes.data_as(ctypes.c_void_p) for array in (moves, J_eq, radii))
        first, *others = pointers
        tolerance = ctypes.c_double(1e-13 * self._mechanism.characteristic_length)
        closed = self._library.peer_run(self._peer, count, first, tolerance, *others)
        assert closed == count
        return J_eq, radii


def compare(library: ctypes.CDLL, folder: Path, name: str) -> tuple[float, float, float]:
    """Seconds a pose: by the peer, at once, and compiled."""
    mechanism = machine(name)
    many, fast, peer = pj.batch(mechanism), compiled(mechanism), Peer(library, mechanism, folder)
    values = targets(mechanism, MANY)
    (J_eq, radii), found = peer.run(values[:SINGLE]), at_once(many, values[:SINGLE])
    size = np.abs(J_eq).max()
    np.testing.assert_allclose(found.J_eq, J_eq, atol=1e-9 * size)
    told = np.stack([found.velocity_radii, found.angular_radii], axis=1)
    np.testing.assert_allclose(told, radii, atol=1e-9 * size)
    times: list[list[float]] = [[], [], []]
    for _ in range(ROUNDS):
        times[0].append(seconds(lambda: peer.run(values[:SINGLE])) / SINGLE)
        for own, batch in zip(times[1:], (many, fast), strict=True):
            own.append(
                np.nan if batch is None else seconds(lambda b=batch: at_once(b, values)) / MANY
            )
    one, once, sooner = map(statistics.median, times)
    return one, once, sooner


def main() -> None:
    if shutil.which("g++") is None or not (INCLUDE / "eigen3").is_dir():
        print("C++ on Pinocchio's library: g++ and Eigen's headers (cmeel-eigen) are not installed")
        return
    titles = ("C++", "at once", "ratio", "compiled", "ratio")
    print(f"{'':16s}{''.join(f'{title:>12s}' for title in titles)}   µs a pose")
    with tempfile.TemporaryDirectory() as folder:
        library = build(Path(folder))
        for name in NAMES:
            one, once, sooner = compare(library, Path(folder), name)
            numbers = (1e6 * one, 1e6 * once, one / once, 1e6 * sooner, one / sooner)
            print(f"{name:16s}{''.join(f'{number:12.2f}' for number in numbers)}", flush=True)


if __name__ == "__main__":
    main()
