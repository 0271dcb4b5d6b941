
/* What a thruster takes for a thrust: on the line from the last of the points (command, thrust) below it to the next. */
static real through(const real (*points)[2], int count, real at_rest, real thrust)
{
    const real t = clamp(thrust, points[0][1], points[count - 1][1]);
    int above = 0; /* so many points are */
    for (int i = 0; i < count; i++) above += t > 0.0@f@ ? points[i][1] < t : points[i][1] <= t;
    if (t == 0.0@f@) return at_rest;
    if (above == 0 || above == count) return points[above == 0 ? 0 : count - 1][0];
    const real *const p = points[above - 1], *const q = points[above];
    return t == q[1] ? q[0] : p[0] + (q[0] - p[0]) * ((t - p[1]) / (q[1] - p[1]));
}
