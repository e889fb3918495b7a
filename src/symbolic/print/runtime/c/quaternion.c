/* The unit quaternion q, q[0] >= 0, of a rotation matrix r by rows: the column of 4 q q^T with the largest diagonal entry,
 * refined by one multiplication. */
static void pintle_quaternion(const double r[9], double q[4])
{
    const double x = r[7] - r[5], y = r[2] - r[6], z = r[3] - r[1];
    const double xy = r[1] + r[3], xz = r[2] + r[6], yz = r[5] + r[7];
    const double m[4][4] = {
        {1.0 + r[0] + r[4] + r[8], x, y, z},
        {x, 1.0 + r[0] - r[4] - r[8], xy, xz},
        {y, xy, 1.0 + r[4] - r[0] - r[8], yz},
        {z, xz, yz, 1.0 + r[8] - r[0] - r[4]},
    };
    double square = 0.0;
    int i, k = 0;
    for (i = 1; i < 4; ++i) {
        if (m[i][i] > m[k][k]) {
            k = i;
        }
    }
    for (i = 0; i < 4; ++i) {
        q[i] = m[i][0] * m[k][0] + m[i][1] * m[k][1] + m[i][2] * m[k][2] + m[i][3] * m[k][3];
        square += q[i] * q[i];
    }
    square = (q[0] < 0.0 ? -1.0 : 1.0) / sqrt(square);
    for (i = 0; i < 4; ++i) {
        q[i] *= square;
    }
}
