def log_coefficient(n, c):
    """The n-th Taylor coefficient of K(c) = 2 acos(c)/sqrt(1 - c^2) at c in (-1, 1]: the rotation vector of the unit quaternion
    (w, v) is K(w) v.

    On symbols the derivative of this formula; on numbers 2 (-1/2)^n n!/(3/2)_n 2F1(n + 1, n + 1; n + 3/2; (1 - c)/2), regular at c = 1.
    """
    c = sympify(c)
    if c.is_number:
        factor = 2 * Rational(-1, 2) ** n * factorial(n) / rf(Rational(3, 2), n)
        value = factor * hyper((n + 1, n + 1), (n + Rational(3, 2),), (1 - c) / 2)
        return value.evalf(prec_to_dps(c._prec)) if c.is_Float else value
    x = Dummy("c")
    return (diff(2 * acos(x) / sqrt(1 - x**2), x, n) / factorial(n)).subs(x, c)


