"""Differences through the closure."""

from __future__ import annotations

import numpy as np
import pinocchio as pin


def difference_quotient(configuration, h):
    """∂(tool twist)/∂θ by closing the loops at θ ± h, to fourth order."""
    mechanism, theta = configuration.mechanism, configuration.actuated

    def pose(step):
        closed = mechanism.close(theta + step, guess=configuration, enforce_limits=False)
        return closed.tool_pose()

    columns = []
    for k in range(theta.size):
        step = h * np.eye(theta.size)[k]
        twist = np.zeros(6)
        for weight, factor in ((8, 1), (-1, 2)):
            ahead, behind = pose(factor * step), pose(-factor * step)
            twist[:3] += weight * (ahead.translation - behind.translation)
            twist[3:] += weight * pin.log3(ahead.rotation @ behind.rotation.T)
        columns.append(twist / (12 * h))
    return np.column_stack(columns)
