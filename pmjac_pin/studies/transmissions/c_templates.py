"""What a header in C99 has of every mechanism; words between @ are filled in."""

from __future__ import annotations

from collections.abc import Mapping


def filled(template: str, words: Mapping[str, str]) -> str:
    """Return a template with its words, each between @."""
    for word, text in words.items():
        template = template.replace(f"@{word}@", text)
    return template


FILE_HEAD = """ *
 *     @name@_pose pose;
 *     if (@name@_at_joints(joints, &pose) == @NAME@_OK)
 *         @name@_motor_efforts(&pose, joint_efforts, motor_efforts);
 *
 * Where the status is another one, all numbers of the pose are NaN, and so is what is made of them.
 */
#ifndef @NAME@_TRANSMISSION_H
#define @NAME@_TRANSMISSION_H

#include <math.h>

enum @name@_status {
    @NAME@_OK = 0,
    @NAME@_OUTSIDE = 1,       /* the joint values are not in the rectangle */
    @NAME@_NOT_CONVERGED = 2, /* no pose of the table was found for these values */
    @NAME@_SINGULAR = 3       /* the joints do not determine the motors, or not the other way */
};

/* A pose, and how rates go there: ratio[@n@ * i + j] is the rate of motor i by that of joint j. */
typedef struct {
    double joints[@n@];
    double motors[@n@];
    double ratio[@nn@];
    double inverse[@nn@];
} @name@_pose;
"""

_POSES = """static inline int @name@_failed(@name@_pose *pose, int status)
{
    int k;
    for (k = 0; k < @n@; ++k)
        pose->joints[k] = pose->motors[k] = NAN;
    for (k = 0; k < @nn@; ++k)
        pose->ratio[k] = pose->inverse[k] = NAN;
    return status;
}

/* Newton's steps at held joints, or to wanted motors, until they are rounding. */
static inline int @name@_polish(
    int by_motors, double q[@inputs@], double *motion, double rates[@nn@])
{
    double next[@nq@], size[1] = {INFINITY}, gap[1] = {NAN}, condition[1] = {NAN};
    int k, step;
    for (step = 0; step < 12; ++step) {
        const int near = size[0] < 3e-7; /* the next step is its square: rounding, or almost */
        if (by_motors && near)
            @name@_step_motors(q, next, size, gap, condition, motion, rates);
        else if (by_motors)
            @name@_near_motors(q, next, size);
        else if (near)
            @name@_step_joints(q, next, size, gap, condition, motion, rates);
        else
            @name@_near_joints(q, next, size);
        for (k = 0; k < @nq@; ++k)
            q[k] = next[k];
        if (!(size[0] < 10.0))
            return @NAME@_NOT_CONVERGED;
        if (near && !(condition[0] * @tolerance@ < 1.0))
            return @NAME@_SINGULAR;
        if (near && size[0] <= 1e-14 * (10.0 + condition[0]))
            return gap[0] <= @gap@ ? @NAME@_OK : @NAME@_NOT_CONVERGED;
    }
    return @NAME@_NOT_CONVERGED;
}

/* Whether q is so near the table that no other pose is. */
static inline int @name@_of_table(const double table[@nq@], const double q[@nq@], double less)
{
    int k, near = 1;
    for (k = 0; k < @nq@; ++k)
        near &= fabs(q[k] - table[k]) <= @name@_alone[k] - less;
    return near;
}

static const double @name@_bare[@nn@] = {@bare@};

/* Position, from joints to motors. */
static inline int @name@_at_joints(const double x[@n@], @name@_pose *pose)
{
    double q[@inputs@], table[@nq@], motion[1] = {NAN};
    double *theta = pose->motors;
    int k, status;
    if (!@name@_inside(x, 0.0))
        return @name@_failed(pose, @NAME@_OUTSIDE);
    for (k = 0; k < @n@; ++k)
        pose->joints[k] = x[k];
    @name@_interpolate(x, q);
    for (k = 0; k < @nq@; ++k)
        table[k] = q[k];
    status = @name@_polish(0, q, motion, pose->ratio);
    if (status != @NAME@_OK)
        return @name@_failed(pose, status);
    if (!@name@_of_table(table, q, 0.0))
        return @name@_failed(pose, @NAME@_NOT_CONVERGED);
    if (!@name@_inverted(pose->ratio, @name@_bare, motion[0], pose->inverse))
        return @name@_failed(pose, @NAME@_SINGULAR);
    @q_to_motors@
    return @NAME@_OK;
}

/* Joint values near those of these motor values: a polynomial. */
static inline void @name@_guess(const double theta[@n@], double x[@n@])
{
    @guess@
    @name@_clip(x);
}

/* The same by Newton's steps on the table, from the nearest of some points. */
static inline void @name@_search(const double theta[@n@], double x[@n@])
{
    double now[@n@], apart[@n@], q[@inputs@], next[@nq@], size[1], gap[1], condition[1], motion[1];
    double rates[@nn@], inverse[@nn@], best = INFINITY;
    int i, k, seed, step;
    for (seed = 0; seed < @seeds@; ++seed) {
        double far = 0.0;
        for (k = 0; k < @n@; ++k)
            now[k] = @name@_seeds[seed][k];
        @apart@
        for (k = 0; k < @n@; ++k)
            far += apart[k] * apart[k];
        if (far < best) {
            best = far;
            for (k = 0; k < @n@; ++k)
                x[k] = @name@_seeds[seed][@n@ + k];
        }
    }
    for (step = 0; step < 20; ++step) {
        double moved = 0.0;
        @name@_interpolate(x, q);
        @name@_step_joints(q, next, size, gap, condition, motion, rates);
        if (!@name@_inverted(rates, @name@_bare, motion[0], inverse))
            return;
        @q_to_now@
        @apart@
        for (i = 0; i < @n@; ++i) {
            const double before = x[i];
            for (k = 0; k < @n@; ++k)
                x[i] += inverse[@n@ * i + k] * apart[k];
            now[i] = before;
        }
        @name@_clip(x);
        for (i = 0; i < @n@; ++i)
            moved = fmax(moved, fabs(x[i] - now[i]));
        if (moved < 1e-6)
            return;
    }
}

static inline int @name@_from(
    const double start[@n@], const double theta[@n@], @name@_pose *pose)
{
    double q[@inputs@], table[@nq@], motion[1] = {NAN}, moved = 0.0;
    double *x = pose->joints;
    int k, status;
    @name@_interpolate(start, q);
    for (k = 0; k < @nq@; ++k)
        table[k] = q[k];
    @motors_to_q@
    for (k = 0; k < @n@; ++k)
        q[@nq@ + k] = theta[k];
    status = @name@_polish(1, q, motion, pose->ratio);
    if (status != @NAME@_OK)
        return @name@_failed(pose, status);
    @q_to_joints@
    if (!@name@_inside(x, 1e-12))
        return @name@_failed(pose, @NAME@_OUTSIDE);
    for (k = 0; k < @n@; ++k)
        moved = fmax(moved, fabs(x[k] - start[k]));
    if (!@name@_of_table(table, q, @steepest@ * moved)) {
        @name@_interpolate(x, table);
        if (!@name@_of_table(table, q, 0.0))
            return @name@_failed(pose, @NAME@_NOT_CONVERGED);
    }
    if (!@name@_inverted(pose->ratio, @name@_bare, motion[0], pose->inverse))
        return @name@_failed(pose, @NAME@_SINGULAR);
    for (k = 0; k < @n@; ++k)
        pose->motors[k] = theta[k];
    return @NAME@_OK;
}

/* Position, from motors to joints. */
static inline int @name@_at_motors(const double theta[@n@], @name@_pose *pose)
{
    double x[@n@];
    int k, status;
    for (k = 0; k < @n@; ++k)
        if (!isfinite(theta[k]))
            return @name@_failed(pose, @NAME@_OUTSIDE);
    @name@_guess(theta, x);
    status = @name@_from(x, theta, pose);
    if (status == @NAME@_OK || status == @NAME@_SINGULAR)
        return status;
    @name@_search(theta, x);
    return @name@_from(x, theta, pose);
}
"""

_PRODUCT = """
/* @what@ */
static inline void @name@_@result@(
    const @name@_pose *pose, const double @given@[@n@], double @result@[@n@])
{
    int i, k;
    for (i = 0; i < @n@; ++i) {
        double sum = 0.0;
        for (k = 0; k < @n@; ++k)
            sum += pose->@entry@ * @given@[k];
        @result@[i] = sum;
    }
}
"""


def _matrix_product(result: str, entry: str, what: str) -> str:
    side, of = result.split("_")
    given = f"{'joint' if side == 'motor' else 'motor'}_{of}"
    return filled(_PRODUCT, {"result": result, "entry": entry, "given": given, "what": what})


_ROW, _COLUMN = "[@n@ * i + k]", "[@n@ * k + i]"  # of a matrix, and of its transpose
_WHAT_PRODUCTS_ARE = (
    ("motor_rates", f"ratio{_ROW}", "Rates of the motors: ratio times those of the joints."),
    ("joint_rates", f"inverse{_ROW}", "Rates of the joints."),
    (
        "motor_efforts",
        f"inverse{_COLUMN}",
        "Efforts of the motors that do what efforts of the joints would.",
    ),
    (
        "joint_efforts",
        f"ratio{_COLUMN}",
        "Efforts of the joints: ratio, transposed, times those of the motors.",
    ),
)
POSES = "".join([_POSES, *(_matrix_product(*one) for one in _WHAT_PRODUCTS_ARE), "\n#endif\n"])
