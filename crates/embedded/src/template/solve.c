/* The part of row i of (I - theta T) z = b that is known, T quasi-triangular; the latest entry of z is added last. */
static real known(const real *row, int first, real theta, const real *z)
{
    real sum = -0.0@f@;
    for (int k = CHANNELS - 1; k >= first; k--) sum += row[k] * z[k];
    return sum * theta;
}
