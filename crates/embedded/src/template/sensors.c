/* How a sensor moves, and what it can measure. */
typedef struct {
    real error, rate, drift, least, most;
    int is_speed;
} sensor;

@sensors@

/* Counts a tick; NEVER is before the first. */
static uint32_t counted(uint32_t ticks) { return ticks < NEVER - 1u ? ticks + 1u : NEVER - 1u; }

/* Whether a value is as near to another as it can be after some ticks. */
static int near(real value, real other, const sensor *of, real rate, uint32_t ticks)
{
    return magnitude(value - other) <= of->error + rate * ((real)ticks * TICK);
}

/* Takes a value of a sensor. Returns whether it is believed again. */
static int judge(@prefix@_watched *one, const sensor *of, real value, int valid)
{
    const int is_first = one->same == NEVER, changed = is_first || value != one->last;
    const uint32_t since = counted(one->same), interval = since < SLOWEST_TICKS ? since : SLOWEST_TICKS;
    const int moves = is_first || near(value, one->last, of, of->rate, interval);
    const int in_range = of->least <= value && value <= of->most;
    const int plausible = valid && is_finite(value) && in_range && moves && (changed || since < STALE_TICKS);
    one->last = value;
    one->same = changed ? 0u : since;
    if (one->lost_for == 0u) {
        if (plausible) {
            one->believed = value;
            if (changed) one->mean += RETURNING * (value - one->mean);
            return 0;
        }
        one->lost_for = 1u;
        one->plausible_for = 0u;
        if (of->is_speed) {
            /* The controller has integrated the noise of a value that did not change. */
            const uint32_t same = one->same < RETURN_TICKS ? one->same : RETURN_TICKS;
            const real share = (real)same / (real)RETURN_TICKS;
            one->believed = one->mean - share * (one->believed - one->mean);
        }
        return 0;
    }
    one->lost_for = counted(one->lost_for);
    const uint32_t longest = one->lost_for < LONGEST_TICKS ? one->lost_for : LONGEST_TICKS;
    const int is_near = near(value, one->believed, of, of->drift, longest);
    one->plausible_for = plausible && is_near ? counted(one->plausible_for) : 0u;
    if (one->plausible_for < REGAINED_TICKS) return 0;
    one->lost_for = 0u;
    one->believed = value;
    one->mean = value;
    return 1;
}

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
