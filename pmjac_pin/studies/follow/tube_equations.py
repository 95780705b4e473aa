"""TubeEquations: the loop equations along the steps of a path, as series in the parameter."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property

import numpy as np

from pmjac_pin.algebra.intervals import Intervals
from pmjac_pin.algebra.series import Series
from pmjac_pin.kinematics.joint_steps import entry_rates
from pmjac_pin.kinematics.tree import Tree
from pmjac_pin.studies.follow.course import Course
from pmjac_pin.studies.follow.motor_path import PathPiece
from pmjac_pin.studies.follow.stretch import PathPose
from pmjac_pin.studies.series_equations import EquationsAlong, SeriesEquations
from pmjac_pin.studies.transmissions.sheet import Sheet
from pmjac_pin.studies.transmissions.sheet_equations import Pieces, series_over


class TubeEquations(SeriesEquations):
    """The equations of a course: leading motors on the path itself, all else on cubics.

    Raises
    ------
    ArgumentError
        A joint of a kind that cannot be taken apart; a gear on a joint without end.
    """

    def __init__(self, course: Course) -> None:
        self._columns = course.columns.tolist()
        super().__init__(course.mechanism, 1, self._columns)
        self._course = course
        links = self._whole_tree.links.values()
        self._single = {link.column for link in links if link.kind.nv == 1}

    def sheet(self, poses: Sequence[PathPose]) -> Sheet:
        """Return the cubics between closed poses of one piece of the path."""
        q = np.array([pose.q for pose in poses])
        slopes = [entry_rates(self._whole_tree, one.q, one.velocity) for one in poses]
        times = np.array([pose.t for pose in poses])
        return Sheet.of((times,), q, np.array(slopes)[:, :, None], q[:, :0])

    def along(self, sheet: Sheet, path: PathPiece, pieces: Pieces) -> EquationsAlong:
        """Return the equations along the cubics of a sheet over some pieces."""
        [t], entries = series_over(sheet, pieces, self.algebra)
        motors = self._motors(path, t)
        coordinates, values = self._course.mechanism.coordinates, {}
        rows = [entries[k] for k in range(len(entries))]
        for column, motor in zip(self._columns, motors, strict=True):
            if column in self._single:
                values[column] = motor
            else:
                rows[coordinates.entry(column)] = motor
        return self.of_series(values, self.algebra.stack(rows), pieces.at.shape[1])

    def _motors(self, path: PathPiece, t: Series) -> list[Series]:
        """Return the leading motors on a piece of the path, by Horner's scheme."""
        x = t - self.algebra.boxes(Intervals.exact([[path.origin]]))
        found = []
        for motor in self._course.driven.leading.tolist():
            highest, *others = path.coefficients[:, motor].tolist()
            total = self.algebra.boxes(Intervals.exact(np.full(t.shape, highest)))
            for coefficient in others:
                total = total * x + self.algebra.boxes(Intervals.exact([[coefficient]]))
            found.append(total)
        return found

    @cached_property
    def _whole_tree(self) -> Tree:
        return Tree(self._course.mechanism.kinematics.model)
