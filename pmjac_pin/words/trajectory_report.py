"""A trajectory as plain data, as headings and tables, and as comma-separated values."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterator

import numpy as np

from pmjac_pin.studies.follow.event import Event
from pmjac_pin.studies.follow.trajectory import Trajectory
from pmjac_pin.values.brief import brief
from pmjac_pin.words.blocks import Block, Heading, Paragraph, Table
from pmjac_pin.words.plain import told


def trajectory_told(trajectory: Trajectory) -> dict[str, object]:
    """Return what JSON tells of a trajectory."""
    home = trajectory.homecoming
    return {
        "mechanism": trajectory.mechanism.name,
        **told(trajectory, "status", "reason"),
        "evidence": told(trajectory.evidence, "kind", "statement"),
        "events": [_event_told(event) for event in trajectory.events],
        "homecoming": None
        if home is None
        else {**told(home, "same_mode", "met_singular", "cuspidal"), "what": str(home)},
        "motors": list(trajectory.mechanism.actuated),
        "passive_joints": list(trajectory.mechanism.passive),
        **told(trajectory, "t", "actuated", "passive", "rates", "accelerations"),
        "steps": trajectory.steps,
        "radii": trajectory.radii,
    }


def trajectory_blocks(trajectory: Trajectory) -> Iterator[Block]:
    """Show where a path led, and what happened on it."""
    yield Heading(f"Path of {trajectory.mechanism.name}")
    steps = len(trajectory.steps) - 1
    ends = f"t = {trajectory.t[0]:.9g} to {trajectory.t[-1]:.9g}"
    yield Paragraph(f"{ends} in {steps} step{'s' * (steps != 1)}: {trajectory.reason}.")
    if trajectory.events:
        rows = tuple((f"{event.t:.12g}", event.kind, event.what) for event in trajectory.events)
        yield Table("Events", ("t", "", ""), rows, "><<")
    yield _ends_table(trajectory)
    if trajectory.homecoming is not None:
        yield Paragraph(f"The path is {trajectory.homecoming}.")
    yield Paragraph(f"{trajectory.evidence}.")


def trajectory_csv(trajectory: Trajectory) -> str:
    """Return the samples as comma-separated values: t, then each freedom by its name."""
    partition = trajectory.mechanism.problem.partition
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(["t", *partition.columns])
    values = np.column_stack([trajectory.t, trajectory.actuated, trajectory.passive])
    writer.writerows([[repr(float(x)) for x in row] for row in values])
    return text.getvalue()


def _ends_table(trajectory: Trajectory) -> Table:
    partition = trajectory.mechanism.problem.partition
    values = np.hstack([trajectory.actuated, trajectory.passive])
    rows = tuple(
        (f"{name} [{partition.units[column]}]", brief(values[0, k]), brief(values[-1, k]))
        for k, (name, column) in enumerate(partition.columns.items())
    )
    return Table("Joints", ("", "first", "last"), rows, "<>>")


def _event_told(event: Event) -> dict[str, object]:
    branches = [told(one, "velocity", "turns_back", "goes_on") for one in event.branches]
    joints = dict(event.configuration.joint_values)
    return {
        **told(event, "kind", "t", "what", "name", "leaves"),
        "joint_values": joints,
        "branches": branches,
    }
