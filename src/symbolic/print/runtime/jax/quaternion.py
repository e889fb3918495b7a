def _quaternion(*r):
    """The unit quaternion, scalar part first and never negative, of a rotation matrix by rows: the column of 4 q q^T with the
    largest diagonal entry, refined by one multiplication."""
    x, y, z = r[7] - r[5], r[2] - r[6], r[3] - r[1]
    xy, xz, yz = r[1] + r[3], r[2] + r[6], r[5] + r[7]
    m = jnp.array([
        [1.0 + r[0] + r[4] + r[8], x, y, z],
        [x, 1.0 + r[0] - r[4] - r[8], xy, xz],
        [y, xy, 1.0 + r[4] - r[0] - r[8], yz],
        [z, xz, yz, 1.0 + r[8] - r[0] - r[4]],
    ])
    start = m[jnp.argmax(jnp.diag(m))]
    q = jnp.sum(m * start, axis=1)
    return q * jnp.where(q[0] < 0.0, -1.0, 1.0) / jnp.sqrt(jnp.sum(q * q))

