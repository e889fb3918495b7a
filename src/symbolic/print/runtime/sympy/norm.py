def norm(*v):
    """sqrt(v1^2 + ... + vn^2)."""
    return sqrt(sum(sympify(x) ** 2 for x in v))


