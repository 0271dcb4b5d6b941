/* The autopilot of a tick: measurements and references in, limited commands out.
 *
 *   monitor the sensors   trust or reject each; without one that nothing replaces, ramp the commands to the safe ones
 *   references            limited in range and rate at V_r; they yield while a steering actuator is at its limit
 *   V_r                   the filtered speed reference
 *   y                     references and measurements as deviations from level flight at V_r, divided by their scales
 *   rho                   the measured speed, mapped from the scheduled range to -1 .. 1
 *   u = K(rho) y          w = rho z,  z = Ct x + Dty y + Dtt w,  u = Cu x + Duy y + Dut w,  x' = A x + By y + Bt w
 *   command               trim at V_r + scale u, within the limits; x' += E excess, the anti-windup
 *
 * Units are SI and radians; times of sensors and actuators are in ticks. The order of operations is that of the
 * controller's FMU, and the results are identical to the last bit if the compiler conforms to IEEE 754:
 * -ffp-contract=off, and no -ffast-math. Loops run a fixed number of times; no allocation, no recursion.
 * Every literal is a float that is exact in a double, too: the text is the same for both types. */

#include "autopilot.h"

#include <float.h>
#include <stddef.h>
#include <stdint.h>

#if defined(__FAST_MATH__) || (defined(__FINITE_MATH_ONLY__) && __FINITE_MATH_ONLY__)
#error "compile without -ffast-math: numbers that are not finite must be seen"
#endif
#if FLT_EVAL_METHOD != 0
#error "each operation must round to its own type; on a 32-bit x86 compile with -msse2 -mfpmath=sse"
#endif
/* Fused multiply-add is disabled: product and sum are rounded separately. */
#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC optimize("fp-contract=off")
#else
#pragma STDC FP_CONTRACT OFF
#endif

typedef autopilot_real real;

/* Number of matrix rows summed at a time. */
#define HEIGHT 4
#define PANELS(rows) (((rows) + HEIGHT - 1) / HEIGHT)

/* C has no arrays of length 0. */
#define LENGTH(count) ((count) > 0 ? (count) : 1)

/* Index of a missing item. */
#define NONE (-1)

/* An input of the controller: y = (plus - minus)/scale, with the indices of two values of a tick. */
typedef struct {
    uint8_t plus, minus;
    real scale;
} controller_input;

/* Limited quantities of a reference: its value, and its rate per second. */
enum { RANGE, RATE };

/* A reference. */
typedef struct {
    int8_t measured;            /* index of the measurement of its signal, or NONE */
    uint8_t is_circular;        /* an angle with a period of one turn */
    uint8_t begins_as_measured; /* equals the measurement at a reset */
    uint8_t is_limited[2];      /* RANGE, RATE */
    uint16_t steered_by;        /* bits of the actuators at whose limits it yields */
    real lag;                   /* s, lag of the vehicle behind a steady reference */
    real negligible;            /* a difference regarded as zero */
    real limit[2][2];           /* RANGE, RATE: lower and upper */
    const real *column[2][2];   /* the same over speed, at the rows of the trim table; NULL: constant */
} reference;

/* Source of the rate of a measured signal: none, a measurement of the rate, pitch and speed along the path, or the
 * commands. */
enum { BY_NOTHING, BY_RATE, BY_PATH, BY_FORCE };

/* Substitute for a lost sensor: the safe commands, the speed at its reference, or the estimate from its source. */
enum { SAFE_COMMANDS, OPEN_LOOP, RECKONED };

/* A measurement, and the dynamics of its sensor. */
typedef struct {
    int8_t reference;       /* index of the reference of its signal, or NONE */
    uint8_t is_circular;    /* an angle with a period of one turn */
    uint8_t source;         /* source of its rate */
    int8_t other;           /* BY_RATE, BY_PATH: index of the measured rate, or of the measured pitch */
    int8_t pitch_trim;      /* BY_PATH: column of the pitch in the trim table */
    uint8_t without;        /* substitute if lost */
    const real *gains;      /* BY_FORCE: gain of each command, per second */
    real time;              /* BY_FORCE: the time constant, s */
    real error;             /* largest change between two values due to noise */
    real rate;              /* largest rate of the vehicle, per second */
    real drift;             /* largest rate of divergence from the estimate, per second */
    real resolution;        /* quantisation step, 0 if hidden by noise */
    real least, most;       /* range of the sensor */
    real oldest;            /* s: older values are lost */
    uint32_t slowest;       /* ticks: a value constant for longer is that of a vehicle at rest */
    uint32_t stale;         /* ticks: a value constant for this long may be stuck */
} measurement;

/* Conversion from thrust to command: none, a square law, or interpolation between points. */
typedef struct {
    real square;             /* thrust = square command |command|; 0: none */
    const real (*points)[2]; /* (command, thrust), both increasing; NULL: none */
    int count;
    real at_rest;            /* command for zero thrust */
} curve;

/* The values of a tick: measurements, references used, level flight at V_r (commands, then signals), V_r, the values
 * measured at the reset, and constants. */
#define USED MEASUREMENTS
#define TRIMMED (USED + REFERENCES)
#define FILTERED_SPEED (TRIMMED + COMMANDS + TRIMS)
#define ORIGIN (FILTERED_SPEED + 1)
#define NUMBER (ORIGIN + ORIGINS)
#define VALUES (NUMBER + NUMBERS)

/* The numbers of this autopilot:
 *
 *   INTO_LOOP, LOOP, OUTPUT, UPDATE   [Ct Dty], Dtt, [Cu Duy Dut] and [A By Bt]; all but Dtt in panels of four rows
 *   ANTI_WINDUP, FOLLOW               E, and F at values of rho from -1 to 1, stacked by rows
 *   FORWARD_SPEED, PATH_SPEED, TRIM   m/s in body axes and along the path, and level flight there: commands, signals
 *   CENTRE, HALF_RANGE                m/s along the path: rho = (V - CENTRE)/HALF_RANGE
 *   LEVEL, FIRST                      inputs in level flight at rho = 0, and the range of each at a reset
 *   SCALE, MINIMUM, MAXIMUM           of each command: its value at u = 1, and its limits
 *   PUSHES                            axial force per command, of a thruster that does not steer
 *   OPENING, OPEN_TICKS               increase of its range per tick after following, and its duration
 *   LARGEST_APPLIED, SAFE             bound on applied commands, and the safe commands
 *   YIELDING, FADE, FADE_STEP         of references, per tick; FADE_TIME in s
 *   FILTER, RETURNING                 fraction of the way of V_r to the reference, and of a lost speed to V_r, per tick
 *   TICK, TURN                        s, rad */
#include "tables.h"

#if SQUARE_LAWS
#include <math.h>
#endif

/* The measurements, then the references, then the ages of the measurements. */
#define TAKEN (MEASUREMENTS + REFERENCES)
#define INPUT_MEMBERS (TAKEN + (FAILSAFE ? MEASUREMENTS : 0))

/* Status bits for the first actuator at its limit, and for the loss of the first sensor. */
#define SATURATED_FIRST 0x10000u
#define LOST_FIRST 0x10u

/* A position in the trim table: a row and the fraction of the interval to the next. */
typedef struct {
    int row;
    real part;
} place;

/* Results of one tick. */
typedef struct {
    real signals[STATES + INPUTS + CHANNELS]; /* x, y, w */
    real value[VALUES];                       /* see above */
    real target[LENGTH(REFERENCES)];          /* each reference, within its range */
    real commands[HEIGHT * PANELS(COMMANDS)];
    real excess[COMMANDS]; /* u minus the limited u */
    real rho;
    unsigned held; /* bits of the actuators for which references yield */
    unsigned status;
} tick;

static int is_finite(real v) { return v >= -LARGEST && v <= LARGEST; }

static real clamp(real v, real low, real high) { return v < low ? low : v > high ? high : v; }

static real magnitude(real v) { return v <= 0.0f ? 0.0f - v : v; }

static real lesser(real a, real b) { return a < b ? a : b; }

static real greater(real a, real b) { return a > b ? a : b; }

static real between(real low, real high, real part) { return (1.0f - part) * low + part * high; }

/* out = M x, M as panels of four rows, each column by column. */
static void multiply(const real (*m)[HEIGHT], int panels, int columns, const real *x, real *out)
{
    for (int panel = 0; panel < panels; panel++, m += columns, out += HEIGHT) {
        real a = 0.0f, b = 0.0f, c = 0.0f, d = 0.0f;
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

/* x += M v; the sum is added last. */
static void add(const real (*m)[COMMANDS], const real *v, real *x)
{
    for (int i = 0; i < STATES; i++) {
        real sum = -0.0f;
        for (int j = 0; j < COMMANDS; j++) sum += m[i][j] * v[j];
        x[i] += sum;
    }
}

/* Returns the equivalent of a circular angle that is nearest to another angle. */
static real nearest(int is_circular, real value, real to)
{
    if (!CIRCULAR_SIGNALS || !is_circular) return value;
    const real turns = (value - to) / TURN;
    if (!(magnitude(turns) < 1e9f)) return value;
    return value - TURN * (real)(long)(turns < 0.0f ? turns - 0.5f : turns + 0.5f);
}

/* Finds a forward speed in the table: beyond the table the fraction is below 0 or above 1. */
static place find(real forward_speed)
{
    int row = 0; /* the last but one whose speed is not above this one */
    for (int stride = FIRST_STRIDE; stride > 0; stride /= 2) {
        const int next = row + stride;
        if (next < ROWS - 1 && FORWARD_SPEED[next] <= forward_speed) row = next;
    }
    const real low = FORWARD_SPEED[row], high = FORWARD_SPEED[row + 1];
    return (place){row, (forward_speed - low) / (high - low)};
}

/* Finds a forward speed in the table, clamped to its ends. */
static place find_within(real forward_speed)
{
    place at = find(forward_speed);
    at.part = clamp(at.part, 0.0f, 1.0f);
    return at;
}

/* Interpolates a column of the trim table. */
static real trim_at(place at, int column)
{
    return between(TRIM[at.row][column], TRIM[at.row + 1][column], at.part);
}

/* ---- References ---- */

/* Interpolates a limit of a reference; exact between two equal rows. */
static real limit_at(const reference *of, int what, int end, place at)
{
    const real *const column = of->column[what][end];
    if (column == NULL) return of->limit[what][end];
    return column[at.row] + at.part * (column[at.row + 1] - column[at.row]);
}

/* Clamps a reference to its range, or its rate to the limits of the rate. */
static real within(const reference *of, int what, place at, real value)
{
    if (of->is_limited[what] == 0u) return value;
    return clamp(value, limit_at(of, what, 0, at), limit_at(of, what, 1, at));
}

/* Returns the bits of the actuators at their limits for so long that the references of the signals they steer yield.
 * The state holds twice the number of ticks, plus 1 while at the limit. */
static unsigned held(const autopilot_state *state)
{
    unsigned bits = 0u;
    for (int j = 0; j < COMMANDS; j++)
        if (state->held[j] % 2 == 1 && state->held[j] / 2 >= HELD_TICKS) bits |= 1u << j;
    return bits;
}

/* Counts the ticks of each actuator at its limit. */
static void count_held(autopilot_state *state, const real *excess)
{
    for (int j = 0; j < COMMANDS; j++) {
        const int is_beyond_now = excess[j] != 0.0f;
        int ticks = state->held[j] / 2;
        if (is_beyond_now)
            ticks += ticks < HELD_TICKS;
        else
            ticks -= ticks > 0;
        state->held[j] = 2 * ticks + is_beyond_now;
    }
}

/* Sets a reference for a tick or a reset: the input, or its transition to it, within its range and rate at V_r. */
static void refer(int r, const autopilot_state *state, const real *in, int is_reset, place at, tick *t)
{
    const reference *const of = &REFERENCE[r];
    const autopilot_transition *const way = &state->way[r];
    const real wanted = in[MEASUREMENTS + r], measured = of->measured == NONE ? wanted : in[of->measured];
    const real last = state->last[r];
    const real asked = is_reset && of->begins_as_measured ? measured : wanted;
    const real target = within(of, RANGE, at, nearest(of->is_circular, asked, is_reset ? measured : last));
    real used = target;
    if (way->share != 0.0f) used = within(of, RANGE, at, between(target, way->start, way->share));
    if (of->is_limited[RATE] != 0u && !is_reset)
        used = clamp(used, last + TICK * limit_at(of, RATE, 0, at), last + TICK * limit_at(of, RATE, 1, at));
    if ((t->held & of->steered_by) != 0u) {
        const real there = nearest(of->is_circular, measured, last);
        used = within(of, RANGE, at, last + YIELDING * (there - last));
    }
    if (used != nearest(of->is_circular, wanted, used)) t->status |= AUTOPILOT_REFERENCE_LIMITED;
    t->target[r] = target;
    t->value[USED + r] = used;
}

/* Advances the transition of a reference from start to target by a tick, through two lags of FADE_TIME. */
static void fade(autopilot_transition *of, real target, real negligible)
{
    if (of->share == 0.0f) return;
    of->start += TICK * of->rate * of->lag;
    of->share = FADE * (of->share + FADE_STEP * of->lag);
    of->lag *= FADE;
    const real left = between(target, of->start, of->share) - target, moves = FADE_TIME * of->rate * of->lag;
    if (magnitude(left) <= negligible && magnitude(moves) <= negligible) of->share = 0.0f;
}

/* Returns the input of the filter of V_r: the speed reference, or the measured speed if it is imposed. */
static real wanted_speed(const real *in, const real *used)
{
    return SPEED_REFERENCE == NONE ? in[SPEED] : used[SPEED_REFERENCE == NONE ? 0 : SPEED_REFERENCE];
}

/* ---- Commands ---- */

#if CHANNELS > 0
/* Sums the known terms of row i of (I - theta T) z = b, T quasi-triangular; the latest entry of z is added last. */
static real known(int i, int first, real theta, const real *z)
{
    real sum = -0.0f;
    for (int k = CHANNELS - 1; k >= first; k--) sum += LOOP[i][k] * z[k];
    return sum * theta;
}

/* Solves row i for z, given the rows below; returns 0 if it is singular to working precision. */
static int solve_one(int i, real theta, real *z)
{
    const real own = theta * LOOP[i][i], d = 1.0f - own;
    const real right = z[i] + known(i, i + 1, theta, z);
    if (!(magnitude(d) > PRECISION * (1.0f + magnitude(own)))) return 0;
    z[i] = right / d;
    return 1;
}

/* Solves the rows i and i + 1, a block of T with two complex eigenvalues. */
static int solve_two(int i, real theta, real *z)
{
    const real a = 1.0f - theta * LOOP[i][i], d = 1.0f - theta * LOOP[i + 1][i + 1];
    const real above = -theta * LOOP[i][i + 1], below = -theta * LOOP[i + 1][i];
    const real left = z[i] + known(i, i + 2, theta, z), right = z[i + 1] + known(i + 1, i + 2, theta, z);
    const real determinant = a * d - above * below;
    const real rounding = PRECISION * (1.0f + magnitude(1.0f - a) + magnitude(1.0f - d));
    const real cancelled = PRECISION * (magnitude(a * d) + magnitude(above * below));
    if (!(magnitude(determinant) > cancelled + rounding * rounding)) return 0;
    z[i] = (d * left - above * right) / determinant;
    z[i + 1] = (a * right - below * left) / determinant;
    return 1;
}
#endif

/* Solves the algebraic loop w = theta z of K(rho); returns 0 if it has no solution. */
static int close_loop(real theta, real *signals)
{
#if CHANNELS > 0
    real z[HEIGHT * PANELS(CHANNELS)];
    multiply(INTO_LOOP, PANELS(CHANNELS), STATES + INPUTS, signals, z);
    for (int end = CHANNELS; end > 0;) {
        const int has_two = end > 1 && LOOP[end - 1][end > 1 ? end - 2 : 0] != 0.0f;
        end -= has_two ? 2 : 1;
        if (!(has_two ? solve_two(end, theta, z) : solve_one(end, theta, z))) return 0;
    }
    for (int i = 0; i < CHANNELS; i++) signals[STATES + INPUTS + i] = theta * z[i];
#else
    (void)theta, (void)signals;
#endif
    return 1;
}

/* Returns the speed that thrusters that do not steer must not oppose: V_r while a steering actuator is beyond its
 * limit, or was in the preceding ticks; else 0. */
static real ahead(const autopilot_state *state, const tick *t)
{
    int any = 0;
    for (int j = 0; j < COMMANDS; j++) {
        const int is_beyond = t->commands[j] < MINIMUM[j] || t->commands[j] > MAXIMUM[j] || state->held[j] > 1;
        any |= (STEERS >> j & 1u) != 0u && is_beyond;
    }
    return any ? t->value[FILTERED_SPEED] : 0.0f;
}

/* Limits command j to the limits of its actuator and, against the speed ahead, to its value in trim. */
static real limited(int j, real ahead, real trim, real value)
{
    const real way = ONE_WAY ? ahead * PUSHES[j] : 0.0f;
    real low = MINIMUM[j], high = MAXIMUM[j];
    if (way > 0.0f) low = greater(low, lesser(trim, 0.0f));
    if (way < 0.0f) high = lesser(high, greater(trim, 0.0f));
    return clamp(value, low, high);
}

/* Computes the outputs of a tick or a reset, without changing the state. */
static int compute(const autopilot_state *state, const real *in, int is_reset, tick *t)
{
    for (int i = 0; i < TAKEN; i++)
        if (!is_finite(in[i])) return AUTOPILOT_BAD_INPUT;

    /* The speed comes first: the limits of the other references depend on V_r, its own do not. */
    t->status = 0u;
    t->held = STEERS != 0u ? held(state) : 0u;
    if (SPEED_REFERENCE != NONE) refer(SPEED_REFERENCE, state, in, is_reset, (place){0, 0.0f}, t);
    const real filtered_speed = HAS_FILTER && !is_reset ? state->filtered_speed : wanted_speed(in, t->value + USED);
    const place at = find_within(filtered_speed);
    for (int r = 0; r < REFERENCES; r++)
        if (r != SPEED_REFERENCE) refer(r, state, in, is_reset, at, t);
    for (int m = 0; m < MEASUREMENTS; m++) {
        const measurement *const of = &MEASUREMENT[m];
        t->value[m] = nearest(of->is_circular, in[m], t->value[of->is_circular ? USED + of->reference : m]);
    }
    for (int k = 0; k < COMMANDS + TRIMS; k++) t->value[TRIMMED + k] = trim_at(at, k);
    t->value[FILTERED_SPEED] = filtered_speed;
#if ORIGINS > 0
    for (int k = 0; k < ORIGINS; k++) t->value[ORIGIN + k] = state->origin[k];
#endif
    for (int k = 0; k < NUMBERS; k++) t->value[NUMBER + k] = NUMBERS_OF[k];

    for (int i = 0; i < STATES; i++) t->signals[i] = state->x[i];
    for (int i = 0; i < INPUTS; i++)
        t->signals[STATES + i] = (t->value[INPUT[i].plus] - t->value[INPUT[i].minus]) / INPUT[i].scale;

    const place here = find(in[SPEED]);
    const real along = clamp(here.part, -FARTHEST, FARTHEST);
    const real rho = (between(PATH_SPEED[here.row], PATH_SPEED[here.row + 1], along) - CENTRE) / HALF_RANGE;
    t->rho = clamp(rho, -1.0f, 1.0f);
    if (magnitude(rho - t->rho) > ROUNDING_OF_RHO) t->status |= AUTOPILOT_OUT_OF_RANGE;

    if (!close_loop(t->rho, t->signals)) return AUTOPILOT_SINGULAR;
    multiply(OUTPUT, PANELS(COMMANDS), STATES + INPUTS + CHANNELS, t->signals, t->commands);
    for (int j = 0; j < COMMANDS; j++) {
        t->commands[j] = t->value[TRIMMED + j] + SCALE[j] * t->commands[j];
        if (!is_finite(t->commands[j])) return AUTOPILOT_DIVERGED;
    }
    const real speed_ahead = ONE_WAY ? ahead(state, t) : 0.0f;
    for (int j = 0; j < COMMANDS; j++) {
        const real value = t->commands[j];
        t->commands[j] = limited(j, speed_ahead, t->value[TRIMMED + j], value);
        t->excess[j] = (value - t->commands[j]) / SCALE[j];
        if (t->excess[j] != 0.0f) t->status |= AUTOPILOT_SATURATED | SATURATED_FIRST << j;
    }
    return AUTOPILOT_OK;
}

/* ---- Actuators ---- */

/* Converts a thrust to the command of an actuator; between points, by linear interpolation from the lower one. */
static real taken_for(const curve *of, real thrust)
{
#if SQUARE_LAWS
    if (of->square > 0.0f) return COPYSIGN(SQRT(magnitude(thrust) / of->square), thrust);
#endif
    if (!POINT_CURVES || of->points == NULL) return thrust;
    const real t = clamp(thrust, of->points[0][1], of->points[of->count - 1][1]);
    int above = 0; /* number of points below */
    for (int i = 0; i < of->count; i++) above += t > 0.0f ? of->points[i][1] < t : of->points[i][1] <= t;
    if (t == 0.0f) return of->at_rest;
    if (above == 0 || above == of->count) return of->points[above == 0 ? 0 : of->count - 1][0];
    const real *const p = of->points[above - 1], *const q = of->points[above];
    return t == q[1] ? q[0] : p[0] + (q[0] - p[0]) * ((t - p[1]) / (q[1] - p[1]));
}

/* Converts the command of an actuator to its thrust. */
static real given_for(const curve *of, real taken)
{
    if (SQUARE_LAWS && of->square > 0.0f) return of->square * taken * magnitude(taken);
    if (!POINT_CURVES || of->points == NULL) return taken;
    int above = 0; /* index of the first point above */
    for (int i = 0; i < of->count; i++) above += of->points[i][0] <= taken;
    if (above == 0 || above == of->count) return of->points[above == 0 ? 0 : of->count - 1][1];
    const real *const p = of->points[above - 1], *const q = of->points[above];
    return taken == q[0] ? q[1] : p[1] + (q[1] - p[1]) * ((taken - p[0]) / (q[0] - p[0]));
}

/* Converts commands to those of the actuators. */
static void take(const real *commands, real *taken)
{
    for (int j = 0; j < COMMANDS; j++) taken[j] = taken_for(&CURVE[j], commands[j]);
}

/* Reads the applied commands, clamped to their limits; returns 0 if one is not finite or far beyond them. */
static int read(const autopilot_commands *applied, real *got)
{
    get_applied(applied, got);
    for (int j = 0; j < COMMANDS; j++) {
        if (!is_finite(got[j])) return 0;
        got[j] = given_for(&CURVE[j], got[j]);
        if (!(magnitude(got[j]) <= LARGEST_APPLIED[j])) return 0;
        got[j] = clamp(got[j], MINIMUM[j], MAXIMUM[j]);
    }
    return 1;
}

/* Delays the commands by AUTOPILOT_DELAY_TICKS. */
static void delay(autopilot_state *state, real *commands)
{
#if AUTOPILOT_DELAY_TICKS > 0
    for (int j = 0; j < COMMANDS; j++) {
        const real due = state->waiting[state->next][j];
        state->waiting[state->next][j] = commands[j];
        commands[j] = due;
    }
    state->next = state->next + 1 == AUTOPILOT_DELAY_TICKS ? 0 : state->next + 1;
#else
    (void)state, (void)commands;
#endif
}

/* Fills the delay with the given commands. */
static void fill_delay(autopilot_state *state, const real *commands)
{
#if AUTOPILOT_DELAY_TICKS > 0
    for (int k = 0; k < AUTOPILOT_DELAY_TICKS; k++)
        for (int j = 0; j < COMMANDS; j++) state->waiting[k][j] = commands[j];
#else
    (void)state, (void)commands;
#endif
}

static void put_out(const tick *t, autopilot_outputs *out)
{
    real taken[COMMANDS];
    take(t->commands, taken);
    put_commands(taken, out);
    put_monitors(t->value, out);
    out->scheduling_parameter = t->rho;
    out->status = t->status;
}

/* ---- Following the commands of others ---- */

/* Corrects the state by F(rho) to reduce the excess of the commands: x -= F excess. */
static void correct(autopilot_state *state, const tick *t)
{
    if (FOLLOW_GAINS == 0) return; /* a controller without gains cannot follow */
    const int last = FOLLOW_GAINS > 1 ? FOLLOW_GAINS - 2 : 0;
    const real along = 0.5f * (t->rho + 1.0f) * (real)(FOLLOW_GAINS - 1);
    const int index = along < (real)last ? (int)along : last;
    const real part = along - (real)index;
    const real(*const low)[COMMANDS] = FOLLOW + index * STATES;
    const real(*const high)[COMMANDS] = FOLLOW_GAINS > 1 ? low + STATES : low;
    for (int i = 0; i < STATES; i++) {
        real sum = -0.0f;
        for (int j = 0; j < COMMANDS; j++) sum += between(low[i][j], high[i][j], part) * t->excess[j];
        state->x[i] -= sum;
    }
}

/* Limits commands to the open range, and adds the difference to their excess; returns 1 if any is limited. */
static int cut_off(const autopilot_state *state, tick *t)
{
    int any = 0;
    for (int j = 0; j < COMMANDS; j++) {
        const real open = OPENING[j] * (real)state->followed_for, value = t->commands[j];
        t->commands[j] = clamp(value, state->anchor[j] - open, state->anchor[j] + open);
        if (t->commands[j] != value) {
            t->excess[j] += (value - t->commands[j]) / SCALE[j];
            any = 1;
        }
    }
    return any;
}

/* Computes the outputs of a tick soon after following: the state follows a limited command. */
static int compute_opening(autopilot_state *state, const real *in, tick *t)
{
    int code = compute(state, in, 0, t);
    if (code != AUTOPILOT_OK || !cut_off(state, t)) return code;
    autopilot_state next = *state;
    correct(&next, t);
    code = compute(&next, in, 0, t);
    if (code != AUTOPILOT_OK) return code;
    cut_off(&next, t);
    for (int j = 0; j < COMMANDS; j++) t->excess[j] = 0.0f;
    t->status &= (SATURATED_FIRST - 1u) & ~AUTOPILOT_SATURATED;
    *state = next;
    return code;
}

/* Returns the rate of a measured signal, from its source and the speed; 0 without a source. */
static real rate_of(const measurement *of, real other, real speed)
{
    if (of->source == BY_RATE) return other;
    if (!PATH_SOURCES || of->source != BY_PATH) return 0.0f;
    return -(speed * (other - trim_at(find_within(speed), of->pitch_trim)));
}

/* Starts a reference ahead of the vehicle by the lag, at the rate of the vehicle. */
static void begin(int r, autopilot_state *state, const real *in, place at)
{
    const reference *const of = &REFERENCE[r];
    real rate = 0.0f;
    if (of->measured != NONE) {
        const measurement *const m = &MEASUREMENT[of->measured];
        rate = rate_of(m, in[m->other], in[SPEED]);
    }
    rate = within(of, RATE, at, rate);
    const real from = in[of->measured == NONE ? MEASUREMENTS + r : of->measured];
    const real used = nearest(of->is_circular, from, state->last[r]) + of->lag * rate;
    state->last[r] = within(of, RANGE, at, used);
    state->way[r] = (autopilot_transition){state->last[r], rate, 1.0f, 1.0f};
}

/* Sets the state so that the next tick outputs the applied commands. */
static int follow(autopilot_state *state, const real *in, const real *got)
{
    autopilot_state next = *state;
    tick t;
    if (SPEED_REFERENCE != NONE) begin(SPEED_REFERENCE, &next, in, (place){0, 0.0f});
    next.filtered_speed = wanted_speed(in, next.last);
    const place at = find_within(next.filtered_speed);
    for (int r = 0; r < REFERENCES; r++)
        if (r != SPEED_REFERENCE) begin(r, &next, in, at);
    for (int j = 0; j < COMMANDS; j++) next.held[j] = 0;
    const int code = compute(&next, in, 0, &t);
    if (code != AUTOPILOT_OK) return code;
    for (int r = 0; r < REFERENCES; r++) next.last[r] = t.value[USED + r];
    next.filtered_speed = t.value[FILTERED_SPEED];
    for (int j = 0; j < COMMANDS; j++) t.excess[j] += (t.commands[j] - got[j]) / SCALE[j];
    correct(&next, &t);
    for (int j = 0; j < COMMANDS; j++) next.anchor[j] = got[j];
    next.followed_for = 0;
    fill_delay(&next, got);
    *state = next;
    return code;
}

/* ---- Sensors ---- */

#if FAILSAFE
#define NEVER UINT32_MAX

/* Counts a tick; NEVER precedes the first. */
static uint32_t counted(uint32_t ticks) { return ticks < NEVER - 1u ? ticks + 1u : NEVER - 1u; }

static uint32_t fewer(uint32_t a, uint32_t b) { return a < b ? a : b; }

/* Returns 1 if a distance is possible after some ticks. */
static int is_near(real distance, real error, real rate, uint32_t ticks)
{
    return magnitude(distance) <= error + rate * ((real)ticks * TICK);
}

/* Returns 1 if a constant value is that of a stuck sensor. */
static int is_stuck(const autopilot_watched *one, const measurement *of, uint32_t since)
{
    const uint32_t ticks = fewer(since, LONGEST_TICKS);
    if (of->source == BY_RATE && !is_near(one->moved, of->error, of->drift, ticks)) return 1;
    if (since < of->stale) return 0;
    return one->wrong_for >= REGAINED_TICKS || of->resolution == 0.0f ||
           !is_near(one->moved, STEPS * of->resolution, of->drift, ticks);
}

/* Marks a sensor as lost, and initialises its estimate. */
static void lose(autopilot_watched *one, const measurement *of, real moved, int is_stuck_now)
{
    one->lost_for = 1u;
    one->plausible_for = 0u;
    one->wrong_for = is_stuck_now ? REGAINED_TICKS : 0u;
    if (of->without == RECKONED) one->believed += moved; /* its value has been wrong since it last changed */
    if (of->without == OPEN_LOOP) {
        /* The controller has integrated the noise of a constant value. */
        const real share = (real)fewer(one->same, RETURN_TICKS) / (real)RETURN_TICKS;
        one->believed = one->mean - share * (one->believed - one->mean);
    }
    one->moved = 0.0f;
}

/* Judges a value of a sensor; `force` is the effect of the commands, and `expected` is 0 without a trusted rate.
 * Returns 1 if the sensor is trusted again. */
static int judge(autopilot_watched *one, const measurement *of, real value, real force, int valid, int expected)
{
    const int is_first = one->same == NEVER, changed = is_first || value != one->last;
    const uint32_t since = counted(one->same);
    const int stuck = !changed && is_stuck(one, of, since);
    const int in_range = of->least <= value && value <= of->most;
    const int moves = is_first || is_near(value - one->last, of->error, of->rate, fewer(since, of->slowest));
    const int speaks = valid && is_finite(value), plausible = speaks && in_range && moves && !stuck;
    const real moved = one->moved;
    one->last = value;
    one->same = changed ? 0u : since;
    if (changed && !(of->source == BY_RATE && one->lost_for > 0u)) {
        one->moved = 0.0f;
        one->anchor = force;
    }
    if (one->lost_for == 0u) {
        if (!plausible) {
            lose(one, of, moved, stuck);
        } else {
            one->believed = value;
            if (changed) one->mean += RETURNING * (value - one->mean);
        }
        return 0;
    }
    one->lost_for = counted(one->lost_for);
    if (plausible && !expected) { /* no estimate contradicts the value */
        one->believed = value;
        one->lost_for = 1u;
        one->wrong_for = 0u;
    }
    const uint32_t lost_for = fewer(one->lost_for, LONGEST_TICKS);
    if (plausible && is_near(value - one->believed, of->error, of->drift, lost_for)) {
        one->plausible_for = counted(one->plausible_for);
    } else {
        one->plausible_for = 0u;
        one->moved = 0.0f;
        one->wrong_for = fewer(one->wrong_for + (speaks ? 1u : 0u), REGAINED_TICKS);
    }
    if (one->plausible_for < REGAINED_TICKS) return 0;
    if (of->source == BY_RATE && one->wrong_for >= REGAINED_TICKS && !(magnitude(one->moved) > of->error)) return 0;
    *one = (autopilot_watched){value, value, value, 0.0f, force, one->same, 0u, 0u, 0u};
    return 1;
}

/* Returns the effect of the last commands on a signal, per second. */
static real force_of(const measurement *of, const autopilot_state *state)
{
    real sum = 0.0f;
    if (of->source != BY_FORCE) return sum;
    for (int j = 0; j < COMMANDS; j++) sum += of->gains[j] * state->put_out[j];
    return sum;
}

/* Returns 1 if there is an estimate for a sensor: not while the sensor of its rate is lost. */
static int is_expected(const measurement *of, const autopilot_sensors *all)
{
    return of->source != BY_RATE || all->watched[of->other].lost_for == 0u;
}

/* Advances the expected change of a sensor, and its estimate if it is lost; `force` is the effect of the commands. */
static void expect(int m, const autopilot_state *state, real force, autopilot_sensors *all)
{
    const measurement *const of = &MEASUREMENT[m];
    autopilot_watched *const one = &all->watched[m];
    real rate = 0.0f;
    if (of->source == BY_FORCE)
        rate = force - one->anchor - one->moved / of->time;
    else if (is_expected(of, all))
        rate = rate_of(of, all->watched[of->other].believed, all->watched[SPEED].believed);
    const real step = TICK * rate;
    one->moved += step;
    if (one->lost_for == 0u) return;
    if (of->without == RECKONED) one->believed += step;
    if (of->without == OPEN_LOOP && SPEED_REFERENCE != NONE)
        one->believed += RETURNING * (state->filtered_speed - one->believed);
}

/* Judges the sensors, once per tick, and replaces the measurements by the trusted or estimated values. Returns the
 * bits of lost sensors. */
static unsigned look(const autopilot_state *state, real *in, autopilot_sensors *all)
{
    unsigned lost = 0u;
    *all = state->sensors;
    const int is_new = !all->judged;
    real force[MEASUREMENTS];
    for (int m = 0; is_new && m < MEASUREMENTS; m++) {
        force[m] = force_of(&MEASUREMENT[m], state);
        expect(m, state, force[m], all);
    }
    for (int m = 0; is_new && m < MEASUREMENTS; m++) {
        const measurement *const of = &MEASUREMENT[m];
        autopilot_watched *const one = &all->watched[m];
        const real value = nearest(of->is_circular, in[m], one->believed), age = in[TAKEN + m];
        const int valid = AUTOPILOT_STALE_AFTER == 0.0 || (age >= 0.0f && age <= of->oldest);
        all->changed |= judge(one, of, value, force[m], valid, is_expected(of, all));
    }
    for (int m = 0; m < MEASUREMENTS; m++) {
        const measurement *const of = &MEASUREMENT[m];
        in[m] = all->watched[m].believed;
        if (all->watched[m].lost_for == 0u) continue;
        lost |= LOST_FIRST << m;
        if (of->without == SAFE_COMMANDS) lost |= AUTOPILOT_FAILED;
        if (PATH_SOURCES && of->source == BY_PATH && of->reference != NONE) {
            /* Its reference is held: the input is the target that holds it. */
            const autopilot_transition *const way = &state->way[of->reference];
            const real last = state->last[of->reference], left = 1.0f - way->share;
            in[MEASUREMENTS + of->reference] = way->share < 1.0f ? (last - way->share * way->start) / left : last;
        }
    }
    return lost;
}

/* Computes the commands of this tick on the ramp to the safe ones. */
static void go_to_safe(autopilot_state *state, autopilot_sensors *all, unsigned lost, autopilot_outputs *out)
{
    if (all->failed_for == 0u)
        for (int j = 0; j < COMMANDS; j++) all->from[j] = state->put_out[j];
    all->failed_for += all->failed_for < RAMP_TICKS;
    const real part = (real)all->failed_for / (real)RAMP_TICKS;
    for (int j = 0; j < COMMANDS; j++) state->put_out[j] = between(all->from[j], SAFE[j], part);
    all->judged = 0;
    state->sensors = *all;
    real taken[COMMANDS];
    take(state->put_out, taken);
    put_commands(taken, out);
    out->status = lost;
}

void autopilot_safe(autopilot_commands *out)
{
    real taken[COMMANDS];
    take(SAFE, taken);
    put_safe(taken, out);
}
#endif

/* ---- Functions of the header ---- */

/* Initialises a state at the given inputs. */
static int begin_at(autopilot_state *state, const real *in, autopilot_outputs *out)
{
    autopilot_state fresh = {0};
    tick t;
    for (int i = 0; i < TAKEN; i++)
        if (!(in[i] >= FIRST[i][0] && in[i] <= FIRST[i][1])) return AUTOPILOT_BAD_INPUT;
    fresh.followed_for = OPEN_TICKS;
#if ORIGINS > 0
    for (int k = 0; k < ORIGINS; k++) fresh.origin[k] = in[ORIGIN_OF[k]];
#endif
    const int code = compute(&fresh, in, 1, &t);
    if (code != AUTOPILOT_OK) return code;
    fresh.filtered_speed = t.value[FILTERED_SPEED];
    for (int r = 0; r < REFERENCES; r++) fresh.last[r] = t.value[USED + r];
    for (int j = 0; j < COMMANDS; j++) {
        fresh.put_out[j] = t.commands[j];
        fresh.held[j] = t.excess[j] != 0.0f;
    }
    fill_delay(&fresh, t.commands);
#if FAILSAFE
    for (int m = 0; m < MEASUREMENTS; m++) {
        autopilot_watched *const one = &fresh.sensors.watched[m];
        one->last = one->believed = one->mean = in[m];
        one->same = NEVER;
    }
#endif
    *state = fresh;
    put_out(&t, out);
    return code;
}

int autopilot_init(autopilot_state *state, autopilot_outputs *out) { return begin_at(state, LEVEL, out); }

int autopilot_reset(autopilot_state *state, const autopilot_inputs *in, autopilot_outputs *out)
{
    real taken[INPUT_MEMBERS];
    get_inputs(in, taken);
    return begin_at(state, taken, out);
}

int autopilot_step(autopilot_state *state, const autopilot_inputs *in, autopilot_outputs *out)
{
    tick t;
    real taken[INPUT_MEMBERS], next[HEIGHT * PANELS(STATES)];
    get_inputs(in, taken);
#if FAILSAFE
    autopilot_sensors all;
    const unsigned lost = look(state, taken, &all);
    if ((lost & AUTOPILOT_FAILED) != 0u) {
        go_to_safe(state, &all, lost, out);
        return AUTOPILOT_OK;
    }
    if (all.changed) {
        const int followed = follow(state, taken, state->put_out);
        if (followed != AUTOPILOT_OK) return followed;
    }
#endif
    const int opens = state->followed_for < OPEN_TICKS;
    const int code = opens ? compute_opening(state, taken, &t) : compute(state, taken, 0, &t);
    if (code != AUTOPILOT_OK) return code;
    if (opens) state->followed_for++;
    multiply(UPDATE, PANELS(STATES), STATES + INPUTS + CHANNELS, t.signals, next);
    for (int i = 0; i < STATES; i++) state->x[i] = next[i];
    if (HAS_ANTI_WINDUP && (t.status & AUTOPILOT_SATURATED) != 0u) add(ANTI_WINDUP, t.excess, state->x);
    delay(state, t.commands);
    for (int j = 0; j < COMMANDS; j++) state->put_out[j] = t.commands[j];
    for (int r = 0; r < REFERENCES; r++) {
        state->last[r] = t.value[USED + r];
        if ((t.held & REFERENCE[r].steered_by) != 0u)
            state->way[r] = (autopilot_transition){t.value[USED + r], 0.0f, 1.0f, 1.0f};
        else
            fade(&state->way[r], t.target[r], REFERENCE[r].negligible);
    }
    count_held(state, t.excess);
    state->filtered_speed = t.value[FILTERED_SPEED];
    if (HAS_FILTER) state->filtered_speed += FILTER * (wanted_speed(taken, t.value + USED) - state->filtered_speed);
#if FAILSAFE
    all.failed_for = 0u;
    all.changed = 0;
    all.judged = 0;
    state->sensors = all;
    t.status |= lost;
#endif
    put_out(&t, out);
    return code;
}

int autopilot_follow(autopilot_state *state, const autopilot_inputs *in, const autopilot_commands *applied)
{
    real got[COMMANDS], taken[INPUT_MEMBERS];
    if (!read(applied, got)) return AUTOPILOT_BAD_INPUT;
    get_inputs(in, taken);
#if FAILSAFE
    autopilot_sensors all;
    const int failed = (look(state, taken, &all) & AUTOPILOT_FAILED) != 0u;
    const int code = failed ? AUTOPILOT_OK : follow(state, taken, got);
    if (code != AUTOPILOT_OK) return code;
    if (!failed) all.changed = 0;
    all.failed_for = 0u;
    all.judged = 1;
    state->sensors = all;
    for (int j = 0; j < COMMANDS; j++) state->put_out[j] = got[j];
    return code;
#else
    return follow(state, taken, got);
#endif
}

int autopilot_feed_back(autopilot_state *state, const autopilot_commands *applied)
{
    real got[COMMANDS];
    int differs = 0;
    if (!read(applied, got)) return AUTOPILOT_BAD_INPUT;
#if FAILSAFE
    for (int m = 0; m < MEASUREMENTS; m++) /* no feedback during the ramp to the safe commands */
        if (MEASUREMENT[m].without == SAFE_COMMANDS && state->sensors.watched[m].lost_for > 0u) return AUTOPILOT_OK;
#endif
    for (int j = 0; j < COMMANDS; j++) {
        got[j] = (state->put_out[j] - got[j]) / SCALE[j];
        differs |= got[j] != 0.0f;
    }
    if (HAS_ANTI_WINDUP && differs) add(ANTI_WINDUP, got, state->x);
    return AUTOPILOT_OK;
}
