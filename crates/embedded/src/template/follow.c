/* What the actuators got, as the tables have it; 0 if it is no number. */
static int read(const @prefix@_commands *applied, real *got)
{
    if (!(@applied_finite@)) return 0;
@read@
    for (int j = 0; j < COMMANDS; j++)
        if (!is_finite(got[j])) return 0;
    return 1;
}

int @prefix@_follow(@prefix@_state *state, const @prefix@_inputs *in, const @prefix@_commands *applied)
{
    @prefix@_state next = *state;
    tick t;
    real got[COMMANDS];
    if (!(@all_finite@) || !read(applied, got)) return @PREFIX@_BAD_INPUT;

@begin@
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
    *state = next;
    return code;
}

int @prefix@_feed_back(@prefix@_state *state, const @prefix@_commands *applied)
{
    real got[COMMANDS];
    if (!read(applied, got)) return @PREFIX@_BAD_INPUT;
@feed_back@
    return @PREFIX@_OK;
}
