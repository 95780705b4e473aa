/* Radii of the ellipsoids of many J_eq, LANES of them at a time: what `rates/many_radii.py` says
 * without this kernel. Plain C99.
 */
#include "../algebra/singular_values.c"

/* What is flat beside the largest, and what is rounding beside sizes, is zero. */
typedef struct {
    double flat, rounding;
} Nothing;

/* The vectors of one of the two blocks of matrices (6, motors), no more of them than their
 * entries; lanes without a matrix have the last one. */
INLINE void take_block(
    const double *J_eq, int64_t motors, int64_t first_row, int width, double (*tile)[LANES])
{
    int across = motors < 3;
    int64_t vectors = across ? motors : 3, length = across ? 3 : motors;
    for (int at = 0; at < LANES; at++) {
        const double *block = J_eq + ((at < width ? at : width - 1) * 6 + first_row) * motors;
        for (int64_t vector = 0; vector < vectors; vector++)
            for (int64_t k = 0; k < length; k++)
                tile[vector * length + k][at] = block[across ? k * motors + vector : vector * motors + k];
    }
}

INLINE void put_radii(
    const Nothing *nothing, double (*values)[LANES], int64_t many, double size, int at, double *radii)
{
    int none = 0;
    for (int64_t k = 0; k < 3; k++) {
        double radius = k < many ? values[k][at] : 0.0;
        none |= isnan(radius);
        radii[k] = radius > nothing->flat * (many ? values[0][at] : 0.0) ? radius : 0.0;
        if (radii[k] <= nothing->rounding * size) radii[k] = 0.0;
    }
    for (int64_t k = 0; k < 3 && none; k++) radii[k] = NAN;
}

/* Of J_eq (count, 6, motors): the radii (count, 3) of the linear and the angular block, beside
 * sizes (2, count). Returns 0, or 1 where there is no memory. */
int pmjac_radii(
    const double *J_eq, int64_t motors, int64_t count, const double *sizes, const void *zero,
    double *linear, double *angular)
{
    const Nothing *nothing = zero;
    int64_t many = motors < 3 ? motors : 3, length = motors < 3 ? 3 : motors, entries = 3 * motors;
    const int64_t places[3] = {0, 1, 2};
    double *radii[2] = {linear, angular};
    void *memory = malloc((size_t)(2 * entries + 3 * many) * sizeof(double[LANES]) + 64);
    if (!memory) return 1;
    double (*tile)[LANES] = (double (*)[LANES])(((uintptr_t)memory + 63) / 64 * 64);
    double (*x)[LANES] = tile + entries, (*values)[LANES] = x + entries;
    for (int64_t start = 0; start < count; start += LANES) {
        int width = count - start < LANES ? (int)(count - start) : LANES;
        for (int block = 0; block < 2; block++) {
            take_block(J_eq + start * 6 * motors, motors, 3 * block, width, tile);
            find_scaled((double *)tile, LANES, LANES, x, many, length, places, many, values);
            for (int at = 0; at < width; at++)
                put_radii(nothing, values, many, sizes[block * count + start + at], at,
                          radii[block] + (start + at) * 3);
        }
    }
    free(memory);
    return 0;
}
