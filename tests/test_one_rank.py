"""One file decomposes matrices and says a rank: `rates/factorisation.py`."""

from __future__ import annotations

import ast

from draw_architecture import PACKAGE

#: What reveals a rank, or takes one for granted, of NumPy's and SciPy's linear algebra.
REVEALING = {
    *("svd", "svdvals", "matrix_rank", "qr", "lstsq", "pinv", "pinvh", "null_space", "orth"),
    *("cond", "eig", "eigh", "eigvals", "eigvalsh", "lu", "ldl", "gelsd", "gesvd", "geqp3"),
    *("dgelsd", "dgelsy", "dgesdd", "dgesvd", "dgeqp3"),
}
#: Where something else is asked than a rank, and what.
OTHERWISE = {
    "files/sdf/inertials.py": {"eigh"},  # the principal moments of a body, none below zero
    "rates/factorisation.py": {"svd"},
    "rates/dynamics.py": {"eigh", "eigvalsh"},  # whether all that is driven, or idles, has mass
    "rates/gradients.py": {"svd"},  # the singular values that are measured
    "rates/polytope.py": {"svd"},  # whether a hull is flat, by a tolerance of its own
    "rates/jacobian.py": {"qr"},  # unit vectors along columns that are independent
    "rates/screw.py": {"eigh", "qr"},  # extremal pitches; unit vectors along independent ones
    "rates/solid.py": {"svd"},  # whether an outline is flat, by a tolerance of its own
    "rates/within_limits.py": {"lstsq"},  # the smallest solution, which is then checked
    "studies/transmissions/fitted_polynomial.py": {"lstsq"},  # a guess for Newton's steps
    "studies/transmissions/newton_program.py": {"svd"},  # condition of gear ratios, n × n
    "rates/singularity.py": {"qr"},  # the same
    "rates/ellipse.py": {"dgesdd"},  # the axes of an ellipsoid; flat by a tolerance of its own
    "rates/ellipsoid.py": {"svd"},  # what is across one vector
    "rates/tool_motion.py": {"qr"},  # unit vectors along motions that are independent
    "algebra/singular_values.py": {"svd"},  # those that are shown, of many poses
    "closing/levenberg_marquardt.py": {"svd"},  # a step that damping holds back
    "studies/modes/marks.py": {"qr"},  # the space of a joint's own motions, for many poses
    "studies/singularities/closest.py": {"eigh"},  # curvatures, of which none counts as zero
    "files/mjcf/actuators.py": {"matrix_rank"},  # of gears that a file gives, no pose's
    "studies/export/masses.py": {"eigh"},  # principal moments of bodies
    "studies/export/mjcf.py": {"eigh"},  # the same
    "studies/follow/bordered.py": {"svd"},  # how many directions beside the one that is lost
    "studies/follow/branching.py": {"svd", "qr", "eigh"},  # unit vectors, and signs of a form
    "studies/follow/tool_losses.py": {"svd"},  # a singular value that is watched along a path
    "studies/singularities/curve_equations.py": {"svd"},  # steps and ways of a rank that is known
    "studies/singularities/curve_tracing.py": {"svd"},  # the one way on along a curve
    "studies/singularities/sheets.py": {"svd"},  # where singular values are small: guesses
    "studies/modes/enclosed_modes.py": {"lstsq", "pinv"},  # guesses: what they are worth is proven
    "studies/reach/nearest.py": {"eigh"},  # which ways lead downhill from where a distance is flat
    "studies/homotopy/curve.py": {"pinv"},  # a step where there is no other
    "words/report.py": {"svd"},  # the singular values that are shown
    "pictures/stick_drawing.py": {"svd"},  # planes of points
    "pictures/stick_figure.py": {"svd"},
}


def of_linear_algebra(path):
    """Return the names that a file takes from a module `linalg`, or from one within it."""
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        match node:
            case ast.ImportFrom(module=str(module), names=names) if "linalg" in module.split("."):
                yield from (name.name for name in names)
            case ast.Attribute(value=ast.Attribute(attr="linalg") | ast.Name(id="linalg")):
                yield node.attr
            case ast.Attribute(value=ast.Call(func=ast.Name(id="lapack"))):
                yield node.attr


def test_ranks_are_said_in_one_file():
    found = {}
    for path in PACKAGE.rglob("*.py"):
        if names := REVEALING & set(of_linear_algebra(path)):
            found[path.relative_to(PACKAGE).as_posix()] = names
    assert found == OTHERWISE
