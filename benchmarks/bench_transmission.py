"""A transmission's C header beside one `close` with its `jacobian`, in the same run.

One call of the header: position, then velocity and effort there; both ways, at random places of a
rectangle. The library's calls are those of its recorded program. The mark is 100 times.
"""

from __future__ import annotations

import ctypes
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
from recording import recorded

import pmjac_pin as pj

MACHINES = (
    ("humanoid_ankle", {"pitch": (-0.4, 0.25), "roll": (-0.15, 0.15)}),
    ("ankle", {"pitch": (-0.3, 0.3), "roll": (-0.2, 0.2)}),
    ("four_bar", {"phi1": (2.1, 2.5)}),
)
MARK = 100.0
POSES, CALLS, ROUNDS = 500, 200_000, 7
TIMED = """#include "t.h"
double timed(const double *values, int poses, int n, int calls, int by_motors);
double timed(const double *values, int poses, int n, int calls, int by_motors)
{
    double sum = 0.0, rates[8], efforts[8];
    int call;
    for (call = 0; call < calls; ++call) {
        const double *at = values + (call % poses) * n;
        t_pose pose;
        if ((by_motors ? t_at_motors(at, &pose) : t_at_joints(at, &pose)) != T_OK)
            return NAN;
        if (by_motors) {
            t_joint_rates(&pose, at, rates);
            t_joint_efforts(&pose, at, efforts);
        } else {
            t_motor_rates(&pose, at, rates);
            t_motor_efforts(&pose, at, efforts);
        }
        sum += rates[0] + efforts[0];
    }
    return sum;
}
"""


def compiled(table: pj.TransmissionTable, folder: Path) -> ctypes.CDLL:
    (folder / "t.h").write_text(table.c("t"))
    (folder / "t.c").write_text(TIMED)
    library = folder / "t.so"
    options = ("-std=c99", "-O2", "-shared", "-fPIC")
    subprocess.run(["cc", *options, str(folder / "t.c"), "-o", str(library), "-lm"], check=True)
    found = ctypes.CDLL(str(library))
    found.timed.restype = ctypes.c_double
    return found


def nanoseconds(library: ctypes.CDLL, values: np.ndarray, by_motors: bool) -> float:
    given = np.ascontiguousarray(values)
    start = time.process_time()
    told = library.timed(ctypes.c_void_p(given.ctypes.data), *given.shape, CALLS, int(by_motors))
    spent = time.process_time() - start
    assert np.isfinite(told), "a pose of the table was refused"
    return 1e9 * spent / CALLS


def library_nanoseconds(mechanism: pj.Mechanism, motors: np.ndarray) -> float:
    start = time.process_time()
    for values in motors:
        mechanism.close(values).jacobian()
    return 1e9 * (time.process_time() - start) / len(motors)


def main() -> int:
    header = f"{'ns a call':18s}{'close + jacobian':>18s}{'from joints':>13s}{'ratio':>8s}"
    print(f"{header}{'from motors':>13s}{'ratio':>8s}")
    met = True
    for name, over in MACHINES:
        mechanism = recorded(pj.load(name))
        table, rng = pj.transmission_table(mechanism, over), np.random.default_rng(0)
        joints = rng.uniform(
            table.rectangle.lower, table.rectangle.upper, (POSES, len(table.joints))
        )
        motors, _ = table.exact(joints)
        library_nanoseconds(mechanism, motors[:50])
        with tempfile.TemporaryDirectory() as folder:
            library = compiled(table, Path(folder))
            rounds = [
                (
                    library_nanoseconds(mechanism, motors),
                    nanoseconds(library, joints, False),
                    nanoseconds(library, motors, True),
                )
                for _ in range(ROUNDS)
            ]
        here, forward, back = (statistics.median(column) for column in zip(*rounds, strict=True))
        met &= min(here / forward, here / back) >= MARK
        print(
            f"{name:18s}{here:18.0f}{forward:13.0f}{here / forward:8.0f}"
            f"{back:13.0f}{here / back:8.0f}"
        )
    print(f"The mark is {MARK:.0f} times: {'met' if met else 'MISSED'}.")
    return 0


if __name__ == "__main__":
    sys.exit(main())
