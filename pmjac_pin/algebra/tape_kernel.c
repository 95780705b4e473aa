/* Runs a tape over many sets of inputs, LANES of them at a time, and finds the singular values of
 * many matrices: plain C99, which compilers turn into vector instructions. `algebra/tape.py` says
 * what instructions are; INSTRUCTIONS there has their names in the order of this enum.
 */
#include <math.h>
#include <stdint.h>
#include <stdlib.h>

enum {
    LOAD, STORE, ADD, SUBTRACT, MULTIPLY, DIVIDE, NEGATE, SINE, COSINE, ROOT, MAGNITUDE, LARGEST,
    COPYSIGN, ARCTANGENT, ROUND, MULTIPLY_ADD, MULTIPLY_SUBTRACT, SUBTRACT_PRODUCT
};

#ifndef LANES
#define LANES 64
#endif
/* A target is one of the operands or apart from them: no lane depends on another. */
#if defined(__GNUC__) && !defined(__clang__)
#define EACH _Pragma("GCC ivdep") for (int i = 0; i < LANES; i++)
#else
#define EACH for (int i = 0; i < LANES; i++)
#endif

/* One version for each kind of processor in one file, where the compiler can. */
#if defined(FOR_EACH_PROCESSOR)
#elif defined(__GNUC__) && !defined(__clang__) && defined(__x86_64__) && defined(__linux__)
#define FOR_EACH_PROCESSOR __attribute__((target_clones("arch=x86-64-v4", "arch=x86-64-v3", "default")))
#else
#define FOR_EACH_PROCESSOR
#endif

/* Quarters of a turn are taken off in three parts of pi/2 (fdlibm's), exactly for |x| < LARGE. */
#define LARGE 1e5
static inline __attribute__((always_inline)) void wave(
    const double *x, double *wave_of, int quarter)
{
    int large = 0;
    EACH large |= !(fabs(x[i]) < LARGE);
    if (large) {
        EACH wave_of[i] = quarter ? cos(x[i]) : sin(x[i]);
        return;
    }
    EACH {
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
}

FOR_EACH_PROCESSOR
static void run(
    const int32_t *code, int64_t length, double (*slots)[LANES], const double *inputs,
    int64_t count, int64_t start, int width, double *outputs)
{
    for (const int32_t *at = code; at != code + 5 * length; at += 5) {
        double *result = slots[at[0] == STORE ? 0 : at[1]];
        const double *a = slots[at[2]], *b = slots[at[3]], *c = slots[at[4]];
        switch (at[0]) {
        case LOAD:
            for (int i = 0; i < LANES; i++)
                result[i] = inputs[at[2] * count + start + (i < width ? i : width - 1)];
            break;
        case STORE:
            for (int i = 0; i < width; i++) outputs[at[1] * count + start + i] = a[i];
            break;
        case ADD: EACH result[i] = a[i] + b[i]; break;
        case SUBTRACT: EACH result[i] = a[i] - b[i]; break;
        case MULTIPLY: EACH result[i] = a[i] * b[i]; break;
        case DIVIDE: EACH result[i] = a[i] / b[i]; break;
        case NEGATE: EACH result[i] = -a[i]; break;
        case SINE: wave(a, result, 0); break;
        case COSINE: wave(a, result, 1); break;
        case ROOT: EACH result[i] = sqrt(a[i]); break;
        case MAGNITUDE: EACH result[i] = fabs(a[i]); break;
        case LARGEST: EACH result[i] = a[i] > b[i] || a[i] != a[i] ? a[i] : b[i]; break;
        case COPYSIGN: EACH result[i] = copysign(a[i], b[i]); break;
        case ARCTANGENT: EACH result[i] = atan2(a[i], b[i]); break;
        case ROUND: EACH result[i] = rint(a[i]); break;
        case MULTIPLY_ADD: EACH result[i] = a[i] * b[i] + c[i]; break;
        case MULTIPLY_SUBTRACT: EACH result[i] = a[i] * b[i] - c[i]; break;
        case SUBTRACT_PRODUCT: EACH result[i] = c[i] - a[i] * b[i]; break;
        default: EACH result[i] = NAN;
        }
    }
}

/* Which source this was built from. */
#ifndef SOURCE
#define SOURCE ""
#endif
const char *pmjac_tape_source(void) { return SOURCE; }

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

#define FEW 16
#if defined(__GNUC__) && !defined(__clang__)
#define EACH_OF_FEW _Pragma("GCC ivdep") for (int i = 0; i < FEW; i++)
#else
#define EACH_OF_FEW for (int i = 0; i < FEW; i++)
#endif
#define MOST_SWEEPS 40
#define ORTHOGONAL 4e-15 /* cosine of an angle that is a right one */

/* x . y, four entries at a time: what is summed up goes through memory less often. */
static inline __attribute__((always_inline)) void product(
    double (*x)[FEW], double (*y)[FEW], int64_t length, double *sum)
{
    int64_t k = 0;
    EACH_OF_FEW sum[i] = 0.0;
    for (; k + 4 <= length; k += 4)
        EACH_OF_FEW sum[i] += (x[k][i] * y[k][i] + x[k + 1][i] * y[k + 1][i])
            + (x[k + 2][i] * y[k + 2][i] + x[k + 3][i] * y[k + 3][i]);
    for (; k < length; k++)
        EACH_OF_FEW sum[i] += x[k][i] * y[k][i];
}

/* Turns two vectors, whose squares are known, in their plane until they are orthogonal; tells
 * whether they were. */
static inline __attribute__((always_inline)) int turn(
    double (*x)[FEW], double (*y)[FEW], int64_t length, double *xx, double *yy)
{
    double xy[FEW], cosine[FEW], sine[FEW];
    int apart = 0;
    product(x, y, length, xy);
    EACH_OF_FEW apart |= xy[i] * xy[i] > ORTHOGONAL * ORTHOGONAL * (xx[i] * yy[i]);
    if (!apart) return 1;
    EACH_OF_FEW {
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
        EACH_OF_FEW {
            double a = x[k][i], b = y[k][i];
            x[k][i] = cosine[i] * a - sine[i] * b;
            y[k][i] = sine[i] * a + cosine[i] * b;
        }
    return 0;
}

/* One-sided Jacobi, several matrices at a time: their vectors are turned in pairs until all are
 * orthogonal; their norms are the singular values, which are put in order. */
FOR_EACH_PROCESSOR
static void orthogonalise(double (*x)[FEW], int64_t vectors, int64_t length, double (*values)[FEW])
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
        EACH_OF_FEW values[p][i] = sqrt(values[p][i]);
    }
    for (int64_t p = 0; p < vectors; p++)
        for (int64_t q = p + 1; q < vectors; q++)
            EACH_OF_FEW {
                double a = values[p][i], b = values[q][i];
                values[p][i] = a > b ? a : b;
                values[q][i] = a > b ? b : a;
            }
}

/* Singular values, (vectors, count), of matrices (vectors, length, count): no more vectors than
 * their length. Returns 0, or 1 where there is no memory. */
int pmjac_singular_values(
    const double *matrices, int64_t vectors, int64_t length, int64_t count, double *values)
{
    int64_t entries = vectors * length;
    void *memory = malloc((size_t)(entries + vectors + 1) * sizeof(double[FEW]) + 64);
    if (!memory) return 1;
    double (*x)[FEW] = (double (*)[FEW])(((uintptr_t)memory + 63) / 64 * 64);
    for (int64_t start = 0; start < count; start += FEW) {
        int width = count - start < FEW ? (int)(count - start) : FEW;
        for (int64_t k = 0; k < entries; k++)
            for (int i = 0; i < FEW; i++)
                x[k][i] = matrices[k * count + start + (i < width ? i : width - 1)];
        orthogonalise(x, vectors, length, x + entries);
        for (int64_t k = 0; k < vectors; k++)
            for (int i = 0; i < width; i++)
                values[k * count + start + i] = x[entries + k][i];
    }
    free(memory);
    return 0;
}
