/* Damped least squares of many starts, LANES of them at a time, as `levenberg_marquardt.py` does it
 * without this kernel and says there. Plain C99.
 *
 * Each lane has a start. All lanes try a step at a time; one that has ended takes up the next start.
 * What is known of the mechanism is in two programs (`recorded_descent.py`): of a pose, and of a
 * step from there.
 */
#ifndef LANES
#define LANES 32
#endif
#include "../../algebra/lane_programs.h"

typedef struct {
    double gap, damping;
    int64_t start, tries, creeping, least, iterations, fresh;
} Lane;

/* The pose's outputs are its gap and what a step takes of it. A step's inputs are q, what it takes
 * of the pose, sizes and damping; its outputs are where it leads, where the next pose's inputs are,
 * sizes, and how long it is. */
typedef struct {
    Program pose, step;
    Lane *lanes;
    const double *starts;
    double *q, *gap;
    int64_t *iterations, *end;
    int64_t nq, known, unknowns, count, taken;
    int64_t busy; /* the first lanes, so many, have a start */
    int64_t steps, creeping_steps;
    double enough, tolerance, damping, least, most, shrinks, grows, grows_within, falling, creeping;
    double fading; /* the damping is multiplied by so much of the gap */
} Descent;

enum { GIVEN_UP, CLOSED, SPENT, GOES_ON };

int pmjac_lanes(void) { return LANES; }

static void take_up(Descent *all, int64_t at)
{
    const double *q = all->starts + all->nq * all->taken;
    for (int64_t k = 0; k < all->nq; k++) all->pose.inputs[k][at] = q[k];
    for (int64_t k = 0; k < all->unknowns; k++)
        all->step.inputs[all->nq + all->known + k][at] = 0.0;
    all->lanes[at] = (Lane){.start = all->taken++, .fresh = 1};
}

static void finish(Descent *all, int64_t at, int64_t end)
{
    const Lane *lane = all->lanes + at;
    double *q = all->q + all->nq * lane->start;
    for (int64_t k = 0; k < all->nq; k++) q[k] = all->step.inputs[k][at];
    all->gap[lane->start] = lane->gap;
    all->iterations[lane->start] = lane->iterations;
    all->end[lane->start] = end;
}

/* What a lane knows of where it is, in place of what another one knew. */
static void move_lane(Descent *all, int64_t to, int64_t from)
{
    int64_t inputs = all->nq + all->known + all->unknowns;
    for (int64_t k = 0; k < inputs; k++) all->step.inputs[k][to] = all->step.inputs[k][from];
    all->lanes[to] = all->lanes[from];
}

/* Look at where a lane's last step has led; tell whether it goes on from there. */
static int better(Descent *all, int64_t at)
{
    Lane *lane = all->lanes + at;
    double reached = all->pose.outputs[0][at], length = all->step.outputs[all->nq + all->unknowns][at];
    if (lane->fresh) {
        lane->fresh = 0, lane->gap = reached, lane->damping = all->damping;
        return 1;
    }
    int nearer = reached < lane->gap, within = lane->gap <= all->tolerance;
    int falls = within || reached < (1.0 - all->creeping) * lane->gap;
    lane->tries++;
    lane->least = within && nearer && reached >= (1.0 - all->falling) * lane->gap;
    lane->creeping = falls ? 0 : lane->creeping + nearer;
    if (nearer) {
        double eased = lane->damping / all->shrinks;
        lane->damping = eased > all->least ? eased : all->least;
        lane->gap = reached, lane->iterations = lane->tries;
    } else { /* where nothing moves, damping changes nothing */
        double grows = within ? all->grows_within : all->grows;
        lane->damping = length > 0.0 ? lane->damping * grows : INFINITY;
    }
    return nearer;
}

static int64_t ended(const Descent *all, const Lane *lane)
{
    if (lane->tries == all->steps) return SPENT;
    if (lane->gap <= all->enough || lane->least) return CLOSED;
    int hopeless = lane->damping >= all->most || lane->creeping >= all->creeping_steps;
    return hopeless ? GIVEN_UP : GOES_ON;
}

/* Look at where all lanes are, take what is nearer, and let go of what has ended. */
FOR_EACH_PROCESSOR
static void judge(Descent *all)
{
    int64_t nearer[LANES];
    Row *known = all->step.inputs + all->nq;
    for (int64_t at = 0; at < all->busy; at++) nearer[at] = better(all, at);
    for (int64_t at = all->busy; at < LANES; at++) nearer[at] = 0;
    for (int64_t k = 0; k < all->nq; k++)
        EACH all->step.inputs[k][i] = nearer[i] ? all->pose.inputs[k][i] : all->step.inputs[k][i];
    for (int64_t k = 0; k < all->known; k++)
        EACH known[k][i] = nearer[i] ? all->pose.outputs[k + 1][i] : known[k][i];
    for (int64_t at = all->busy - 1; at >= 0; at--) {
        int64_t end = ended(all, all->lanes + at);
        if (end == GOES_ON) continue;
        finish(all, at, end);
        move_lane(all, at, --all->busy);
    }
}

/* Try a step in all lanes. */
static void try_steps(Descent *all)
{
    Row *sizes = all->step.inputs + all->nq + all->known, *damping = sizes + all->unknowns;
    for (int64_t at = 0; at < all->busy; at++)
        damping[0][at] = all->lanes[at].damping * (all->fading * all->lanes[at].gap);
    run_stage(&all->step, 0, (int)all->busy);
    for (int64_t k = 0; k < all->unknowns; k++)
        EACH sizes[k][i] = all->step.outputs[all->nq + k][i];
}

/* Goes on, up to so many steps of each lane; 1 where more are to be tried. */
int pmjac_descend(Descent *all, int64_t steps)
{
    for (; steps; steps--) {
        while (all->busy < LANES && all->taken < all->count) take_up(all, all->busy++);
        if (!all->busy) return 0;
        run_stage(&all->pose, 0, (int)all->busy);
        judge(all);
        if (all->busy) try_steps(all);
    }
    return all->busy > 0 || all->taken < all->count;
}
