"""The programs of many poses: how long it takes until they are there, beside single calls.

Each machine is in processes of its own, in which it was loaded and has its home's J_eq, so that
SciPy is there. Then "imports" is what `pj.batch` imports. "Planned" is how much longer `pj.batch`
and its first poses with J_eq and radii, a hundred, take than these a second time; "calls" is how
many single poses with the same are found in that time by Pinocchio and singular values: of more,
many at once are sooner. All are seconds of the processor's, medians, and of planning the least.

python benchmarks/bench_planning.py [machine ...]
"""

from __future__ import annotations

import multiprocessing
import statistics
import sys
import time

import numpy as np
from bench_batch import at_once, machine, one_by_one, seconds, targets
from recording import unrecorded

import pmjac_pin as pj

ROUNDS, POSES = 7, 100


def measured(name: str) -> tuple[float, float, float]:
    """Return the seconds of imports and of planning, and as how many calls this takes."""
    mechanism, alone = machine(name), unrecorded(machine(name))
    values = targets(mechanism, POSES)
    mechanism.home.jacobian()
    imports = seconds(lambda: pj.batch)
    start = time.process_time()
    many = pj.batch(mechanism)
    at_once(many, values)
    planned = time.process_time() - start - seconds(lambda: at_once(many, values))
    one_by_one(alone, values[:1])
    return imports, planned, planned * POSES / seconds(lambda: one_by_one(alone, values))


def main() -> None:
    """Print the table."""
    columns = "".join(f"{title:>9s}" for title in ("imports", "planned", "least", "calls"))
    print(f"{'':26s}{columns}   the first three in ms", flush=True)
    in_new_processes = multiprocessing.get_context("spawn").Pool
    with in_new_processes(processes=1, maxtasksperchild=1) as pool:
        for name in sys.argv[1:] or (*pj.list_mechanisms(), "humanoid"):
            rows = np.array(pool.map(measured, [name] * ROUNDS, chunksize=1))
            imports, planned, calls = (statistics.median(column) for column in rows.T.tolist())
            numbers = f"{1e3 * imports:9.1f}{1e3 * planned:9.1f}{1e3 * rows[:, 1].min():9.1f}"
            print(f"{name:26s}{numbers}{calls:9.0f}", flush=True)


if __name__ == "__main__":
    main()
