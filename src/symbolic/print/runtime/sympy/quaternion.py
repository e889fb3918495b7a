def quaternion(*r):
    """The unit quaternion, scalar part first and never negative, of a rotation matrix by rows.

    On symbols w = sqrt(1 + tr R)/2, which is not zero: half turns are left out. On numbers it is the column of 4 q q^T with the
    largest diagonal entry, and holds everywhere.
    """
    r = [sympify(x) for x in r]
    x, y, z = r[7] - r[5], r[2] - r[6], r[3] - r[1]
    xy, xz, yz = r[1] + r[3], r[2] + r[6], r[5] + r[7]
    m = [
        [1 + r[0] + r[4] + r[8], x, y, z],
        [x, 1 + r[0] - r[4] - r[8], xy, xz],
        [y, xy, 1 + r[4] - r[0] - r[8], yz],
        [z, xz, yz, 1 + r[8] - r[0] - r[4]],
    ]
    k = max(range(4), key=lambda i: m[i][i]) if all(x.is_number for x in r) else 0
    q = [m[i][k] / (2 * sqrt(m[k][k])) for i in range(4)]
    if q[0].is_number and q[0] < 0:
        q = [-part for part in q]
    return q


