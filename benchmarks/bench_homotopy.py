"""All complex assembly modes, beside other people's homotopies on the same mechanisms.

`pj.parameter_homotopy` works on the model file: `start` is what it takes once for a mechanism,
`at` what it takes for each set of motor values, proofs of the ends included. pypolsys
(POLSYS_PLP) and bertini2, where they are installed (the extra `peers`), get polynomials that are
written by hand from the geometry, in tests/polynomials_by_hand.py, so that equal counts mean
something. `assembly_modes` is after the real ones alone, and says what their number rests on.
Each solver runs in a process of its own, on one thread, with a limit of time; a time is the
median of three, or of as many as fit into ten seconds: the processor's, so that others who work
beside it count little.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import time
from importlib import metadata, util
from pathlib import Path
from statistics import median
from typing import Any

import pmjac_pin as pj

PATIENCE = 300.0  # seconds for a solver and a mechanism
LONG = 10.0
TESTS = Path(__file__).parents[1] / "tests"
CASES: tuple[tuple[str, tuple[float, ...]], ...] = (
    ("four_bar", (0.9,)),
    ("planar_3rpr", (0.32461369, 0.36873712, 0.49813137)),
    ("three_rps_ss", (2 / 3, 3 / 5, 3 / 4)),
    ("three_rps_ss", (0.5, 1.0, 2.0)),
    ("stewart_gough_dietmaier", (1.0, 0.645275, 1.086284, 1.503439, 1.281933, 0.771071)),
)
PEERS = {"bertini": "bertini2", "pypolsys": "pypolsys"}  # modules, and their distributions
Outcome = dict[str, Any]


def start(name: str, motors: list[float]) -> Outcome:
    found = pj.parameter_homotopy(pj.load(name), rng=0)
    return {"complex": found.count, "real": "", "note": f"trace straight to {found.bend:.0e}"}


def at(name: str, motors: list[float]) -> Outcome:
    homotopy = pj.parameter_homotopy(pj.load(name), rng=0)
    begin = time.process_time()
    found = homotopy.at(motors)
    seconds = time.process_time() - begin
    note = f"{found.certified} ends proven"
    return {"complex": found.count, "real": len(found.real), "note": note, "seconds": seconds}


def assembly_modes(name: str, motors: list[float]) -> Outcome:
    found = pj.assembly_modes(pj.load(name), motors, rng=0, limits=False)
    return {"complex": "", "real": len(found), "note": found.evidence.kind}


def peer(module: str, name: str, motors: list[float]) -> Outcome:
    from homotopy_oracles import ORACLES  # noqa: PLC0415
    from polynomials_by_hand import SYSTEMS  # noqa: PLC0415 - on the child's path only

    found = ORACLES[module](SYSTEMS[name](motors))
    note = f"{found.paths} paths, {found.lost} lost" if found.lost else f"{found.paths} paths"
    return {"complex": len(found.points), "real": len(found.real), "note": note}


def timed(solver: str, name: str, motors: list[float]) -> Outcome:
    """In a process of its own: solve three times, or until it takes too long."""
    own = {"start": start, "at": at, "assembly_modes": assembly_modes}
    times: list[float] = []
    while len(times) < 3 and sum(times) < LONG:
        begin = time.process_time()
        outcome = own[solver](name, motors) if solver in own else peer(solver, name, motors)
        times.append(outcome.get("seconds", time.process_time() - begin))
    return {**outcome, "seconds": median(times)}


def run(solver: str, name: str, motors: tuple[float, ...]) -> Outcome:
    """Let a child process do it, which may hang or crash; its last line is the outcome."""
    if solver in PEERS and not all(util.find_spec(module) for module in (solver, "sympy")):
        return {"note": "not installed"}
    paths = [str(TESTS), *filter(None, [os.environ.get("PYTHONPATH")])]
    threads = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "BERTINI_NUM_THREADS")
    one_thread = {**os.environ, "PYTHONPATH": os.pathsep.join(paths), **dict.fromkeys(threads, "1")}
    command = [sys.executable, __file__, solver, name, json.dumps(motors)]
    try:
        child = subprocess.run(
            command, env=one_thread, timeout=PATIENCE, capture_output=True, text=True, check=False
        )
    except subprocess.TimeoutExpired:
        return {"note": f"no answer within {PATIENCE:.0f} s"}
    if child.returncode:
        reason = (child.stderr.strip().splitlines() or ["no message"])[-1]
        return {"note": f"failed with status {child.returncode}: {reason}"}
    outcome: Outcome = json.loads(child.stdout.splitlines()[-1])
    return outcome


def line(label: str, outcome: Outcome, reference: Outcome) -> str:
    """Return a row of the table; ratios and differences are to the reference."""
    if "seconds" not in outcome:
        return f"  {label:16}{outcome['note']}"
    ratio = f"{outcome['seconds'] / reference['seconds']:10.3f}" if "seconds" in reference else ""
    told = [outcome["note"]]
    differs = (
        "" not in (outcome[key], reference.get(key, "")) and outcome[key] != reference[key]
        for key in ("complex", "real")
    )
    if any(differs):
        told.append("DIFFERS")
    return (
        f"  {label:16}{outcome['complex']:>8}{outcome['real']:>6}{outcome['seconds']:10.3f}"
        f"{ratio:>10}  {', '.join(told)}"
    )


def main() -> int:
    if len(sys.argv) > 1:
        solver, name, motors = sys.argv[1:]
        print(json.dumps(timed(solver, name, json.loads(motors))))
        return 0
    labels = {
        module: f"{name} {metadata.version(name)}" if util.find_spec(module) else name
        for module, name in PEERS.items()
    }
    print(f"  {'':16}{'complex':>8}{'real':>6}{'seconds':>10}{'ratio':>10}")
    for name, motors in CASES:
        print(f"{name} at ({', '.join(f'{value:.4g}' for value in motors)})")
        ours = run("at", name, motors)
        print(line("start", run("start", name, motors), ours))
        print(line("at", ours, ours))
        for module in PEERS:
            print(line(labels[module], run(module, name, motors), ours))
        print(line("assembly_modes", run("assembly_modes", name, motors), ours), flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
