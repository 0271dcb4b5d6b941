/* What the actuators got, as the tables have it and within their limits; 0 if it is no number or far beyond them. */
static int read(const @prefix@_commands *applied, real *got)
{
    if (!(@applied_finite@)) return 0;
@read@
    for (int j = 0; j < COMMANDS; j++) {
        if (!(magnitude(got[j]) <= LARGEST_APPLIED[j])) return 0;
        got[j] = clamp(got[j], MINIMUM[j], MAXIMUM[j]);
    }
    return 1;
}

/* Brings the state, by F, to where the controller commands less of its excess. */
static void correct(@prefix@_state *state, const tick *t)
{
    (void)state, (void)t; /* not every controller can follow */
@correct@
}

/* Cuts off commands beyond the range that is open, and adds to their excess; returns whether any is. */
static int cut_off(const @prefix@_state *state, tick *t)
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

/* The outputs of a tick soon after following. */
static int compute_opening(@prefix@_state *state, const @prefix@_inputs *in, tick *t)
{
    int code = compute(state, in, 0, t);
    if (code != @PREFIX@_OK || !cut_off(state, t)) return code;
    @prefix@_state next = *state;
    correct(&next, t);
    code = compute(&next, in, 0, t);
    if (code != @PREFIX@_OK) return code;
    cut_off(&next, t);
    for (int j = 0; j < COMMANDS; j++) t->excess[j] = 0.0@f@;
    t->status &= ~(@PREFIX@_SATURATED | @all_saturated@);
    *state = next;
    return code;
}

/* Brings the state to where the next tick commands what the actuators got. */
static int follow(@prefix@_state *state, const @prefix@_inputs *in, const real *got)
{
    @prefix@_state next = *state;
    tick t;
    if (!(@all_finite@)) return @PREFIX@_BAD_INPUT;

@begin@
@free@
    const int code = compute(&next, in, 0, &t);
    if (code != @PREFIX@_OK) return code;
@keep@
    for (int j = 0; j < COMMANDS; j++) t.excess[j] += (t.commands[j] - got[j]) / SCALE[j];
    correct(&next, &t);
    for (int j = 0; j < COMMANDS; j++) next.anchor[j] = got[j];
    next.followed_for = 0;
@wait@
    *state = next;
    return code;
}

@functions_of_sensors@

int @prefix@_follow(@prefix@_state *state, const @prefix@_inputs *in, const @prefix@_commands *applied)
{
    real got[COMMANDS];
    if (!read(applied, got)) return @PREFIX@_BAD_INPUT;
@follow_with_sensors@
}

int @prefix@_feed_back(@prefix@_state *state, const @prefix@_commands *applied)
{
    real got[COMMANDS];
    if (!read(applied, got)) return @PREFIX@_BAD_INPUT;
@if_failed@
@feed_back@
    return @PREFIX@_OK;
}

