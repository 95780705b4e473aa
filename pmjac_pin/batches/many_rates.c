/* J_eq at many poses, LANES of them at a time, and where it is certain. Plain C99.
 *
 * Poses and what is found of them are rows, so that nothing is turned over and copied between a
 * caller's arrays and a program's lanes. `Certainty` says what is asked of a program's numbers.
 */
#define LANES 64
#include "../algebra/lane_programs.h"
#include <float.h>

/* What is asked of the numbers of a program: `certain_jacobians` of `batches/judge.py`. */
typedef struct {
    double tolerance, weakest, rank_tolerance, least_size, felt, spread;
} Certainty;

enum { OPEN_BY, INVERSE_OF, SIZE_OF, FORBIDDEN, FELT, TOOL, SPREAD, DOUBTS };

INLINE int is_certain(const Certainty *asked, const Row *told, int at)
{
    double inverse = told[INVERSE_OF][at], size = told[SIZE_OF][at];
    double forbidden = told[FORBIDDEN][at], zero = asked->rank_tolerance;
    int regular = (asked->weakest * size + DBL_MIN) * inverse < 1.0
        && zero * asked->least_size * inverse < 1.0;
    int follows = forbidden <= zero * size || forbidden <= zero * asked->least_size;
    return regular && follows && told[OPEN_BY][at] <= asked->tolerance
        && told[FELT][at] <= asked->felt * told[TOOL][at] && told[SPREAD][at] > asked->spread;
}

/* What finds the radii of J_eq beside sizes: `pmjac_radii` of `rates/many_radii.c`. */
typedef int (*Radii)(
    const double *J_eq, int64_t motors, int64_t count, const double *sizes, const void *nothing,
    double *linear, double *angular);

/* From rows (count, nq) to rows (count, entries), to numbers (more, count) that follow these in the
 * program, and to whether each is certain; and how many are not. Where radii are asked for, these
 * numbers are sizes. */
typedef struct {
    Program program;
    Certainty asked;
    Radii radii;
    const void *nothing;
    int64_t nq, entries, more, count;
    const double *q;
    double *J_eq, *others;
    uint8_t *certain;
    double *linear, *angular; /* NULL: no radii */
    int64_t uncertain; /* -1 before all is done */
} Rates;

/* Returns what `radii` does, else 0. What walks paths may ask for it where they end. */
int pmjac_rates(void *of)
{
    Rates *rates = of;
    const Program *program = &rates->program;
    const Row *told = program->outputs;
    int64_t count = rates->count, nq = rates->nq, entries = rates->entries, certain = 0;
    for (int64_t start = 0; start < count; start += LANES) {
        int width = count - start < LANES ? (int)(count - start) : LANES;
        for (int64_t k = 0; k < nq; k++)
            for (int at = 0; at < LANES; at++)
                program->inputs[k][at] = rates->q[(start + (at < width ? at : width - 1)) * nq + k];
        run_stage(program, 0, width);
        for (int at = 0; at < width; at++) {
            int it_is = is_certain(&rates->asked, told, at);
            rates->certain[start + at] = (uint8_t)it_is, certain += it_is;
            for (int64_t k = 0; k < entries; k++)
                rates->J_eq[(start + at) * entries + k] = told[DOUBTS + k][at];
        }
        for (int64_t k = 0; k < rates->more; k++)
            for (int at = 0; at < width; at++)
                rates->others[k * count + start + at] = told[DOUBTS + entries + k][at];
    }
    int failed = !rates->linear ? 0
        : rates->radii(rates->J_eq, entries / 6, count, rates->others, rates->nothing,
                       rates->linear, rates->angular);
    if (!failed) rates->uncertain = count - certain;
    return failed;
}

int pmjac_lanes(void) { return LANES; }
