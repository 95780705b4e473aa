"""What stands beside a still picture: motors, principal velocities, how near K* is to singular."""

from __future__ import annotations

import math

from pmjac_pin.configuration import Configuration
from pmjac_pin.values.brief import brief
from pmjac_pin.viewer.equivalent import equivalent
from pmjac_pin.words.labelled_values import Labels, joint_values
from pmjac_pin.words.numbers import matrix_numbers
from pmjac_pin.words.tables import limits_warning, motor_line


def pose_facts(configuration: Configuration) -> tuple[str, ...]:
    """Return what is known of a pose in a few lines.

    Examples
    --------
    >>> import pmjac_pin as pj
    >>> for line in pose_facts(pj.load("five_bar").home):
    ...     print(line)
    theta1 = 2.18748 rad, theta2 = 0.95411 rad
    Tool at 0.1500, 0.4800, 0.0000 m
    Principal velocities 0.3607, 0.2623 m/s for motor rates of length 1
    K*: smallest singular value 0.366, relative
    """
    mechanism, singularity = configuration.mechanism, configuration.singularity()
    place = configuration.tool_pose().translation.tolist()
    [entries] = matrix_numbers([place], mechanism.characteristic_length)
    lines = [motor_line(joint_values(configuration, Labels.of(mechanism.problem.partition)))]
    lines.append(f"Tool at {', '.join(entries)} m")
    jacobian, _ = equivalent(configuration)
    if jacobian is None:
        lines.append(f"No J_eq here: {singularity.kind}")
    else:
        radii = jacobian.velocity_ellipsoid().radii[: len(mechanism.actuated)].tolist()
        [found] = matrix_numbers([radii])
        lines.append(f"Principal velocities {', '.join(found)} m/s for motor rates of length 1")
    if math.isfinite(singularity.smallest):
        lines.append(f"K*: smallest singular value {brief(singularity.smallest)}, relative")
    if configuration.limits_violated:
        lines.append(limits_warning(configuration))
    return tuple(lines)
