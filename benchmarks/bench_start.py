"""Starting up, beside `import pinocchio`: whole processes, alternating, medians of each.

python benchmarks/bench_start.py
"""

from __future__ import annotations

import statistics
import subprocess
import sys
import time

ROUNDS = 7
PROGRAMS = {
    "import pinocchio": "import pinocchio",
    "import pmjac_pin": "import pmjac_pin",
    "import pmjac_pin, load four_bar": "import pmjac_pin as pj; pj.load('four_bar')",
    "pmjac list": "from pmjac_pin.cli.running import run_command; run_command(['list'])",
}


def seconds(program: str) -> float:
    """Return how long a fresh interpreter takes for a program."""
    start = time.perf_counter()
    subprocess.run([sys.executable, "-c", program], check=True, stdout=subprocess.DEVNULL)
    return time.perf_counter() - start


def main() -> None:
    """Print the table."""
    taken: dict[str, list[float]] = {name: [] for name in PROGRAMS}
    for _ in range(ROUNDS):
        for name, program in PROGRAMS.items():
            taken[name].append(seconds(program))
    least = taken["import pinocchio"]
    print(f"{'process':32} {'s':>6} {'x import pinocchio':>19}")
    for name, times in taken.items():
        ratio = statistics.median(one / other for one, other in zip(times, least, strict=True))
        print(f"{name:32} {statistics.median(times):6.2f} {ratio:19.2f}")


if __name__ == "__main__":
    main()
