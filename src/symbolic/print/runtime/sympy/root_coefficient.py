def root_coefficient(n, b, s):
    """The n-th Taylor coefficient at s >= 0 of cos(sqrt(s)/2) (b = 1) or 2 sin(sqrt(s)/2)/sqrt(s) (b = 3)."""
    s, half = sympify(s), Rational(b, 2)
    if s.is_number:
        factor = Rational(-1, 16) ** n / (factorial(n) * rf(half, n))
        value = factor * hyper((), (half + n,), -s / 16)
        return value.evalf(prec_to_dps(s._prec)) if s.is_Float else value
    x = Dummy("s")
    function = cos(sqrt(x) / 2) if b == 1 else 2 * sin(sqrt(x) / 2) / sqrt(x)
    return (diff(function, x, n) / factorial(n)).subs(x, s)


