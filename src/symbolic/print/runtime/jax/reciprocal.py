def _reciprocal(x):
    """1/x, and 0 where that is infinite: the derivative of least norm at a point that has none."""
    inverse = 1.0 / jnp.asarray(x, dtype=jnp.float64)
    return jnp.where(jnp.isinf(inverse), 0.0, inverse)

