/* Walks many paths at a time: as many as vector instructions are busy with. */
#define LANES 64
#include "path_kernel.c"
