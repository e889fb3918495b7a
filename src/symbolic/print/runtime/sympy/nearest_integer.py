def nearest_integer(x):
    """The nearest integer, halves away from zero."""
    return sign(x) * floor(Abs(x) + Rational(1, 2))


