/* @title@ @prefix@.h says how it is used.
 *
 * Not to be edited: `squid verify --c` compares it with the certificate. Every loop runs a fixed number of times. The
 * order of the operations is that of the controller's FMU, and so are the results to the last bit, if the compiler
 * keeps to IEEE 754: -ffp-contract=off, and no -ffast-math.
@libm@
 */

#include "@prefix@.h"

#include <float.h>
@include_math@

#if defined(__FAST_MATH__) || (defined(__FINITE_MATH_ONLY__) && __FINITE_MATH_ONLY__)
#error "compile without -ffast-math: numbers that are not finite must be seen"
#endif
#if FLT_EVAL_METHOD != 0
#error "each operation must round to its own type; on a 32-bit x86 compile with -msse2 -mfpmath=sse"
#endif
/* A product and a sum are not to be fused into one rounding. */
#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC optimize("fp-contract=off")
#else
#pragma STDC FP_CONTRACT OFF
#endif

typedef @prefix@_real real;

enum { STATES = @n@, INPUTS = @p@, CHANNELS = @r@, COMMANDS = @m@, SIGNALS = STATES + INPUTS + CHANNELS };
/* Rows of a matrix are summed four at a time. */
enum { HEIGHT = 4, STATE_PANELS = (STATES + 3) / HEIGHT, COMMAND_PANELS = (COMMANDS + 3) / HEIGHT };
@channel_panels@
/* The trim table: its rows, and the greatest power of two in a search for one. */
enum { ROWS = @rows@, FIRST_STRIDE = @stride@ };

@tables@
/* What one tick computes. */
typedef struct {
    real signals[SIGNALS]; /* x, y, w */
    real commands[HEIGHT * COMMAND_PANELS];
    real excess[COMMANDS]; /* what the limits cut off of u */
    real scheduling_parameter;
@trim_members@
@used_members@
    unsigned status;
} tick;

static int is_finite(real v) { return v >= -LARGEST && v <= LARGEST; }

static real clamp(real v, real low, real high) { return v < low ? low : v > high ? high : v; }

static real magnitude(real v) { return v <= 0.0@f@ ? 0.0@f@ - v : v; }

/* out = M x, M as panels of four rows, each column by column. */
static void multiply(const real (*m)[HEIGHT], int panels, int columns, const real *x, real *out)
{
    for (int panel = 0; panel < panels; panel++, m += columns, out += HEIGHT) {
        real a = 0.0@f@, b = 0.0@f@, c = 0.0@f@, d = 0.0@f@;
        for (int k = 0; k < columns; k++) {
            a += m[k][0] * x[k];
            b += m[k][1] * x[k];
            c += m[k][2] * x[k];
            d += m[k][3] * x[k];
        }
        out[0] = a;
        out[1] = b;
        out[2] = c;
        out[3] = d;
    }
}

/* The last row of the trim table, but one, whose forward speed is not above this one. */
static int row_at(real forward_speed)
{
    int row = 0;
    for (int stride = FIRST_STRIDE; stride > 0; stride /= 2) {
        const int next = row + stride;
        if (next < ROWS - 1 && FORWARD_SPEED[next] <= forward_speed) row = next;
    }
    return row;
}

/* How far a speed is on the way from a row to the next. */
static real way(int row, real forward_speed)
{
    return (forward_speed - FORWARD_SPEED[row]) / (FORWARD_SPEED[row + 1] - FORWARD_SPEED[row]);
}

@nearest@@limit@
static real between(real low, real high, real part) { return (1.0@f@ - part) * low + part * high; }

@solvers@
@curves@
@held@

/* The outputs of a tick, or of a reset; the state stays. */
static int compute(const @prefix@_state *state, const @prefix@_inputs *in, int is_reset, tick *t)
{
    (void)state, (void)is_reset; /* not every design needs both */
    if (!(@all_finite@)) return @PREFIX@_BAD_INPUT;

    t->status = 0u;
@wanted_speed@
    const real filtered_speed = @filtered_speed@;

    /* Level flight at V_r; the trim is held beyond its table. */
    const int row = row_at(filtered_speed);
    const real part = clamp(way(row, filtered_speed), 0.0@f@, 1.0@f@);
@trims@
@references@

    real *const y = t->signals + STATES;
    for (int i = 0; i < STATES; i++) t->signals[i] = state->x[i];
@y@

    const int here = row_at(in->@speed@);
    const real along = clamp(way(here, in->@speed@), -FARTHEST, FARTHEST);
    const real rho = (between(SPEED[here], SPEED[here + 1], along) - CENTRE) / HALF_RANGE;
    const real theta = clamp(rho, -1.0@f@, 1.0@f@);
    t->scheduling_parameter = theta;
    if (magnitude(rho - theta) > ROUNDING_OF_RHO) t->status |= @PREFIX@_OUT_OF_RANGE;

@close_loop@
    multiply(OUTPUT, COMMAND_PANELS, SIGNALS, t->signals, t->commands);
    real level[COMMANDS];
    for (int j = 0; j < COMMANDS; j++) {
        level[j] = between(TRIM[row][j], TRIM[row + 1][j], part);
        t->commands[j] = level[j] + SCALE[j] * t->commands[j];
        if (!is_finite(t->commands[j])) return @PREFIX@_DIVERGED;
    }
@ahead@
    for (int j = 0; j < COMMANDS; j++) {
        const real value = t->commands[j];
@limits@
        t->commands[j] = clamp(value, low, high);
        t->excess[j] = (value - t->commands[j]) / SCALE[j];
        if (t->excess[j] != 0.0@f@) t->status |= @PREFIX@_SATURATED | @saturated_first@ << j;
    }
    return @PREFIX@_OK;
}

static void put_out_commands(const real *commands, @prefix@_outputs *out)
{
@put_out@
}

static void put_out(const tick *t, @prefix@_outputs *out)
{
    put_out_commands(t->commands, out);
    out->scheduling_parameter = t->scheduling_parameter;
@put_out_trims@
@put_out_references@
    out->status = t->status;
}

@fade@
@follow@

@safe@

int @prefix@_init(@prefix@_state *state, @prefix@_outputs *out)
{
    const @prefix@_inputs level = {@level@};
    return @prefix@_reset(state, &level, out);
}

int @prefix@_reset(@prefix@_state *state, const @prefix@_inputs *in, @prefix@_outputs *out)
{
    @prefix@_state fresh;
    tick t;
@first@
    for (int i = 0; i < STATES; i++) fresh.x[i] = 0.0@f@;
    for (int j = 0; j < COMMANDS; j++) fresh.anchor[j] = 0.0@f@;
    fresh.followed_for = OPEN;
@origins@
    const int code = compute(&fresh, in, 1, &t);
    if (code != @PREFIX@_OK) return code;
@reset@
    *state = fresh;
    put_out(&t, out);
    return code;
}

int @prefix@_step(@prefix@_state *state, const @prefix@_inputs *in, @prefix@_outputs *out)
{
    tick t;
    real next[HEIGHT * STATE_PANELS];
@look@
    const int opens = state->followed_for < OPEN;
    const int code = opens ? compute_opening(state, in, &t) : compute(state, in, 0, &t);
    if (code != @PREFIX@_OK) return code;
    if (opens) state->followed_for++;
    multiply(UPDATE, STATE_PANELS, SIGNALS, t.signals, next);
    for (int i = 0; i < STATES; i++) state->x[i] = next[i];
@anti_windup@
@delay@
@keep_references@
@keep_commands@
@end_of_transitions@
@filter@
@keep_sensors@
    put_out(&t, out);
    return code;
}
