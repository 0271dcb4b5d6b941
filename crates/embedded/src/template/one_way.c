
/* Whether an actuator is beyond its limit with one of the values, or was in the ticks before. */
static int is_beyond(const @prefix@_state *before, const real *values, int j)
{
    return values[j] < MINIMUM[j] || values[j] > MAXIMUM[j] || (before && before->held[j] > 1);
}

static real lesser(real a, real b) { return a < b ? a : b; }

static real greater(real a, real b) { return a > b ? a : b; }
