"""Numbers with first and second derivatives, and vectors of them: the arithmetic of the corpus, which shares nothing with pintle."""

import math

import numpy

numpy.seterr(invalid="ignore", over="ignore")


class Jet:
    """A number, its gradient and its second derivatives by some variables."""

    __slots__ = ("g", "h", "v")

    def __init__(self, v, g, h):
        self.v, self.g, self.h = v, g, h

    def lifted(self, f, f1, f2):
        """A function of this number, of which value and derivatives are given."""
        return Jet(f, f1 * self.g, f1 * self.h + f2 * numpy.outer(self.g, self.g))

    def __neg__(self):
        return Jet(-self.v, -self.g, -self.h)

    def __add__(self, other):
        if isinstance(other, Jet):
            return Jet(self.v + other.v, self.g + other.g, self.h + other.h)
        return Jet(self.v + other, self.g, self.h)

    __radd__ = __add__

    def __sub__(self, other):
        return self + -other

    def __rsub__(self, other):
        return -self + other

    def __mul__(self, other):
        if isinstance(other, Jet):
            cross = numpy.outer(self.g, other.g)
            h = self.v * other.h + other.v * self.h + cross + cross.T
            return Jet(self.v * other.v, self.v * other.g + other.v * self.g, h)
        return Jet(self.v * other, self.g * other, self.h * other)

    __rmul__ = __mul__

    def __truediv__(self, other):
        return self * reciprocal(other)

    def __rtruediv__(self, other):
        return reciprocal(self) * other


def variables(values, constant=False):
    """Numbers that are variables themselves; plain numbers where only values are wanted."""
    if constant:
        return [float(v) for v in values]
    size = len(values)
    return [Jet(float(v), numpy.eye(size)[i], numpy.zeros((size, size))) for i, v in enumerate(values)]


def value(x):
    return x.v if isinstance(x, Jet) else float(x)


def reciprocal(x):
    v = 1.0 / value(x) if value(x) else math.inf
    if not isinstance(x, Jet):
        return v
    return x.lifted(v, -v * v, 2 * v * v * v)


def over(x, y):
    """x / y, infinite where y is zero: a routine of doubles does not stop there."""
    return x * reciprocal(y)


def sqrt(x):
    if not isinstance(x, Jet):
        return math.sqrt(x)
    v = math.sqrt(x.v)
    return x.lifted(v, 0.5 / v, -0.25 / (v * x.v)) if v > 0 else x.lifted(0.0, 0.0, 0.0)


def sin(x):
    if not isinstance(x, Jet):
        return math.sin(x)
    return x.lifted(math.sin(x.v), math.cos(x.v), -math.sin(x.v))


def cos(x):
    if not isinstance(x, Jet):
        return math.cos(x)
    return x.lifted(math.cos(x.v), -math.sin(x.v), -math.cos(x.v))


def log(x):
    if not isinstance(x, Jet):
        return math.log(x)
    return x.lifted(math.log(x.v), 1 / x.v, -1 / x.v**2)


def acos(x):
    """As it is called where nobody thinks: NaN beyond 1, infinite slopes at 1."""
    if not isinstance(x, Jet):
        return math.nan if abs(x) > 1 else math.acos(x)
    if not -1 < x.v < 1:
        return x.lifted(math.nan if abs(x.v) > 1 else math.acos(x.v), math.inf, math.inf)
    root = math.sqrt(1 - x.v * x.v)
    return x.lifted(math.acos(x.v), -1 / root, -x.v / root**3)


def asin(x):
    return math.pi / 2 - acos(x)


def atan(x):
    if not isinstance(x, Jet):
        return math.atan(x)
    return x.lifted(math.atan(x.v), 1 / (1 + x.v**2), -2 * x.v / (1 + x.v**2) ** 2)


def atan2(y, x):
    if not isinstance(y, Jet) and not isinstance(x, Jet):
        return math.atan2(y, x)
    if not isinstance(x, Jet):
        x = 0.0 * y + x
    if not isinstance(y, Jet):
        y = 0.0 * x + y
    square = x.v * x.v + y.v * y.v
    fy, fx = x.v / square, -y.v / square
    twice, across = 2 * x.v * y.v / square**2, (y.v * y.v - x.v * x.v) / square**2
    cross = numpy.outer(x.g, y.g)
    h = fy * y.h + fx * x.h - twice * numpy.outer(y.g, y.g) + twice * numpy.outer(x.g, x.g) + across * (cross + cross.T)
    return Jet(math.atan2(y.v, x.v), fy * y.g + fx * x.g, h)


def magnitude(x):
    return x if value(x) >= 0 else -x


def dot(v, w):
    return sum((x * y for x, y in zip(v, w)), 0.0)


def cross(v, w):
    return [v[(i + 1) % 3] * w[(i + 2) % 3] - v[(i + 2) % 3] * w[(i + 1) % 3] for i in range(3)]


def add(v, w):
    return [x + y for x, y in zip(v, w)]


def sub(v, w):
    return [x - y for x, y in zip(v, w)]


def scaled(v, factor):
    return [x * factor for x in v]


def norm(v):
    return sqrt(dot(v, v))


def turned(v, theta):
    """exp(theta^) v to second order in a small rotation, which is all that derivatives at zero need."""
    if not isinstance(theta[0], Jet):
        return v
    once = cross(theta, v)
    return add(add(v, once), scaled(cross(theta, once), 0.5))


def quotient(sine, cosine):
    """angle / sine of an angle of which both are given, sine ≥ 0 by its square `sine`, without a hole at zero."""
    if value(cosine) > 0 and value(sine) < 0.02:
        # asin(x)/x = Σ c x^2n, c the central binomials.
        coefficients, c = [], 1.0
        for n in range(14):
            coefficients.append(c / (2 * n + 1))
            c *= (2 * n + 1) / (2 * n + 2)
        total = coefficients[-1] + 0.0 * sine
        for c in reversed(coefficients[:-1]):
            total = total * sine + c
        return total
    root = sqrt(sine)
    return over(atan2(root, cosine), root)


def quaternion(matrix):
    """(w, x, y, z) of a rotation matrix, of rows of numbers: from its largest entry on the diagonal."""
    m = matrix
    trace = m[0][0] + m[1][1] + m[2][2]
    largest = max(range(4), key=lambda n: value(trace) if n == 3 else value(m[n][n]))
    if largest == 3:
        w = sqrt(trace + 1.0) * 0.5
        return [w, *((m[(k + 2) % 3][(k + 1) % 3] - m[(k + 1) % 3][(k + 2) % 3]) / (4 * w) for k in range(3))]
    i, j, k = largest, (largest + 1) % 3, (largest + 2) % 3
    x = sqrt(m[i][i] - m[j][j] - m[k][k] + 1.0) * 0.5
    q = [(m[k][j] - m[j][k]) / (4 * x), 0, 0, 0]
    q[1 + i], q[1 + j], q[1 + k] = x, (m[i][j] + m[j][i]) / (4 * x), (m[i][k] + m[k][i]) / (4 * x)
    return q if value(q[0]) >= 0 else [-x for x in q]


def rotation_vector(matrix):
    """The principal rotation vector of a rotation matrix."""
    w, *v = quaternion(matrix)
    return scaled(v, 2 * quotient(dot(v, v), w))


def product(a, b):
    """The entries e_i · e_j of two triads, each a list of its directions."""
    return [[dot(x, y) for y in b] for x in a]
