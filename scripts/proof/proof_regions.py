"""Parametrizations for scripts/proof/prove.py: states in which directions, lengths and angles are rational in cosines and sines.

A region is a neighbourhood of one sample state. A family draws regions on every branch of the formulas that it serves.
"""

import random
import sys
from dataclasses import dataclass

import mpmath
import sympy
from proof_algebra import Evaluation, Ring
from proof_formulas import State

D = sympy.symbols("d:3")
Q = sympy.Matrix(3, 3, sympy.symbols("Q:3:3"))
Q0 = sympy.Matrix(3, 3, sympy.symbols("Q0_:3:3"))
PHI_REF = sympy.symbols("phi_ref:3")
E_FIXED = sympy.symbols("e_fixed:3")
PSI_A, PSI_B, L0, BETA_S, SIGN, TURNS = sympy.symbols("Psi_a Psi_b l0 beta_s s n_torsion")
INPUTS = {
    "d": D, "Q": Q, "Psi_a": PSI_A, "Psi_b": PSI_B, "Q0": Q0, "l0": L0, "e_fixed": E_FIXED, "beta_s": BETA_S,
    "phi_ref": PHI_REF, "s": SIGN, "n_torsion": TURNS,
}
"""The inputs of an exported module in the directions of a, as symbols."""


def relative_state(turns):
    """The state in which formulas are printed, seen in the directions of a."""
    return State(
        a=sympy.eye(3), b=Q, d=sympy.Matrix(D), flow_a=PSI_A, flow_b=PSI_B, initial=Q0, length=L0, flow_scale=BETA_S,
        euler_sign=SIGN, turns=turns,
    )


@dataclass
class Region:
    """One sample state and its neighbourhood."""

    kind: str
    """What tells the sheets of a formula apart."""
    ring: Ring
    numbers: dict
    angles: list
    turns: int = 0
    is_exact: bool = True
    """Whether to prove here, or only to sample."""

    def evaluation(self):
        return Evaluation(self.ring, self.numbers, self.angles, self.is_exact)


NODE_ANGLES = ["node1", "node2", "node3"]
"""Cardan angles of the orientation of a."""

NODE_POSITIONS = ["X0", "X1", "X2", "U_a0", "U_a1", "U_a2"]

PLAIN = ["d0", "d1", "d2", "Psi_a", "Psi_b", "l0", "beta_s", "phi_ref0", "phi_ref1", "phi_ref2", "e_fixed0", "e_fixed1", "e_fixed2"]


class Draw:
    """Random numbers of 200 bits."""

    def __init__(self, seed):
        self.random = random.Random(seed)
        self.at_nodes = False

    def between(self, low, high):
        return low + (high - low) * mpmath.mpf(self.random.getrandbits(200)) / mpmath.mpf(2) ** 200

    def angles(self, **angles):
        """Those of a family, and those of a."""
        return angles | {name: self.between(0.2, 1.3) for name in NODE_ANGLES} if self.at_nodes else angles

    def state(self):
        names = PLAIN + NODE_POSITIONS if self.at_nodes else PLAIN
        values = {name: self.between(-2, 2) for name in names}
        values["l0"] = self.between(5, 7)
        return values


def about(ring, axis, angle):
    """Rx, Ry or Rz of a combination of angles, as fractions."""
    cosine, sine = ring.cosine_sine(angle)
    one, zero = ring.constant(1), ring.constant(0)
    j, k = (axis + 1) % 3, (axis + 2) % 3
    matrix = [[one if i == j_ else zero for j_ in range(3)] for i in range(3)]
    matrix[j][j], matrix[j][k], matrix[k][j], matrix[k][k] = cosine, -sine, sine, cosine
    return matrix


def times(a, b):
    return [[a[i][0] * b[0][j] + a[i][1] * b[1][j] + a[i][2] * b[2][j] for j in range(3)] for i in range(3)]


def product(first, *rest):
    for matrix in rest:
        first = times(first, matrix)
    return first


def matrix_of(quaternion):
    w, x, y, z = quaternion
    one, two = w.ring.constant(1), w.ring.constant(2)
    return [
        [one - two * (y * y + z * z), two * (x * y - w * z), two * (x * z + w * y)],
        [two * (x * y + w * z), one - two * (x * x + z * z), two * (y * z - w * x)],
        [two * (x * z - w * y), two * (y * z + w * x), one - two * (x * x + y * y)],
    ]


def region(kind, values, angles, build, turns=0, sign=1, d=None):
    """`build(ring)` gives Q, what arctangents may be, and Q0 where it matters."""
    ring = Ring(values, angles)
    q, candidates, q0 = build(ring)
    numbers = {symbol: ring.named(str(symbol)) for symbol in (*D, PSI_A, PSI_B, L0, BETA_S, *PHI_REF, *E_FIXED)}
    if d is not None:
        numbers |= dict(zip(D, d(ring)))
    unit = [[ring.constant(int(i == j)) for j in range(3)] for i in range(3)]
    for i in range(3):
        for j in range(3):
            numbers[Q[i, j]] = q[i][j]
            numbers[Q0[i, j]] = (q0 or unit)[i][j]
    numbers[SIGN] = ring.constant(sign)
    numbers[TURNS] = ring.constant(turns)
    return Region(kind, ring, numbers, [ring.constant(0)] + candidates, turns)


def cardan_build(ring):
    a, b, c = (ring.named(name) for name in ("a", "b", "c"))
    q = product(about(ring, 0, a), about(ring, 1, b), about(ring, 2, c))
    return q, [a, b, c], None


def cardan_regions(draw, count):
    for _ in range(count):
        angles = draw.angles(**{"a": draw.between(-3, 3), "b": draw.between(-1.5, 1.5), "c": draw.between(-3, 3)})
        yield region("Cardan", draw.state(), angles, cardan_build)


def euler_build(ring):
    a, b, c = (ring.named(name) for name in ("a", "b", "c"))
    q = product(about(ring, 2, a), about(ring, 0, b), about(ring, 2, c))
    return q, [a, b, c], None


def euler_regions(draw, count):
    for i in range(count):
        sign = 1 if i % 2 == 0 else -1
        angles = draw.angles(**{"a": draw.between(-3, 3), "b": sign * draw.between(0.1, 3), "c": draw.between(-3, 3)})
        yield region(f"Euler, s = {sign}", draw.state(), angles, euler_build, sign=sign)


def shaft_build(ring):
    """Rz(φ) Ry(α) Rz(ψ) with α = 4f, β = φ + ψ = 4t, χ = (φ − ψ)/2 = x."""
    f, t, x = (ring.named(name) for name in ("f", "t", "x"))
    two, four = ring.constant(2), ring.constant(4)
    q = product(about(ring, 2, two * t + x), about(ring, 1, four * f), about(ring, 2, two * t - x))
    quarter = ring.named("pi") * ring.constant(sympy.Rational(1, 2))
    candidates = [four * f, two * f, f, four * t, two * t, t, two * t + x + quarter]
    return q, candidates, None


def shaft_regions(draw, count):
    quarter = mpmath.pi / 4
    for i in range(count):
        angles = draw.angles(**{"f": draw.between(0.02, 0.97) * quarter, "t": draw.between(-0.97, 0.97) * quarter, "x": draw.between(-3, 3)})
        turns = (0, 0, 1, -2)[i % 4]
        yield region(f"shafts, {turns} turns", draw.state(), angles, shaft_build, turns=turns)


def vector_build(ring):
    """exp(φ^) with φ = 2h n, n by two angles."""
    h, a, b = (ring.named(name) for name in ("h", "a", "b"))
    cos_a, sin_a = ring.cosine_sine(a)
    cos_b, sin_b = ring.cosine_sine(b)
    cos_h, sin_h = ring.cosine_sine(h)
    n = [sin_b * cos_a, sin_b * sin_a, cos_b]
    quaternion = [cos_h] + [sin_h * part for part in n]
    return matrix_of(quaternion), [h, ring.constant(2) * h], None


def vector_regions(draw, count):
    for i in range(count):
        turns = (0, 0, 1, -1)[i % 4]
        angles = draw.angles(**{"h": draw.between(0.05, 1.5), "a": draw.between(-3, 3), "b": draw.between(0.1, 3)})
        values = draw.state()
        length = 2 * angles["h"] + 2 * mpmath.pi * turns
        axis = [
            mpmath.sin(angles["b"]) * mpmath.cos(angles["a"]),
            mpmath.sin(angles["b"]) * mpmath.sin(angles["a"]),
            mpmath.cos(angles["b"]),
        ]
        for k in range(3):
            values[f"phi_ref{k}"] = length * axis[k] * mpmath.mpf("0.99") + mpmath.mpf("0.01") * k
        yield region(f"rotation vector, {turns} turns", values, angles, vector_build, turns=turns)


def frozen_build(ring):
    q, candidates, _ = vector_build(ring)
    # Q = exp(ψ^) Q0 with Q0 = Rx(u) Rz(v).
    u, v = ring.named("u"), ring.named("v")
    q0 = product(about(ring, 0, u), about(ring, 2, v))
    return times(q, q0), candidates, q0


def frozen_regions(draw, count):
    for _ in range(count):
        angles = draw.angles(**{"h": draw.between(0.05, 1.5), "a": draw.between(-3, 3), "b": draw.between(0.1, 3)})
        angles |= {"u": draw.between(-3, 3), "v": draw.between(-3, 3)}
        yield region("frozen", draw.state(), angles, frozen_build)


def length_regions(draw, count):
    def spherical(ring):
        length = ring.named("l")
        (cos_a, sin_a), (cos_b, sin_b) = ring.cosine_sine(ring.named("a")), ring.cosine_sine(ring.named("b"))
        return [length * sin_b * cos_a, length * sin_b * sin_a, length * cos_b]

    for _ in range(count):
        values = draw.state() | {"l": draw.between(0.1, 9)}
        angles = draw.angles(**{"a": draw.between(-3, 3), "b": draw.between(0.1, 3)})
        yield region("length", values, angles, lambda ring: (identity(ring), [], None), d=spherical)


def radial_regions(draw, count):
    def polar(ring):
        r, (cos_a, sin_a) = ring.named("r"), ring.cosine_sine(ring.named("a"))
        return [r * cos_a, r * sin_a, ring.named("d2")]

    for _ in range(count):
        values = draw.state() | {"r": draw.between(0.1, 9)}
        yield region("radius", values, draw.angles(a=draw.between(-3, 3)), lambda ring: (identity(ring), [], None), d=polar)


def identity(ring):
    return [[ring.constant(int(i == j)) for j in range(3)] for i in range(3)]


FAMILIES = {
    "AXIAL": length_regions, "LINK": length_regions, "SLIPRING": length_regions, "RADIAL-THRUST": radial_regions,
    "PROJECTION CARTESIAN": shaft_regions, "PROJECTION FLEXION-TORSION": shaft_regions, "FLEXION-TORSION": shaft_regions,
    "CONSTANT VELOCITY": shaft_regions, "EULER": euler_regions, "ROTATION": vector_regions,
    "ROTATION-ACCELEROMETER": vector_regions,
} | dict.fromkeys(
    ("ACCELEROMETER", "CARTESIAN", "JOIN", "SLIDE-PLANE", "SLOT", "ALIGN", "CARDAN", "FLOW-CONVERTER", "REVOLUTE", "UNIVERSAL"),
    cardan_regions,
)


def regions_for(type_name, component, draw, count, at_nodes=False):
    """The regions that serve a component of a basic type; `at_nodes` with an orientation of a and positions."""
    draw.at_nodes = at_nodes
    if type_name not in FAMILIES:
        sys.exit(f"scripts/proof/proof_regions.py: FAMILIES says not in which regions {type_name} is proven: add it to a family there")
    family = FAMILIES[type_name]
    if type_name == "ALIGN" and component.endswith("_constraint"):
        family = frozen_regions
    return list(family(draw, count))
