"""The masses of MJCF's bodies, as MuJoCo has them, less those that were made up."""

from __future__ import annotations

from collections.abc import Container

import numpy as np
import pinocchio as pin

from pmjac_pin.files.joint_dialects import listed
from pmjac_pin.files.massless import without_mass
from pmjac_pin.files.mjcf.bodies import place
from pmjac_pin.files.mjcf.kept import NO_MASS
from pmjac_pin.files.mjcf.mujoco import Compiled
from pmjac_pin.files.mjcf.names import Names


def inertias(
    compiled: Compiled, names: Names, moving: Container[str], wanted: float | None
) -> tuple[dict[str, pin.Inertia], list[str]]:
    """Return the inertia of each body that has one, in the body's frame, and notes.

    Parameters
    ----------
    compiled : Compiled
    names : Names
    moving : container of str
        Bodies with joints: of the others nobody is told that they have no mass.
    wanted : float or None
        The mass of all bodies together, kg.
    """
    bodies = list(enumerate(names.bodies))[1:]  # the world has none
    found = {name: _compiled_inertia(compiled, number) for number, name in bodies}
    known = {name: body for name, body in found.items() if body.mass or body.inertia.any()}
    total = sum(body.mass for body in known.values())
    if wanted is not None and total > 0.0:
        known = {name: _scaled(body, wanted / total) for name, body in known.items()}
    guessed = [name for number, name in bodies if number in compiled.unknown_mass]
    notes = []
    if guessed:
        what = "the mass of meshes, which are not opened, is left out of"
        notes.append(f"{what} {listed(guessed)}")
    points = [name for name, body in known.items() if body.mass and not body.inertia.any()]
    if points:
        notes.append(f"no moments of inertia are given for {listed(points)}: they are 0 in `model`")
    none = [name for _, name in bodies if name in moving and name not in {*known, *guessed}]
    return known, [*notes, *without_mass(none)]


def _compiled_inertia(compiled: Compiled, number: int) -> pin.Inertia:
    model = compiled.model
    mass, moments = float(model.body_mass[number]), model.body_inertia[number]
    at = place(model.body_ipos[number], model.body_iquat[number])
    axes = at.rotation
    kept = np.where(moments > NO_MASS, moments, 0.0)
    turned = axes @ np.diag(kept) @ axes.T
    return pin.Inertia(mass if mass > NO_MASS else 0.0, at.translation, (turned + turned.T) / 2.0)


def _scaled(inertia: pin.Inertia, factor: float) -> pin.Inertia:
    return pin.Inertia(factor * inertia.mass, inertia.lever, factor * inertia.inertia)
