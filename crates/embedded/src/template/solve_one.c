
/* Replaces row i of b by that of z, the rows below being solved; 0 if it is singular to working precision. */
static int solve_one(int i, real theta, real *z)
{
    const real own = theta * LOOP[i][i], d = 1.0@f@ - own;
    const real right = z[i] + known(LOOP[i], i + 1, theta, z);
    if (!(magnitude(d) > PRECISION * (1.0@f@ + magnitude(own)))) return 0;
    z[i] = right / d;
    return 1;
}
