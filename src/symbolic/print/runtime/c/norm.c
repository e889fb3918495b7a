/* sqrt(v1^2 + ... + vn^2) without overflow or underflow. */
static double pintle_norm(int n, const double *v)
{
    double square = 0.0, largest = 0.0;
    int i;
    for (i = 0; i < n; ++i) {
        square += v[i] * v[i];
        largest = fmax(largest, fabs(v[i]));
    }
    if (isnan(square) || largest == 0.0 || (square > 1e-280 && square < 1e300)) {
        return sqrt(square);
    }
    square = 0.0;
    for (i = 0; i < n; ++i) {
        square += (v[i] / largest) * (v[i] / largest);
    }
    return largest * sqrt(square);
}
