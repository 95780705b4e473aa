"""What the page shows of a load: the motor efforts that balance it, against their limits."""

from __future__ import annotations

import msgspec
import numpy as np

from pmjac_pin.configuration import Configuration
from pmjac_pin.errors import PmjacError, SingularError, enumerated
from pmjac_pin.model.inertias import massless
from pmjac_pin.rates.statics import Statics
from pmjac_pin.viewer.load import Load
from pmjac_pin.words.load_report import MotorEffort, motor_efforts

_NO_BALANCE = "No motor efforts balance a load at this pose: it is singular."


class LoadReadout(msgspec.Struct, frozen=True):
    """A load, and what balances it and the weight of the bodies at rest.

    Attributes
    ----------
    kind, mass, size, azimuth, elevation
        Of the load.
    force : tuple of float
        On the tool, N, in the world.
    efforts : tuple of MotorEffort
        Their values NaN, which JSON writes as null, where nothing balances it.
    beyond : tuple of bool
        Which of them are more than their motors may exert.
    note : str
        What is to be known of them; empty for nothing.
    refusal : str
        Why there are none, in a sentence; "" where there are.
    reason : str
        In full.
    """

    kind: str
    mass: float
    size: float
    azimuth: float
    elevation: float
    force: tuple[float, ...]
    efforts: tuple[MotorEffort, ...]
    beyond: tuple[bool, ...]
    note: str
    refusal: str
    reason: str


def make_load_readout(configuration: Configuration, load: Load) -> LoadReadout:
    """Balance a load and the weight of the bodies at a pose.

    Examples
    --------
    >>> import pmjac_pin as pj
    >>> readout = make_load_readout(pj.load("three_rps").home, Load("weight", mass=3.0))
    >>> [round(effort.value, 4) for effort in readout.efforts], readout.beyond
    ([11.3276, 11.3276, 11.3276], (False, False, False))
    """
    force = load.force(configuration.mechanism)
    given = (load.kind, load.mass, load.size, load.azimuth, load.elevation, tuple(force.tolist()))
    try:
        statics = configuration.statics([*force, 0.0, 0.0, 0.0])
    except PmjacError as error:
        short = (
            _NO_BALANCE if isinstance(error, SingularError) else f"Nothing balances it: {error}."
        )
        none = np.full(len(configuration.mechanism.actuated), np.nan)
        unknown = motor_efforts(configuration, none)
        return LoadReadout(*given, unknown, (False,) * none.size, "", short, str(error))
    efforts = motor_efforts(configuration, statics.efforts)
    beyond = tuple(effort.is_beyond for effort in efforts)
    return LoadReadout(*given, efforts, beyond, _note(configuration, statics), "", "")


def _note(configuration: Configuration, statics: Statics) -> str:
    notes = []
    if statics.internal_efforts.shape[1]:
        notes.append("Motors may work against each other: these are the smallest efforts.")
    if names := massless(configuration.mechanism.kinematics.model):
        notes.append(f"Without mass in the model, and so without weight: {enumerated(names, 3)}.")
    return " ".join(notes)
