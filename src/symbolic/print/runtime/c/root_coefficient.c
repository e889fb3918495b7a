/* The n-th Taylor coefficient at s >= 0 of cos(sqrt(s)/2) (b = 1) or 2 sin(sqrt(s)/2)/sqrt(s) (b = 3). */
static double pintle_root_coefficient(int n, int b, double s)
{
    double value = 1.0, w, k;
    int m;
    if (s < 16.0) {
        for (m = 40; m >= 0; --m) {
            value = 1.0 - value * s / (8.0 * (m + 1) * (b + 2 * (m + n)));
        }
        for (m = 0; m < n; ++m) {
            value /= -8.0 * (m + 1) * (b + 2 * m);
        }
        return value;
    }
    w = cos(0.5 * sqrt(s));
    k = sin(0.5 * sqrt(s)) / sqrt(s);
    for (m = 0; m < n; ++m) { /* w' = -k/4 and s k' = w/4 - k/2, and their derivatives */
        const double next = -k / (4.0 * (m + 1));
        k = (0.25 * w - (m + 0.5) * k) / ((m + 1) * s);
        w = next;
    }
    return b == 1 ? w : 2.0 * k;
}
