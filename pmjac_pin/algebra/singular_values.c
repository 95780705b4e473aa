/* Singular values of many matrices, LANES of them at a time: few vectors are turned in pairs until
 * all are orthogonal (Jacobi, from one side), more are reflected to two diagonals (Golub and
 * Kahan), whose singular values are found by halving and Newton's method.
 */
#define LANES 32
#include "lanes.h"

#define FEW 4 /* vectors */
#define MOST_SWEEPS 40
#define ORTHOGONAL 4e-15 /* cosine of an angle that is a right one */
#define ROUNDING 1e-16   /* of the longer vector: what is shorter is that */

/* x . y, four entries at a time: what is summed up goes through memory less often. */
INLINE void product(
    double (*x)[LANES], double (*y)[LANES], int64_t length, double *sum)
{
    int64_t k = 0;
    EACH sum[i] = 0.0;
    for (; k + 4 <= length; k += 4)
        EACH sum[i] += (x[k][i] * y[k][i] + x[k + 1][i] * y[k + 1][i])
            + (x[k + 2][i] * y[k + 2][i] + x[k + 3][i] * y[k + 3][i]);
    for (; k < length; k++)
        EACH sum[i] += x[k][i] * y[k][i];
}

/* Turns two vectors, whose squares are known, in their plane until they are orthogonal; tells
 * whether they were. */
INLINE int turn(
    double (*x)[LANES], double (*y)[LANES], int64_t length, double *xx, double *yy)
{
    double xy[LANES], cosine[LANES], sine[LANES];
    int apart = 0;
    product(x, y, length, xy);
    EACH {
        double least = xx[i] < yy[i] ? xx[i] : yy[i], most = xx[i] < yy[i] ? yy[i] : xx[i];
        apart |= (xy[i] * xy[i] > ORTHOGONAL * ORTHOGONAL * (xx[i] * yy[i]))
            & (least > ROUNDING * ROUNDING * most);
    }
    if (!apart) return 1;
    EACH {
        double some = fabs(xy[i]) > 0.0 ? xy[i] : 1.0;
        double across = 0.5 * (yy[i] - xx[i]) / some;
        double tangent = copysign(1.0, across) / (fabs(across) + sqrt(1.0 + across * across));
        tangent = fabs(xy[i]) > 0.0 ? tangent : 0.0;
        cosine[i] = 1.0 / sqrt(1.0 + tangent * tangent);
        sine[i] = cosine[i] * tangent;
        xx[i] -= tangent * xy[i];
        yy[i] += tangent * xy[i];
    }
    for (int64_t k = 0; k < length; k++)
        EACH {
            double a = x[k][i], b = y[k][i];
            x[k][i] = cosine[i] * a - sine[i] * b;
            y[k][i] = sine[i] * a + cosine[i] * b;
        }
    return 0;
}

/* One-sided Jacobi, several matrices at a time: their vectors are turned in pairs until all are
 * orthogonal; their norms are the singular values, which are put in order. */
INLINE void orthogonalise(double (*x)[LANES], int64_t vectors, int64_t length, double (*values)[LANES])
{
    int settled = 0;
    for (int sweep = 0; sweep < MOST_SWEEPS && !settled; sweep++) {
        settled = 1;
        for (int64_t p = 0; p < vectors; p++)
            product(x + p * length, x + p * length, length, values[p]);
        for (int64_t p = 0; p < vectors; p++)
            for (int64_t q = p + 1; q < vectors; q++)
                settled &= turn(x + p * length, x + q * length, length, values[p], values[q]);
    }
    for (int64_t p = 0; p < vectors; p++) {
        product(x + p * length, x + p * length, length, values[p]);
        EACH values[p][i] = sqrt(values[p][i]);
    }
    for (int64_t p = 0; p < vectors; p++)
        for (int64_t q = p + 1; q < vectors; q++)
            EACH {
                double a = values[p][i], b = values[q][i];
                values[p][i] = a > b ? a : b;
                values[q][i] = a > b ? b : a;
            }
}

/* Turns the part of a vector from `first` on into its first axis: the reflection I - factor v v^T
 * of each lane, whose v is left in the vector's place. Entries lie `apart` from each other. */
INLINE void reflect_to_axis(
    double (*x)[LANES], int64_t first, int64_t end, int64_t apart, double *becomes, double *factor)
{
    double (*head)[LANES] = x + first * apart;
    EACH becomes[i] = 0.0;
    for (int64_t k = first; k < end; k++)
        EACH becomes[i] += x[k * apart][i] * x[k * apart][i];
    EACH {
        double size = sqrt(becomes[i]), along = fabs((*head)[i]), both = size * (size + along);
        factor[i] = both > 0.0 ? 1.0 / (both > 0.0 ? both : 1.0) : 0.0;
        becomes[i] = -copysign(size, (*head)[i]);
        (*head)[i] -= becomes[i];
    }
}

/* y - factor v (v . y), from `first` on. */
INLINE void reflect(
    double (*v)[LANES], double (*y)[LANES], int64_t first, int64_t end, int64_t apart,
    const double *factor)
{
    double share[LANES];
    EACH share[i] = 0.0;
    for (int64_t k = first; k < end; k++)
        EACH share[i] += v[k * apart][i] * y[k * apart][i];
    EACH share[i] *= factor[i];
    for (int64_t k = first; k < end; k++)
        EACH y[k * apart][i] -= share[i] * v[k * apart][i];
}

/* Golub and Kahan's reflections from both sides leave two diagonals, whose squares are kept. */
INLINE void to_two_diagonals(
    double (*x)[LANES], int64_t vectors, int64_t length, double (*main)[LANES], double (*upper)[LANES])
{
    double entry[LANES], factor[LANES];
    for (int64_t k = 0; k < vectors; k++) {
        reflect_to_axis(x + k * length, k, length, 1, entry, factor);
        for (int64_t p = k + 1; p < vectors; p++)
            reflect(x + k * length, x + p * length, k, length, 1, factor);
        EACH main[k][i] = entry[i] * entry[i];
        EACH upper[k][i] = 0.0;
        if (k + 1 == vectors) continue;
        reflect_to_axis(x + k, k + 1, vectors, length, entry, factor);
        for (int64_t row = k + 1; row < length; row++)
            reflect(x + k, x + row, k + 1, vectors, length, factor);
        EACH upper[k][i] = entry[i] * entry[i];
    }
}

#define HALVINGS 54 /* to the last digit of the largest */
#define FIRST 18    /* of them, before Newton's method */
#define NEWTON 3    /* steps, which are enough unless others are as near as a thousandth */
#define LAST 2e-16  /* of the largest: how far Newton's method may be off */
#define NOTHING 1e-290
#define LEAST_ORDER -1000 /* of a power of two that has an inverse */

/* Of two diagonals with these squares: how many singular values are below a number is how many
 * pivots of B^T B less its square are negative. */
INLINE void count_below(
    double (*main)[LANES], double (*upper)[LANES], int64_t vectors, const double *number,
    double *below)
{
    double square[LANES], rest[LANES];
    EACH {
        square[i] = number[i] * number[i];
        rest[i] = -square[i];
        below[i] = 0.0;
    }
    for (int64_t k = 0; k < vectors; k++)
        EACH {
            double pivot = main[k][i] + rest[i], sign = copysign(1.0, pivot);
            below[i] += 0.5 - 0.5 * sign;
            rest[i] = rest[i] * (upper[k][i] / (pivot + NOTHING * sign)) - square[i];
        }
}

/* Newton's step to where the product of the pivots vanishes, of the square of a number. */
INLINE void improve(
    double (*main)[LANES], double (*upper)[LANES], int64_t vectors, const double *low,
    const double *high, double *number)
{
    double square[LANES], rest[LANES], slope[LANES], sum[LANES];
    EACH {
        square[i] = number[i] * number[i];
        rest[i] = -square[i];
        slope[i] = -1.0;
        sum[i] = 0.0;
    }
    for (int64_t k = 0; k < vectors; k++)
        EACH {
            double pivot = main[k][i] + rest[i];
            double inverse = 1.0 / (pivot + copysign(NOTHING, pivot));
            double share = slope[i] * inverse, factor = upper[k][i] * inverse;
            sum[i] += share;
            slope[i] = factor * (slope[i] - rest[i] * share) - 1.0;
            rest[i] = rest[i] * factor - square[i];
        }
    EACH {
        double better = square[i] - 1.0 / sum[i];
        better = sqrt(better > 0.0 ? better : 0.0);
        better = better > low[i] ? better : low[i];
        number[i] = better < high[i] ? better : high[i];
    }
}

INLINE void halve(
    double (*main)[LANES], double (*upper)[LANES], int64_t vectors, int64_t place, int times,
    double *low, double *high)
{
    double middle[LANES], below[LANES];
    for (int halving = 0; halving < times; halving++) {
        EACH middle[i] = 0.5 * (low[i] + high[i]);
        count_below(main, upper, vectors, middle, below);
        EACH {
            double under = below[i] >= (double)(vectors - place) ? 1.0 : 0.0;
            high[i] = under > 0.0 ? middle[i] : high[i];
            low[i] = under > 0.0 ? low[i] : middle[i];
        }
    }
}

/* The singular value at a place, 0 that of the largest, of two diagonals with these squares. What
 * Newton's method finds is taken where counts on both sides say that it is right. */
INLINE void value_at(
    double (*main)[LANES], double (*upper)[LANES], int64_t vectors, int64_t place, double *value)
{
    double low[LANES], high[LANES], before[LANES], off[LANES], less[LANES], more[LANES];
    double wrong[LANES], any = 0.0;
    EACH { low[i] = high[i] = before[i] = 0.0; }
    for (int64_t k = 0; k < vectors; k++)
        EACH { /* Gershgorin */
            double sum = sqrt(main[k][i]) + sqrt(upper[k][i]), other = sqrt(main[k][i]) + before[i];
            sum = sum > other ? sum : other;
            high[i] = high[i] > sum ? high[i] : sum;
            before[i] = sqrt(upper[k][i]);
        }
    EACH off[i] = LAST * high[i];
    halve(main, upper, vectors, place, FIRST, low, high);
    EACH value[i] = 0.5 * (low[i] + high[i]);
    for (int step = 0; step < NEWTON; step++) improve(main, upper, vectors, low, high, value);
    EACH {
        less[i] = value[i] - off[i];
        less[i] = less[i] > 0.0 ? less[i] : 0.0;
        more[i] = value[i] + off[i];
    }
    count_below(main, upper, vectors, less, before);
    count_below(main, upper, vectors, more, wrong);
    EACH {
        double above = before[i] < (double)(vectors - place) ? 0.0 : 1.0;
        wrong[i] = wrong[i] >= (double)(vectors - place) ? above : 1.0;
    }
    for (int i = 0; i < LANES; i++) any += wrong[i];
    if (!(any > 0.0)) return;
    halve(main, upper, vectors, place, HALVINGS - FIRST, low, high);
    EACH value[i] = wrong[i] > 0.0 ? low[i] : value[i];
}

INLINE void find(
    double (*x)[LANES], int64_t vectors, int64_t length, const int64_t *places, int64_t many,
    double (*values)[LANES])
{
    double (*main)[LANES] = values + many, (*upper)[LANES] = main + vectors;
    if (vectors > FEW) {
        to_two_diagonals(x, vectors, length, main, upper);
        for (int64_t k = 0; k < many; k++)
            value_at(main, upper, vectors, places[k], values[k]);
        return;
    }
    orthogonalise(x, vectors, length, main);
    for (int64_t k = 0; k < many; k++)
        EACH values[k][i] = main[places[k]][i];
}

/* Those at some places of LANES matrices, or fewer, in `values`; what follows there is room for two
 * vectors. */
FOR_EACH_PROCESSOR
static void find_scaled(
    const double *matrices, int64_t count, int width, double (*x)[LANES], int64_t vectors,
    int64_t length, const int64_t *places, int64_t many, double (*values)[LANES])
{
    int64_t entries = vectors * length;
    double size[LANES], scale[LANES], nothing[LANES];
    EACH size[i] = nothing[i] = 0.0;
    for (int64_t k = 0; k < entries; k++) {
        const double *given = matrices + k * count;
        if (width == LANES) EACH x[k][i] = given[i];
        else for (int i = 0; i < LANES; i++) x[k][i] = given[i < width ? i : width - 1];
        EACH {
            size[i] = size[i] > fabs(x[k][i]) ? size[i] : fabs(x[k][i]);
            nothing[i] += 0.0 * x[k][i]; /* NaN where an entry is no number */
        }
    }
    for (int i = 0; i < LANES; i++) {
        int some = size[i] > 0.0 && nothing[i] == 0.0;
        int order = some ? ilogb(size[i]) : 0;
        size[i] = ldexp(1.0, order > LEAST_ORDER ? order : LEAST_ORDER);
        scale[i] = some ? 1.0 / size[i] : 0.0;
    }
    for (int64_t k = 0; k < entries; k++)
        EACH x[k][i] = scale[i] > 0.0 ? x[k][i] * scale[i] : 0.0;
    find(x, vectors, length, places, many, values);
    for (int64_t k = 0; k < many; k++)
        EACH values[k][i] = values[k][i] * size[i] + nothing[i];
}

/* Singular values, (many, count), of matrices (vectors, length, count), no more vectors than their
 * length: those at some places, 0 that of the largest; NaN where an entry is no number. Returns 0,
 * or 1 where there is no memory. */
int pmjac_singular_values(
    const double *matrices, int64_t vectors, int64_t length, int64_t count, const int64_t *places,
    int64_t many, double *values)
{
    int64_t entries = vectors * length, room = entries + many + 2 * vectors;
    void *memory = malloc((size_t)room * sizeof(double[LANES]) + 64);
    if (!memory) return 1;
    double (*x)[LANES] = (double (*)[LANES])(((uintptr_t)memory + 63) / 64 * 64);
    for (int64_t start = 0; start < count; start += LANES) {
        int width = count - start < LANES ? (int)(count - start) : LANES;
        find_scaled(matrices + start, count, width, x, vectors, length, places, many, x + entries);
        for (int64_t k = 0; k < many; k++)
            for (int i = 0; i < width; i++) values[k * count + start + i] = x[entries + k][i];
    }
    free(memory);
    return 0;
}
