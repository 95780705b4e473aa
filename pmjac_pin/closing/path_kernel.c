/* One pose at a time: runs a tape, and walks one path of the motors. Plain C99.
 *
 * `closing/closure.py` says how a path is walked, `closing/recorded_step.py` when a step is
 * covered. A path is walked here for as long as all of it is certain: K* regular at both ends of
 * each step, and the step covered by norms. What is not, others decide. All that is known of the
 * mechanism is in programs: `Walker` runs the same ones for many paths at once.
 */
#define LANES 1
#define FOR_EACH_PROCESSOR
#include "../algebra/tape_kernel.c"

#include <string.h>

/* The slots hold the constants from the beginning, and nothing is written over them. */
typedef struct {
    const int32_t *code;
    int64_t length;
    double *slots, *inputs, *outputs;
} Program;

void pmjac_run_once(const Program *program)
{
    run(program->code, program->length, (double (*)[LANES])program->slots, program->inputs,
        1, 0, 1, program->outputs);
}

typedef struct {
    int64_t nq, nv, motors;
    const int32_t *motor_entries, *motor_circles; /* a circle has a cosine and sine in q */
    double tolerance, enough, walking, rank_tolerance, least_size;
    double largest_step, smallest_step, largest_correction, slowest_contraction, no_inverse, margin;
    int64_t most_corrections;
} Machine;

/* A path that has come to a point; all of a point is what the arrival's program gives:
 * (q, gap, inverse, size, size of Newton's step, pace, Newton's step, velocity). */
typedef struct {
    const Machine *machine;
    Program move, arrival, leg;
    double *point, *displacement, *target;
    double share, next;
    int64_t iterations, tries;
} Path;

enum { GAP, INVERSE, SIZE, CORRECTION, PACE, MOTIONS };

static const double *known(const Machine *machine, const double *point)
{
    return point + machine->nq;
}

static const double *newton(const Machine *machine, const double *point)
{
    return known(machine, point) + MOTIONS;
}

static const double *velocity(const Machine *machine, const double *point)
{
    return newton(machine, point) + machine->nv;
}

static int regular(const Machine *machine, const double *point)
{
    const double *of = known(machine, point);
    double size = of[SIZE] > machine->least_size ? of[SIZE] : machine->least_size;
    return of[INVERSE] * machine->rank_tolerance * size < 1.0;
}

static void copy(double *to, const double *from, int64_t count)
{
    memcpy(to, from, sizeof(double) * (size_t)count);
}

/* What is known where the program's q is moved by v, or not moved. */
static void arrive_at(Path *path, const double *v)
{
    const Machine *machine = path->machine;
    double *motion = path->arrival.inputs + machine->nq;
    if (v) copy(motion, v, machine->nv);
    else memset(motion, 0, sizeof(double) * (size_t)machine->nv);
    pmjac_run_once(&path->arrival);
}

/* Newton's method from the arrival's q; 1 where it closes the loops at once. */
static int correct(Path *path, double allowed, int last)
{
    const Machine *machine = path->machine;
    const double *found = path->arrival.outputs, *of = known(machine, found);
    double enough = last ? machine->enough : machine->walking, before = HUGE_VAL;
    arrive_at(path, NULL);
    for (int64_t k = 1; k < machine->most_corrections; k++) {
        double gap = of[GAP], size = of[CORRECTION];
        int closed = gap <= machine->tolerance;
        if (gap <= enough || (closed && (gap > 0.5 * before || !isfinite(size)))) {
            path->iterations += k;
            return 1;
        }
        if (!(closed || size <= allowed)) return 0;
        allowed = machine->slowest_contraction * size, before = gap;
        copy(path->arrival.inputs, found, machine->nq);
        arrive_at(path, newton(machine, found));
    }
    return 0;
}

/* Whether the step to where the arrival is now is covered; the leg has its q and v at the start. */
static int covered(Path *path, double stride)
{
    const Machine *machine = path->machine;
    const double *found = path->arrival.outputs, *onward = velocity(machine, found);
    double *other = path->leg.inputs + machine->nq;
    double *arriving = other + machine->nq + machine->nv;
    copy(other, found, machine->nq);
    for (int64_t k = 0; k < machine->nv; k++) arriving[k] = onward[k] * stride;
    pmjac_run_once(&path->leg);
    const double *of = path->leg.outputs;
    double change = of[0], rho = of[1], tau = of[2], within = of[3], inverse = of[4];
    return machine->margin * (change + inverse * within) < 1.0 && change < 1.0
        && within * tau <= rho;
}

static void set_motors(const Machine *machine, const double *target, double *q)
{
    for (int64_t k = 0; k < machine->motors; k++) {
        double *entry = q + machine->motor_entries[k];
        if (machine->motor_circles[k])
            entry[0] = cos(target[k]), entry[1] = sin(target[k]);
        else
            entry[0] = target[k];
    }
}

/* Where the path steps to, before it is corrected, as the arrival's q. */
static void predict(Path *path, double stride, int last)
{
    const Machine *machine = path->machine;
    const double *rates = velocity(machine, path->point);
    double *leaving = path->leg.inputs + 2 * machine->nq;
    copy(path->leg.inputs, path->point, machine->nq);
    for (int64_t k = 0; k < machine->nv; k++) leaving[k] = rates[k] * stride;
    copy(path->move.inputs, path->point, machine->nq);
    copy(path->move.inputs + machine->nq, leaving, machine->nv);
    pmjac_run_once(&path->move);
    copy(path->arrival.inputs, path->move.outputs, machine->nq);
    if (last) set_motors(machine, path->target, path->arrival.inputs);
}

static void take(Path *path)
{
    const Machine *machine = path->machine;
    copy(path->point, path->arrival.outputs, machine->nq + MOTIONS + 2 * machine->nv);
}

/* Take up: what is known at the q that the point has, with nothing walked yet. */
void pmjac_begin(Path *path)
{
    const Machine *machine = path->machine;
    copy(path->arrival.inputs, path->point, machine->nq);
    copy(path->arrival.inputs + machine->nq + machine->nv, path->displacement, machine->motors);
    arrive_at(path, NULL);
    take(path);
    path->share = 0.0, path->next = 1.0, path->iterations = 0, path->tries = 0;
}

/* Walks on, up to so many tries; 1 where more of them may lead further. */
int pmjac_walk(Path *path, int64_t tries)
{
    const Machine *machine = path->machine;
    const double *found = path->arrival.outputs, *of = known(machine, found);
    if (!regular(machine, path->point)) return 0;
    for (; tries; tries--) {
        double pace = known(machine, path->point)[PACE];
        double left = 1.0 - path->share, stride = path->next;
        if (stride * pace > machine->largest_step) stride = machine->largest_step / pace;
        int last = stride >= left;
        if (last) stride = left;
        if (!(last || stride * pace >= machine->smallest_step)) return 0;
        predict(path, stride, last);
        path->next = 0.5 * stride, path->tries++;
        int64_t spent = path->iterations;
        if (!(correct(path, machine->largest_correction * stride * pace, last)
              && of[INVERSE] * of[SIZE] * machine->no_inverse < 1.0
              && regular(machine, found) && covered(path, stride))) {
            path->iterations = spent;
            continue;
        }
        take(path);
        path->share = last ? 1.0 : path->share + stride, path->next = 2.0 * stride;
        if (last) return 0;
    }
    return 1;
}
