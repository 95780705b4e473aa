/* Follows points of a curve from planes to planes, LANES of them at a time, as `curve.py` does
 * without this kernel and says there. Plain C99.
 *
 * Each lane has a point. All lanes take a step at a time; one whose point has arrived, or is lost,
 * takes up the next. What is known of the mechanism is in a program: F and its derivatives.
 */
#ifndef LANES
#define LANES 32
#endif
#include "../../algebra/tape_kernel.c"

typedef double Row[LANES];
typedef Row Number[2]; /* a complex number of each lane: its real and its imaginary part */

typedef struct {
    int64_t path, tries; /* no path: -1 */
    double share, step, length;
} Lane;

/* A point (X, h, t) has `size` numbers, a plane as many: its normal's, and its offset. Points,
 * planes and how these move are complex numbers, one row a path. */
typedef struct {
    const int32_t *code;
    Row *slots;
    Number *inputs; /* of the program: a point, and what is the same for all */
    Number *matrix; /* (size, size + 1): the program's outputs, two rows more, and a right side */
    Number *memory; /* 9 size */
    Lane *lanes;
    double *points, *share;
    const double *planes, *pulls;
    int64_t length, size, count, taken, most_steps, corrections;
    double first_step, smallest_step, arrived, close, exact;
} Walk;

enum { POINT, TRIAL, VELOCITY, SUM, ACROSS, PLANE, PULL, START, MOVED };

int pmjac_lanes(void) { return LANES; }

INLINE Number *numbers(const Walk *walk, int which) { return walk->memory + which * walk->size; }

INLINE void copy(Number *to, Number *from, int64_t count)
{
    for (int64_t k = 0; k < count; k++)
        for (int part = 0; part < 2; part++)
            EACH to[k][part][i] = from[k][part][i];
}

/* sum += a b */
INLINE void add_product(Row *sum, const Row *a, const Row *b)
{
    EACH {
        double real = a[0][i] * b[0][i] - a[1][i] * b[1][i];
        double imaginary = a[0][i] * b[1][i] + a[1][i] * b[0][i];
        sum[0][i] += real, sum[1][i] += imaginary;
    }
}

INLINE void subtract_product(Row *sum, const Row *a, const Row *b)
{
    EACH {
        double real = a[0][i] * b[0][i] - a[1][i] * b[1][i];
        double imaginary = a[0][i] * b[1][i] + a[1][i] * b[0][i];
        sum[0][i] -= real, sum[1][i] -= imaginary;
    }
}

/* to = a + share b */
INLINE void go(Number *to, Number *a, Number *b, const Row share, int64_t count)
{
    for (int64_t k = 0; k < count; k++)
        for (int part = 0; part < 2; part++)
            EACH to[k][part][i] = a[k][part][i] + share[i] * b[k][part][i];
}

/* a · (X, h t) − b h of a plane's numbers a, b */
INLINE void missed_by_ray(Number *plane, Number *point, int64_t size, Row *missed)
{
    Number height;
    EACH {
        height[0][i] = -plane[size - 1][0][i], height[1][i] = -plane[size - 1][1][i];
        missed[0][i] = missed[1][i] = 0.0;
    }
    add_product(height, plane[size - 2], point[size - 1]);
    for (int64_t k = 0; k < size - 2; k++) add_product(missed, plane[k], point[k]);
    add_product(missed, height, point[size - 2]);
}

/* F, the plane's equation and that of (X, h)'s own, and their derivatives, as a matrix with a
 * column more. */
INLINE void know(Walk *walk, Number *point)
{
    int64_t size = walk->size, width = size + 1;
    Number *plane = numbers(walk, PLANE), *across = numbers(walk, ACROSS);
    Number *cut = walk->matrix + (size - 2) * width, *patch = cut + width;
    copy(walk->inputs, point, size);
    run(walk->code, walk->length, walk->slots, (const double *)walk->inputs, LANES, 0, LANES,
        (double *)walk->matrix);
    copy(cut, plane, size - 2);
    EACH cut[size - 2][0][i] = -plane[size - 1][0][i], cut[size - 2][1][i] = -plane[size - 1][1][i];
    add_product(cut[size - 2], plane[size - 2], point[size - 1]);
    EACH cut[size - 1][0][i] = cut[size - 1][1][i] = 0.0;
    add_product(cut[size - 1], plane[size - 2], point[size - 2]);
    missed_by_ray(plane, point, size, cut[size]);
    copy(patch, across, size - 1);
    EACH patch[size - 1][0][i] = patch[size - 1][1][i] = patch[size][1][i] = 0.0;
    EACH patch[size][0][i] = -1.0;
    for (int64_t k = 0; k < size - 1; k++) add_product(patch[size], across[k], point[k]);
}

/* Bring the largest entry of a column to the diagonal, by exchanging rows of each lane. */
INLINE void exchange(Number *matrix, int64_t size, int64_t column)
{
    int64_t width = size + 1, best[LANES];
    Row most;
    EACH {
        const Row *own = matrix[column * width + column];
        most[i] = fabs(own[0][i]) + fabs(own[1][i]), best[i] = column;
    }
    for (int64_t row = column + 1; row < size; row++) {
        const Row *own = matrix[row * width + column];
        EACH {
            double length = fabs(own[0][i]) + fabs(own[1][i]);
            best[i] = length > most[i] ? row : best[i];
            most[i] = length > most[i] ? length : most[i];
        }
    }
    for (int lane = 0; lane < LANES; lane++) {
        if (best[lane] == column) continue;
        Number *one = matrix + column * width, *other = matrix + best[lane] * width;
        for (int64_t k = column; k < width; k++)
            for (int part = 0; part < 2; part++) {
                double kept = one[k][part][lane];
                one[k][part][lane] = other[k][part][lane], other[k][part][lane] = kept;
            }
    }
}

/* Gauss's elimination: the last column becomes the solution. */
INLINE void solve(Number *matrix, int64_t size)
{
    int64_t width = size + 1;
    for (int64_t column = 0; column < size; column++) {
        Number *own = matrix + column * width, inverse;
        exchange(matrix, size, column);
        EACH {
            double real = own[column][0][i], imaginary = own[column][1][i];
            double square = real * real + imaginary * imaginary;
            inverse[0][i] = real / square, inverse[1][i] = -imaginary / square;
        }
        for (int64_t k = column + 1; k < width; k++) {
            Number whole;
            EACH {
                whole[0][i] = own[k][0][i] * inverse[0][i] - own[k][1][i] * inverse[1][i];
                whole[1][i] = own[k][0][i] * inverse[1][i] + own[k][1][i] * inverse[0][i];
            }
            copy(own + k, &whole, 1);
        }
        for (int64_t row = column + 1; row < size; row++)
            for (int64_t k = column + 1; k < width; k++)
                subtract_product(matrix[row * width + k], matrix[row * width + column], own[k]);
    }
    for (int64_t column = size - 1; column > 0; column--)
        for (int64_t row = 0; row < column; row++)
            subtract_product(
                matrix[row * width + size], matrix[row * width + column],
                matrix[column * width + size]);
}

/* The planes that far along each lane's step. */
INLINE void put_planes(Walk *walk, double part)
{
    Row share;
    for (int at = 0; at < LANES; at++)
        share[at] = walk->lanes[at].share + part * walk->lanes[at].length;
    go(numbers(walk, PLANE), numbers(walk, START), numbers(walk, PULL), share, walk->size);
}

/* How a point moves with its planes. */
INLINE void find_velocity(Walk *walk, Number *point, double part)
{
    int64_t size = walk->size, width = size + 1;
    Number *velocity = numbers(walk, VELOCITY), missed;
    put_planes(walk, part);
    know(walk, point);
    missed_by_ray(numbers(walk, PULL), point, size, missed);
    for (int64_t row = 0; row < size; row++) {
        Row *side = walk->matrix[row * width + size];
        int moves = row == size - 2;
        EACH side[0][i] = moves ? -missed[0][i] : 0.0, side[1][i] = moves ? -missed[1][i] : 0.0;
    }
    solve(walk->matrix, size);
    for (int64_t row = 0; row < size; row++)
        copy(velocity + row, walk->matrix + row * width + size, 1);
}

/* Runge and Kutta's fourth-order rule: the points a step further. */
INLINE void predict(Walk *walk)
{
    static const double parts[] = {0.0, 0.5, 0.5, 1.0}, weights[] = {1.0, 2.0, 2.0, 1.0};
    int64_t size = walk->size;
    Number *point = numbers(walk, POINT), *trial = numbers(walk, TRIAL);
    Number *sum = numbers(walk, SUM), *velocity = numbers(walk, VELOCITY);
    copy(trial, point, size);
    copy(sum, point, size);
    for (int k = 0; k < 4; k++) {
        Row share;
        find_velocity(walk, trial, parts[k]);
        EACH share[i] = walk->lanes[i].length / 6.0 * weights[k];
        go(sum, sum, velocity, share, size);
        if (k == 3) break;
        EACH share[i] = parts[k + 1] * walk->lanes[i].length;
        go(trial, point, velocity, share, size);
    }
    copy(trial, sum, size);
}

/* Newton's step of the trial; how long it was, t relative to its size. */
INLINE void correct(Walk *walk, Row length)
{
    int64_t size = walk->size, width = size + 1;
    Number *trial = numbers(walk, TRIAL);
    Row squares = {0.0};
    know(walk, trial);
    solve(walk->matrix, size);
    for (int64_t k = 0; k < size; k++) {
        const Row *step = walk->matrix[k * width + size];
        EACH {
            double square = step[0][i] * step[0][i] + step[1][i] * step[1][i];
            if (k < size - 1) {
                squares[i] += square;
            } else {
                double real = trial[k][0][i], imaginary = trial[k][1][i];
                double t = 1.0 + sqrt(real * real + imaginary * imaginary);
                length[i] = sqrt(squares[i]) + sqrt(square) / t;
            }
            trial[k][0][i] -= step[0][i], trial[k][1][i] -= step[1][i];
        }
    }
}

/* (X, h) of length 1. */
INLINE void take_unit_point(Walk *walk, const int64_t *good)
{
    int64_t size = walk->size;
    Number *point = numbers(walk, POINT), *trial = numbers(walk, TRIAL);
    Row squares = {0.0};
    for (int64_t k = 0; k < size - 1; k++)
        EACH squares[i] += trial[k][0][i] * trial[k][0][i] + trial[k][1][i] * trial[k][1][i];
    for (int64_t k = 0; k < size; k++)
        for (int part = 0; part < 2; part++)
            EACH {
                double unit = k < size - 1 ? 1.0 / sqrt(squares[i]) : 1.0;
                point[k][part][i] = good[i] ? trial[k][part][i] * unit : point[k][part][i];
            }
}

/* One step of each lane, tried. */
FOR_EACH_PROCESSOR
static void step(Walk *walk)
{
    Number *point = numbers(walk, POINT), *across = numbers(walk, ACROSS);
    Row first, last;
    int64_t good[LANES];
    for (int at = 0; at < LANES; at++) {
        Lane *lane = walk->lanes + at;
        double left = 1.0 - lane->share;
        lane->length = lane->step < left ? lane->step : left;
    }
    for (int64_t k = 0; k < walk->size - 1; k++)
        EACH across[k][0][i] = point[k][0][i], across[k][1][i] = -point[k][1][i];
    predict(walk);
    put_planes(walk, 1.0);
    correct(walk, first);
    for (int64_t k = 1; k < walk->corrections; k++) correct(walk, last);
    for (int at = 0; at < LANES; at++)
        good[at] = walk->lanes[at].path >= 0 && first[at] < walk->close && last[at] < walk->exact;
    take_unit_point(walk, good);
    for (int at = 0; at < LANES; at++) {
        Lane *lane = walk->lanes + at;
        lane->tries++;
        lane->share += good[at] ? lane->length : 0.0;
        lane->step *= good[at] ? 2.0 : 0.5;
    }
}

/* Numbers of one lane, from a row of complex ones. */
static void put(Number *numbers, const double *given, int64_t count, int lane)
{
    for (int64_t k = 0; k < count; k++)
        numbers[k][0][lane] = given[2 * k], numbers[k][1][lane] = given[2 * k + 1];
}

static void take_up(Walk *walk, int at)
{
    int64_t path = walk->taken++, size = walk->size, place = 2 * size * path;
    put(numbers(walk, POINT), walk->points + place, size, at);
    put(numbers(walk, START), walk->planes + place, size, at);
    put(numbers(walk, PULL), walk->pulls + place, size, at);
    walk->lanes[at] = (Lane){.path = path, .step = walk->first_step};
}

static void finish(Walk *walk, int at)
{
    Lane *lane = walk->lanes + at;
    Number *point = numbers(walk, POINT);
    double *found = walk->points + 2 * walk->size * lane->path;
    for (int64_t k = 0; k < walk->size; k++)
        found[2 * k] = point[k][0][at], found[2 * k + 1] = point[k][1][at];
    walk->share[lane->path] = lane->share;
    lane->path = -1;
}

static int goes_on(const Walk *walk, const Lane *lane)
{
    return lane->share < walk->arrived && lane->step >= walk->smallest_step
        && lane->tries < walk->most_steps;
}

/* How many lanes have a point to go on with. Those that have none stay where they are. */
static int set_out(Walk *walk)
{
    int going = 0;
    for (int at = 0; at < LANES; at++) {
        Lane *lane = walk->lanes + at;
        if (lane->path >= 0 && !goes_on(walk, lane)) finish(walk, at);
        if (lane->path < 0 && walk->taken < walk->count) take_up(walk, at);
        going += lane->path >= 0;
    }
    return going;
}

/* Follows on, up to so many steps of each lane; 1 where more of them lead further. Before the
 * first, no lane has a path. */
int pmjac_follow(Walk *walk, int64_t steps)
{
    for (; set_out(walk); steps--) {
        if (!steps) return 1;
        step(walk);
    }
    return 0;
}
