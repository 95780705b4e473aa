/* Runs a tape over intervals, LANES boxes at a time: every result holds what it stands for.
 *
 * +, - and * round to the nearest double, so that a result z is off by at most u|z|, u = 2^-53, or
 * by less than 1e-300 where it underflows. An end is moved outwards by 3u|z| + 1e-290, which also
 * covers the rounding of that move; where two results lead to it, by 3u of both their sizes. What
 * overflows is not a number: in a box where anything did, no end is one. `algebra/intervals.py`
 * does the same with NumPy. Plain C99; nothing here may be compiled with -ffast-math.
 */
#ifndef LANES
#define LANES 32
#endif
/* A third of a count of quarters below 2^20 (636620 in LARGE) and 33 bits of pi/2 is exact. */
#define LARGE 1e6
#include "tape_kernel.c"

typedef double Row[LANES];
typedef Row Ends[2]; /* lower and upper ends, one of each lane */

#define UNIT 1.1102230246251565e-16
#define TINY 1e-290

INLINE double least(double x, double y) { return x < y ? x : y; }
INLINE double most(double x, double y) { return x > y ? x : y; }
INLINE double moved_by(double size) { return size * (3.0 * UNIT) + TINY; }
INLINE double down(double x) { return x - moved_by(fabs(x)); }
INLINE double up(double x) { return x + moved_by(fabs(x)); }

/* Not a number from where a box has ends that are none, or that are not finite. */
#define LOSE(ends) lost[i] += ((ends)[0][i] - (ends)[1][i]) * 0.0

/* The least and the largest of what rounds to the products of two intervals' ends; of an interval
 * with itself, of the squares. */
INLINE void multiply(Ends product, const Row *a, const Row *b)
{
    if (a == b) {
        EACH {
            double one = a[0][i] * a[0][i], other = a[1][i] * a[1][i];
            double low = least(one, other);
            product[0][i] = a[0][i] < 0.0 && a[1][i] > 0.0 ? 0.0 : low;
            product[1][i] = most(one, other);
        }
        return;
    }
    EACH {
        double one = a[0][i] * b[0][i], two = a[0][i] * b[1][i];
        double three = a[1][i] * b[0][i], four = a[1][i] * b[1][i];
        product[0][i] = least(least(one, two), least(three, four));
        product[1][i] = most(most(one, two), most(three, four));
    }
}

/* Sine, or cosine a quarter further. `wave` is off by less than 3u for |x| < LARGE: y, what is left
 * of x, by less than u; the polynomial, by its terms, by 2^-57; and each of these and their sums is
 * rounded to u of numbers below 1, most of them far below. */
#define WAVE_ERROR (8.0 * UNIT)
#define TURN_SLACK 1e-9 /* turns: more than x / 2 pi is off by up to LARGE */
INLINE void wave_between(const Row *angle, Row *result, int quarter)
{
    double top = quarter ? 0.0 : 0.25;
    Ends at;
    wave(angle[0], at[0], quarter, LANES);
    wave(angle[1], at[1], quarter, LANES);
    EACH {
        double from = angle[0][i] * 0.15915494309189535 - top - TURN_SLACK;
        double to = angle[1][i] * 0.15915494309189535 - top + TURN_SLACK;
        int far = !(fabs(angle[0][i]) < LARGE) | !(fabs(angle[1][i]) < LARGE);
        int highest = far | (ceil(from) <= floor(to));
        int lowest = far | (ceil(from - 0.5) <= floor(to - 0.5));
        double low = most(least(at[0][i], at[1][i]) - WAVE_ERROR, -1.0);
        double high = least(most(at[0][i], at[1][i]) + WAVE_ERROR, 1.0);
        result[0][i] = lowest ? -1.0 : low;
        result[1][i] = highest ? 1.0 : high;
    }
}

/* An instruction that it does not know bounds nothing. */
INLINE void run_intervals(
    const int32_t *code, int64_t length, Ends *slots, Ends *inputs, Ends *outputs, double *lost)
{
    const int32_t *end = code + 5 * length;
    for (const int32_t *at = code; at != end; at += 5) {
        Row *result = slots[at[0] == STORE ? 0 : at[1]], product[2];
        const Row *a = slots[at[2]], *b = slots[at[3]], *c = slots[at[4]];
        switch (at[0]) {
        case LOAD: {
            const Row *given = inputs[at[2]];
            EACH { result[0][i] = given[0][i], result[1][i] = given[1][i]; LOSE(result); }
            break;
        }
        case STORE: {
            Row *target = outputs[at[1]];
            EACH target[0][i] = a[0][i], target[1][i] = a[1][i];
            break;
        }
        case ADD:
            EACH {
                double low = a[0][i] + b[0][i], high = a[1][i] + b[1][i];
                result[0][i] = down(low), result[1][i] = up(high); LOSE(result);
            }
            break;
        case SUBTRACT:
            EACH {
                double low = a[0][i] - b[1][i], high = a[1][i] - b[0][i];
                result[0][i] = down(low), result[1][i] = up(high); LOSE(result);
            }
            break;
        case NEGATE:
            EACH {
                double low = -a[1][i], high = -a[0][i];
                result[0][i] = low, result[1][i] = high;
            }
            break;
        case SINE: wave_between(a, result, 0); break;
        case COSINE: wave_between(a, result, 1); break;
        case MULTIPLY:
            multiply(product, a, b);
            EACH {
                result[0][i] = down(product[0][i]), result[1][i] = up(product[1][i]);
                LOSE(result);
            }
            break;
        case MULTIPLY_ADD:
            multiply(product, a, b);
            EACH {
                double low = product[0][i] + c[0][i], high = product[1][i] + c[1][i];
                result[0][i] = low - moved_by(fabs(product[0][i]) + fabs(low));
                result[1][i] = high + moved_by(fabs(product[1][i]) + fabs(high)); LOSE(result);
            }
            break;
        case MULTIPLY_SUBTRACT:
            multiply(product, a, b);
            EACH {
                double low = product[0][i] - c[1][i], high = product[1][i] - c[0][i];
                result[0][i] = low - moved_by(fabs(product[0][i]) + fabs(low));
                result[1][i] = high + moved_by(fabs(product[1][i]) + fabs(high)); LOSE(result);
            }
            break;
        case SUBTRACT_PRODUCT:
            multiply(product, a, b);
            EACH {
                double low = c[0][i] - product[1][i], high = c[1][i] - product[0][i];
                result[0][i] = low - moved_by(fabs(product[1][i]) + fabs(low));
                result[1][i] = high + moved_by(fabs(product[0][i]) + fabs(high)); LOSE(result);
            }
            break;
        default: EACH { result[0][i] = -INFINITY, result[1][i] = INFINITY; LOSE(result); }
        }
    }
}
