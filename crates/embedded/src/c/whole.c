/* @title@ */

#include "autopilot.h"

@parts@

/* Keeps the first code that is not OK. */
static void note(int *result, int code)
{
    if (*result == AUTOPILOT_OK) *result = code;
}

int autopilot_init(autopilot_state *state, autopilot_outputs *out)
{
    autopilot_state fresh;
    autopilot_outputs first;
    int result = AUTOPILOT_OK;
@init@
    if (result != AUTOPILOT_OK) return result;
    *state = fresh;
    *out = first;
    return result;
}

int autopilot_reset(autopilot_state *state, const autopilot_inputs *in, autopilot_outputs *out)
{
    autopilot_state fresh;
    autopilot_outputs first;
    int result = AUTOPILOT_OK;
@reset@
    if (result != AUTOPILOT_OK) return result;
    *state = fresh;
    *out = first;
    return result;
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
