/* Runs a tape over many sets of inputs, LANES of them at a time. `algebra/tape.py` says what
 * instructions are; INSTRUCTIONS there has their names in the order of this enum.
 */
#ifndef LANES
#define LANES 64
#endif
#include "lanes.h"

enum {
    LOAD, STORE, ADD, SUBTRACT, MULTIPLY, DIVIDE, NEGATE, SINE, COSINE, ROOT, MAGNITUDE, LARGEST,
    COPYSIGN, ARCTANGENT, ROUND, MULTIPLY_ADD, MULTIPLY_SUBTRACT, SUBTRACT_PRODUCT
};

/* For so many of the lanes as have something to do. */
#define BUSY EACH_OF(lanes)

/* Quarters of a turn are taken off in three parts of pi/2 (fdlibm's), exactly for |x| < LARGE. */
#ifndef LARGE
#define LARGE 1e5
#endif
INLINE void wave(const double *x, double *wave_of, int quarter, const int lanes)
{
    double angle[LANES]; /* x may be where the wave goes */
    int large = 0;
    BUSY { angle[i] = x[i]; large |= !(fabs(x[i]) < LARGE); }
    BUSY {
        const double magic = 6755399441055744.0; /* 1.5 * 2^52: what is added is rounded */
        union { double number; int64_t bits; } turns = {x[i] * 0.63661977236758134308 + magic};
        double count = turns.number - magic;
        double y = x[i] - count * 1.57079632673412561417e+00;
        y -= count * 6.07710050630396597660e-11;
        y -= count * 2.02226624879595063154e-21;
        double z = y * y;
        double sine = y + y * z * (-1.66666666666666324348e-01 + z * (8.33333333332248946124e-03
            + z * (-1.98412698298579493134e-04 + z * (2.75573137070700676789e-06
            + z * (-2.50507602534068634195e-08 + z * 1.58969099521155010221e-10)))));
        double cosine = 1.0 - 0.5 * z + z * z * (4.16666666666666019037e-02
            + z * (-1.38888888888741095749e-03 + z * (2.48015872894767294178e-05
            + z * (-2.75573143513906633035e-07 + z * (2.08757232129817482790e-09
            + z * -1.13596475577881948265e-11)))));
        int64_t which = turns.bits + quarter;
        double value = which & 1 ? cosine : sine;
        wave_of[i] = which & 2 ? -value : value;
    }
    if (large)
        for (int i = 0; i < lanes; i++)
            if (!(fabs(angle[i]) < LARGE)) wave_of[i] = quarter ? cos(angle[i]) : sin(angle[i]);
}

/* How many products that follow are added to the target, or taken from it, and nothing else is done
 * with what it holds between them: so it need not go through memory. */
INLINE int more_products(const int32_t *at, const int32_t *end, int operation, int most)
{
    int target = at[1], count = 0;
    for (at += 5; count < most && at != end && at[0] == operation; at += 5, count++)
        if (at[1] != target || at[4] != target || at[2] == target || at[3] == target) break;
    return count;
}

#define PRODUCT(later) (slots[at[5 * (later) + 2]][i] * slots[at[5 * (later) + 3]][i])

/* On so many of the lanes, which is a number that is known where this is inlined. */
INLINE void run_lanes(
    const int lanes, const int32_t *code, int64_t length, double (*slots)[LANES],
    const double *inputs, int64_t count, int64_t start, int width, double *outputs)
{
    const int32_t *end = code + 5 * length;
    int more = 0;
    for (const int32_t *at = code; at != end; at += 5 * (1 + more)) {
        more = 0;
        double *result = slots[at[0] == STORE ? 0 : at[1]];
        const double *a = slots[at[2]], *b = slots[at[3]], *c = slots[at[4]];
        switch (at[0]) {
        case LOAD: {
            const double *given = inputs + at[2] * count + start;
            if (width == lanes) BUSY result[i] = given[i];
            else for (int i = 0; i < lanes; i++) result[i] = given[i < width ? i : width - 1];
            break;
        }
        case STORE: {
            double *target = outputs + at[1] * count + start;
            if (width == lanes) BUSY target[i] = a[i];
            else for (int i = 0; i < width; i++) target[i] = a[i];
            break;
        }
        case ADD: BUSY result[i] = a[i] + b[i]; break;
        case SUBTRACT: BUSY result[i] = a[i] - b[i]; break;
        case MULTIPLY:
            more = more_products(at, end, MULTIPLY_ADD, 3);
            switch (more) {
            case 0: BUSY result[i] = PRODUCT(0); break;
            case 1: BUSY result[i] = PRODUCT(1) + PRODUCT(0); break;
            case 2: BUSY result[i] = PRODUCT(2) + (PRODUCT(1) + PRODUCT(0)); break;
            default: BUSY result[i] = PRODUCT(3) + (PRODUCT(2) + (PRODUCT(1) + PRODUCT(0)));
            }
            break;
        case DIVIDE: BUSY result[i] = a[i] / b[i]; break;
        case NEGATE: BUSY result[i] = -a[i]; break;
        case SINE: wave(a, result, 0, lanes); break;
        case COSINE: wave(a, result, 1, lanes); break;
        case ROOT: BUSY result[i] = sqrt(a[i]); break;
        case MAGNITUDE: BUSY result[i] = fabs(a[i]); break;
        case LARGEST: BUSY result[i] = a[i] > b[i] || a[i] != a[i] ? a[i] : b[i]; break;
        case COPYSIGN: BUSY result[i] = copysign(a[i], b[i]); break;
        case ARCTANGENT: BUSY result[i] = atan2(a[i], b[i]); break;
        case ROUND: BUSY result[i] = rint(a[i]); break;
        case MULTIPLY_ADD:
            more = more_products(at, end, MULTIPLY_ADD, 3);
            switch (more) {
            case 0: BUSY result[i] = PRODUCT(0) + c[i]; break;
            case 1: BUSY result[i] = PRODUCT(1) + (PRODUCT(0) + c[i]); break;
            case 2: BUSY result[i] = PRODUCT(2) + (PRODUCT(1) + (PRODUCT(0) + c[i])); break;
            default:
                BUSY result[i] = PRODUCT(3) + (PRODUCT(2) + (PRODUCT(1) + (PRODUCT(0) + c[i])));
            }
            break;
        case MULTIPLY_SUBTRACT: BUSY result[i] = a[i] * b[i] - c[i]; break;
        case SUBTRACT_PRODUCT:
            more = more_products(at, end, SUBTRACT_PRODUCT, 3);
            switch (more) {
            case 0: BUSY result[i] = c[i] - PRODUCT(0); break;
            case 1: BUSY result[i] = c[i] - PRODUCT(0) - PRODUCT(1); break;
            case 2: BUSY result[i] = c[i] - PRODUCT(0) - PRODUCT(1) - PRODUCT(2); break;
            default: BUSY result[i] = c[i] - PRODUCT(0) - PRODUCT(1) - PRODUCT(2) - PRODUCT(3);
            }
            break;
        default: BUSY result[i] = NAN;
        }
    }
}

/* For inputs from `start` on, `width` of them; in few lanes where that is all. */
FOR_EACH_PROCESSOR
static void run(
    const int32_t *code, int64_t length, double (*slots)[LANES], const double *inputs,
    int64_t count, int64_t start, int width, double *outputs)
{
    if (4 * width <= LANES)
        run_lanes(LANES / 4, code, length, slots, inputs, count, start, width, outputs);
    else if (2 * width <= LANES)
        run_lanes(LANES / 2, code, length, slots, inputs, count, start, width, outputs);
    else
        run_lanes(LANES, code, length, slots, inputs, count, start, width, outputs);
}

/* Returns 0, or 1 where there is no memory for the slots. */
int pmjac_run_tape(
    const int32_t *code, int64_t length, const double *constants, int64_t known, int64_t many,
    const double *inputs, int64_t count, double *outputs)
{
    void *memory = malloc((size_t)(many + 1) * sizeof(double[LANES]) + 64);
    if (!memory) return 1;
    double (*slots)[LANES] = (double (*)[LANES])(((uintptr_t)memory + 63) / 64 * 64);
    for (int64_t slot = 0; slot < known; slot++)
        EACH slots[slot][i] = constants[slot];
    for (int64_t start = 0; start < count; start += LANES) {
        int width = count - start < LANES ? (int)(count - start) : LANES;
        run(code, length, slots, inputs, count, start, width, outputs);
    }
    free(memory);
    return 0;
}
