"""What a page is told of a session: its state, and about the mechanism what seldom changes."""

from __future__ import annotations

from msgspec.structs import asdict

from pmjac_pin.rates.motor_limits import efforts_unit, rates_unit
from pmjac_pin.rates.partition import Partition
from pmjac_pin.viewer.legend import legend
from pmjac_pin.viewer.load_readout import make_load_readout
from pmjac_pin.viewer.messages import About, Drawn, Passive, State
from pmjac_pin.viewer.readout import make_readout
from pmjac_pin.viewer.scene import solids_of
from pmjac_pin.viewer.session import Session
from pmjac_pin.viewer.solids import solid_or_refusal


def page_state(
    session: Session,
    number: int | None = None,
    *,
    about: bool = False,
    framing: bool = False,
    jump: bool = False,
) -> State:
    """Return all that a page shows; on wish what seldom changes, and how to frame it."""
    return State(
        id=number,
        pose=session.pose,
        values=_slider_values(session),
        parameters=tuple(session.mechanism.parameters.values()),
        readout=session.readout(),
        notice=session.notice,
        drawn=Drawn(**asdict(session.options), no_polytopes=_no_polytopes(session)),
        load=make_load_readout(session.configuration, session.load),
        moment=session.moment,
        about=_about_mechanism(session) if about else None,
        framing=session.framing() if framing else None,
        jump=session.framing() if jump else None,
    )


def _slider_values(session: Session) -> tuple[float, ...]:
    """Return the motors' values, as the sliders show them."""
    values = dict(zip(session.mechanism.actuated, session.configuration.actuated, strict=True))
    return tuple(float(values[motor.name]) for motor in session.design.motors)


def _no_polytopes(session: Session) -> dict[str, str]:
    """Return why polytopes that are chosen are not there, by their kinds."""
    kinds = solids_of(session.options)
    found = {kind: solid_or_refusal(session.configuration, kind)[1] for kind in kinds}
    return {kind: refusal for kind, refusal in found.items() if refusal}


def _about_mechanism(session: Session) -> About:
    mechanism, design, replay = session.mechanism, session.design, session.replay
    units = mechanism.units
    return About(
        mechanism=mechanism.name,
        description=mechanism.spec.description,
        counted=_counted(mechanism.problem.partition),
        motors=design.motors,
        parameters=design.parameters,
        passive=tuple(Passive(name, units[name]) for name in mechanism.passive),
        poses=tuple(design.poses),
        home=make_readout(mechanism.home, design.ranks),
        legend=legend(mechanism),
        load=design.loads,
        replay=None if replay is None else replay.slider(),
        happenings=() if replay is None else replay.happenings(),
    )


def _counted(partition: Partition) -> str:
    """Return in what ellipsoids count the motors, "" where there are none."""
    rates, efforts = rates_unit(partition), efforts_unit(partition)
    told = f"Ellipsoids: motor rates together 1 in {rates}, efforts together 1 in {efforts}."
    return told if rates else ""
