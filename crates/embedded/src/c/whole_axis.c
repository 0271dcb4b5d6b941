static @own@_inputs @axis@_inputs(const autopilot_inputs *from)
{
    @own@_inputs to;
@take@
    return to;
}

static @own@_commands @axis@_commands(const autopilot_commands *from)
{
    @own@_commands to;
@apply@
    return to;
}

static void put_@axis@(const @own@_outputs *from, autopilot_outputs *to)
{
@put@
}

static int begin_@axis@(@own@_state *state, const autopilot_inputs *in, autopilot_outputs *out)
{
    @own@_outputs found;
    int code;
    if (in == 0) {
        code = @own@_init(state, &found);
    } else {
        const @own@_inputs own = @axis@_inputs(in);
        code = @own@_reset(state, &own, &found);
    }
    if (code == @OWN@_OK) put_@axis@(&found, out);
    return code;
}

static int step_@axis@(@own@_state *state, const autopilot_inputs *in, autopilot_outputs *out)
{
    const @own@_inputs own = @axis@_inputs(in);
    @own@_outputs found;
    const int code = @own@_step(state, &own, &found);
    if (code == @OWN@_OK) put_@axis@(&found, out);
    return code;
}

static int follow_@axis@(@own@_state *state, const autopilot_inputs *in, const autopilot_commands *applied)
{
    const @own@_inputs own = @axis@_inputs(in);
    const @own@_commands got = @axis@_commands(applied);
    return @own@_follow(state, &own, &got);
}

static int feed_back_@axis@(@own@_state *state, const autopilot_commands *applied)
{
    const @own@_commands got = @axis@_commands(applied);
    return @own@_feed_back(state, &got);
}
