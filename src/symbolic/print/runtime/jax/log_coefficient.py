def _log_coefficient(n, c):
    """The n-th Taylor coefficient of K(c) = 2 acos(c)/sqrt(1 - c^2) at c in (-1, 1]: the rotation vector of the unit quaternion
    (w, v) is K(w) v. For c > 0 the series 2 (-1/2)^n n!/(3/2)_n 2F1(n + 1, n + 1; n + 3/2; (1 - c)/2)."""
    y = 0.5 * (1.0 - c)
    series = 1.0
    for m in range(80 + 2 * n, -1, -1):
        series = 1.0 + series * y * (2.0 * (n + 1 + m) ** 2) / ((2 * n + 3 + 2 * m) * (m + 1))
    series = 2.0 * series
    for m in range(n):
        series = series * -(m + 1.0) / (3.0 + 2.0 * m)
    rest = (1.0 - c) * (1.0 + c)
    before, value = 0.0, 2.0 * jnp.arccos(c) / jnp.sqrt(rest)
    for m in range(n):  # (1 - c^2) K' = c K - 2 and its derivatives
        last = -2.0 if m == 0 else m * before
        before, value = value, ((2 * m + 1) * c * value + last) / ((m + 1) * rest)
    return jnp.where(c > 0.0, series, value)

