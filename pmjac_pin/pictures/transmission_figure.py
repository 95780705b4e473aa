"""A transmission over a rectangle as a figure: limit polygons, gear ratios and condition."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from pmjac_pin.errors import ArgumentError
from pmjac_pin.pictures.figures import as_it_is, new_figure
from pmjac_pin.rates.motor_limits import EFFORT_UNITS
from pmjac_pin.studies.transmissions.transmission_map import TransmissionMap
from pmjac_pin.values.arrays import Array
from pmjac_pin.values.checks import as_limits, check_kind

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_BLUE, _VERMILION, _GREY = "#0072B2", "#D55E00", "#B8B8B8"
_SIGNS = np.array([[1.0, 1.0], [1.0, -1.0], [-1.0, -1.0], [-1.0, 1.0], [1.0, 1.0]])
_LEVELS = 12
_TWO_JOINTS = 2


def plot_transmission(found: TransmissionMap, motor_limits: ArrayLike) -> Figure:
    """Draw how limits, gear ratios and condition vary over a rectangle.

    Of two joints: the efforts that the motors' limits reach, a polygon at each point, the one next
    to home in colour; the four entries of R and the condition over the rectangle, blank where the
    transmission does not exist. Of one joint: R, and the largest effort and rate.

    Parameters
    ----------
    found : TransmissionMap
    motor_limits : array_like, shape (n,)
        Of each motor's effort, and of its rate, N m or N, rad/s or m/s.

    Returns
    -------
    matplotlib.figure.Figure

    Raises
    ------
    ArgumentError
        It exists at no point; limits that are no numbers above 0.
    MissingDependencyError
        If matplotlib is not installed.

    Examples
    --------
    >>> import pmjac_pin as pj
    >>> over = {"pitch": (-0.2, 0.2), "roll": (-0.1, 0.1)}
    >>> found = pj.transmission_map(pj.load("humanoid_ankle"), over, points=5)
    >>> figure = plot_transmission(found, [1.0, 1.0])
    >>> [axes.get_title() for axes in figure.axes if axes.get_title()][:2]
    ['Efforts within the limits', 'motor1 by pitch']
    """
    check_kind(found, TransmissionMap)
    limits = as_limits(motor_limits, len(found.joints))
    if not found.exists.any():
        raise ArgumentError("the transmission exists nowhere in the rectangle: nothing to draw")
    mechanism = found.transmission.by_motors
    of_two = len(found.joints) == _TWO_JOINTS
    size = (13.0, 8.0) if of_two else (13.0, 4.5)
    figure: Figure = new_figure(f"Transmission of {mechanism.name}", size, 15.0)
    if of_two:
        panels = figure.subplots(2, 3)
        _draw_polygons(panels[0, 0], found, limits)
        _draw_maps(figure, [*panels[0, 1:], *panels[1]], found)
    else:
        _draw_lines(figure.subplots(1, 3), found, limits)
    return figure


def _draw_polygons(axes: Any, found: TransmissionMap, limits: Array) -> None:
    ratios = found.ratio[found.exists]
    for ratio in ratios:
        axes.plot(*(_SIGNS * limits @ ratio).T, color=_GREY, linewidth=0.5)
    mesh = np.stack(np.meshgrid(*found.axes, indexing="ij"), axis=-1)[found.exists]
    home = found.transmission.by_joints.home.actuated
    nearest = int(np.linalg.norm(mesh - home, axis=-1).argmin())
    axes.plot(
        *(_SIGNS * limits @ ratios[nearest]).T,
        color=_VERMILION,
        linewidth=2.0,
        label=_at(found, mesh[nearest]),
    )
    axes.axhline(0.0, color="0.8", linewidth=0.8, zorder=0)
    axes.axvline(0.0, color="0.8", linewidth=0.8, zorder=0)
    units = found.transmission.by_motors.units
    one, other = (as_it_is(f"{name} [{EFFORT_UNITS[units[name]]}]") for name in found.joints)
    axes.set(title="Efforts within the limits", xlabel=one, ylabel=other)
    axes.legend(loc="upper right", fontsize=8)
    axes.margins(y=0.25)


def _draw_maps(figure: Any, panels: list[Any], found: TransmissionMap) -> None:
    motors = found.transmission.motors
    pairs = [(i, j) for i in range(_TWO_JOINTS) for j in range(_TWO_JOINTS)]
    shown = [(f"{motors[i]} by {found.joints[j]}", found.ratio[..., i, j]) for i, j in pairs]
    condition = np.where(found.exists, found.condition, np.nan)
    for axes, (title, values) in zip(panels, [*shown, ("Condition", condition)], strict=True):
        _draw_map(figure, axes, found, title, values)


def _draw_map(figure: Any, axes: Any, found: TransmissionMap, title: str, values: Array) -> None:
    units = found.transmission.by_motors.units
    whole = np.ma.masked_invalid(values).T
    flat = not float(np.ptp(whole.compressed())) > 1e-9 * float(np.abs(whole).max())
    if flat:
        drawn = axes.pcolormesh(*found.axes, whole, cmap="viridis", shading="nearest")
    else:
        drawn = axes.contourf(*found.axes, whole, levels=_LEVELS, cmap="viridis")
    figure.colorbar(drawn, ax=axes)
    one, other = (as_it_is(f"{name} [{units[name]}]") for name in found.joints)
    axes.set(title=as_it_is(title), xlabel=one, ylabel=other)


def _draw_lines(panels: Any, found: TransmissionMap, limits: Array) -> None:
    units, (joint,) = found.transmission.by_motors.units, found.joints
    (motor,), (axis,) = found.transmission.motors, found.axes
    efforts, rates = found.efforts_alone(limits)[:, 0], found.rates_alone(limits)[:, 0]
    unit = units[joint]
    for axes, title, values, label in zip(
        panels,
        ("Gear ratio", "Largest effort", "Largest rate"),
        (found.ratio[:, 0, 0], efforts, rates),
        (f"{motor} by {joint}", f"{joint} [{EFFORT_UNITS[unit]}]", f"{joint} [{unit}/s]"),
        strict=True,
    ):
        axes.plot(axis, values, color=_BLUE, marker=".")
        axes.set(title=title, xlabel=as_it_is(f"{joint} [{unit}]"), ylabel=as_it_is(label))
        axes.grid(color="0.9")


def _at(found: TransmissionMap, values: Array) -> str:
    known = zip(found.joints, values.tolist(), strict=True)
    return as_it_is(", ".join(f"{name} = {value + 0.0:.3g}" for name, value in known))
