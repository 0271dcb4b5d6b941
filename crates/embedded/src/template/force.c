/* What the commands that came out last give, by the gain of each. */
static real force(const real *gains, const @prefix@_state *state)
{
    real sum = 0.0@f@;
    for (int j = 0; j < COMMANDS; j++) sum += gains[j] * state->put_out[j];
    return sum;
}
