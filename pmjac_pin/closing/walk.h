/* What a walk of LANES paths works on, and where all of that is. */
#include "../algebra/lane_programs.h"
#include <string.h>

#define BOUNDS 3 /* that the leg tells of a step, a stage each */
typedef char bounds_are_stages[BOUNDS <= MOST_STAGES ? 1 : -1];

typedef struct {
    int64_t nq, nv, motors;
    const int32_t *motor_entries, *motor_circles; /* a circle has a cosine and sine in q */
    const double *scale; /* of the rates of joints: what a pace counts as one length */
    double tolerance, enough, walking, rank_tolerance, least_size;
    double largest_step, smallest_step, largest_correction, slowest_contraction, no_inverse, margin;
    double arrival_tolerance; /* of the rank of K* where a step may end; 0: elsewhere paths do */
    double lowest, highest; /* what all motors can reach */
    int64_t most_corrections;
} Machine;

/* A path that a lane walks; `next` is how far the next step is to go, of the whole way. */
typedef struct {
    int64_t state, path, tries, iterations, corrections, last;
    double share, next, stride, allowed, before;
    double size, left; /* of the correction before, and what that left to correct */
} Lane;

enum { IDLE, BEGINS, CORRECTS, CLOSED, COVERED, REFUSED };

/* Where paths end: tries are spent, at the target, where K* may be singular, or where steps
 * become too small to be resolved. */
enum { SPENT, ARRIVED, DOUBTFUL, STUCK, GOES_ON };

/* Paths, one row each, but for one start that is all paths': `apart` is 0 then. All of a point is
 * what the arrival's program gives: (q, gap, inverse, size, size of Newton's step, pace, Newton's
 * step, velocity). */
typedef struct {
    const Machine *machine;
    Program move, arrival, leg;
    Row *point;
    Lane *lanes;
    double *common; /* of one start: all of its point, (motors, nv), the rates with each motor, and how
                     * paths bend there (`learn_bends`) */
    double *learnt; /* its q, no number before it is known */
    double inverse; /* of K* at one start by its smallest singular value, 0 where that is not known */
    const double *start, *displacement, *target;
    double *ways; /* where displacements go that are not given: those of entries of q; else NULL */
    const double *design; /* what programs know of each path's own machine: the last of their inputs */
    int64_t designed, apart, count, taken, most_tries, few, patience;
    int64_t busy; /* lanes up to the last one that has a path */
    int64_t arrived; /* paths at their targets */
    int64_t only_inside; /* whether nothing is done where a target is no number that all motors can reach */
    double *q, *gap, *share;
    int64_t *iterations, *end;
    /* What is done with all q as soon as all have arrived; NULL: nothing. */
    int (*follow)(void *given, const double *q, int64_t count);
    void *given;
} Walk;

enum { GAP, INVERSE, SIZE, CORRECTION, PACE, MOTIONS };

INLINE Row *known(const Machine *machine, Row *point) { return point + machine->nq; }

INLINE Row *newton(const Machine *machine, Row *point) { return known(machine, point) + MOTIONS; }

INLINE Row *velocity(const Machine *machine, Row *point)
{
    return newton(machine, point) + machine->nv;
}

INLINE int regular(const Machine *machine, const Row *of, int lane, double tolerance)
{
    double size = of[SIZE][lane] > machine->least_size ? of[SIZE][lane] : machine->least_size;
    return of[INVERSE][lane] * tolerance * size < 1.0;
}

INLINE void copy(Row *to, const Row *from, int64_t rows)
{
    for (int64_t k = 0; k < rows; k++)
        EACH to[k][i] = from[k][i];
}

INLINE void copy_where(const int64_t *on, Row *to, const Row *from, int64_t rows)
{
    for (int64_t k = 0; k < rows; k++)
        EACH to[k][i] = on[i] ? from[k][i] : to[k][i];
}

INLINE int64_t numbers(const Machine *machine) /* of a point */
{
    return machine->nq + MOTIONS + 2 * machine->nv;
}
