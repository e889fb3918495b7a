/* 1/x, and 0 where that is infinite: the derivative of least norm at a point that has none. */
static double pintle_reciprocal(double x)
{
    const double inverse = 1.0 / x;
    return isinf(inverse) ? 0.0 : inverse;
}
