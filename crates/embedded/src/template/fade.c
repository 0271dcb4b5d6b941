/* Moves a reference on by a tick on its way from a start to a target. */
static void fade(real *share, real start, real target, real negligible)
{
    if (*share == 0.0@f@) return;
    *share *= FADE;
    const real left = between(target, start, *share) - target;
    if (magnitude(left) <= negligible) *share = 0.0@f@;
}
