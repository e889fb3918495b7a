# /// script
# requires-python = ">=3.11"
# dependencies = ["mpmath==1.3.0"]
# ///
"""Reference values of verify/golden/wide.json: what the 237-bit scalar `Wide` must return.

Every input is a decimal of 75 digits and means the binary256 number nearest to it; every output is the function at
exactly that number, with 80 digits. The Taylor coefficients come from hypergeometric functions, which neither `Wide` nor
the f64 scalar uses:
  cos(sqrt(s)/2)             = 0F1(1/2; -s/16)
  sin(sqrt(s)/2)/sqrt(s)     = 0F1(3/2; -s/16)/2
  2 acos(c)/sqrt(1 - c^2)    = 2 2F1(1, 1; 3/2; (1-c)/2)
One coefficient beyond the order that Wide offers is given, for the conditioned scale |f_n| + |x (n+1) f_(n+1)|.

  python scripts/numbers/wide_golden.py            writes the file
  python scripts/numbers/wide_golden.py --check    compares it with a fresh computation
"""

import json
import random
import sys
from fractions import Fraction
from pathlib import Path

import mpmath
from mpmath import atan2, cos, exp, hyp0f1, hyp2f1, mp, mpf, nstr, pi, rf, sin, sqrt

DIGITS, SEED, ORDER = 100, 20261121, 5
TARGET = Path(__file__).parents[2] / "verify/golden/wide.json"
mp.dps = DIGITS
draw = random.Random(SEED)


def exact(x):
    """An mpf as a fraction."""
    sign, mantissa, exponent, _ = x._mpf_
    return Fraction(-mantissa if sign else mantissa) * Fraction(2) ** exponent


def rounded(q, bits=237):
    """The fraction q rounded to the given bits, half to even, as a fraction."""
    if q == 0:
        return q
    exponent = abs(q).numerator.bit_length() - q.denominator.bit_length() - bits
    while abs(q) >= Fraction(2) ** (exponent + bits):
        exponent += 1
    while abs(q) < Fraction(2) ** (exponent + bits - 1):
        exponent -= 1
    return round(q / Fraction(2) ** exponent) * Fraction(2) ** exponent


def number(q):
    """A fraction with a power of two below, as an mpf without rounding."""
    exponent = q.denominator.bit_length() - 1
    assert q.denominator == 1 << exponent
    with mp.workprec(max(mp.prec, q.numerator.bit_length() + 1)):
        return mpf(q.numerator) * mpf(2) ** -exponent


def decimal(value, digits=75):
    """The text of a number, which may be given as a text, a fraction, an mpf or a double."""
    if isinstance(value, str):
        return value
    if isinstance(value, Fraction):
        value = number(value)
    with mp.workdps(digits + 30):
        return nstr(mpf(value), digits)


class Input:
    """A decimal and the binary256 number that it means."""

    def __init__(self, value):
        self.text = decimal(value)
        self.fraction = rounded(Fraction(self.text))
        self.value = number(self.fraction)


def out(value):
    return nstr(value, 80)


def log_uniform(low, high, signed=True):
    magnitude = mpf(10) ** (mpf(low) + mpf(draw.random()) * (high - low)) * (1 + mpf(draw.getrandbits(240)) / 2**240)
    return -magnitude if signed and draw.random() < 0.5 else magnitude


def uniform(low, high):
    return low + (high - low) * mpf(draw.getrandbits(260)) / 2**260


def doubles(q):
    """Doubles whose sum is q: the nearest, the nearest to the rest, and so on, as bits."""
    parts = []
    for _ in range(5):
        part = float(q)
        parts.append(bits(part))
        q -= Fraction(part)
    assert q == 0
    return parts


def bits(x):
    import struct

    return struct.pack(">d", x).hex()


def parse():
    values = [mpf(1) / 3, pi, "1e75", "0.1", "-2.5e-7", "1" + "0" * 90] + [log_uniform(-200, 300) for _ in range(20)]
    return [[x.text, doubles(x.fraction)] for x in map(Input, values)]


def to_f64():
    ulp, tiny = Fraction(1, 2**52), Fraction(1, 2**1074)
    rest = Fraction(1, 2**180)
    one = [1 + ulp / 2, 1 + ulp / 2 + rest, 1 + ulp / 2 - rest, 1 + 3 * ulp / 2, 1 + 3 * ulp / 2 - rest, 2 - ulp / 2]
    one += [2 - ulp / 2 - rest, 1 + ulp / 2 + Fraction(1, 2**236), 1 + 3 * ulp / 2 - Fraction(1, 2**236)]
    subnormal = [tiny / 2, tiny * (1 + rest) / 2, tiny * (1 - rest) / 2, tiny / 4, tiny * 3 / 4, tiny * 3 / 2, tiny * 5 / 2]
    subnormal += [tiny * (2**52) - tiny / 2, tiny * (2**52 - 1), tiny * (2**52), tiny * (2**30 + Fraction(1, 2)), tiny / 2**40]
    top = Fraction(2) ** 1024
    large = [top - Fraction(2) ** 970, (top - Fraction(2) ** 970) * (1 - Fraction(1, 2**200)), top - Fraction(2) ** 971]
    large += [top, top * 2**3000]
    rows = []
    for q in one + subnormal + large + [exact(log_uniform(-324, 309)) for _ in range(25)]:
        for sign in (1, -1):
            # The sum of decimals may need more than 75 digits to be exact: a product of integers and a power of two is not.
            q = rounded(q)
            try:
                nearest = float(sign * q)
            except OverflowError:
                nearest = sign * float("inf")
            mantissa, exponent = q.numerator, 1 - q.denominator.bit_length()
            while mantissa % 2 == 0:
                mantissa, exponent = mantissa // 2, exponent + 1
            rows.append([str(sign * mantissa), exponent, bits(nearest)])
    return rows


def arithmetic():
    pairs = [(log_uniform(-5, 5), log_uniform(-5, 5)) for _ in range(15)]
    pairs += [(log_uniform(-300, 300), log_uniform(-300, 300)) for _ in range(10)]
    for digits in (5, 16, 40, 70):
        x = log_uniform(-3, 3)
        pairs.append((x, x * (1 + mpf(10) ** -digits * uniform(0, 1))))
    rows = []
    for a, b in ((Input(a), Input(b)) for a, b in pairs):
        p, q = a.fraction, b.fraction
        results = [decimal(rounded(r), 80) for r in (p + q, p - q, p * q, p / q)]
        rows.append([a.text, b.text, results])
    return rows


def square_root():
    values = [1, 2, 3, 4, "1e300", "1e-300", "1e-16", "1e-160", "1e-1000", 2**-1074, 1 - mpf(2) ** -237]
    values += [log_uniform(-300, 300, signed=False) for _ in range(20)] + [uniform(1, 4) for _ in range(10)]
    return [[x.text, out(sqrt(x.value))] for x in map(Input, values)]


def reciprocal():
    values = [1, 2, 3, 7, "-1e300", "1e-300"] + [log_uniform(-300, 300) for _ in range(20)]
    return [[x.text, out(1 / x.value)] for x in map(Input, values)]


def exponential():
    values = [0, 1, -1, "1e-300", "-1e-80", 2 * mp.ln2, -1000 * mp.ln2, mp.ln2 / 2, "709.5", "-99999"]
    values += [log_uniform(-4, 4) for _ in range(20)] + [uniform(-40, 40) for _ in range(10)]
    return [[x.text, out(exp(x.value))] for x in map(Input, values)]


def sine_cosine():
    values = [k * pi / 4 for k in range(-8, 9) if k] + [float(k * pi / 4) for k in range(-8, 9) if k]
    values += ["1e-300", "1e300", "1e22", "1e-9", "9.99999e-10", "-1.00001e-9", 1000 * pi, float(100000 * pi / 2)]
    values += [log_uniform(-e - 1, -e) for e in (1, 4, 8, 9, 10, 16, 40, 76, 77, 80, 100, 139, 140, 141, 148, 150, 160)]
    values += [uniform(-10, 10) for _ in range(20)] + [uniform(-1000000, 1000000) for _ in range(10)]
    rows = []
    for x in map(Input, values):
        with mp.workdps(DIGITS + 330):
            rows.append([x.text, out(sin(x.value)), out(cos(x.value))])
    return rows


def arctangent():
    pairs = []
    for size in (1, "1e300", "1e-300", "0.1", "1e-160"):
        for sy in (1, -1):
            for sx in (1, -1):
                pairs.append((sy * mpf(size), sx * mpf(size)))
    for ratio in (16, 35, 36, 70, 72, 77, 100, 140, 160, 600):
        for sy in (1, -1):
            for sx in (1, -1):
                y, x = sy * log_uniform(-2, 2, False) * mpf(10) ** (-ratio // 2), sx * log_uniform(-2, 2, False) * mpf(10) ** (ratio // 2)
                pairs += [(y, x), (x, y)]
    for k in range(24):
        angle = pi * k / 12
        pairs.append((sin(angle), cos(angle)))
        pairs.append((float(sin(angle)), float(cos(angle))))
    for offset in ("1e-70", "1e-30", "1e-16", "-1e-30", "-1e-70"):
        pairs += [(1, 1 + mpf(offset)), (-1 - mpf(offset), -1)]
    pairs += [(log_uniform(-3, 3), log_uniform(-3, 3)) for _ in range(20)]
    pairs += [(log_uniform(-300, 300), log_uniform(-300, 300)) for _ in range(10)]
    rows = []
    for y, x in ((Input(y), Input(x)) for y, x in pairs):
        # The sum of the half-plane and a tiny quotient needs both in full.
        with mp.workdps(DIGITS + 620):
            rows.append([y.text, x.text, out(atan2(y.value, x.value))])
    return rows


def with_turns():
    turns = [0, 1, -1, 2, -3, 1000003, -1000003, 2**53 + 1, 2**63 - 1, -(2**63)]
    rows = []
    for n in turns:
        for principal in (pi, -pi, 0, log_uniform(-20, 0), uniform(-3, 3)):
            x = Input(principal)
            with mp.workdps(DIGITS + 30):
                rows.append([x.text, n, out(x.value + 2 * pi * n)])
    return rows


def direction_and_norm():
    vectors = [(3, 4, 12), (1, 1, 1), ("1e300", "-1e300", "1e300"), ("1e-300", "1e-300", "-1e-300"), ("1e-300", "1e300", 1)]
    vectors += [[log_uniform(-e, e) for _ in range(3)] for e in (1, 10, 150, 300) for _ in range(4)]
    rows = []
    for v in vectors:
        v = [Input(x) for x in v]
        with mp.workdps(DIGITS + 600):
            norm = sqrt(sum(x.value**2 for x in v))
            rows.append([[x.text for x in v], [out(x.value / norm) for x in v], out(norm)])
    return rows


def exp_series():
    values = [0, "1e-40", "1e-300", "1e-16", "1e-8", "1e-3", 1, 2, 10, 32, 63, 64, 65, 100, "1e3", "1e4", "1e6", "1e9", "1e12"]
    values += [mpf(64) - mpf(2) ** -200]
    for k in range(1, 6):
        values += [(k * pi) ** 2, float((k * pi) ** 2)]
    values += [log_uniform(-4, 4, False) for _ in range(15)] + [uniform(20, 200) for _ in range(15)]
    rows = []
    for s in map(Input, values):
        with mp.workdps(DIGITS + 40):
            series = []
            for b, factor in ((mpf(1) / 2, mpf(1)), (mpf(3) / 2, mpf(1) / 2)):
                series.append(
                    [
                        factor * mpf(-1) ** n / (16**n * rf(b, n) * mp.factorial(n)) * hyp0f1(b + n, -s.value / 16)
                        for n in range(ORDER + 1)
                    ]
                )
            assert abs(series[0][0] - cos(sqrt(s.value) / 2)) < mpf(10) ** -DIGITS
            rows.append([s.text] + [[out(c) for c in coefficients] for coefficients in series])
    return rows


def log_series():
    values = [1, 1 - mpf(10) ** -70, "0." + "9" * 30, "0." + "9" * 16, "0.999", "0.9", "0.75", "0.5", 0.5 - mpf(2) ** -200]
    values += [0.5 + mpf(2) ** -200, "0.25", 0, "1e-30", "-1e-30", "1e-300", "-0.25", "-0.5", "-0.75", "-0.9", "-0.99"]
    values += ["-0." + "9" * 8, "-0." + "9" * 16, "-0." + "9" * 30, "-0." + "9" * 50, 1 - mpf(2) ** -236, 1 - mpf(2) ** -53]
    values += [uniform(-1, 1) for _ in range(20)] + [uniform(mpf(1) / 2, 1) for _ in range(8)]
    rows = []
    for c in map(Input, values):
        with mp.workdps(DIGITS + 60):
            y = (1 - c.value) / 2
            coefficients = [
                2 * (-mpf(1) / 2) ** n * mp.factorial(n) / rf(mpf(3) / 2, n) * hyp2f1(1 + n, 1 + n, mpf(3) / 2 + n, y)
                for n in range(ORDER + 1)
            ]
            rows.append([c.text, [out(k) for k in coefficients]])
    return rows


def document():
    tables = [
        parse, to_f64, arithmetic, square_root, reciprocal, sine_cosine, arctangent, with_turns, direction_and_norm,
        exp_series, log_series, exponential,
    ]  # fmt: skip
    content = {"script": "scripts/numbers/wide_golden.py", "mpmath": mpmath.__version__, "digits": DIGITS, "seed": SEED}
    lines = [json.dumps(content)[:-1] + ","]
    for table in tables:
        rows = ",\n".join("  " + json.dumps(row) for row in table())
        lines.append(f' "{table.__name__}": [\n{rows}\n ]' + ("" if table is tables[-1] else ","))
    return "\n".join(lines) + "\n}\n"


if __name__ == "__main__":
    text = document()
    if "--check" in sys.argv:
        if TARGET.read_text() != text:
            sys.exit(f"{TARGET.name} differs from a fresh computation: run scripts/numbers/wide_golden.py")
        print(f"{TARGET.name}: all values agree")
    else:
        TARGET.parent.mkdir(exist_ok=True)
        TARGET.write_text(text)
        print(f"wrote {TARGET}")
