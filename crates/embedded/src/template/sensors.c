/* How a sensor moves, and what it can measure. */
typedef struct {
    real error, rate, drift, resolution, least, most;
    uint32_t slowest, stale;
    int is_speed, is_reckoned, has_rate;
} sensor;

@sensors@

/* Counts a tick; NEVER is before the first. */
static uint32_t counted(uint32_t ticks) { return ticks < NEVER - 1u ? ticks + 1u : NEVER - 1u; }

static uint32_t fewer(uint32_t a, uint32_t b) { return a < b ? a : b; }

/* Whether a distance is as small as it can be after some ticks. */
static int near(real distance, real error, real rate, uint32_t ticks)
{
    return magnitude(distance) <= error + rate * ((real)ticks * TICK);
}

/* Whether a value that stays the same is that of a stuck sensor. */
static int is_stuck(const @prefix@_watched *one, const sensor *of, uint32_t since)
{
    const uint32_t ticks = fewer(since, LONGEST_TICKS);
    if (of->has_rate && !near(one->moved, of->error, of->drift, ticks)) return 1;
    if (since < of->stale) return 0;
    return one->wrong_for >= REGAINED_TICKS || of->resolution == 0.0@f@ ||
           !near(one->moved, STEPS * of->resolution, of->drift, ticks);
}

/* Takes a value of a sensor; `force` is what the commands give, and without a believed rate nothing is `expected` of it.
 * Returns whether it is believed again. */
static int judge(@prefix@_watched *one, const sensor *of, real value, real force, int valid, int expected)
{
    const int is_first = one->same == NEVER, changed = is_first || value != one->last;
    const uint32_t since = counted(one->same);
    const int stuck = !changed && is_stuck(one, of, since);
    const int in_range = of->least <= value && value <= of->most;
    const int moves = is_first || near(value - one->last, of->error, of->rate, fewer(since, of->slowest));
    const int speaks = valid && is_finite(value), plausible = speaks && in_range && moves && !stuck;
    const real moved = one->moved;
    one->last = value;
    one->same = changed ? 0u : since;
    if (changed && !(of->has_rate && one->lost_for > 0u)) {
        one->moved = 0.0@f@;
        one->anchor = force;
    }
    if (one->lost_for == 0u) {
        if (plausible) {
            one->believed = value;
            if (changed) one->mean += RETURNING * (value - one->mean);
            return 0;
        }
        one->lost_for = 1u;
        one->plausible_for = 0u;
        one->wrong_for = stuck ? REGAINED_TICKS : 0u;
        if (of->is_reckoned) one->believed += moved; /* since its value changed last it has been wrong */
        if (of->is_speed) {
            /* The controller has integrated the noise of a value that did not change. */
            const real share = (real)fewer(one->same, RETURN_TICKS) / (real)RETURN_TICKS;
            one->believed = one->mean - share * (one->believed - one->mean);
        }
        one->moved = 0.0@f@;
        return 0;
    }
    one->lost_for = counted(one->lost_for);
    if (plausible && !expected) { /* nothing contradicts it */
        one->believed = value;
        one->lost_for = 1u;
        one->wrong_for = 0u;
    }
    if (plausible && near(value - one->believed, of->error, of->drift, fewer(one->lost_for, LONGEST_TICKS))) {
        one->plausible_for = counted(one->plausible_for);
    } else {
        one->plausible_for = 0u;
        one->moved = 0.0@f@;
        one->wrong_for = fewer(one->wrong_for + (speaks ? 1u : 0u), REGAINED_TICKS);
    }
    if (one->plausible_for < REGAINED_TICKS) return 0;
    if (of->has_rate && one->wrong_for >= REGAINED_TICKS && !(magnitude(one->moved) > of->error)) return 0;
    *one = (@prefix@_watched){value, value, value, 0.0@f@, force, one->same, 0u, 0u, 0u};
    return 1;
}

@force@
/* Judges the sensors, once a tick. Returns the bits of those that are lost; `used` are the inputs as they are believed. */
static unsigned look(const @prefix@_state *state, const @prefix@_inputs *in, @prefix@_sensors *all, @prefix@_inputs *used)
{
    unsigned lost = 0u;
    *all = state->sensors;
    *used = *in;
    if (!all->judged) {
@expect@
@judge@
    }
@believe@
    return lost;
}

/* The commands of this tick on the way to the safe ones. */
static void go_to_safe(@prefix@_state *state, @prefix@_sensors *all, unsigned lost, @prefix@_outputs *out)
{
    if (all->failed_for == 0u)
        for (int j = 0; j < COMMANDS; j++) all->from[j] = state->put_out[j];
    all->failed_for += all->failed_for < RAMP_TICKS;
    const real part = (real)all->failed_for / (real)RAMP_TICKS;
    for (int j = 0; j < COMMANDS; j++) state->put_out[j] = between(all->from[j], SAFE[j], part);
    all->judged = 0;
    state->sensors = *all;
    put_out_commands(state->put_out, out);
    out->status = lost;
}
