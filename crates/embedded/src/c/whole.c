/* @title@ */

#include "autopilot.h"

@parts@

/* Keeps the first code that is not OK. */
static void note(int *result, int code)
{
    if (*result == AUTOPILOT_OK) *result = code;
}

/* Init if there are no inputs, otherwise reset; if an axis refuses, state and outputs remain as they were. */
static int begin(autopilot_state *state, const autopilot_inputs *in, autopilot_outputs *out)
{
    autopilot_state fresh;
    autopilot_outputs first;
    int result = AUTOPILOT_OK;
@begin@
    if (result != AUTOPILOT_OK) return result;
    *state = fresh;
    *out = first;
    return result;
}

int autopilot_init(autopilot_state *state, autopilot_outputs *out)
{
    return begin(state, 0, out);
}

int autopilot_reset(autopilot_state *state, const autopilot_inputs *in, autopilot_outputs *out)
{
    return begin(state, in, out);
}

int autopilot_step(autopilot_state *state, const autopilot_inputs *in, autopilot_outputs *out)
{
    int result = AUTOPILOT_OK;
@step@
    return result;
}

int autopilot_follow(autopilot_state *state, const autopilot_inputs *in, const autopilot_commands *applied)
{
    int result = AUTOPILOT_OK;
@follow@
    return result;
}

int autopilot_feed_back(autopilot_state *state, const autopilot_commands *applied)
{
    int result = AUTOPILOT_OK;
@feed_back@
    return result;
}
@safe_of_each@
