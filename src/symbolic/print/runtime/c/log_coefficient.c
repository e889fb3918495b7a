/* The n-th Taylor coefficient of K(c) = 2 acos(c)/sqrt(1 - c^2) at c in (-1, 1]: the rotation vector of the unit quaternion
 * (w, v) is K(w) v. For c > 0 the series 2 (-1/2)^n n!/(3/2)_n 2F1(n + 1, n + 1; n + 3/2; (1 - c)/2). */
static double pintle_log_coefficient(int n, double c)
{
    const double rest = (1.0 - c) * (1.0 + c);
    double before = 0.0, value;
    int m;
    if (c > 0.0) {
        const double y = 0.5 * (1.0 - c);
        value = 1.0;
        for (m = 80 + 2 * n; m >= 0; --m) {
            value = 1.0 + value * y * (2.0 * (n + 1 + m) * (n + 1 + m)) / ((2.0 * n + 3 + 2 * m) * (m + 1));
        }
        value *= 2.0;
        for (m = 0; m < n; ++m) {
            value *= -(m + 1.0) / (3.0 + 2.0 * m);
        }
        return value;
    }
    value = 2.0 * acos(c) / sqrt(rest);
    for (m = 0; m < n; ++m) { /* (1 - c^2) K' = c K - 2 and its derivatives */
        const double next = ((2 * m + 1) * c * value + (m == 0 ? -2.0 : m * before)) / ((m + 1) * rest);
        before = value;
        value = next;
    }
    return value;
}
