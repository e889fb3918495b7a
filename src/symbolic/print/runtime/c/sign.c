/* -1, 0 or 1. */
static double pintle_sign(double x)
{
    return (double)((x > 0.0) - (x < 0.0));
}
