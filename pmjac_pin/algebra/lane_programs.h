/* A program that can be run in lanes: its instructions, or what they were compiled to, and where
 * its numbers are. */
#include "tape_kernel.c"

typedef double Row[LANES]; /* a number of each lane */

#define MOST_STAGES 3

/* The slots hold the constants from the beginning, and nothing is written over them. Stages end
 * after so many instructions. Where a program is compiled, the slots are what it keeps. */
typedef struct {
    const int32_t *code;
    int64_t length, stages[MOST_STAGES];
    Row *slots, *inputs, *outputs;
    void (*compiled)(
        int64_t stage, int64_t apart, int64_t lanes, const double *inputs, double *outputs,
        double *kept);
} Program;

/* In the first lanes, so many. */
static void run_stage(const Program *program, int stage, int lanes)
{
    const double *inputs = (const double *)program->inputs;
    double *outputs = (double *)program->outputs;
    if (program->compiled) {
        program->compiled(stage, LANES, lanes, inputs, outputs, (double *)program->slots);
        return;
    }
    int64_t from = stage ? program->stages[stage - 1] : 0, length = program->stages[stage] - from;
    run(program->code + 5 * from, length, program->slots, inputs, LANES, 0, lanes, outputs);
}
