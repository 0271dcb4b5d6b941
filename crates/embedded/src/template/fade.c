/* What is left of the difference of a reference from what is asked. */
static real fade(real difference, real negligible)
{
    const real next = FADE * difference;
    return magnitude(next) > negligible ? next : 0.0@f@;
}

