/* A limit of a reference; exact where its numbers are the same. */
static real limit(const real *column, int row, real part)
{
    return column[row] + part * (column[row + 1] - column[row]);
}

