/* @title@ */

#include "@prefix@.h"

@parts@

/* Keeps the first code that is not OK. */
static void note(int *result, int code)
{
    if (*result == @PREFIX@_OK) *result = code;
}

int @prefix@_init(@prefix@_state *state, @prefix@_outputs *out)
{
    @prefix@_state fresh;
    @prefix@_outputs first;
    int result = @PREFIX@_OK;
@init@
    if (result != @PREFIX@_OK) return result;
    *state = fresh;
    *out = first;
    return result;
}

int @prefix@_reset(@prefix@_state *state, const @prefix@_inputs *in, @prefix@_outputs *out)
{
    @prefix@_state fresh;
    @prefix@_outputs first;
    int result = @PREFIX@_OK;
@reset@
    if (result != @PREFIX@_OK) return result;
    *state = fresh;
    *out = first;
    return result;
}

int @prefix@_step(@prefix@_state *state, const @prefix@_inputs *in, @prefix@_outputs *out)
{
    int result = @PREFIX@_OK;
@step@
    return result;
}

int @prefix@_follow(@prefix@_state *state, const @prefix@_inputs *in, const @prefix@_commands *applied)
{
    int result = @PREFIX@_OK;
@follow@
    return result;
}

int @prefix@_feed_back(@prefix@_state *state, const @prefix@_commands *applied)
{
    int result = @PREFIX@_OK;
@feed_back@
    return result;
}
@safe_of_each@
