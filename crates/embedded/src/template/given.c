/* What a thruster gives for what it takes, on the line from the last of the points (command, thrust) below it. */
static real given_through(const real (*points)[2], int count, real command)
{
    int above = 0; /* the first point that is */
    for (int i = 0; i < count; i++) above += points[i][0] <= command;
    if (above == 0 || above == count) return points[above == 0 ? 0 : count - 1][1];
    const real *const p = points[above - 1], *const q = points[above];
    return command == q[0] ? q[1] : p[1] + (q[1] - p[1]) * ((command - p[0]) / (q[0] - p[0]));
}

