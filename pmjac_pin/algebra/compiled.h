/* What the text of a compiled program begins with: as many doubles at a time as the processor has
 * room for, and the instructions of a tape that are no operators, to the same last bit.
 */
#include <math.h>
#include <stdint.h>

#if defined(__AVX512F__)
#define WIDTH 8
#elif defined(__AVX__)
#define WIDTH 4
#else
#define WIDTH 2
#endif

typedef double Many __attribute__((vector_size(8 * WIDTH)));
typedef int64_t Bits __attribute__((vector_size(8 * WIDTH)));
typedef double Stored __attribute__((vector_size(8 * WIDTH), aligned(8)));

#define INLINE static inline __attribute__((always_inline))
#define APART static __attribute__((noinline)) void /* functions of some thousand lines compile slowly */
#define EACH for (int i = 0; i < WIDTH; i++)
#define SIGN ((Bits){} + INT64_MIN)
#define LARGE 1e5

INLINE Many all(double number) { return (Many){} + number; }

INLINE Many load(const double *from) { return *(const Stored *)from; }

INLINE void store(double *to, Many x) { *(Stored *)to = x; }

INLINE Many either(Bits which, Many x, Many y)
{
    return (Many)((which & (Bits)x) | (~which & (Bits)y));
}

INLINE Many magnitude(Many x) { return (Many)((Bits)x & ~SIGN); }

INLINE Many with_sign(Many x, Many of) { return (Many)(((Bits)x & ~SIGN) | ((Bits)of & SIGN)); }

INLINE Many largest(Many x, Many y) { return either((Bits)(x > y) | (Bits)(x != x), x, y); }

INLINE Many root(Many x)
{
    Many found;
    EACH found[i] = sqrt(x[i]);
    return found;
}

INLINE Many whole(Many x)
{
    Many found;
    EACH found[i] = rint(x[i]);
    return found;
}

INLINE Many arctangent(Many y, Many x)
{
    Many found;
    EACH found[i] = atan2(y[i], x[i]);
    return found;
}

/* As in tape_kernel.c. */
INLINE Many wave(Many x, int quarter)
{
    const double magic = 6755399441055744.0;
    Many turns = x * 0.63661977236758134308 + magic, count = turns - magic;
    Many y = x - count * 1.57079632673412561417e+00;
    y -= count * 6.07710050630396597660e-11;
    y -= count * 2.02226624879595063154e-21;
    Many z = y * y;
    Many sine = y + y * z * (-1.66666666666666324348e-01 + z * (8.33333333332248946124e-03
        + z * (-1.98412698298579493134e-04 + z * (2.75573137070700676789e-06
        + z * (-2.50507602534068634195e-08 + z * 1.58969099521155010221e-10)))));
    Many cosine = 1.0 - 0.5 * z + z * z * (4.16666666666666019037e-02
        + z * (-1.38888888888741095749e-03 + z * (2.48015872894767294178e-05
        + z * (-2.75573143513906633035e-07 + z * (2.08757232129817482790e-09
        + z * -1.13596475577881948265e-11)))));
    Bits which = (Bits)turns + quarter;
    Many value = either(-(which & 1), cosine, sine);
    value = (Many)((Bits)value ^ ((which & 2) << 62));
    EACH if (!(fabs(x[i]) < LARGE)) value[i] = quarter ? cos(x[i]) : sin(x[i]);
    return value;
}

/* Entries of a row lie beside each other, rows of inputs and of outputs this far apart. */
typedef struct {
    const double *inputs;
    double *outputs;
    int64_t from, to;
} Rows;

static void run_stage(int64_t stage, Rows rows, Many *kept);

int64_t pmjac_kept(void);

/* One stage, for so many sets of inputs, up to a multiple of WIDTH, rows of which are so far apart;
 * `kept` is what stages after it need, on addresses that vectors are loaded from. */
void pmjac_run_stage(
    int64_t stage, int64_t apart, int64_t lanes, const double *inputs, double *outputs,
    double *kept)
{
    for (int64_t lane = 0; lane < lanes; lane += WIDTH) {
        Rows rows = {inputs + lane, outputs + lane, apart, apart};
        run_stage(stage, rows, (Many *)kept + lane / WIDTH * pmjac_kept());
    }
}

#define LANES 64

int64_t pmjac_lanes(void) { return LANES; }

INLINE void copy(const double *from, int64_t apart, double *to, int64_t beside, int64_t rows)
{
    for (int64_t row = 0; row < rows; row++)
        for (int lane = 0; lane < LANES; lane++)
            to[row * beside + lane] = from[row * apart + lane];
}

/* All stages, for so many sets of inputs, LANES of them at a time; what is left over is not. Rows
 * of many sets are pages apart, so they are copied to and from rows of LANES. */
void pmjac_run_rows(
    int64_t stages, int64_t count, const double *inputs, int64_t given, double *outputs,
    int64_t told, double *kept)
{
    double *tile = kept + LANES * pmjac_kept(), *found = tile + LANES * given;
    for (int64_t at = 0; at + LANES <= count; at += LANES) {
        copy(inputs + at, count, tile, LANES, given);
        for (int64_t stage = 0; stage < stages; stage++)
            pmjac_run_stage(stage, LANES, LANES, tile, found, kept);
        copy(found, LANES, outputs + at, count, told);
    }
}
