/* Walks many paths at a time: as many as vector instructions are busy with. */
#define LANES 96
#include "path_kernel.c"
