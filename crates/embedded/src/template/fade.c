/* Moves a reference on by a tick on its way from a start to a target. */
static void fade(@prefix@_transition *of, real target, real negligible)
{
    if (of->share == 0.0@f@) return;
    of->start += TICK * of->rate * of->lag;
    of->share = FADE * (of->share + FADE_STEP * of->lag);
    of->lag *= FADE;
    const real left = between(target, of->start, of->share) - target, moves = FADE_TIME * of->rate * of->lag;
    if (magnitude(left) <= negligible && magnitude(moves) <= negligible) of->share = 0.0@f@;
}
