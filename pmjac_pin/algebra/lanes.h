/* What the kernels share: plain C99, which compilers turn into vector instructions. */
#include <math.h>
#include <stdint.h>
#include <stdlib.h>

/* For every lane. A target is one of the operands or apart from them: no lane depends on another. */
#if defined(__GNUC__) && !defined(__clang__)
#define EACH_OF(lanes) _Pragma("GCC ivdep") for (int i = 0; i < lanes; i++)
#else
#define EACH_OF(lanes) for (int i = 0; i < lanes; i++)
#endif
#define EACH EACH_OF(LANES)

/* One version for each kind of processor in one file, where the compiler can. */
#if defined(FOR_EACH_PROCESSOR)
#elif defined(__GNUC__) && !defined(__clang__) && defined(__x86_64__) && defined(__linux__)
#define FOR_EACH_PROCESSOR __attribute__((target_clones("arch=x86-64-v4", "arch=x86-64-v3", "default")))
#else
#define FOR_EACH_PROCESSOR
#endif

#define INLINE static inline __attribute__((always_inline))

/* Which sources this was built from. */
#ifndef SOURCE
#define SOURCE ""
#endif
const char *pmjac_source(void) { return SOURCE; }
