
/* Whether an actuator has been at its limit for so long that the references of what it steers yield. */
static int held(const @prefix@_state *state, int actuator)
{
    return state->saturated[actuator] && state->held[actuator] >= HELD;
}

/* Counts a tick of each actuator. */
static void count(@prefix@_state *state, const real *excess)
{
    for (int j = 0; j < COMMANDS; j++) {
        state->saturated[j] = excess[j] != 0.0@f@;
        if (state->saturated[j])
            state->held[j] += state->held[j] < HELD;
        else
            state->held[j] -= state->held[j] > 0;
    }
}
