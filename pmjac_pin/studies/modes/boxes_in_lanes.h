/* What is known of LANES boxes at a time, and how loop equations are enclosed over them. */
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

/* What LANES boxes need. `values` are the rows', at the middle, and then of the rows combined. */
typedef struct {
    Ends *whole_slots, *values_slots, *inputs, *found, *values, *combined, *step;
    Row *inverse, *square, *middle, *width;
    int64_t out[LANES];
} Work;

INLINE int64_t outputs_of(const Loops *loops)
{
    return loops->rows * (loops->unknowns + 1) + loops->cosines;
}

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
    int64_t k = loops->unknowns, p = loops->rows, found = outputs_of(loops);
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

/* Where anything overflowed no end is a number: it excludes nothing, and narrows nothing. */
INLINE void evaluate(const Program *program, Ends *slots, Work *work, Ends *found, int64_t outputs)
{
    Row lost;
    EACH lost[i] = 0.0;
    run_intervals(program->code, program->length, slots, work->inputs, found, lost);
    for (int64_t n = 0; n < outputs; n++)
        EACH found[n][0][i] += lost[i], found[n][1][i] += lost[i];
}

INLINE void set_zero(double *row) { EACH row[i] = 0.0; }
