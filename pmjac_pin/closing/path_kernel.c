/* One pose at a time: runs a tape, and walks one path of the motors. Plain C99.
 *
 * `closing/closure.py` says how a path is walked, `closing/recorded_step.py` when a step is
 * covered, `model/joint_kind.py` how joints move. A path is walked here for as long as all of it
 * is certain: K* regular at both ends of each step, and the step covered by norms. What is not,
 * others decide.
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

/* How a joint turns: by angles, by a cosine and sine, or by a quaternion x, y, z, w. */
enum { STILL, ANGLE, CIRCLE, QUATERNION };
typedef struct {
    int32_t entry, column, slides, turn, turned; /* turned: what it slides along turns with it */
} Joint;

typedef struct {
    int64_t nq, nv, motors, joints;
    const Joint *joint;
    const int32_t *motor_entries, *motor_circles; /* a circle has a cosine and sine in q */
    const double *rates_to_lengths;               /* (nv): a rad counts as one length */
    double tolerance, enough, walking, rank_tolerance, least_size;
    double largest_step, smallest_step, largest_correction, slowest_contraction, no_inverse, margin;
    int64_t most_corrections;
} Machine;

/* A path at q, where the point's program knows (gap, inverse, size, Newton's step, velocity). */
typedef struct {
    const Machine *machine;
    Program point, step;
    double *q, *known, *tangent, *displacement, *target, *spare;
    double share, next;
    int64_t iterations, tries;
} Path;

static void cross(const double *u, const double *v, double *w)
{
    w[0] = u[1] * v[2] - u[2] * v[1];
    w[1] = u[2] * v[0] - u[0] * v[2];
    w[2] = u[0] * v[1] - u[1] * v[0];
}

/* v + 2 w (a x v) + 2 a x (a x v), for the quaternion (a, w), or with -a for its inverse. */
static void rotate(const double *quaternion, double way, const double *v, double *rotated)
{
    double once[3], twice[3];
    cross(quaternion, v, once);
    cross(quaternion, once, twice);
    for (int k = 0; k < 3; k++)
        rotated[k] = v[k] + 2.0 * (way * quaternion[3] * once[k] + twice[k]);
}

static void multiply(const double *p, double way, const double *q, double *product)
{
    double crossed[3];
    cross(p, q, crossed);
    for (int k = 0; k < 3; k++)
        product[k] = p[3] * q[k] + way * (q[3] * p[k] + crossed[k]);
    product[3] = p[3] * q[3] - way * (p[0] * q[0] + p[1] * q[1] + p[2] * q[2]);
}

static void exponential(const double *vector, double *quaternion)
{
    double angle = sqrt(vector[0] * vector[0] + vector[1] * vector[1] + vector[2] * vector[2]);
    double factor = angle < 1e-3 ? 0.5 - angle * angle / 48.0 : sin(0.5 * angle) / angle;
    for (int k = 0; k < 3; k++) quaternion[k] = factor * vector[k];
    quaternion[3] = cos(0.5 * angle);
}

static void logarithm(const double *quaternion, double *vector)
{
    const double *a = quaternion;
    double sine = sqrt(a[0] * a[0] + a[1] * a[1] + a[2] * a[2]);
    double angle = 2.0 * atan2(sine, fabs(a[3])), factor = copysign(1.0, a[3]);
    factor *= sine < 1e-3 ? 2.0 + sine * sine / 3.0 : angle / sine;
    for (int k = 0; k < 3; k++) vector[k] = factor * a[k];
}

/* Slides in the moved axes as slides in those before; with way -1 the other way round. */
static void turn_slides(
    const Joint *joint, const double *turn, double way, const double *v, double *turned)
{
    if (!joint->turned)
        for (int k = 0; k < joint->slides; k++) turned[k] = v[k];
    else if (joint->turn == QUATERNION)
        rotate(turn, way, v, turned);
    else {
        turned[0] = turn[0] * v[0] - way * turn[1] * v[1];
        turned[1] = way * turn[1] * v[0] + turn[0] * v[1];
    }
}

static void move(const Machine *machine, const double *q, const double *v, double *moved)
{
    for (const Joint *joint = machine->joint; joint != machine->joint + machine->joints; joint++) {
        const double *from = q + joint->entry, *rate = v + joint->column;
        const double *turn = from + joint->slides;
        double *to = moved + joint->entry, slid[3], half[4], whole[4];
        turn_slides(joint, turn, 1.0, rate, slid);
        rate += joint->slides;
        if (joint->turn == ANGLE)
            to[joint->slides] = turn[0] + rate[0];
        else if (joint->turn == CIRCLE) {
            double angle = atan2(turn[1], turn[0]) + rate[0];
            to[joint->slides] = cos(angle), to[joint->slides + 1] = sin(angle);
        } else if (joint->turn == QUATERNION) {
            exponential(rate, half);
            multiply(turn, 1.0, half, whole);
            double size = sqrt(whole[0] * whole[0] + whole[1] * whole[1] + whole[2] * whole[2]
                + whole[3] * whole[3]);
            for (int k = 0; k < 4; k++) to[joint->slides + k] = whole[k] / size;
        }
        for (int k = 0; k < joint->slides; k++) to[k] = from[k] + slid[k];
    }
}

/* The motion from q to other, and what v at its end makes of it: its rates there. */
static void between(
    const Machine *machine, const double *q, const double *other, const double *v, double *way,
    double *arriving)
{
    for (const Joint *joint = machine->joint; joint != machine->joint + machine->joints; joint++) {
        const double *from = q + joint->entry, *to = other + joint->entry;
        const double *rate = v + joint->column;
        double *along = way + joint->column, *rates = arriving + joint->column, slid[3];
        const int s = joint->slides;
        const double *turn = from + s, *end = to + s;
        for (int k = 0; k < s; k++) slid[k] = to[k] - from[k];
        turn_slides(joint, turn, -1.0, slid, along);
        if (joint->turn == ANGLE)
            along[s] = end[0] - turn[0];
        else if (joint->turn == CIRCLE)
            along[s] = atan2(
                turn[0] * end[1] - turn[1] * end[0], turn[0] * end[0] + turn[1] * end[1]);
        double turned[4] = {0};
        if (joint->turn == QUATERNION) {
            double back[4] = {-turn[0], -turn[1], -turn[2], turn[3]}, once[3], twice[3];
            multiply(back, 1.0, end, turned);
            logarithm(turned, along + s);
            const double *x = along + s, *omega = rate + s;
            double square = x[0] * x[0] + x[1] * x[1] + x[2] * x[2], angle = sqrt(square);
            double factor = angle < 1e-3
                ? 1.0 / 12.0 + square / 720.0
                : 1.0 / square - (1.0 + cos(angle)) / (2.0 * angle * sin(angle));
            cross(x, omega, once);
            cross(x, once, twice);
            for (int k = 0; k < 3; k++)
                rates[s + k] = omega[k] + 0.5 * once[k] + factor * twice[k];
        } else if (joint->turn != STILL) {
            if (joint->turned) turned[0] = cos(along[s]), turned[1] = sin(along[s]);
            rates[s] = rate[s];
        }
        turn_slides(joint, turned, 1.0, rate, rates);
    }
}

static double size_of(const Machine *machine, const double *v)
{
    double total = 0.0;
    for (int64_t k = 0; k < machine->nv; k++) {
        double length = v[k] * machine->rates_to_lengths[k];
        total += length * length;
    }
    return sqrt(total);
}

static int regular(const Machine *machine, const double *known)
{
    double size = known[2] > machine->least_size ? known[2] : machine->least_size;
    return known[1] * machine->rank_tolerance * size < 1.0;
}

/* Newton's method from the q that the point's inputs hold; 1 where it closes the loops at once. */
static int correct(Path *path, int last)
{
    const Machine *machine = path->machine;
    const double *known = path->point.outputs;
    double enough = last ? machine->enough : machine->walking, before = HUGE_VAL;
    double allowed = machine->largest_correction * size_of(machine, path->tangent);
    for (int64_t k = 1; k < machine->most_corrections; k++) {
        pmjac_run_once(&path->point);
        double gap = known[0], size = size_of(machine, known + 3);
        int closed = gap <= machine->tolerance;
        if (gap <= enough || (closed && (gap > 0.5 * before || !isfinite(size)))) {
            path->iterations += k;
            return 1;
        }
        if (!(closed || size <= allowed)) return 0;
        allowed = machine->slowest_contraction * size, before = gap;
        move(machine, path->point.inputs, known + 3, path->spare);
        memcpy(path->point.inputs, path->spare, sizeof(double) * (size_t)machine->nq);
    }
    return 0;
}

/* Whether the step from q to the point's inputs is covered: the program's inputs are both ends, the
 * middle of the curve between them, the rates at both, and the way. */
static int covered(Path *path, double stride)
{
    const Machine *machine = path->machine;
    const size_t nq = (size_t)machine->nq, nv = (size_t)machine->nv;
    double *first = path->step.inputs, *leaving = first + 3 * nq, *arriving = leaving + nv;
    double *way = arriving + nv, *velocity = path->spare;
    memcpy(first, path->q, sizeof(double) * nq);
    memcpy(first + nq, path->point.inputs, sizeof(double) * nq);
    memcpy(leaving, path->tangent, sizeof(double) * nv);
    for (size_t k = 0; k < nv; k++) velocity[k] = path->point.outputs[3 + nv + k] * stride;
    between(machine, first, first + nq, velocity, way, arriving);
    for (size_t k = 0; k < nv; k++)
        velocity[k] = 0.5 * way[k] + 0.125 * (leaving[k] - arriving[k]);
    move(machine, first, velocity, first + 2 * nq);
    pmjac_run_once(&path->step);
    const double *known = path->step.outputs;
    double change = known[0], rho = known[1], tau = known[2], within = known[3];
    return machine->margin * (change + known[4] * within) < 1.0 && change < 1.0
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

static void arrive(Path *path)
{
    const size_t nq = (size_t)path->machine->nq, nv = (size_t)path->machine->nv;
    memcpy(path->q, path->point.inputs, sizeof(double) * nq);
    memcpy(path->known, path->point.outputs, sizeof(double) * (3 + 2 * nv));
}

/* Take up: what is known at q, with nothing walked yet. */
void pmjac_begin(Path *path)
{
    const size_t nq = (size_t)path->machine->nq;
    memcpy(path->point.inputs, path->q, sizeof(double) * nq);
    for (int64_t k = 0; k < path->machine->motors; k++)
        path->point.inputs[nq + (size_t)k] = path->displacement[k];
    pmjac_run_once(&path->point);
    arrive(path);
    path->share = 0.0, path->next = 1.0, path->iterations = 0, path->tries = 0;
}

/* Walks on, up to so many tries; 1 where more of them may lead further. */
int pmjac_walk(Path *path, int64_t tries)
{
    const Machine *machine = path->machine;
    const double *velocity = path->known + 3 + machine->nv;
    if (!regular(machine, path->known)) return 0;
    for (; tries; tries--) {
        double pace = size_of(machine, velocity), left = 1.0 - path->share, stride = path->next;
        if (stride * pace > machine->largest_step) stride = machine->largest_step / pace;
        int last = stride >= left;
        if (last) stride = left;
        if (!(last || stride * pace >= machine->smallest_step)) return 0;
        for (int64_t k = 0; k < machine->nv; k++) path->tangent[k] = velocity[k] * stride;
        move(machine, path->q, path->tangent, path->point.inputs);
        if (last) set_motors(machine, path->target, path->point.inputs);
        path->next = 0.5 * stride, path->tries++;
        int64_t spent = path->iterations;
        const double *found = path->point.outputs;
        if (!(correct(path, last) && found[1] * found[2] * machine->no_inverse < 1.0
              && regular(machine, found) && covered(path, stride))) {
            path->iterations = spent;
            continue;
        }
        arrive(path);
        path->share = last ? 1.0 : path->share + stride, path->next = 2.0 * stride;
        if (last) return 0;
    }
    return 1;
}
