# /// script
# requires-python = ">=3.11"
# dependencies = ["mpmath==1.3.0"]
# ///
"""Reference values of the elementary functions and of SO(3): verify/golden/numerics.json and numerics.bin.

Every function is computed with at least 130 decimal digits on jets (value, first and second derivatives) of its own,
from textbook formulas, at doubles taken exactly. Rotations enter as their rounded matrix or quaternion; the reference is
the function of the nearest exact rotation (polar factor, q/|q|), its derivatives are along R(e) = exp(e^) R.

Beside each number f stands its conditioned scale S = |f| + sum |x_i| |df/dx_i| over all input doubles x_i (and, for the
second derivative of a log, max |J| of that component: the seeds d2R/de2 are rounded inputs too). An error of u S,
u = 2^-53, is what rounding the inputs once may cause.

The JSON file lists, per function, the counts; the binary file holds little-endian records: the inputs (float64), then
per output component the value, the first derivatives and the second derivatives (11, 12, ... in rows of the upper
triangle), each as float64 (rounded), float64 (S) and float32 (what the rounding left, in units u S).

  python scripts/numbers/numerics_golden.py            writes both files
  python scripts/numbers/numerics_golden.py --check    compares them with a fresh computation
"""

import json
import random
import struct
import sys
from pathlib import Path

import mpmath
from mpmath import mp, mpf

SEED = 20
STEP = mpf(10) ** -30  # relative perturbation of an input, for S only
FOLDER = Path(__file__).parents[2] / "verify/golden"
mp.dps = 130


# ---------------------------------------------------------------------------------------------------------------- jets
class Jet:
    """A number with first and second derivatives in n variables; the Hessian as its upper triangle in rows."""

    def __init__(self, value, gradient, hessian):
        self.value, self.gradient, self.hessian = value, gradient, hessian

    @staticmethod
    def constant(x, n):
        return Jet(mpf(x), [mpf(0)] * n, [mpf(0)] * (n * (n + 1) // 2))

    @staticmethod
    def variables(xs):
        jets = [Jet.constant(x, len(xs)) for x in xs]
        for i, jet in enumerate(jets):
            jet.gradient[i] = mpf(1)
        return jets

    @property
    def pairs(self):
        n = len(self.gradient)
        return [(i, j) for i in range(n) for j in range(i, n)]

    def of(self, f0, f1, f2):
        """f(self) for a univariate f with value f0 and derivatives f1, f2 at this point."""
        g = self.gradient
        hessian = [f1 * h + f2 * g[i] * g[j] for h, (i, j) in zip(self.hessian, self.pairs)]
        return Jet(f0, [f1 * d for d in g], hessian)

    def lift(self, other):
        return other if isinstance(other, Jet) else Jet.constant(other, len(self.gradient))

    def __add__(self, other):
        other = self.lift(other)
        return Jet(
            self.value + other.value,
            [a + b for a, b in zip(self.gradient, other.gradient)],
            [a + b for a, b in zip(self.hessian, other.hessian)],
        )

    def __mul__(self, other):
        if not isinstance(other, Jet):
            return Jet(self.value * other, [g * other for g in self.gradient], [h * other for h in self.hessian])
        a, b, f, g = self.value, other.value, self.gradient, other.gradient
        return Jet(
            a * b,
            [a * y + b * x for x, y in zip(f, g)],
            [
                a * k + b * h + f[i] * g[j] + f[j] * g[i]
                for h, k, (i, j) in zip(self.hessian, other.hessian, self.pairs)
            ],
        )

    __radd__, __rmul__ = __add__, __mul__

    def __neg__(self):
        return self * -1

    def __sub__(self, other):
        return self + -self.lift(other)

    def __rsub__(self, other):
        return -self + other

    def numbers(self):
        return [self.value, *self.gradient, *self.hessian]


def sqrt(x):
    r = mp.sqrt(x.value)
    return x.of(r, 1 / (2 * r), -1 / (4 * r**3))


def inverse_sqrt(x):
    r = mp.sqrt(x.value)
    return x.of(1 / r, -1 / (2 * r**3), 3 / (4 * r**5))


def recip(x):
    v = x.value
    return x.of(1 / v, -1 / v**2, 2 / v**3)


def sin(x):
    s, c = mp.sin(x.value), mp.cos(x.value)
    return x.of(s, c, -s)


def cos(x):
    s, c = mp.sin(x.value), mp.cos(x.value)
    return x.of(c, -s, -c)


def atan2(y, x):
    a, b = y.value, x.value
    r2 = a * a + b * b
    fy, fx = b / r2, -a / r2
    fyy, fxy = -2 * a * b / r2**2, (a * a - b * b) / r2**2
    p, q = y.gradient, x.gradient
    return Jet(
        mp.atan2(a, b),
        [fy * i + fx * j for i, j in zip(p, q)],
        [
            fy * h + fx * k + fyy * (p[i] * p[j] - q[i] * q[j]) + fxy * (p[i] * q[j] + p[j] * q[i])
            for h, k, (i, j) in zip(y.hessian, x.hessian, y.pairs)
        ],
    )


def series(x, coefficient):
    """sum c_n x^n for a small x, from coefficient(n)."""
    v, total, power, n = x.value, [mpf(0)] * 3, mpf(1), 0
    while n < 4 or abs(power) > mpf(10) ** (-mp.dps - 5):
        c = [coefficient(n + k) for k in range(3)]
        total[0] += c[0] * power
        total[1] += (n + 1) * c[1] * power
        total[2] += (n + 1) * (n + 2) * c[2] * power
        power *= v
        n += 1
    return x.of(*total)


def dot(u, v):
    return sum((a * b for a, b in zip(u[1:], v[1:])), u[0] * v[0])


# ----------------------------------------------------------------------------------------------------------- functions
SMALL = mpf(10) ** -4  # where power series take over
ZERO = mpf(10) ** -100  # what is left of an exact zero


def norm(v):
    return sqrt(dot(v, v))


def direction(v):
    inverse = recip(norm(v))
    return [x * inverse for x in v]


def exp_quaternion(phi):
    s = dot(phi, phi)
    if s.value < SMALL:
        w = series(s, lambda n: mpf(-1) ** n / (mpf(4) ** n * mp.factorial(2 * n)))
        k = series(s, lambda n: mpf(-1) ** n / (2 * mpf(4) ** n * mp.factorial(2 * n + 1)))
    else:
        theta = sqrt(s)
        half = theta * mpf(0.5)
        w, k = cos(half), sin(half) * recip(theta)
    return [w, *(k * p for p in phi)]


def exp_matrix(phi):
    """I + (sin t/t) P + ((1 - cos t)/t^2) P^2, P = phi^, t = |phi|."""
    s = dot(phi, phi)
    if s.value < SMALL:
        a = series(s, lambda n: mpf(-1) ** n / mp.factorial(2 * n + 1))
        b = series(s, lambda n: mpf(-1) ** n / mp.factorial(2 * n + 2))
    else:
        theta = sqrt(s)
        a, b = sin(theta) * recip(theta), (1 - cos(theta)) * recip(s)
    x, y, z = phi
    zero = Jet.constant(0, len(x.gradient))
    p = [[zero, -z, y], [z, zero, -x], [-y, x, zero]]
    square = [[dot(p[i], [p[k][j] for k in range(3)]) for j in range(3)] for i in range(3)]
    return [a * p[i][j] + b * square[i][j] + (1 if i == j else 0) for i in range(3) for j in range(3)]


def log_quaternion(q, turn=0):
    """(theta + 2 pi turn) v/|v| of the unit quaternion (w, v), w >= 0."""
    if q[0].value < 0:
        q = [-c for c in q]
    w, v = q[0], q[1:]
    s = dot(v, v)
    if s.value < SMALL:
        # asin(x)/x = sum (2n)!/(4^n n!^2 (2n + 1)) x^2n
        k = series(s, lambda n: 2 * mp.binomial(2 * n, n) / (mpf(4) ** n * (2 * n + 1)))
    else:
        r = sqrt(s)
        k = 2 * atan2(r, w) * recip(r)
    phi = [k * c for c in v]
    if turn:
        phi = [p + 2 * mp.pi * turn * d for p, d in zip(phi, direction(v))]
    return phi


def product(p, q):
    return [
        p[0] * q[0] - p[1] * q[1] - p[2] * q[2] - p[3] * q[3],
        p[0] * q[1] + p[1] * q[0] + p[2] * q[3] - p[3] * q[2],
        p[0] * q[2] + p[2] * q[0] + p[3] * q[1] - p[1] * q[3],
        p[0] * q[3] + p[3] * q[0] + p[1] * q[2] - p[2] * q[1],
    ]


def turned(q):
    """exp(e^) q for the real quaternion q, at e = 0: the seed of derivatives along the rotation."""
    e = Jet.variables([0, 0, 0])
    w = 1 - dot(e, e) * mpf(0.125)
    return product([w, *(c * mpf(0.5) for c in e)], [Jet.constant(c, 3) for c in q])


def turned_matrix(m):
    """(I + E + E^2/2) m, E = e^, for the real matrix m."""
    rows = [[Jet.constant(c, 3) for c in row] for row in m]
    x, y, z = Jet.variables([0, 0, 0])
    zero = Jet.constant(0, 3)
    e = [[zero, -z, y], [z, zero, -x], [-y, x, zero]]

    def times(a, b):
        return [[dot(a[i], [b[k][j] for k in range(3)]) for j in range(3)] for i in range(3)]

    first = times(e, rows)
    second = times(e, first)
    return [[rows[i][j] + first[i][j] + second[i][j] * mpf(0.5) for j in range(3)] for i in range(3)]


def unit(q):
    r = mp.sqrt(sum(c * c for c in q))
    return [c / r for c in q]


def polar(entries):
    """The rotation nearest to a rounded rotation matrix, by Newton's iteration X <- (X + X^-T)/2."""
    x = mpmath.matrix([[entries[3 * i + j] for j in range(3)] for i in range(3)])
    for _ in range(5):
        x = (x + (x**-1).T) / 2
    return x


def quaternion(r):
    """The unit quaternion of a real rotation matrix, by way of its largest component."""
    squares = [
        1 + r[0, 0] + r[1, 1] + r[2, 2],
        *(1 + 2 * r[i, i] - (r[0, 0] + r[1, 1] + r[2, 2]) for i in range(3)),
    ]
    largest = max(range(4), key=lambda i: squares[i])
    axial = [r[2, 1] - r[1, 2], r[0, 2] - r[2, 0], r[1, 0] - r[0, 1]]
    if largest == 0:
        q = [squares[0], *axial]
    else:
        i = largest - 1
        w = axial[i] if abs(axial[i]) > ZERO else mpf(0)
        q = [w, *(r[i, j] + r[j, i] if j != i else squares[largest] for j in range(3))]
    return unit(q)


def log_matrix(entries):
    return log_quaternion(turned(quaternion(polar(entries))))


def rows(entries):
    return [list(entries[3 * i : 3 * i + 3]) for i in range(3)]


def cardan(entries):
    r = turned_matrix(rows(entries))
    return [
        atan2(-r[1][2], r[2][2]),
        atan2(r[0][2], norm([r[1][2], r[2][2]])),
        atan2(-r[0][1], r[0][0]),
    ]


def euler(entries, s):
    r = turned_matrix(rows(entries))
    return [
        atan2(r[0][2] * s, -r[1][2] * s),
        atan2(norm([r[0][2], r[1][2]]), r[2][2]) * s,
        atan2(r[2][0] * s, r[2][1] * s),
    ]


# -------------------------------------------------------------------------------------------------------------- inputs
def powers(rng, count, low, high):
    return [rng.choice([-1, 1]) * 10 ** rng.uniform(low, high) for _ in range(count)]


def directions(rng):
    """Axes, diagonals, nearly axial and random unit vectors."""
    fixed = [(1, 0, 0), (0, -1, 0), (0, 0, 1), (1, 1, 0), (1, -1, 1), (1, 1e-9, 0), (1e-5, 1, -1e-12), (3e-17, 2e-8, 1)]
    some = [[rng.gauss(0, 1) for _ in range(3)] for _ in range(8)]
    return [unit([mpf(c) for c in d]) for d in [*fixed, *some]]


def near(centre, smallest):
    """centre, and centre -+ 10^-k down to `smallest`."""
    deltas = [mpf(10) ** -k for k in range(1, smallest + 1, 3)] + [mpf(10) ** -smallest]
    return [centre, *(centre - d for d in deltas), *(centre + d for d in deltas)]


def angles_to_pi():
    small = [mpf(0), *(mpf(10) ** -k for k in (16, 15, 12, 10, 8, 7, 6, 5, 4, 3, 2, 1))]
    between = [mpf(x) for x in (0.3, 0.7, 1.1, 1.5, 1.8, 2.1, 2.6, 3.0)] + [mp.pi / 2, 2 * mp.pi / 3]
    return small + between + near(mp.pi, 17)


def rounded(numbers):
    return [float(x) if abs(x) > ZERO else 0.0 for x in numbers]


def spread(values, per_value, rng):
    """Each angle with several directions, all directions in use."""
    all_directions = directions(rng)
    order, at = [], 0
    for value in values:
        for _ in range(per_value):
            order.append((value, all_directions[at % len(all_directions)]))
            at += 1
    return order


def real_exp(phi):
    return [j.value for j in exp_quaternion([Jet.constant(p, 1) for p in phi])]


def real_exp_matrix(phi):
    return [j.value for j in exp_matrix([Jet.constant(p, 1) for p in phi])]


def inputs_scalar(rng):
    return [[abs(x)] for x in powers(rng, 40, -300, 300)] + [[1.0], [0.5], [2.0], [4.0], [1e-300], [1e300]]


def inputs_angle(rng):
    return [[x] for x in [0.0, *powers(rng, 40, -16, 6), *rounded(near(mp.pi, 15)), *rounded(near(mp.pi / 2, 15))]]


def inputs_vector(n):
    def inputs(rng):
        cases = [[c if k == i else 0.0 for k in range(n)] for i in range(n) for c in (1.0, -1.0, 1e300, -1e-300)]
        for _ in range(60):
            scale = 10 ** rng.uniform(-300, 299)
            cases.append([scale * x for x in powers(rng, n, -rng.choice([0.1, 3, 20]), 0)])
        if n == 2:
            cases += [[1.0, x] for x in powers(rng, 16, -17, 0)] + [[x, -1.0] for x in powers(rng, 16, -17, 0)]
        return cases

    return inputs


def inputs_exp(rng):
    angles = angles_to_pi() + near(2 * mp.pi, 15) + [mpf(x) for x in (4.4, 4.5, 9.0, 50.0, 1e3, 1e4, 123456.7, 1e6)]
    return [rounded(t * c for c in d) for t, d in spread(angles, 4, rng)]


def inputs_log_quaternion(rng):
    return [rounded(real_exp([t * c for c in d])) for t, d in spread(angles_to_pi(), 4, rng)]


def inputs_log_matrix(rng):
    return [rounded(real_exp_matrix([t * c for c in d])) for t, d in spread(angles_to_pi(), 4, rng)]


def inputs_continuous(rng, rotation=real_exp):
    """The rotation, then the reference (3) that selects the turn."""
    cases = []
    angles = near(2 * mp.pi, 15)[1:] + near(mp.pi, 9) + near(3 * mp.pi, 9) + near(20 * mp.pi, 15)[1:]
    angles += [mpf(x) for x in (3.5, 4.5, 5.5, 8.0, 100.0, 6283.0, 62831.0)]
    for t, d in spread(angles, 3, rng):
        from_reference = t + mpf(rng.choice([-1, 1])) / 3
        cases.append(rounded(rotation([t * c for c in d])) + rounded(from_reference * c for c in d))
    return cases


def inputs_continuous_matrix(rng):
    return inputs_continuous(rng, real_exp_matrix)


def continuous_log(q, reference):
    phi = [p.value for p in log_quaternion([Jet.constant(c, 1) for c in q])]
    v = [c if q[0] >= 0 else -c for c in q[1:]]
    r, theta = mp.sqrt(sum(c * c for c in v)), mp.sqrt(sum(p * p for p in phi))
    along = sum(a * b for a, b in zip(v, reference)) / r
    return log_quaternion(turned(q), int(mp.nint((along - theta) / (2 * mp.pi))))


def from_axes(first, second, third):
    """The product of three real rotations about coordinate axes (axis, angle), rounded."""

    def elementary(axis, angle):
        m = mp.eye(3)
        i, j = (axis + 1) % 3, (axis + 2) % 3
        m[i, i] = m[j, j] = mp.cos(angle)
        m[i, j], m[j, i] = -mp.sin(angle), mp.sin(angle)
        return m

    m = elementary(*first) * elementary(*second) * elementary(*third)
    return rounded(m[i, j] for i in range(3) for j in range(3))


def angle_triples(rng, lock):
    deltas = [mpf(10) ** -k for k in range(1, 17)] + [mpf(1), mpf(1) / 2]
    middle = [lock + s * d for d in deltas for s in (-1, 1)] if lock == 0 else [s * (lock - d) for d in deltas for s in (-1, 1)]
    ends = [mpf(0), mp.pi / 2, -mp.pi / 2, mp.pi, mpf(1e-9)]
    for beta in middle:
        for k in range(4):
            alpha = rng.choice(ends) if k == 0 else mpf(rng.uniform(-3.1, 3.1))
            gamma = rng.choice(ends) if k == 1 else mpf(rng.uniform(-3.1, 3.1))
            yield alpha, beta, gamma


def inputs_cardan(rng):
    return [from_axes((0, a), (1, b), (2, c)) for a, b, c in angle_triples(rng, mp.pi / 2)]


def inputs_euler(rng):
    cases = []
    for a, b, c in angle_triples(rng, mpf(0)):
        about = rng.choice([mpf(0), mp.pi])
        cases.append(from_axes((2, a), (0, about + b), (2, c)) + [rng.choice([1.0, -1.0])])
    return cases


# Name, function of the exact inputs, inputs, how many of them are rounded numbers (the rest selects a branch),
# and whether S of the second derivative contains the first.
FUNCTIONS = [
    ("sqrt", lambda x: [sqrt(*Jet.variables(x))], inputs_scalar, 1, False),
    ("inverse_sqrt", lambda x: [inverse_sqrt(*Jet.variables(x))], inputs_scalar, 1, False),
    ("recip", lambda x: [recip(*Jet.variables(x))], inputs_scalar, 1, False),
    ("sin_cos", lambda x: [f(*Jet.variables(x)) for f in (sin, cos)], inputs_angle, 1, False),
    ("atan2", lambda x: [atan2(*Jet.variables(x))], inputs_vector(2), 2, False),
    ("norm2", lambda x: [norm(Jet.variables(x))], inputs_vector(2), 2, False),
    ("norm3", lambda x: [norm(Jet.variables(x))], inputs_vector(3), 3, False),
    ("direction3", lambda x: direction(Jet.variables(x)), inputs_vector(3), 3, False),
    ("exp_quaternion", lambda x: exp_quaternion(Jet.variables(x)), inputs_exp, 3, False),
    ("exp_matrix", lambda x: exp_matrix(Jet.variables(x)), inputs_exp, 3, False),
    ("log_quaternion", lambda x: log_quaternion(turned(unit(x))), inputs_log_quaternion, 4, True),
    ("log_matrix", log_matrix, inputs_log_matrix, 9, True),
    ("continuous_log", lambda x: continuous_log(unit(x[:4]), x[4:]), inputs_continuous, 4, True),
    (
        "continuous_log_matrix",
        lambda x: continuous_log(quaternion(polar(x[:9])), x[9:]),
        inputs_continuous_matrix,
        9,
        True,
    ),
    ("cardan", cardan, inputs_cardan, 9, False),
    ("euler", lambda x: euler(x[:9], x[9]), inputs_euler, 9, False),
]


def moved(function, x, i, base):
    """The function where input i has grown by STEP, or shrunk where growing it crosses the cut of a log at half a turn."""

    def at(step):
        return function([c * (1 + step) if k == i else c for k, c in enumerate(x)])

    jets = at(STEP)
    if any(abs(a.value - b.value) > 1 + abs(a.value) for a, b in zip(base, jets)):
        jets = at(-STEP)
    return jets


def without_noise(numbers, jet):
    """What cancels exactly leaves a remainder of mpmath's precision: zero beside the largest number of its order."""
    n = len(jet.gradient)
    for block in (range(1), range(1, 1 + n), range(1 + n, len(numbers[0]))):
        largest = max(abs(component[k]) for component in numbers for k in block)
        for component in numbers:
            for k in block:
                if abs(component[k]) < largest * ZERO:
                    component[k] = mpf(0)
    return numbers


def evaluated(function, inputs, rounded_count, with_first):
    """Per output the jets' numbers and their conditioned scales."""
    x = [mpf(c) for c in inputs]
    base = function(x)
    numbers = without_noise([j.numbers() for j in base], base[0])
    scales = [[abs(c) for c in component] for component in numbers]
    for i in range(rounded_count):
        if x[i] == 0:
            continue
        others = without_noise([j.numbers() for j in moved(function, x, i, base)], base[0])
        for scale, component, other in zip(scales, numbers, others):
            for k, (a, b) in enumerate(zip(component, other)):
                scale[k] += abs(b - a) / STEP
    if with_first:
        for scale, jet in zip(scales, base):
            n = len(jet.gradient)
            largest = max(abs(g) for g in jet.gradient)
            for k in range(1 + n, len(scale)):
                scale[k] += largest
    return numbers, scales


def record(function, inputs, rounded_count, with_first):
    numbers, scales = evaluated(function, inputs, rounded_count, with_first)
    parts = [struct.pack("<d", x) for x in inputs]
    for component, scale in zip(numbers, scales):
        for x, s in zip(component, scale):
            parts.append(struct.pack("<ddf", *split(x, s)))
    return b"".join(parts), len(numbers), len(numbers[0])


def split(x, s):
    """(rounded x, S, what the rounding left in units u S); infinite where x overflows."""
    high = float(x)
    if s == 0 or mpmath.isinf(high):
        return high, abs(high), 0.0
    return high, float(s), float((x - mpf(high)) / s * 2**53)


def compute():
    sections, blob = [], b""
    for name, function, inputs, rounded_count, with_first in FUNCTIONS:
        rng = random.Random(f"{SEED} {name}")
        cases = inputs(rng)
        offset = len(blob)
        for case in cases:
            data, outputs, numbers = record(function, case, rounded_count, with_first)
            blob += data
        sections.append(
            {
                "function": name,
                "cases": len(cases),
                "inputs": len(cases[0]),
                "outputs": outputs,
                "numbers": numbers,
                "offset": offset,
            }
        )
        print(name, len(cases), len(blob), flush=True)
    header = {
        "written by": "scripts/numbers/numerics_golden.py",
        "mpmath": mpmath.__version__,
        "digits": mp.dps,
        "seed": SEED,
        "sections": sections,
    }
    return json.dumps(header, indent=2) + "\n", blob


if __name__ == "__main__":
    header, blob = compute()
    files = {FOLDER / "numerics.json": header.encode(), FOLDER / "numerics.bin": blob}
    if "--check" in sys.argv:
        for path, content in files.items():
            if path.read_bytes() != content:
                sys.exit(f"{path.name} differs from a fresh computation: run scripts/numbers/numerics_golden.py")
        print("golden numbers agree with a fresh computation")
    else:
        FOLDER.mkdir(exist_ok=True)
        for path, content in files.items():
            path.write_bytes(content)
