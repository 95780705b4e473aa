/* Where paths start: each at a pose of its own, or all at one, of which more is known. */
#include "walk.h"

#define LITTLE 4e-3 /* of the largest step: far enough that what Newton's method corrects is no rounding */

/* A program of one stage. */
void pmjac_run_once(const Program *program) { run_stage(program, 0, LANES); }

INLINE int have_common_start(const Walk *walk)
{
    return LANES > 1 && !walk->apart && walk->machine->motors <= LANES;
}

/* Whether a lane is where all paths start. */
INLINE int is_at_common(const Walk *walk, int lane)
{
    return have_common_start(walk) && !(walk->lanes[lane].share > 0.0);
}

/* How far motors go whose values are entries of q. */
static void set_ways(const Walk *walk)
{
    const Machine *machine = walk->machine;
    for (int64_t path = 0; path < walk->count; path++) {
        const double *start = walk->start + path * walk->apart;
        int64_t first = path * machine->motors;
        for (int64_t k = 0; k < machine->motors; k++)
            walk->ways[first + k] = walk->target[first + k] - start[machine->motor_entries[k]];
    }
}

/* A lane is at the start of a path, with nothing known there yet. */
static void put(Walk *walk, int lane, int64_t path)
{
    const Machine *machine = walk->machine;
    int64_t nq = machine->nq, nv = machine->nv;
    Row *motors = walk->arrival.inputs + nq + nv;
    for (int64_t k = 0; k < nq; k++)
        walk->point[k][lane] = walk->start[path * walk->apart + k];
    for (int64_t k = nq; k < numbers(machine); k++)
        walk->point[k][lane] = 0.0;
    for (int64_t k = 0; k < machine->motors; k++)
        motors[k][lane] = walk->displacement[path * machine->motors + k];
    Row *of_leg = walk->leg.inputs + 2 * nq + 2 * nv + 2;
    for (int64_t k = 0; k < walk->designed; k++)
        motors[machine->motors + k][lane] = of_leg[k][lane] = walk->design[path * walk->designed + k];
    walk->lanes[lane] = (Lane){.state = BEGINS, .path = path, .next = 1.0};
}

/* The size of a motion, a rad counted as one length. */
static double size_of(const Machine *machine, const double *motion)
{
    double square = 0.0;
    for (int64_t k = 0; k < machine->nv; k++)
        square += motion[k] / machine->scale[k] * (motion[k] / machine->scale[k]);
    return sqrt(square);
}

/* The same at the start of all paths, where rates are sums of those with each motor. */
static void put_at_common(Walk *walk, int lane, int64_t path)
{
    const Machine *machine = walk->machine;
    int64_t nv = machine->nv, first = numbers(machine) - nv;
    const double *displacement = walk->displacement + path * machine->motors;
    double *rates = walk->common + first, *of_motor = rates + nv;
    put(walk, lane, path);
    for (int64_t k = 0; k < nv; k++) rates[k] = 0.0;
    for (int64_t motor = 0; motor < machine->motors; motor++, of_motor += nv)
        for (int64_t k = 0; k < nv; k++) rates[k] += of_motor[k] * displacement[motor];
    for (int64_t k = 0; k < numbers(machine); k++) walk->point[k][lane] = walk->common[k];
    known(machine, walk->point)[PACE][lane] = size_of(machine, rates);
}

/* The pair of motors in a place, the same one twice among them: (0, 0), (1, 0), (1, 1), (2, 0), ... */
INLINE void pair_in(int64_t place, int64_t *one, int64_t *other)
{
    for (*one = 0; place > *one; ++*one) place -= *one + 1;
    *other = place;
}

INLINE int64_t twice(int64_t motor) { return motor * (motor + 3) / 2; } /* its place with itself */

/* Lanes go along the rates with a pair of motors, each by the same length, there and back: so much
 * as Newton's method corrects there, paths bend. */
static void ask_bends(Walk *walk, const double *pace, int64_t first, int64_t count, double *bend)
{
    const Machine *machine = walk->machine;
    int64_t nv = machine->nv;
    const double *of_motor = walk->common + numbers(machine);
    const Row *found = newton(machine, walk->arrival.outputs);
    double size = LITTLE * machine->largest_step;
    for (int lane = 0; lane < LANES; lane++) {
        int64_t one, other, at = lane / 2 < count ? lane / 2 : 0;
        pair_in(first + at, &one, &other);
        for (int64_t k = 0; k < nv; k++) {
            double way = of_motor[one * nv + k] / pace[one];
            if (other != one) way += of_motor[other * nv + k] / pace[other];
            walk->arrival.inputs[machine->nq + k][lane] = lane % 2 ? -size * way : size * way;
        }
    }
    run_stage(&walk->arrival, 0, (int)(2 * count));
    for (int64_t at = 0; at < count; at++, bend += nv)
        for (int64_t k = 0; k < nv; k++)
            bend[k] = (found[k][2 * at] + found[k][2 * at + 1]) / (2.0 * size * size);
}

/* How paths bend at the common start, by pairs of motors: with motors' ways x_i, as long as all
 * joints go with them, sum of x_i x_j b_ij beyond their rates, to third order. */
static void learn_bends(Walk *walk)
{
    const Machine *machine = walk->machine;
    int64_t nv = machine->nv, pairs = machine->motors * (machine->motors + 1) / 2;
    double *bends = walk->common + numbers(machine) + machine->motors * nv;
    double *pace = bends + pairs * nv;
    for (int64_t motor = 0; motor < machine->motors; motor++)
        pace[motor] = size_of(machine, walk->common + numbers(machine) + motor * nv);
    for (int64_t first = 0; first < pairs; first += LANES / 2) {
        int64_t count = pairs - first < LANES / 2 ? pairs - first : LANES / 2;
        ask_bends(walk, pace, first, count, bends + first * nv);
    }
    for (int64_t place = 0; place < pairs; place++) {
        int64_t one, other;
        pair_in(place, &one, &other);
        const double *of_one = bends + twice(one) * nv, *of_other = bends + twice(other) * nv;
        for (int64_t k = 0; k < nv; k++) {
            double bend = bends[place * nv + k];
            if (other != one) bend -= of_one[k] + of_other[k];
            bends[place * nv + k] = isfinite(bend) ? bend : 0.0;
        }
    }
}

/* Bend the first steps of paths from the common start. */
INLINE void bend(Walk *walk, Row *motion)
{
    const Machine *machine = walk->machine;
    int64_t nv = machine->nv, motors = machine->motors;
    const double *bends = walk->common + numbers(machine) + motors * nv;
    const double *pace = bends + motors * (motors + 1) / 2 * nv;
    const Row *moves = walk->arrival.inputs + machine->nq + nv;
    Row stride;
    for (int at = 0; at < LANES; at++)
        stride[at] = is_at_common(walk, at) ? walk->lanes[at].stride : 0.0;
    for (int64_t one = 0; one < motors; one++)
        for (int64_t other = 0; other <= one; other++, bends += nv) {
            double size = pace[one] * pace[other];
            Row both;
            EACH both[i] = size * (moves[one][i] * stride[i]) * (moves[other][i] * stride[i]);
            for (int64_t k = 0; k < nv; k++)
                if (bends[k] != 0.0) EACH motion[k][i] += both[i] * bends[k];
        }
}

/* What is known where all paths start, unless that is where those of the call before did: lanes are
 * asked for the rates with a motor each. */
static void learn_common(Walk *walk)
{
    const Machine *machine = walk->machine;
    int64_t nq = machine->nq, nv = machine->nv, motors = machine->motors;
    if (!memcmp(walk->learnt, walk->start, (size_t)nq * sizeof(double))) return;
    Row *inputs = walk->arrival.inputs, *found = walk->arrival.outputs;
    double *of_motor = walk->common + numbers(machine);
    for (int64_t k = 0; k < nq + nv + motors; k++)
        for (int lane = 0; lane < LANES; lane++)
            inputs[k][lane] = k < nq ? walk->start[k] : k == nq + nv + lane;
    run_stage(&walk->arrival, 0, (int)motors);
    for (int64_t k = 0; k < numbers(machine); k++) walk->common[k] = found[k][0];
    for (int64_t motor = 0; motor < motors; motor++)
        for (int64_t k = 0; k < nv; k++)
            of_motor[motor * nv + k] = velocity(machine, found)[k][motor];
    learn_bends(walk);
    memcpy(walk->learnt, walk->start, (size_t)nq * sizeof(double));
}

/* How large the inverse of K* is, as it is known best. */
INLINE void set_inverse(const Walk *walk, Row *inverse)
{
    copy(inverse, known(walk->machine, walk->point) + INVERSE, 1);
    if (!(walk->inverse > 0.0)) return;
    for (int at = 0; at < LANES; at++)
        if (is_at_common(walk, at)) inverse[0][at] = walk->inverse;
}
