
/* The same for the rows i and i + 1, a block of T with two complex eigenvalues. */
static int solve_two(int i, real theta, real *z)
{
    const real a = 1.0@f@ - theta * LOOP[i][i], d = 1.0@f@ - theta * LOOP[i + 1][i + 1];
    const real above = -theta * LOOP[i][i + 1], below = -theta * LOOP[i + 1][i];
    const real left = z[i] + known(LOOP[i], i + 2, theta, z);
    const real right = z[i + 1] + known(LOOP[i + 1], i + 2, theta, z);
    const real determinant = a * d - above * below;
    const real rounding = PRECISION * (1.0@f@ + magnitude(1.0@f@ - a) + magnitude(1.0@f@ - d));
    const real cancelled = PRECISION * (magnitude(a * d) + magnitude(above * below));
    if (!(magnitude(determinant) > cancelled + rounding * rounding)) return 0;
    z[i] = (d * left - above * right) / determinant;
    z[i + 1] = (a * right - below * left) / determinant;
    return 1;
}
