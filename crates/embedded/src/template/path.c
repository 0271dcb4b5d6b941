
/* The rate at which the depth changes along the path. */
static real along_path(real speed, real pitch, const real *trim)
{
    const int row = row_at(speed);
    const real part = clamp(way(row, speed), 0.0@f@, 1.0@f@);
    return -(speed * (pitch - between(trim[row], trim[row + 1], part)));
}
