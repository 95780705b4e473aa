"""Is the CAD export the machine that was designed?
================================================

A program for CAD writes its own file of the machine: with joints cut elsewhere, named and counted
from elsewhere, in rounded numbers. How the tool's points move with the motors depends on none of
this. So the file has the designed machine where its points are and move as designed at many poses,
and nobody has to measure or to calibrate anything. Limits and masses are another question.

What the file has is asked of MuJoCo, which reads, closes and differentiates it by itself: the two
sides of the comparison share the motors' strokes, and no line of code.
"""

# %%
import re
import tempfile
from pathlib import Path

import mujoco
import numpy as np

import pmjac_pin as pj

designed = pj.load("three_rps")
corners = ("S1", "S2", "S3")
print(designed)

# %%
# For want of a CAD program, MJCF files are written here, of a machine that is cut otherwise (its
# platform is three rods between the legs), with numbers of six decimals. In the second file
# somebody has put the legs' feet 1 mm too far outwards.


def cad_export(machine, folder):
    """Write the machine as a program for CAD would, and return what MuJoCo reads."""
    file = folder / "machine.xml"
    pj.export(machine, to="mjcf", file=file, force=True)
    numbers = re.compile(r"-?\d\.\d{7,}(e-\d+)?")
    file.write_text(numbers.sub(lambda number: f"{float(number[0]):.6f}", file.read_text()))
    model = mujoco.MjModel.from_xml_path(str(file))
    model.opt.jacobian = mujoco.mjtJacobian.mjJAC_DENSE
    return model


with tempfile.TemporaryDirectory() as folder:
    by_rods = pj.load("three_rps_ss")
    good = cad_export(by_rods, Path(folder))
    bad = cad_export(by_rods.with_parameters(b=1.001), Path(folder))
print(f"{good.nv} joints, equalities between {[good.tendon(k).name for k in range(good.ntendon)]}")

# %%
# In MuJoCo: Newton's method on the file's equalities, from its keyframe, and the corners' rates
# J − J* K*⁻¹ K from MuJoCo's own Jacobians. `efc_pos` and `efc_J` have the equalities first.


def corners_in_mujoco(model, strokes):
    """Return where the corners are and how they move with the motors, for the motors' strokes."""
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, 0)
    motors = [model.joint(name).qposadr[0] for name in ("l1", "l2", "l3")]
    passive = [k for k in range(model.nv) if k not in motors]
    data.qpos[motors] += strokes
    for _ in range(20):
        mujoco.mj_fwdPosition(model, data)
        jacobian = data.efc_J.reshape(data.nefc, model.nv)[: data.ne]
        step = np.linalg.solve(jacobian[:, passive], data.efc_pos[: data.ne])
        if np.abs(step).max() < 1e-13:
            break
        data.qpos[passive] -= step
    assert np.abs(data.efc_pos[: data.ne]).max() < 1e-12
    rates = np.zeros((model.nv, 3))
    rates[motors] = np.eye(3)
    rates[passive] = -np.linalg.solve(jacobian[:, passive], jacobian[:, motors])
    places, velocities, jacobian = [], [], np.empty((3, model.nv))
    for corner in corners:
        site = model.site(corner).id
        mujoco.mj_jacSite(model, data, jacobian, None, site)
        places.append(data.site_xpos[site].copy())
        velocities.append(jacobian @ rates)
    return places, velocities


def corners_as_designed(strokes):
    """Return the same of the designed machine, for many strokes."""
    places, velocities = [], []
    for corner in corners:
        many = pj.batch(designed.with_tool(corner))
        poses = many.close(designed.home.actuated + strokes)
        assert (poses.status == pj.Status.CLOSED).all()
        found = many.measures(poses.q)
        places.append(found.position)
        velocities.append(found.J_eq[:, :3])
    return np.stack(places, axis=1), np.stack(velocities, axis=1)


# %%
# 200 times the three motors are moved by strokes from home. Compared are the corners' places, and
# their velocities by the motors', in m/s a m/s.
strokes = np.random.default_rng(0).uniform(-0.08, 0.08, (200, 3))  # m
places, velocities = corners_as_designed(strokes)
differ = {}
for name, model in (("as designed", good), ("feet 1 mm outwards", bad)):
    there = [corners_in_mujoco(model, stroke) for stroke in strokes]
    moved = np.abs(np.array([place for place, _ in there]) - places).max()
    faster = np.abs(np.array([velocity for _, velocity in there]) - velocities).max()
    differ[name] = moved, faster
    print(f"{name}: corners are {1e3 * moved:.4f} mm apart, velocities differ by {faster:.1e}")
assert differ["as designed"][0] < 1e-5
assert differ["as designed"][1] < 3e-5
assert differ["feet 1 mm outwards"][0] > 5e-4

# %%
# The machine that was exported.
figure = pj.plot(by_rods.home)
