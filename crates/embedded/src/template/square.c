
/* What a thruster takes for a thrust, by its square law: thrust = k command |command|. */
static real square(real k, real thrust) { return copysign@f@(sqrt@f@(magnitude(thrust) / k), thrust); }
