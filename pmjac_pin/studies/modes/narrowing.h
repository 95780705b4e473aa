/* Where in LANES boxes loop equations can hold: interval Newton steps on the rows, and on these
 * combined by an approximate inverse, as `narrowing.py` takes them and says there. */
/* The rows at the middles of the boxes, as far from 0 as they may be. */
INLINE void look_at_middle(const Loops *loops, Work *work)
{
    int64_t k = loops->unknowns, p = loops->rows;
    for (int64_t j = 0; j < k; j++) {
        Row *box = work->inputs[j];
        EACH {
            double middle = box[0][i] + 0.5 * (box[1][i] - box[0][i]);
            work->middle[j][i] = least(most(middle, box[0][i]), box[1][i]);
            work->step[j][0][i] = box[0][i], work->step[j][1][i] = box[1][i];
            box[0][i] = box[1][i] = work->middle[j][i];
        }
    }
    evaluate(&loops->values, work->values_slots, work, work->values, p);
    for (int64_t row = 0; row < p; row++) {
        Row *value = work->values[row];
        double allowed = loops->tolerance[row];
        EACH value[0][i] = down(value[0][i] - allowed), value[1][i] = up(value[1][i] + allowed);
    }
    for (int64_t j = 0; j < k; j++)
        for (int end = 0; end < 2; end++)
            EACH work->inputs[j][end][i] = work->step[j][end][i];
}

/* A matrix of doubles times intervals: sum += factor x, size += what it may be in size. */
INLINE void add_multiple(Row *sum, double *size, const double *factor, const Row *x)
{
    EACH {
        double one = factor[i] * x[0][i], other = factor[i] * x[1][i];
        sum[0][i] += least(one, other), sum[1][i] += most(one, other);
        size[i] += most(fabs(one), fabs(other));
    }
}

/* Move the ends of a sum of so many products outwards; what overflows bounds nothing. */
INLINE void widen(Row *sum, const double *size, int64_t terms)
{
    double share = (double)(terms + 4) * UNIT;
    EACH {
        double by = size[i] * share + TINY + size[i] * 0.0;
        sum[0][i] -= by, sum[1][i] += by;
    }
}

/* Factors L D L^T of a symmetric matrix, in its place. */
INLINE void factorise(Row *square, int64_t k)
{
    for (int64_t j = 0; j < k; j++)
        for (int64_t row = j + 1; row < k; row++) {
            double *factor = square[row * k + j];
            EACH factor[i] = square[j * k + row][i] / square[j * k + j][i];
            for (int64_t n = j + 1; n <= row; n++) {
                double *to = square[n * k + row];
                EACH to[i] -= factor[i] * square[j * k + n][i];
            }
        }
}

INLINE void solve(Row *square, Row *x, int64_t k)
{
    for (int64_t j = 0; j < k; j++)
        for (int64_t row = j + 1; row < k; row++)
            EACH x[row][i] -= square[row * k + j][i] * x[j][i];
    for (int64_t j = 0; j < k; j++)
        EACH x[j][i] /= square[j * k + j][i];
    for (int64_t j = k - 1; j > 0; j--)
        for (int64_t row = 0; row < j; row++)
            EACH x[row][i] -= square[j * k + row][i] * x[j][i];
}

/* About (J^T J)^-1 J^T of rows by their tolerances, a column for each row: `inverse` has them one
 * after the other. Of what is no number, 0: no proof depends on how exact it is. */
INLINE void invert(const Loops *loops, Work *work)
{
    int64_t k = loops->unknowns, p = loops->rows;
    double smallest = INFINITY;
    Row most_square;
    for (int64_t row = 0; row < p; row++) smallest = least(smallest, loops->tolerance[row]);
    for (int64_t n = 0; n < k * k; n++) set_zero(work->square[n]);
    for (int64_t row = 0; row < p; row++) {
        double weight = smallest / loops->tolerance[row];
        Row *x = work->inverse + row * k;
        for (int64_t j = 0; j < k; j++) {
            const Row *own = work->found[p + row * k + j];
            EACH x[j][i] = (own[0][i] + 0.5 * (own[1][i] - own[0][i])) * (weight * weight);
        }
        for (int64_t j = 0; j < k; j++)
            for (int64_t n = 0; n <= j; n++)
                EACH work->square[n * k + j][i] += x[n][i] * x[j][i] / (weight * weight);
    }
    set_zero(most_square);
    for (int64_t j = 0; j < k; j++)
        EACH most_square[i] = most(most_square[i], work->square[j * k + j][i]);
    for (int64_t j = 0; j < k; j++)
        EACH work->square[j * k + j][i] += 1e-13 * most_square[i] + 1e-200;
    factorise(work->square, k);
    for (int64_t row = 0; row < p; row++) {
        Row *x = work->inverse + row * k;
        solve(work->square, x, k);
        for (int64_t j = 0; j < k; j++)
            EACH x[j][i] = fabs(x[j][i]) < 1e100 ? x[j][i] : 0.0;
    }
}

/* The rows combined by the approximate inverse: values, behind those of the rows; derivatives. */
INLINE void combine(const Loops *loops, Work *work)
{
    int64_t k = loops->unknowns, p = loops->rows;
    Row size;
    for (int64_t j = 0; j < k; j++)
        for (int64_t n = 0; n <= k; n++) {
            Row *sum = n < k ? work->combined[j * k + n] : work->values[p + j];
            set_zero(sum[0]), set_zero(sum[1]), set_zero(size);
            for (int64_t row = 0; row < p; row++) {
                const Row *x = n < k ? work->found[p + row * k + n] : work->values[row];
                add_multiple(sum, size, work->inverse[row * k + j], x);
            }
            widen(sum, size, p);
        }
}

/* Narrow the step along one unknown to where 0 is in value + derivatives . step. */
INLINE void solve_for(
    const Row *value, Ends *derivatives, Ends *step, int64_t k, int64_t column, Ends bound)
{
    const Row *own = derivatives[column];
    int possible = 0;
    for (int i = 0; i < LANES; i++) possible |= (own[0][i] > 0.0) | (own[1][i] < 0.0);
    if (!possible) return;
    Ends sum, product;
    Row size;
    EACH {
        sum[0][i] = value[0][i], sum[1][i] = value[1][i];
        size[i] = most(fabs(value[0][i]), fabs(value[1][i]));
    }
    for (int64_t j = 0; j < k; j++) {
        if (j == column) continue;
        multiply(product, derivatives[j], step[j]);
        EACH {
            sum[0][i] += product[0][i], sum[1][i] += product[1][i];
            size[i] += most(fabs(product[0][i]), fabs(product[1][i]));
        }
    }
    widen(sum, size, k);
    EACH {
        int turned = own[1][i] < 0.0;
        double small = turned ? -own[1][i] : own[0][i], large = turned ? -own[0][i] : own[1][i];
        double from = turned ? sum[0][i] : -sum[1][i], to = turned ? sum[1][i] : -sum[0][i];
        double low = down(from / (from >= 0.0 ? large : small));
        double high = up(to / (to >= 0.0 ? small : large));
        bound[0][i] = small > 0.0 && low > bound[0][i] ? low : bound[0][i];
        bound[1][i] = small > 0.0 && high < bound[1][i] ? high : bound[1][i];
    }
}

/* The part of each box where 0 is in all rows, by one unknown after the other. */
INLINE void narrow(const Loops *loops, Work *work)
{
    int64_t k = loops->unknowns, p = loops->rows;
    for (int64_t j = 0; j < k; j++)
        EACH {
            work->step[j][0][i] = down(work->inputs[j][0][i] - work->middle[j][i]);
            work->step[j][1][i] = up(work->inputs[j][1][i] - work->middle[j][i]);
        }
    for (int64_t column = 0; column < k; column++) {
        Ends bound;
        EACH bound[0][i] = work->step[column][0][i], bound[1][i] = work->step[column][1][i];
        for (int64_t row = 0; row < p + k; row++) {
            Ends *own = row < p ? work->found + p + row * k : work->combined + (row - p) * k;
            solve_for(work->values[row], own, work->step, k, column, bound);
        }
        EACH work->step[column][0][i] = bound[0][i], work->step[column][1][i] = bound[1][i];
    }
    for (int64_t j = 0; j < k; j++)
        EACH {
            double low = down(work->middle[j][i] + work->step[j][0][i]);
            double high = up(work->middle[j][i] + work->step[j][1][i]);
            /* The box's own end where the other is no number. */
            work->step[j][0][i] = most(low, work->inputs[j][0][i]);
            work->step[j][1][i] = least(high, work->inputs[j][1][i]);
            work->out[i] |= work->step[j][0][i] > work->step[j][1][i];
        }
}
