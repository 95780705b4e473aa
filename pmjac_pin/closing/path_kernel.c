/* Runs tapes, and walks paths of the motors, LANES of them at a time: one here, many in
 * `many_paths.c`. Plain C99.
 *
 * `closing/straight_path.py` says how a path is walked, `closing/recorded_step.py` when a step is
 * covered. A path is walked here for as long as all of it is certain: K* regular at both ends of
 * each step, and the step covered by norms. What is not, others decide. All that is known of the
 * mechanism is in programs. `Walker` runs the same ones without this kernel.
 *
 * Each lane has a path. All lanes take a step at a time; a lane whose path has ended takes up the
 * next one.
 */
#ifndef LANES
#define LANES 1
#define FOR_EACH_PROCESSOR
#endif
#include "starts.h"

int pmjac_lanes(void) { return LANES; }

static void finish(Walk *walk, int at, int64_t end)
{
    const Machine *machine = walk->machine;
    Lane *lane = walk->lanes + at;
    for (int64_t k = 0; k < machine->nq; k++)
        walk->q[lane->path * machine->nq + k] = walk->point[k][at];
    walk->gap[lane->path] = known(machine, walk->point)[GAP][at];
    walk->share[lane->path] = lane->share;
    walk->iterations[lane->path] = lane->iterations;
    walk->end[lane->path] = end, walk->arrived += end == ARRIVED;
    lane->state = IDLE, lane->stride = 0.0;
}

/* Set out on a step, or say how the path ends. */
static int64_t set_out(Walk *walk, int at, int64_t most_tries)
{
    const Machine *machine = walk->machine;
    const Row *of = known(machine, walk->point);
    Lane *lane = walk->lanes + at;
    if (lane->share >= 1.0) return ARRIVED;
    if (!regular(machine, of, at, machine->rank_tolerance)) return DOUBTFUL;
    if (lane->tries >= most_tries) return SPENT;
    double pace = of[PACE][at], left = 1.0 - lane->share, stride = lane->next;
    if (stride * pace > machine->largest_step) stride = machine->largest_step / pace;
    lane->last = stride >= left;
    if (lane->last) stride = left;
    if (!(lane->last || stride * pace >= machine->smallest_step)) return STUCK;
    lane->stride = stride, lane->next = 0.5 * stride, lane->tries++;
    lane->allowed = machine->largest_correction * stride * pace, lane->before = HUGE_VAL;
    lane->corrections = 0, lane->state = CORRECTS, lane->size = 0.0, lane->left = HUGE_VAL;
    return GOES_ON;
}

/* A lane without a path takes up the next one. */
static void take_up(Walk *walk, int at)
{
    while (walk->lanes[at].state == IDLE && walk->taken < walk->count) {
        if (!have_common_start(walk)) {
            put(walk, at, walk->taken++);
            return;
        }
        put_at_common(walk, at, walk->taken++);
        int64_t end = set_out(walk, at, walk->most_tries);
        if (end != GOES_ON) finish(walk, at, end);
    }
}

/* Take up the first paths. Lanes behind the last one that has a path are left alone. */
static void begin(Walk *walk)
{
    if (have_common_start(walk)) learn_common(walk);
    walk->taken = walk->busy = walk->arrived = 0;
    for (int lane = 0; lane < LANES; lane++) {
        walk->lanes[lane].state = IDLE;
        take_up(walk, lane);
        if (walk->lanes[lane].state != IDLE) walk->busy = lane + 1;
    }
}

/* Set out with all that goes on, and say up to which lane that is. */
static void set_all_out(Walk *walk)
{
    int living = 0;
    int64_t busy = 0;
    for (int at = 0; at < LANES; at++) living += walk->lanes[at].state != IDLE;
    int few = walk->taken == walk->count && living <= walk->few;
    int64_t most = few && walk->patience < walk->most_tries ? walk->patience : walk->most_tries;
    for (int at = 0; at < LANES; at++) {
        if (walk->lanes[at].state != IDLE) {
            int64_t end = set_out(walk, at, most);
            if (end != GOES_ON) finish(walk, at, end);
        }
        take_up(walk, at);
        if (walk->lanes[at].state != IDLE) busy = at + 1;
    }
    walk->busy = busy;
}

static void set_motors(const Machine *machine, const double *target, Row *q, int lane)
{
    for (int64_t k = 0; k < machine->motors; k++) {
        Row *entry = q + machine->motor_entries[k];
        if (machine->motor_circles[k])
            entry[0][lane] = cos(target[k]), entry[1][lane] = sin(target[k]);
        else
            entry[0][lane] = target[k];
    }
}

/* Where paths step to, before that is corrected, as the arrival's q. */
INLINE void predict(Walk *walk)
{
    const Machine *machine = walk->machine;
    const Row *rates = velocity(machine, walk->point);
    Row *leaving = walk->leg.inputs + 2 * machine->nq, *ahead = walk->arrival.inputs, stride;
    int64_t steps[LANES];
    int any = 0;
    copy(ahead, walk->point, machine->nq);
    for (int at = 0; at < LANES; at++) {
        stride[at] = walk->lanes[at].stride;
        steps[at] = walk->lanes[at].state == CORRECTS, any |= steps[at] != 0;
    }
    if (!any) return;
    for (int64_t k = 0; k < machine->nv; k++)
        EACH leaving[k][i] = rates[k][i] * stride[i];
    copy(walk->leg.inputs, walk->point, machine->nq);
    set_inverse(walk, leaving + 2 * machine->nv);
    copy(walk->move.inputs, walk->point, machine->nq);
    copy(walk->move.inputs + machine->nq, leaving, machine->nv);
    if (have_common_start(walk)) bend(walk, walk->move.inputs + machine->nq);
    run_stage(&walk->move, 0, walk->busy);
    copy_where(steps, ahead, walk->move.outputs, machine->nq);
    for (int at = 0; at < LANES; at++) {
        const Lane *lane = walk->lanes + at;
        if (lane->state == CORRECTS && lane->last)
            set_motors(machine, walk->target + lane->path * machine->motors, ahead, at);
    }
}

/* Whether a lane, whose q has just been looked at, is to be corrected once more. */
INLINE int corrects(const Machine *machine, Lane *lane, double gap, double size)
{
    if (lane->state != CORRECTS) return 0;
    int closed = gap <= machine->tolerance;
    double enough = lane->last ? machine->enough : machine->walking;
    lane->corrections++;
    int resolved = lane->left <= enough || gap > 0.5 * lane->before || !isfinite(size);
    if (gap <= enough || (closed && resolved))
        lane->state = CLOSED;
    else if (!(closed || size <= lane->allowed)
             || lane->corrections + 1 >= machine->most_corrections)
        lane->state = REFUSED;
    lane->allowed = machine->slowest_contraction * size, lane->before = gap;
    lane->left = size * (size / lane->size) * (size / lane->size); /* they square */
    lane->size = size;
    return lane->state == CORRECTS;
}

/* Newton's method from the arrival's q, until none is corrected any more. Lanes that are done are
 * looked at again where they are, and so stay. */
INLINE void correct(Walk *walk)
{
    const Machine *machine = walk->machine;
    Row *q = walk->arrival.inputs, *motion = q + machine->nq, *found = walk->arrival.outputs;
    const Row *of = known(machine, found);
    for (int64_t k = 0; k < machine->nv; k++)
        EACH motion[k][i] = 0.0;
    for (;;) {
        int64_t on[LANES];
        int any = 0;
        run_stage(&walk->arrival, 0, walk->busy);
        for (int at = 0; at < LANES; at++) {
            on[at] = corrects(machine, walk->lanes + at, of[GAP][at], of[CORRECTION][at]);
            any |= on[at] != 0;
        }
        if (!any) return;
        copy_where(on, q, found, machine->nq);
        copy_where(on, motion, newton(machine, found), machine->nv);
    }
}

/* Whether K* has an inverse where a step has led to. */
INLINE int invertible(const Machine *machine, const Row *of, int lane)
{
    return of[INVERSE][lane] * of[SIZE][lane] * machine->no_inverse < 1.0
        && regular(machine, of, lane, machine->arrival_tolerance);
}

INLINE int covered(const Machine *machine, const Row *bound, int lane)
{
    double change = bound[0][lane], rho = bound[1][lane];
    double beyond = bound[2][lane], contraction = bound[3][lane];
    return machine->margin * contraction < 1.0 && change < 1.0 && beyond <= rho;
}

/* Refuse what is not invertible, and steps that are not covered by any bound; the leg has their q,
 * v and inverse at the start. */
INLINE void judge(Walk *walk)
{
    const Machine *machine = walk->machine;
    Row *found = walk->arrival.outputs, *other = walk->leg.inputs + machine->nq;
    Row *arriving = other + machine->nq + machine->nv, *onward = velocity(machine, found), stride;
    int left = 0;
    for (int at = 0; at < LANES; at++) {
        Lane *lane = walk->lanes + at;
        if (lane->state == CLOSED && !invertible(machine, known(machine, found), at))
            lane->state = REFUSED;
        stride[at] = lane->stride, left += lane->state == CLOSED;
    }
    copy(other, found, machine->nq);
    copy(arriving + machine->nv + 1, known(machine, found) + INVERSE, 1);
    for (int64_t k = 0; k < machine->nv; k++)
        EACH arriving[k][i] = onward[k][i] * stride[i];
    for (int part = 0; part < BOUNDS && left; part++) {
        run_stage(&walk->leg, part, walk->busy);
        for (int at = 0; at < LANES; at++) {
            Lane *lane = walk->lanes + at;
            if (lane->state == CLOSED
                && covered(machine, walk->leg.outputs + 4 * part, at))
                lane->state = COVERED, left--;
        }
    }
    for (int at = 0; at < LANES; at++)
        if (walk->lanes[at].state == CLOSED) walk->lanes[at].state = REFUSED;
}

/* Arrive where steps are covered, and where paths begin. */
INLINE void take(Walk *walk)
{
    const Machine *machine = walk->machine;
    int64_t here[LANES];
    for (int at = 0; at < LANES; at++) {
        Lane *lane = walk->lanes + at;
        here[at] = lane->state == COVERED || lane->state == BEGINS;
        if (lane->state != COVERED) continue;
        lane->share = lane->last ? 1.0 : lane->share + lane->stride;
        lane->next = 2.0 * lane->stride, lane->iterations += lane->corrections;
    }
    copy_where(here, walk->point, walk->arrival.outputs, numbers(machine));
}

/* One step of each lane, tried. */
FOR_EACH_PROCESSOR
static void step(Walk *walk)
{
    predict(walk);
    correct(walk);
    judge(walk);
    take(walk);
}

/* Walks on, up to so many steps of each lane; 1 where more of them lead further. */
int pmjac_walk(Walk *walk, int64_t steps)
{
    for (; walk->busy && steps; steps--) {
        step(walk);
        set_all_out(walk);
    }
    if (walk->follow && walk->arrived == walk->count)
        walk->follow(walk->given, walk->q, walk->count);
    return walk->busy > 0;
}

/* Whether a target is no number that all motors can reach. */
static int some_are_beyond(const Walk *walk)
{
    const double lowest = walk->machine->lowest, highest = walk->machine->highest;
    int beyond = 0;
    for (int64_t k = 0; k < walk->count * walk->machine->motors; k++)
        beyond |= !(walk->target[k] >= lowest) | !(walk->target[k] <= highest);
    return beyond;
}

/* The same from where paths start; less than 0 where nothing is done. */
int pmjac_set_out(Walk *walk, int64_t steps)
{
    if (walk->only_inside && some_are_beyond(walk)) return -1;
    if (walk->ways) set_ways(walk);
    begin(walk);
    return pmjac_walk(walk, steps);
}
