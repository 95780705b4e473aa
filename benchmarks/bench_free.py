"""How much of the way to a singular pose is proven, in one step of order 1 and of order 2.

Beside each radius its share of the largest change of a motor up to the nearest singular pose that
is found, of either kind or of gains: no radius can be larger.
"""

from __future__ import annotations

import time

import pmjac_pin as pj

MACHINES = (
    "serial_2r",
    "five_bar",
    "planar_3rpr",
    "planar_3rrr",
    "ankle",
    "ur5",
    "delta_rods",
    "agile_eye",
    "head_6rss",
    "stewart_gough",
)


def main() -> None:
    print(f"{'':14} kind  order 1   share    [s]  order 2   share    [s]  further")
    for name in MACHINES:
        home = pj.load(name).home
        kinds = ("gain", "loss") if home.problem.partition.passive_rank else ("loss",)
        for kind in kinds:
            both = [
                pj.nearest_singularity(home, kind=one, rng=0)
                for one in kinds[: 1 + (kind == "loss")]
            ]
            far = min(max(map(abs, one.motor_change.values())) for one in both if one)
            found = []
            for order in (1, 2):
                start = time.perf_counter()
                proven = pj.singularity_free(home, kind=kind, order=order)
                found.append((proven.radius, time.perf_counter() - start))
                assert 0.0 < proven.radius < far
            told = "  ".join(f"{r:.5f}  {100.0 * r / far:5.1f}%  {s:5.2f}" for r, s in found)
            print(f"{name:14} {kind}  {told}  {found[1][0] / found[0][0]:7.1f}")


if __name__ == "__main__":
    main()
