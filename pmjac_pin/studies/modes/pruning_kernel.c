/* Narrows boxes to where loop equations can hold, LANES boxes at a time, as `narrowing.py` does
 * without this kernel and says there. Plain C99.
 */
#include "../../algebra/interval_tape.c"

typedef struct {
    const int32_t *code;
    const double *constants;
    int64_t length, known, slots;
} Program;

/* p rows of k unknowns. `whole` tells the rows, their derivatives, row by row, and cosines;
 * `values` the rows alone. Their inputs are the unknowns and `fixed` intervals more, `given`. */
typedef struct {
    Program whole, values;
    const double *given, *tolerance, *scale;
    int64_t fixed, unknowns, rows, cosines;
    double progress;
} Loops;

enum { DROPPED = -2, UNCUT = -1 }; /* what becomes of a box; else which unknown is to be cut */

/* What LANES boxes need. `values` are the rows', at the middle, and then of the rows combined. */
typedef struct {
    Ends *whole_slots, *values_slots, *inputs, *found, *values, *combined, *step;
    Row *inverse, *square, *middle, *width;
    int64_t out[LANES];
    Row lost;
} Work;

INLINE void put_constants(const Program *program, Ends *slots)
{
    for (int64_t slot = 0; slot < program->known; slot++)
        EACH slots[slot][0][i] = slots[slot][1][i] = program->constants[slot];
}

INLINE Row *rows(Row **memory, int64_t count)
{
    Row *first = *memory;
    *memory += count;
    return first;
}

INLINE Ends *intervals(Row **memory, int64_t count) { return (Ends *)rows(memory, 2 * count); }

/* Returns what is to be freed, or NULL. */
static void *prepared(const Loops *loops, Work *work)
{
    int64_t k = loops->unknowns, p = loops->rows, found = p * (k + 1) + loops->cosines;
    int64_t slots = loops->whole.slots + loops->values.slots + 2;
    int64_t whole = slots + (k + loops->fixed) + found + (p + k) + k * k + k;
    void *memory = malloc((size_t)(2 * whole + k * (p + k + 2)) * sizeof(Row) + 64);
    if (!memory) return memory;
    Row *at = (Row *)(((uintptr_t)memory + 63) / 64 * 64);
    work->whole_slots = intervals(&at, loops->whole.slots + 1);
    work->values_slots = intervals(&at, loops->values.slots + 1);
    work->inputs = intervals(&at, k + loops->fixed);
    work->found = intervals(&at, found);
    work->values = intervals(&at, p + k);
    work->combined = intervals(&at, k * k);
    work->step = intervals(&at, k);
    work->inverse = rows(&at, k * p);
    work->square = rows(&at, k * k);
    work->middle = rows(&at, k);
    work->width = rows(&at, k);
    put_constants(&loops->whole, work->whole_slots);
    put_constants(&loops->values, work->values_slots);
    for (int64_t n = 0; n < loops->fixed; n++)
        for (int end = 0; end < 2; end++)
            EACH work->inputs[k + n][end][i] = loops->given[2 * n + end];
    return memory;
}

/* Rows of so many numbers, one row a box, to lanes; the last box again where there are fewer. */
INLINE void take(const double *rows, int64_t columns, int width, Ends *to, int end)
{
    for (int64_t j = 0; j < columns; j++)
        for (int i = 0; i < LANES; i++)
            to[j][end][i] = rows[(i < width ? i : width - 1) * columns + j];
}

INLINE void evaluate(const Program *program, Ends *slots, Work *work, Ends *found)
{
    run_intervals(program->code, program->length, slots, work->inputs, found, work->lost);
}

/* A matrix of doubles times intervals: sum += factor x, size += what it may be in size. */
INLINE void add_multiple(Row *sum, double *size, const double *factor, const Row *x)
{
    EACH {
        double one = factor[i] * x[0][i], other = factor[i] * x[1][i];
        sum[0][i] += least(one, other), sum[1][i] += most(one, other);
        size[i] += most(fabs(one), fabs(other));
    }
}

/* Move the ends of a sum of so many products outwards; what overflows bounds nothing. */
INLINE void widen(Row *sum, const double *size, int64_t terms)
{
    double share = (double)(terms + 4) * UNIT;
    EACH {
        double by = size[i] * share + TINY + size[i] * 0.0;
        sum[0][i] -= by, sum[1][i] += by;
    }
}

INLINE void set_zero(double *row) { EACH row[i] = 0.0; }

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

/* Factors L D L^T of a symmetric matrix, in its place. */
INLINE void factorise(Row *square, int64_t k)
{
    for (int64_t j = 0; j < k; j++)
        for (int64_t row = j + 1; row < k; row++) {
            double *factor = square[row * k + j];
            EACH factor[i] = square[j * k + row][i] / square[j * k + j][i];
            for (int64_t n = j + 1; n <= row; n++) {
                double *to = square[n * k + row];
                EACH to[i] -= factor[i] * square[j * k + n][i];
            }
        }
}

INLINE void solve(Row *square, Row *x, int64_t k)
{
    for (int64_t j = 0; j < k; j++)
        for (int64_t row = j + 1; row < k; row++)
            EACH x[row][i] -= square[row * k + j][i] * x[j][i];
    for (int64_t j = 0; j < k; j++)
        EACH x[j][i] /= square[j * k + j][i];
    for (int64_t j = k - 1; j > 0; j--)
        for (int64_t row = 0; row < j; row++)
            EACH x[row][i] -= square[j * k + row][i] * x[j][i];
}

/* About (J^T J)^-1 J^T of rows by their tolerances, a column for each row: `inverse` has them one
 * after the other. Of what is no number, 0: no proof depends on how exact it is. */
INLINE void invert(const Loops *loops, Work *work)
{
    int64_t k = loops->unknowns, p = loops->rows;
    double smallest = INFINITY;
    Row most_square;
    for (int64_t row = 0; row < p; row++) smallest = least(smallest, loops->tolerance[row]);
    for (int64_t n = 0; n < k * k; n++) set_zero(work->square[n]);
    for (int64_t row = 0; row < p; row++) {
        double weight = smallest / loops->tolerance[row];
        Row *x = work->inverse + row * k;
        for (int64_t j = 0; j < k; j++) {
            const Row *own = work->found[p + row * k + j];
            EACH x[j][i] = (own[0][i] + 0.5 * (own[1][i] - own[0][i])) * (weight * weight);
        }
        for (int64_t j = 0; j < k; j++)
            for (int64_t n = 0; n <= j; n++)
                EACH work->square[n * k + j][i] += x[n][i] * x[j][i] / (weight * weight);
    }
    set_zero(most_square);
    for (int64_t j = 0; j < k; j++)
        EACH most_square[i] = most(most_square[i], work->square[j * k + j][i]);
    for (int64_t j = 0; j < k; j++)
        EACH work->square[j * k + j][i] += 1e-13 * most_square[i] + 1e-200;
    factorise(work->square, k);
    for (int64_t row = 0; row < p; row++) {
        Row *x = work->inverse + row * k;
        solve(work->square, x, k);
        for (int64_t j = 0; j < k; j++)
            EACH x[j][i] = fabs(x[j][i]) < 1e100 ? x[j][i] : 0.0;
    }
}

/* The rows combined by the approximate inverse: values behind those of the rows, and derivatives. */
INLINE void combine(const Loops *loops, Work *work)
{
    int64_t k = loops->unknowns, p = loops->rows;
    Row size;
    for (int64_t j = 0; j < k; j++)
        for (int64_t n = 0; n <= k; n++) {
            Row *sum = n < k ? work->combined[j * k + n] : work->values[p + j];
            set_zero(sum[0]), set_zero(sum[1]), set_zero(size);
            for (int64_t row = 0; row < p; row++) {
                const Row *x = n < k ? work->found[p + row * k + n] : work->values[row];
                add_multiple(sum, size, work->inverse[row * k + j], x);
            }
            widen(sum, size, p);
        }
}

/* Narrow the step along one unknown to where 0 is in value + derivatives . step. */
INLINE void solve_for(
    const Row *value, Ends *derivatives, Ends *step, int64_t k, int64_t column, Ends bound)
{
    const Row *own = derivatives[column];
    int possible = 0;
    for (int i = 0; i < LANES; i++) possible |= (own[0][i] > 0.0) | (own[1][i] < 0.0);
    if (!possible) return;
    Ends sum, product;
    Row size;
    EACH {
        sum[0][i] = value[0][i], sum[1][i] = value[1][i];
        size[i] = most(fabs(value[0][i]), fabs(value[1][i]));
    }
    for (int64_t j = 0; j < k; j++) {
        if (j == column) continue;
        multiply(product, derivatives[j], step[j]);
        EACH {
            sum[0][i] += product[0][i], sum[1][i] += product[1][i];
            size[i] += most(fabs(product[0][i]), fabs(product[1][i]));
        }
    }
    widen(sum, size, k);
    EACH {
        int turned = own[1][i] < 0.0;
        double small = turned ? -own[1][i] : own[0][i], large = turned ? -own[0][i] : own[1][i];
        double from = turned ? sum[0][i] : -sum[1][i], to = turned ? sum[1][i] : -sum[0][i];
        double low = down(from / (from >= 0.0 ? large : small));
        double high = up(to / (to >= 0.0 ? small : large));
        bound[0][i] = small > 0.0 && low > bound[0][i] ? low : bound[0][i];
        bound[1][i] = small > 0.0 && high < bound[1][i] ? high : bound[1][i];
    }
}

/* The part of each box where 0 is in all rows, by one unknown after the other. */
INLINE void narrow(const Loops *loops, Work *work)
{
    int64_t k = loops->unknowns, p = loops->rows;
    for (int64_t j = 0; j < k; j++)
        EACH {
            work->step[j][0][i] = down(work->inputs[j][0][i] - work->middle[j][i]);
            work->step[j][1][i] = up(work->inputs[j][1][i] - work->middle[j][i]);
        }
    for (int64_t column = 0; column < k; column++) {
        Ends bound;
        EACH bound[0][i] = work->step[column][0][i], bound[1][i] = work->step[column][1][i];
        for (int64_t row = 0; row < p + k; row++) {
            Ends *own = row < p ? work->found + p + row * k : work->combined + (row - p) * k;
            solve_for(work->values[row], own, work->step, k, column, bound);
        }
        EACH work->step[column][0][i] = bound[0][i], work->step[column][1][i] = bound[1][i];
    }
    for (int64_t j = 0; j < k; j++)
        EACH {
            double low = down(work->middle[j][i] + work->step[j][0][i]);
            double high = up(work->middle[j][i] + work->step[j][1][i]);
            int kept = work->lost[i] != 0.0; /* what is not a number narrows nothing */
            work->step[j][0][i] = kept ? work->inputs[j][0][i] : most(low, work->inputs[j][0][i]);
            work->step[j][1][i] = kept ? work->inputs[j][1][i] : least(high, work->inputs[j][1][i]);
            work->out[i] |= work->step[j][0][i] > work->step[j][1][i];
        }
}

/* The unknown that the rows feel most, for the boxes that did not get much smaller. */
INLINE void choose(const Loops *loops, Work *work, int32_t *cut, int width)
{
    int64_t k = loops->unknowns, p = loops->rows;
    Row before, after, whole, best;
    int64_t column[LANES];
    set_zero(before), set_zero(after), set_zero(whole);
    for (int64_t j = 0; j < k; j++) {
        double by = 1.0 / loops->scale[j];
        EACH {
            double own = (work->step[j][1][i] - work->step[j][0][i]) * by;
            before[i] = most(before[i], (work->inputs[j][1][i] - work->inputs[j][0][i]) * by);
            after[i] = most(after[i], own);
            whole[i] += own;
            work->width[j][i] = own;
            work->middle[j][i] = 0.0;
        }
    }
    for (int64_t row = 0; row < p; row++) {
        Row felt;
        EACH felt[i] = 1.0;
        for (int64_t share = 0; share < 2; share++)
            for (int64_t j = 0; j < k; j++) {
                const Row *own = work->found[p + row * k + j];
                double by = loops->scale[j] / loops->tolerance[row];
                EACH {
                    double size = most(fabs(own[0][i]), fabs(own[1][i])) * by * work->width[j][i];
                    size = size < INFINITY ? size : 0.0;
                    double part = (size + 0.5 * work->width[j][i] / (whole[i] + 1e-300)) / felt[i];
                    if (share) work->middle[j][i] += part; else work->square[j][i] = size;
                }
                if (!share && j == k - 1)
                    for (int64_t n = 0; n < k; n++) EACH felt[i] += work->square[n][i];
            }
    }
    EACH best[i] = -2.0, column[i] = 0;
    for (int64_t j = 0; j < k; j++)
        EACH {
            double share = work->width[j][i] > 0.0 ? work->middle[j][i] : -1.0;
            column[i] = share > best[i] ? j : column[i];
            best[i] = share > best[i] ? share : best[i];
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
    int64_t k = loops->unknowns, p = loops->rows;
    set_zero(work->lost);
    take(lower, k, width, work->inputs, 0), take(upper, k, width, work->inputs, 1);
    evaluate(&loops->whole, work->whole_slots, work, work->found);
    for (int64_t n = 0; n < p + p * k + loops->cosines; n++)
        EACH work->found[n][0][i] += work->lost[i], work->found[n][1][i] += work->lost[i];
    if (!excluded(loops, work)) {
        for (int i = 0; i < width; i++) cut[i] = DROPPED;
        return;
    }
    for (int64_t j = 0; j < k; j++) {
        Row *box = work->inputs[j];
        EACH {
            double middle = box[0][i] + 0.5 * (box[1][i] - box[0][i]);
            work->middle[j][i] = least(most(middle, box[0][i]), box[1][i]);
            work->step[j][0][i] = box[0][i], work->step[j][1][i] = box[1][i];
            box[0][i] = box[1][i] = work->middle[j][i];
        }
    }
    evaluate(&loops->values, work->values_slots, work, work->values);
    for (int64_t row = 0; row < p; row++) {
        Row *value = work->values[row];
        double allowed = loops->tolerance[row];
        EACH value[0][i] = down(value[0][i] - allowed), value[1][i] = up(value[1][i] + allowed);
    }
    for (int64_t j = 0; j < k; j++)
        for (int end = 0; end < 2; end++)
            EACH work->inputs[j][end][i] = work->step[j][end][i];
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
    int64_t k = loops->unknowns, outputs = loops->rows * (k + 1) + loops->cosines;
    set_zero(work->lost);
    take(lower + start * k, k, width, work->inputs, 0);
    take(upper + start * k, k, width, work->inputs, 1);
    evaluate(&loops->whole, work->whole_slots, work, work->found);
    for (int64_t n = 0; n < outputs; n++)
        for (int end = 0; end < 2; end++)
            for (int i = 0; i < width; i++)
                found[(n * 2 + end) * count + start + i] = work->found[n][end][i] + work->lost[i];
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
