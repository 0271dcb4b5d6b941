
/* Whether an actuator has been at its limit for so long that the references of what it steers yield. */
static int held(const @prefix@_state *state, int actuator)
{
    return state->held[actuator] % 2 == 1 && state->held[actuator] / 2 >= HELD;
}

/* Counts a tick of each actuator. */
static void count(@prefix@_state *state, const real *excess)
{
    for (int j = 0; j < COMMANDS; j++) {
        const int is_beyond_now = excess[j] != 0.0@f@;
        int ticks = state->held[j] / 2;
        if (is_beyond_now)
            ticks += ticks < HELD;
        else
            ticks -= ticks > 0;
        state->held[j] = 2 * ticks + is_beyond_now;
    }
}
