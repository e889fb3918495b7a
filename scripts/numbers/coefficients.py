# /// script
# requires-python = ">=3.11"
# dependencies = ["mpmath==1.3.0"]
# ///
"""Economised polynomials of src/kinematics/scalar/coefficients.rs.

Near-minimax (Chebyshev) fits, computed with 60 digits, of
  j1(x)/x   and j2(x)/x^2        as polynomials in x^2 on [0, 5]   (spherical Bessel functions; exp of SO(3))
  K'(c)     and K''(c)/2         as polynomials in y = (1-c)/2 on [0, 1/4]
  K(c), K'(c) and K''(c)/2       as polynomials in y on [0, 1/2], for lanes, which have one formula for all of it
  (atan(t) - t)/t^3              as a polynomial in t^2 on [0, tan(pi/8)^2], for lanes
where K(c) = 2 acos(c)/sqrt(1-c^2) (log of SO(3)).

  python scripts/numbers/coefficients.py            writes the Rust file
  python scripts/numbers/coefficients.py --check    compares it with a fresh computation
"""

import sys
from pathlib import Path

from mpmath import atan, chebyfit, fac2, mp, mpf, sqrt

mp.dps = 60
TARGET = Path(__file__).parents[2] / "src/kinematics/scalar/coefficients.rs"


def bessel_ratio(order):
    """j_order(x)/x^order as a function of x^2, by its everywhere convergent series."""

    def g(square):
        term = 1 / fac2(2 * order + 1)
        total = mpf(0)
        for k in range(80):
            total += term
            term *= -square / (2 * (k + 1) * (2 * order + 2 * k + 3))
        return total

    return g


def log_factor(derivative):
    """The derivative-th Taylor coefficient in c of K = 2 sum (2n)!!/(2n+1)!! y^n, y = (1-c)/2."""

    def k(y):
        total, weight = mpf(0), mpf(2)
        for n in range(400):
            if n >= derivative:
                binomial = mpf(1)
                for i in range(derivative):
                    binomial *= mpf(n - i) / (i + 1)
                total += weight * binomial * y ** (n - derivative)
            weight *= mpf(2 * n + 2) / (2 * n + 3)
        return total * mpf(-1) ** derivative / 2**derivative

    return k


def arctangent_rest(square):
    """(atan(t) - t)/t^3 as a function of t^2."""
    if square < mpf(10) ** -20:
        return mpf(-1) / 3 + square / 5
    t = sqrt(square)
    return (atan(t) - t) / t**3


HALF = mpf(1) / 2
TABLE = [
    ("BESSEL_1", "j₁(x)/x, x² in [0, 5], ascending powers of x²", bessel_ratio(1), 5, 9),
    ("BESSEL_2", "j₂(x)/x², x² in [0, 5], ascending powers of x²", bessel_ratio(2), 5, 9),
    ("LOG_1", "K′(c), y = (1 − c)/2 in [0, 1/4], ascending powers of y", log_factor(1), mpf(1) / 4, 16),
    ("LOG_2", "K″(c)/2, y = (1 − c)/2 in [0, 1/4], ascending powers of y", log_factor(2), mpf(1) / 4, 17),
    ("LONG_LOG_0", "K(c), y = (1 − c)/2 in [0, 1/2], ascending powers of y", log_factor(0), HALF, 22),
    ("LONG_LOG_1", "K′(c), y = (1 − c)/2 in [0, 1/2], ascending powers of y", log_factor(1), HALF, 23),
    (
        "LONG_LOG_2",
        "K″(c)/2, y = (1 − c)/2 in [0, 1/2], ascending powers of y − 1/4 (in powers of y its coefficients would cancel)",
        lambda x: log_factor(2)(x + mpf(1) / 4),
        (-mpf(1) / 4, mpf(1) / 4),
        24,
    ),
    (
        "ARCTANGENT",
        "(atan t − t)/t³, t² in [0, tan² π/8], ascending powers of t²",
        arctangent_rest,
        (sqrt(2) - 1) ** 2,
        10,
    ),
]


def rust():
    lines = [
        "//! Economised polynomials for [`crate::scalar::double`] and [`crate::scalar::lanes`]; written by `scripts/numbers/coefficients.py`, which states the fits.",
        "",
    ]
    for name, what, function, end, degree in TABLE:
        start, end = end if isinstance(end, tuple) else (mpf(0), end)
        fit, error = chebyfit(function, [start, end], degree + 1, error=True)
        relative = error / abs(function(end))
        lines.append(f"/// {what}; fit error {mp.nstr(relative * 2**53, 2)} u.")
        lines.append(f"pub(super) const {name}: [f64; {degree + 1}] = [")
        lines += [f"    {float(c)!r}," for c in reversed(fit)]
        lines += ["];", ""]
    return "\n".join(lines)


if __name__ == "__main__":
    text = rust()
    if "--check" in sys.argv:
        if TARGET.read_text() != text:
            sys.exit(f"{TARGET.name} differs from a fresh computation: run scripts/numbers/coefficients.py")
        print(f"{TARGET.name}: {len(TABLE)} polynomials agree")
    else:
        TARGET.write_text(text)
        print(f"wrote {TARGET}")
