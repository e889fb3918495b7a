def _norm(*v):
    """sqrt(v1^2 + ... + vn^2) without overflow or underflow."""
    v = jnp.stack([jnp.asarray(x, dtype=jnp.float64) for x in v])
    largest = jnp.max(jnp.abs(v))
    square = jnp.sum(v * v)
    scale = jnp.where((largest == 0.0) | ((square > 1e-280) & (square < 1e300)), 1.0, largest)
    return scale * jnp.sqrt(jnp.sum((v / scale) ** 2))

