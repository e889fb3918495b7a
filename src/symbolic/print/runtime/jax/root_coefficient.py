def _root_coefficient(n, b, s):
    """The n-th Taylor coefficient at s >= 0 of cos(sqrt(s)/2) (b = 1) or 2 sin(sqrt(s)/2)/sqrt(s) (b = 3)."""
    series = 1.0
    for m in range(40, -1, -1):
        series = 1.0 - series * s / (8.0 * (m + 1) * (b + 2 * (m + n)))
    for m in range(n):
        series = series / (-8.0 * (m + 1) * (b + 2 * m))
    root = jnp.sqrt(s)
    w, k = jnp.cos(0.5 * root), jnp.sin(0.5 * root) / root
    for m in range(n):  # w' = -k/4 and s k' = w/4 - k/2, and their derivatives
        w, k = -k / (4.0 * (m + 1)), (0.25 * w - (m + 0.5) * k) / ((m + 1) * s)
    return jnp.where(s < 16.0, series, w if b == 1 else 2.0 * k)

