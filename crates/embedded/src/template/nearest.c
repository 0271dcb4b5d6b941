/* Of an angle that comes back to itself, the one nearest to another. */
static real nearest(real value, real to)
{
    const real turns = (value - to) / TURN;
    if (!(magnitude(turns) < 1e9@f@)) return value;
    return value - TURN * (real)(long)(turns < 0.0@f@ ? turns - 0.5@f@ : turns + 0.5@f@);
}

