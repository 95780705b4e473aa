"""Is the CAD export the machine that was designed?
================================================

A program for CAD writes its own file of the machine: with joints cut elsewhere, named and counted
from elsewhere, in rounded numbers. J_eq does not depend on any of this. So two files move
the tool alike where J_eq is the same at many poses, and nobody has to measure or to calibrate
anything. Limits and masses are another question.
"""

# %%
import re
import tempfile
from pathlib import Path

import numpy as np

import pmjac_pin as pj

designed = pj.load("three_rps")
print(designed)

# %%
# For want of a CAD program, SDFormat files are written here, of a machine that is cut otherwise
# (its platform is three rods between the legs), with numbers of six decimals. In the second file
# somebody has put the legs' feet 1 mm too far outwards.


def cad_export(machine, folder):
    """Write the machine as a program for CAD would, and read it as somebody who knows its file."""
    path = folder / "machine.sdf"
    file = pj.export(machine, to="sdf", file=path, force=True)
    text = re.sub(
        r"-?\d\.\d{7,}(e-\d+)?", lambda number: f"{float(number[0]):.6f}", path.read_text()
    )
    path.write_text(text)
    return pj.load(path, actuated=file.actuated, tolerance=1e-5).with_tool(file.tool)


with tempfile.TemporaryDirectory() as folder:
    by_rods = pj.load("three_rps_ss")
    good = cad_export(by_rods, Path(folder))
    bad = cad_export(by_rods.with_parameters(b=1.001), Path(folder))
for note in good.notes:
    print("note:", note)
for machine in (designed, good):
    passive = f"{len(machine.passive)} passive joints from {machine.passive[0]!r}"
    print(f"{machine.name}: {passive}, motors at home {machine.home.actuated}")

# %%
# The motors of both are moved by the same strokes from home; compared are J_eq, entry by entry, and
# where the platform's middle is.
strokes = np.random.default_rng(0).uniform(-0.08, 0.08, (200, 3))  # m


def compare(exported):
    """Return the largest difference in J_eq, as a share of its size, and in the place, m."""
    matrices, places = [], []
    for machine in (designed, exported):
        many = pj.batch(machine)
        poses = many.close(machine.home.actuated + strokes)
        assert (poses.status == pj.Status.CLOSED).all()
        found = many.measures(poses.q)
        matrices.append(found.J_eq)
        places.append(found.position)
    apart = np.abs(matrices[1] - matrices[0]).max() / np.abs(matrices[0]).max()
    return apart, np.abs(places[1] - places[0]).max()


for name, exported in (("as designed", good), ("feet 1 mm outwards", bad)):
    apart, moved = compare(exported)
    print(f"{name}: J_eq differs by {apart:.1e} of its size, places by {1e3 * moved:.4f} mm")
assert compare(good)[0] < 2e-5
assert compare(bad)[0] > 1e-4

# %%
# The machine as it was exported.
figure = pj.plot(good.home)
