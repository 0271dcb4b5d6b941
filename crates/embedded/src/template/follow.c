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

/* Brings the state to where the next tick commands what the actuators got. */
static int follow(@prefix@_state *state, const @prefix@_inputs *in, const real *got)
{
    @prefix@_state next = *state;
    tick t;
    if (!(@all_finite@)) return @PREFIX@_BAD_INPUT;

@begin@
@free@
    int code;
    for (int k = 0; k < @corrections@; k++) {
        code = compute(&next, in, 0, &t);
        if (code != @PREFIX@_OK) return code;
@keep@
@correct@
    }
@wait@
    code = compute(&next, in, 0, &t);
    if (code != @PREFIX@_OK) return code;
@keep@
@note@
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

