"""What the kernels that walk paths are given: structures as `walk.h` has them."""

from __future__ import annotations

import ctypes
from functools import cache

from pmjac_pin.algebra.c_kernels import COUNT, NUMBER, POINTER, loaded
from pmjac_pin.algebra.lane_programs import PROGRAM_SOURCES, ProgramStruct

_SOURCES = (
    "closing/path_kernel.c",
    "closing/starts.h",
    "closing/walk.h",
    *PROGRAM_SOURCES,
)

_TAKES = (POINTER, COUNT)


@cache
def path_kernel() -> ctypes.PyDLL | None:
    """Return the kernel of one lane, None where none was built from the sources.

    Its calls take microseconds: other threads wait, instead of taking over in each of them.
    """
    library = loaded("closing/_path_kernel.so", *_SOURCES)
    if library is None:
        return None
    alone = ctypes.PyDLL(library._name, handle=library._handle)
    alone.pmjac_set_out.argtypes = alone.pmjac_walk.argtypes = _TAKES
    return alone


@cache
def many_paths_kernel() -> ctypes.CDLL | None:
    """Return the kernel of many lanes, None where none was built; it lets other threads run."""
    sources = ("closing/many_paths.c", *_SOURCES)
    return loaded("closing/_many_paths.so", *sources, pmjac_set_out=_TAKES, pmjac_walk=_TAKES)


class MachineStruct(ctypes.Structure):
    """`Machine`."""

    _fields_ = (
        *((name, COUNT) for name in ("nq", "nv", "motors")),
        *((name, POINTER) for name in ("motor_entries", "motor_circles", "scale")),
        *((name, NUMBER) for name in ("tolerance", "enough", "walking", "rank_tolerance")),
        *((name, NUMBER) for name in ("least_size", "largest_step", "smallest_step")),
        *((name, NUMBER) for name in ("largest_correction", "slowest_contraction")),
        *((name, NUMBER) for name in ("no_inverse", "margin", "arrival_tolerance")),
        *((name, NUMBER) for name in ("lowest", "highest")),
        ("most_corrections", COUNT),
    )


class LaneStruct(ctypes.Structure):
    """`Lane`."""

    _fields_ = (
        *((name, COUNT) for name in ("state", "path", "tries", "iterations", "corrections")),
        ("last", COUNT),
        *((name, NUMBER) for name in ("share", "next", "stride", "allowed", "before")),
        *((name, NUMBER) for name in ("size", "left")),
    )


class WalkStruct(ctypes.Structure):
    """`Walk`."""

    _fields_ = (
        ("machine", POINTER),
        *((name, ProgramStruct) for name in ("move", "arrival", "leg")),
        *((name, POINTER) for name in ("point", "lanes", "common", "learnt")),
        ("inverse", NUMBER),
        *((name, POINTER) for name in ("start", "displacement", "target", "ways", "design")),
        *(
            (name, COUNT)
            for name in ("designed", "apart", "count", "taken", "most_tries", "few", "patience")
        ),
        ("busy", COUNT),
        ("arrived", COUNT),
        ("only_inside", COUNT),
        *((name, POINTER) for name in ("q", "gap", "share", "iterations", "end")),
        *((name, POINTER) for name in ("follow", "given")),
    )
