"""What a header in C99 has for tables of one joint, or of two: between their points, and inverses.

Words between @ are filled in.
"""

from __future__ import annotations

_CELL = """static inline int @name@_cell(const double *axis, int points, double x)
{
    int cell = (int)((x - axis[0]) / (axis[points - 1] - axis[0]) * (points - 1));
    if (cell < 0)
        return 0;
    return cell > points - 2 ? points - 2 : cell;
}

/* Cubic Hermite polynomials: values and slopes at both ends, by where between them. */
static inline void @name@_basis(const double *axis, int cell, double x, double basis[4])
{
    const double width = axis[cell + 1] - axis[cell];
    const double u = (x - axis[cell]) / width;
    const double v = 1.0 - u;
    basis[0] = (1.0 + 2.0 * u) * v * v;
    basis[1] = width * u * v * v;
    basis[2] = u * u * (3.0 - 2.0 * u);
    basis[3] = -width * u * u * v;
}
"""

INTERPOLATION = {
    1: _CELL
    + """
static inline void @name@_interpolate(const double x[1], double q[@nq@])
{
    const int cell = @name@_cell(@name@_axis0, @points0@, x[0]);
    const double *near = @name@_data[cell];
    const double *far = @name@_data[cell + 1];
    double one[4];
    @name@_basis(@name@_axis0, cell, x[0], one);
    @sums@
    @joints_to_q@
}

static inline int @name@_inside(const double x[1], double slack)
{
    return x[0] >= @name@_axis0[0] - slack && x[0] <= @name@_axis0[@points0@ - 1] + slack;
}

static inline void @name@_clip(double x[1])
{
    x[0] = fmin(fmax(x[0], @name@_axis0[0]), @name@_axis0[@points0@ - 1]);
}
""",
    2: _CELL
    + """
static inline void @name@_interpolate(const double x[2], double q[@nq@])
{
    const int row = @name@_cell(@name@_axis0, @points0@, x[0]);
    const int column = @name@_cell(@name@_axis1, @points1@, x[1]);
    const double *d0 = @name@_data[row * @points1@ + column];
    const double *d1 = @name@_data[row * @points1@ + column + 1];
    const double *d2 = @name@_data[(row + 1) * @points1@ + column];
    const double *d3 = @name@_data[(row + 1) * @points1@ + column + 1];
    double one[4], other[4];
    @name@_basis(@name@_axis0, row, x[0], one);
    @name@_basis(@name@_axis1, column, x[1], other);
    {
        @weights@
        @sums@
    }
    @joints_to_q@
}

static inline int @name@_inside(const double x[2], double slack)
{
    return x[0] >= @name@_axis0[0] - slack && x[0] <= @name@_axis0[@points0@ - 1] + slack
        && x[1] >= @name@_axis1[0] - slack && x[1] <= @name@_axis1[@points1@ - 1] + slack;
}

static inline void @name@_clip(double x[2])
{
    x[0] = fmin(fmax(x[0], @name@_axis0[0]), @name@_axis0[@points0@ - 1]);
    x[1] = fmin(fmax(x[1], @name@_axis1[0]), @name@_axis1[@points1@ - 1]);
}
""",
}

_REGULAR = """\
/* Invert a matrix; 0 where it is singular, beside all motion and made dimensionless by bare. */
static inline int @name@_inverted(
    const double matrix[@nn@], const double bare[@nn@], double motion, double inverse[@nn@])
{
"""

ALGEBRA = {
    1: _REGULAR
    + """    inverse[0] = 1.0 / matrix[0];
    return fabs(matrix[0] * bare[0]) > @tolerance@ * motion;
}
""",
    2: _REGULAR
    + """    const double a = matrix[0], b = matrix[1], c = matrix[2], d = matrix[3];
    const double determinant = a * d - b * c;
    const double size = sqrt(
        a * a * bare[0] * bare[0] + b * b * bare[1] * bare[1] + c * c * bare[2] * bare[2]
        + d * d * bare[3] * bare[3]);
    inverse[0] = d / determinant;
    inverse[1] = -b / determinant;
    inverse[2] = -c / determinant;
    inverse[3] = a / determinant;
    return fabs(determinant * bare[0] * bare[3]) > @tolerance@ * motion * size;
}
""",
}
