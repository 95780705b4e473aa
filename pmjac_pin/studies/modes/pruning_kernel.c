/* Narrows boxes to where loop equations can hold, LANES boxes at a time, as `narrowing.py` does
 * without this kernel and says there. Plain C99.
 */
#include "boxes_in_lanes.h"
#include "narrowing.h"

enum { DROPPED = -2, UNCUT = -1 }; /* what becomes of a box; else which unknown is to be cut */

/* Which boxes no row, and no cosine, allows. */
INLINE int64_t excluded(const Loops *loops, Work *work)
{
    int64_t left = 0, k = loops->unknowns, p = loops->rows;
    EACH work->out[i] = 0;
    for (int64_t row = 0; row < p; row++) {
        const Row *value = work->found[row];
        double allowed = loops->tolerance[row];
        EACH work->out[i] |= (value[0][i] > allowed) | (value[1][i] < -allowed);
    }
    for (int64_t n = 0; n < loops->cosines; n++) {
        const Row *cosine = work->found[p + p * k + n];
        EACH work->out[i] |= cosine[1][i] <= 0.0;
    }
    for (int i = 0; i < LANES; i++) left += !work->out[i];
    return left;
}

/* How much a row feels each unknown, as a share of all: it is added to `share`. A row that cannot
 * change by as much as its tolerance feels, by half, how wide each unknown is, of all widths. */
INLINE void add_shares(
    const Loops *loops, Work *work, int64_t row, const double *widths, Row *share)
{
    int64_t k = loops->unknowns;
    Row felt, *size = work->square;
    EACH felt[i] = 1.0;
    for (int64_t j = 0; j < k; j++) {
        const Row *own = work->found[loops->rows + row * k + j];
        double by = loops->scale[j] / loops->tolerance[row];
        EACH {
            double found = most(fabs(own[0][i]), fabs(own[1][i])) * by * work->width[j][i];
            size[j][i] = found < INFINITY ? found : 0.0;
            felt[i] += size[j][i];
        }
    }
    for (int64_t j = 0; j < k; j++)
        EACH {
            double part = 0.5 * work->width[j][i] / (widths[i] + 1e-300);
            share[j][i] += (size[j][i] + part) / felt[i];
        }
}

/* What becomes of each box: the unknown that the rows feel most, where it did not get small. */
INLINE void choose(const Loops *loops, Work *work, int32_t *cut, int width)
{
    int64_t k = loops->unknowns, column[LANES];
    Row before, after, widths, best, *share = work->middle;
    set_zero(before), set_zero(after), set_zero(widths);
    for (int64_t j = 0; j < k; j++) {
        double by = 1.0 / loops->scale[j];
        set_zero(share[j]);
        EACH {
            double own = (work->step[j][1][i] - work->step[j][0][i]) * by;
            before[i] = most(before[i], (work->inputs[j][1][i] - work->inputs[j][0][i]) * by);
            after[i] = most(after[i], own);
            widths[i] += own;
            work->width[j][i] = own;
        }
    }
    for (int64_t row = 0; row < loops->rows; row++) add_shares(loops, work, row, widths, share);
    EACH best[i] = -2.0, column[i] = 0;
    for (int64_t j = 0; j < k; j++)
        EACH {
            double own = work->width[j][i] > 0.0 ? share[j][i] : -1.0;
            column[i] = own > best[i] ? j : column[i];
            best[i] = own > best[i] ? own : best[i];
        }
    for (int i = 0; i < width; i++) {
        int smaller = after[i] <= loops->progress * before[i];
        cut[i] = work->out[i] ? DROPPED : smaller ? UNCUT : (int32_t)column[i];
    }
}

FOR_EACH_PROCESSOR
static void prune(
    const Loops *loops, Work *work, double *lower, double *upper, int32_t *cut, int width)
{
    int64_t k = loops->unknowns;
    take(lower, k, width, work->inputs, 0), take(upper, k, width, work->inputs, 1);
    evaluate(&loops->whole, work->whole_slots, work, work->found, outputs_of(loops));
    if (!excluded(loops, work)) {
        for (int i = 0; i < width; i++) cut[i] = DROPPED;
        return;
    }
    look_at_middle(loops, work);
    invert(loops, work);
    combine(loops, work);
    narrow(loops, work);
    choose(loops, work, cut, width);
    for (int64_t j = 0; j < k; j++)
        for (int i = 0; i < width; i++)
            lower[i * k + j] = work->step[j][0][i], upper[i * k + j] = work->step[j][1][i];
}

/* Boxes (count, k) are narrowed in their place, and `cut` says what becomes of each; 1 where there
 * is no memory. */
int pmjac_prune(const Loops *loops, int64_t count, double *lower, double *upper, int32_t *cut)
{
    Work work;
    void *memory = prepared(loops, &work);
    if (!memory) return 1;
    for (int64_t start = 0; start < count; start += LANES) {
        int width = count - start < LANES ? (int)(count - start) : LANES;
        int64_t at = start * loops->unknowns;
        prune(loops, &work, lower + at, upper + at, cut + start, width);
    }
    free(memory);
    return 0;
}

FOR_EACH_PROCESSOR
static void enclose(
    const Loops *loops, Work *work, const double *lower, const double *upper, double *found,
    int64_t count, int64_t start, int width)
{
    int64_t k = loops->unknowns, outputs = outputs_of(loops);
    take(lower + start * k, k, width, work->inputs, 0);
    take(upper + start * k, k, width, work->inputs, 1);
    evaluate(&loops->whole, work->whole_slots, work, work->found, outputs);
    for (int64_t n = 0; n < outputs; n++)
        for (int end = 0; end < 2; end++)
            for (int i = 0; i < width; i++)
                found[(n * 2 + end) * count + start + i] = work->found[n][end][i];
}

/* What `whole` tells of boxes (count, k): lower and upper ends of each, a row of boxes. */
int pmjac_enclose(
    const Loops *loops, int64_t count, const double *lower, const double *upper, double *found)
{
    Work work;
    void *memory = prepared(loops, &work);
    if (!memory) return 1;
    for (int64_t start = 0; start < count; start += LANES) {
        int width = count - start < LANES ? (int)(count - start) : LANES;
        enclose(loops, &work, lower, upper, found, count, start, width);
    }
    free(memory);
    return 0;
}
