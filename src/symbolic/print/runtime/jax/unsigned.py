def _unsigned(x):
    """x, with 0 for -0: half a turn is then +pi."""
    return jnp.where(x == 0.0, 0.0, x)

