"""All complex solutions of polynomials by other people's homotopies: pypolsys and bertini2."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

REAL = 1e-7
_FAR = 1e6
_SOLVED = 1e-8
_SAME = 1e-6


@dataclass(frozen=True)
class Found:
    """Distinct finite solutions, rows of `points`; how many paths there were, and were lost."""

    points: np.ndarray
    paths: int
    lost: int

    @property
    def real(self):
        return self.points[np.abs(self.points.imag).max(axis=1, initial=0.0) <= REAL].real


def by_pypolsys(system):
    """POLSYS_PLP (Wise, Sommese, Watson: Algorithm 801, ACM TOMS 26, 2000), in doubles."""
    from pypolsys import polsys, utils

    count, unknowns = len(system.unknowns), system.unknowns
    groups = [[unknowns.index(one) + 1 for one in group] for group in system.groups]
    polsys.init_poly(*utils.fromSympy(list(system.polynomials)))
    polsys.init_partition(*utils.make_mh_part(count, groups))
    paths = polsys.solve(1e-8, 1e-14, 0.0)
    lost = int((polsys.path_status % 10 != 1).sum())  # 1 + 10 k is a normal end
    return Found(_distinct(system, polsys.myroots[:count].T), paths, lost)


def by_bertini2(system):
    """Bertini 2 with its defaults: adaptive precision, start system by the groups."""
    import bertini
    from bertini.sympy_bridge import from_sympy

    bertini.recording(False)
    bertini.random.set_random_seed(0)
    named = {one.name: bertini.Variable(one.name) for one in system.unknowns}
    target = bertini.System()
    for polynomial in system.polynomials:
        target.add_function(from_sympy(polynomial.as_expr(), named))
    for group in system.groups:
        target.add_variable_group(bertini.VariableGroup([named[one.name] for one in group]))
    solver = bertini.ZeroDimSolver(target)
    finite = solver.solve(show_progress=False).answer.finite
    points = np.array([[complex(x) for x in point] for point in finite], dtype=complex)
    report = solver.report()
    shape = (len(finite), len(system.unknowns))
    return Found(points.reshape(shape), report.num_paths_tracked, report.num_failed)


def _distinct(system, ends):
    """The ends that are near, solve the equations, and are not there yet."""
    import sympy as sp

    equations = sp.lambdify(
        system.unknowns, [one.as_expr().evalf(17) for one in system.polynomials]
    )
    points = np.zeros((0, ends.shape[1]), dtype=complex)
    for end in ends[np.abs(ends).max(axis=1) <= _FAR]:
        solved = np.abs(np.array(equations(*end))).max() <= _SOLVED
        if solved and np.abs(points - end).max(axis=1, initial=0.0).min(initial=np.inf) > _SAME:
            points = np.vstack([points, end])
    return points


ORACLES = {"pypolsys": by_pypolsys, "bertini": by_bertini2}  # by the name of the module
