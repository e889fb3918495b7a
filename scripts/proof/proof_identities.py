"""Identities between printed formulas, and by how much a printed formula differs where a decision sets it aside.

Every claim is a list of pairs whose difference is to be zero. Nothing here asks the program.
"""

from dataclasses import dataclass, field

import mpmath
import sympy
from proof_algebra import Evaluation, Ring
from proof_formulas import (
    bend_axis, rates_to_vector, rodrigues, rotation_vector_of, translator_by_parts, translator_in_one_line,
)
from proof_regions import (
    D, Q, Draw, about, cardan_regions, euler_regions, matrix_of, product, relative_state, shaft_regions, vector_regions,
)
from sympy import Abs, Integer, Matrix, Rational, acos, atan, cos, eye, pi, sin, sqrt, symbols

REGIONS = 4


@dataclass
class Claim:
    """Pairs of expressions that are equal in a region."""

    name: str
    source: str
    cases: list = field(default_factory=list)
    """(evaluation, left, right)."""

    def add(self, evaluation, left, right):
        left, right = Matrix([left]) if not hasattr(left, "shape") else left, Matrix([right]) if not hasattr(right, "shape") else right
        self.cases += [(evaluation, one, other) for one, other in zip(list(left), list(right), strict=True)]


def skew(v):
    return Matrix([[0, -v[2], v[1]], [v[2], 0, -v[0]], [-v[1], v[0], 0]])


def plain(names, values=None, draw=None):
    """Evaluation of expressions in plain symbols."""
    draw = draw or Draw(7)
    values = values or {name: draw.between(mpmath.mpf("0.3"), mpmath.mpf(3)) for name in names}
    ring = Ring(values, {})
    return Evaluation(ring, {sympy.Symbol(name, positive=True): ring.named(name) for name in names})


def rotation(ring, names):
    """A general rotation as a matrix of fractions: half its angle and two angles of its axis."""
    h, a, b = (ring.named(name) for name in names)
    (cos_h, sin_h), (cos_a, sin_a), (cos_b, sin_b) = (ring.cosine_sine(angle) for angle in (h, a, b))
    return matrix_of([cos_h, sin_h * sin_b * cos_a, sin_h * sin_b * sin_a, sin_h * cos_b])


def revolute_constraint(draw):
    """Turning about the turned axis last, or about the axis first, is the same."""
    claim = Claim("C(φJ a) C(φM) = C(φM) C(φJ a0), a = C(φM) a0", "seed MPC Revolute joint")
    rates = Claim("δφS = δφM + δφJ a: dC(φS)/dφJ = a^ C(φS), C(φM) → exp(ε^) C(φM) turns C(φS) by ε", "seed MPC Revolute joint, Equation 1")
    angles = {name: draw.between(0.1, 1.4) for name in ("h", "a", "b", "e", "g", "j")}
    ring = Ring({}, angles)
    c = Matrix(3, 3, symbols("C:3:3"))
    axis, cosine, sine = Matrix(symbols("p:3")), *symbols("cj sj")
    numbers = {}
    master = rotation(ring, ("h", "a", "b"))
    for i in range(3):
        for j in range(3):
            numbers[c[i, j]] = master[i][j]
    (cos_e, sin_e), (cos_g, sin_g) = (ring.cosine_sine(ring.named(name)) for name in "eg")
    numbers |= dict(zip(axis, (sin_g * cos_e, sin_g * sin_e, cos_g)))
    numbers[cosine], numbers[sine] = ring.cosine_sine(ring.named("j"))
    evaluation = Evaluation(ring, numbers)
    current = c * axis
    first, second = rodrigues(current, cosine, sine) * c, c * rodrigues(axis, cosine, sine)
    claim.add(evaluation, first, second)
    # d/dφJ: cos → −sin, sin → cos.
    slope = c * (-sine * eye(3) + cosine * skew(axis) + sine * axis * axis.T)
    rates.add(evaluation, slope, skew(current) * second)
    for i in range(3):
        spin = skew(eye(3)[:, i])
        varied = spin * c
        rates.add(evaluation, varied * rodrigues(axis, cosine, sine), spin * second)
    return [claim, rates]


def universal_constraint(draw):
    """Both axes carried along: the same as the axes in their first places, first the second one."""
    claim = Claim("C(φ2 a2) C(φ1 a1) C(φM) = C(φM) C(φ1 a10) C(φ2 a20)", "MPC Universal joint: a1 = C(φM) a10, a2 = C(φ1 a1) C(φM) a20")
    angles = {name: draw.between(0.1, 1.4) for name in ("h", "a", "b", "j", "k")}
    ring = Ring({}, angles)
    master = Matrix(3, 3, symbols("C:3:3"))
    cosines = symbols("c1 s1 c2 s2")
    entries = rotation(ring, ("h", "a", "b"))
    numbers = {master[i, j]: entries[i][j] for i in range(3) for j in range(3)}
    numbers |= dict(zip(cosines, (*ring.cosine_sine(ring.named("j")), *ring.cosine_sine(ring.named("k")))))
    evaluation = Evaluation(ring, numbers)
    # a10 · a20 = 0; other directions are the same up to a rotation of the model.
    first0, second0 = Matrix([1, 0, 0]), Matrix([0, 1, 0])
    c1, s1, c2, s2 = cosines
    turned = rodrigues(master * first0, c1, s1) * master
    left = rodrigues(turned * second0, c2, s2) * turned
    claim.add(evaluation, left, master * rodrigues(first0, c1, s1) * rodrigues(second0, c2, s2))
    return [claim]


def constraint_moments():
    """The virtual work M_S·δφS + M_M·δφM + M_J δφJ vanishes for M_S = −M_M, M_J = −M_S·a."""
    claim = Claim("M_S·δφS + M_M·δφM + M_J δφJ = 0 with M_S = −M_M, M_J = −M_S·a", "seed MPC Revolute joint (D-20)")
    names = [f"{v}{i}" for v in ("M", "t", "a") for i in range(3)] + ["j"]
    evaluation = plain(names)
    m, theta, a = (Matrix(symbols(f"{v}:3", positive=True)) for v in ("M", "t", "a"))
    j = sympy.Symbol("j", positive=True)
    work = m.dot(theta + j * a) + (-m).dot(theta) + (-m.dot(a)) * j
    claim.add(evaluation, work, Integer(0))
    return [claim]


def revolute_forms(draw):
    """The two dot products, and the second and third Cardan angle."""
    angles = Claim("e1a·e3b = sin β, e1a·e2b = −cos β sin γ: both vanish just where β = γ = 0 (cos β > 0, e1a·e1b > 0)", "seed REVOLUTE, Description")
    same = Claim("|e1a × e1b|² = (e1a·e2b)² + (e1a·e3b)²: both vanish just where e1a = ±e1b", "seed REVOLUTE, Description")
    moment = Claim("at e1a = e1b: δ(e1a·e2b) = −e3b·δθ, δ(e1a·e3b) = e2b·δθ, so that m = m2 e2a + m3 e3a spans them", "seed REVOLUTE, Description")
    for region in cardan_regions(draw, 2):
        evaluation, ring = region.evaluation(), region.ring
        b, c = (sympy.Symbol(name) for name in "bc")
        evaluation = Evaluation(ring, region.numbers | {b: ring.named("b"), c: ring.named("c")})
        s = relative_state(Integer(0))
        angles.add(evaluation, s.r(1, 3), sin(b))
        angles.add(evaluation, s.r(1, 2), -cos(b) * sin(c))
        across = s.ea(1).cross(s.eb(1))
        same.add(evaluation, across.dot(across), s.r(1, 2) ** 2 + s.r(1, 3) ** 2)
    ring = Ring({}, {"a": draw.between(-3, 3)})
    entries = about(ring, 0, ring.named("a"))
    evaluation = Evaluation(ring, {Q[i, j]: entries[i][j] for i in range(3) for j in range(3)})
    s = relative_state(Integer(0))
    for of, other, sign in ((2, 3, -1), (3, 2, 1)):
        # δ(e1a·e_j^b) = e1a·(δθ × e_j^b) = (e_j^b × e1a)·δθ.
        moment.add(evaluation, s.eb(of).cross(s.ea(1)), sign * s.eb(other))
        moment.add(evaluation, s.eb(of)[0], Integer(0))
    return [angles, same, moment]


def revolute_branch(draw):
    """By how much −tan⁻¹ misses the angle, quadrant by quadrant (decision D-1)."""
    claim = Claim("α − (−tan⁻¹(R23/R33)) = 0 for |α| < π/2, ±π beyond: n of both parities; used: atan2", "seed REVOLUTE, Description (D-1)")
    for low, high, n in ((-1.5, 1.5, 0), (1.6, 3.1, 1), (-3.1, -1.6, -1), (3.2, 4.6, 1), (4.8, 7.8, 2), (8.0, 9.4, 3), (-9.4, -8.0, -3)):
        ring = Ring({}, {"a": draw.between(low, high)})
        entries = about(ring, 0, ring.named("a"))
        angle = sympy.Symbol("a")
        evaluation = Evaluation(
            ring, {Q[i, j]: entries[i][j] for i in range(3) for j in range(3)} | {angle: ring.named("a")}, [ring.named("a")]
        )
        claim.add(evaluation, angle + atan(Q[1, 2] / Q[2, 2]), n * pi)
    return [claim]


def translator_forms():
    """F_C by contributions and in one line, and their gradients (decision D-18)."""
    claim = Claim("|m1|/R_r + √(f2² + f3²) + 2√(m2² + m3²)/L = |m1/R_r| + √(f2² + f3²) + √((β m2)² + (β m3)²), β = 2/L", "seed TRANSLATOR, Friction (D-18)")
    gradient = Claim("the same of their gradients by f2, f3, m1, m2, m3", "seed TRANSLATOR, Friction (D-18)")
    names = ["f1", "f2", "f3", "m1", "m2", "m3", "R_r", "L"]
    forces = [sympy.Symbol(name, real=True) for name in names[:6]]
    parameters = {name: sympy.Symbol(name, positive=True) for name in names[6:]}
    for signs in ((1, 1, 1, 1, 1, 1), (-1, 1, -1, -1, 1, -1)):
        draw = Draw(str(signs))
        values = {name: draw.between(0.3, 3) for name in names}
        values |= {name: sign * values[name] for name, sign in zip(names, signs)}
        ring = Ring(values, {})
        numbers = {symbol: ring.named(str(symbol)) for symbol in [*forces, *parameters.values()]}
        evaluation = Evaluation(ring, numbers)
        parts, line = translator_by_parts(forces, parameters), translator_in_one_line(forces, parameters)
        claim.add(evaluation, parts, line)
        for force in forces:
            gradient.add(evaluation, parts.diff(force), line.diff(force))
    return [claim, gradient]


def dual_axes(draw):
    """m_i = M·axis_i and M = Σ m_i dual_i say the same; M = Σ m_i axis_i does not (decision D-4)."""
    claims = []
    for name, regions, axes in (
        ("CARDAN", cardan_regions, lambda s, a: [s.ea(1), cos(a) * s.ea(2) + sin(a) * s.ea(3), s.eb(3)]),
        ("EULER", euler_regions, lambda s, a: [s.ea(3), cos(a) * s.ea(1) + sin(a) * s.ea(2), s.eb(3)]),
    ):
        dual = Claim("axis_i · dual_j = δ_ij: m_i = M·axis_i ⇔ M = Σ m_j dual_j", f"{name}, Description (D-4)")
        excess = Claim(
            "the printed style M = Σ m_i axis_i would give M·axis_1 = m1 + m3 "
            + ("sin β" if name == "CARDAN" else "cos β") + ": off by that; used: the dual vectors",
            f"{name} (D-4)",
        )
        for region in regions(draw, 2):
            a, b = sympy.Symbol("a"), sympy.Symbol("b")
            ring = region.ring
            evaluation = Evaluation(ring, region.numbers | {a: ring.named("a"), b: ring.named("b")}, region.angles)
            s = relative_state(Integer(0))
            first, middle, last = axes(s, a)
            along = first.dot(last)
            square = 1 - along**2
            duals = [(first - along * last) / square, middle, (last - along * first) / square]
            for i, axis in enumerate((first, middle, last)):
                for j, other in enumerate(duals):
                    dual.add(evaluation, axis.dot(other), Integer(int(i == j)))
            excess.add(evaluation, (first + last).dot(first), 1 + (sin(b) if name == "CARDAN" else cos(b)))
        claims += [dual, excess]
    return claims


def universal_misaligned(draw):
    """By how much m1 e1a + m3 e3b misses at a frozen β0 (decision D-5)."""
    example = mpmath.nstr(mpmath.tan(mpmath.mpf("0.3")), 4)
    claim = Claim(
        f"|(e1a − sin β0 e3b)/cos² β0 − e1a| = |tan β0|, zero where aligned ({example} at β0 = 0.3); used: the dual vectors",
        "UNIVERSAL, REVOLUTE (D-5)",
    )
    for region in cardan_regions(draw, 3):
        b = sympy.Symbol("b")
        evaluation = Evaluation(region.ring, region.numbers | {b: region.ring.named("b")})
        s = relative_state(Integer(0))
        difference = (s.ea(1) - sin(b) * s.eb(3)) / cos(b) ** 2 - s.ea(1)
        claim.add(evaluation, difference.dot(difference), (sin(b) / cos(b)) ** 2)
    return [claim]


def rotation_moment(draw):
    """m_i = M·e_i^a against M = A H⁻ᵀ m (decision D-6), and e_i^b·φ = e_i^a·φ (decision D-7)."""
    parallel = Claim("H⁻ᵀ φ = φ: the printed m_i = M·e_i^a is exact for m ∥ φ", "seed ROTATION, Description (D-6)")
    size = mpmath.mpf("1.15")
    kappa = 1 / size**2 - (1 + mpmath.cos(size)) / (2 * size * mpmath.sin(size))
    norm = mpmath.nstr(size * mpmath.sqrt(2 * (mpmath.mpf("0.25") + kappa**2 * size**2)), 3)
    across = Claim(
        "|H⁻ᵀ m − m|² = (1/4 + κ² t²) |φ × m|², κ = 1/t² − (1 + cos t)/(2 t sin t): exact for no other m "
        f"(|H⁻ᵀ − I| = {norm} at |φ| = 1.15, Frobenius norm); used: H⁻ᵀ, reported beside it: M·e_i^a",
        "seed ROTATION, Description (D-6)",
    )
    carried = Claim("e_i^b·φ = e_i^a·φ", "seed ROTATION-ACCELEROMETER, Description (D-7)")
    inverse = Claim("H H⁻¹ = I", "Rotation variables")
    m = Matrix(symbols("l0 beta_s Psi_a"))
    for region in vector_regions(draw, REGIONS):
        evaluation = region.evaluation()
        phi = rotation_vector_of(Q, region.turns)
        t = sqrt(phi.dot(phi))
        rates = rates_to_vector(phi)
        parallel.add(evaluation, rates.T * phi, phi)
        kappa = 1 / t**2 - (1 + cos(t)) / (2 * t * sin(t))
        difference = rates.T * m - m
        spin = phi.cross(m)
        across.add(evaluation, difference.dot(difference), (Rational(1, 4) + kappa**2 * t**2) * spin.dot(spin))
        carried.add(evaluation, Q.T * phi, phi)
        spin = skew(phi)
        forward = eye(3) + (1 - cos(t)) / t**2 * spin + (t - sin(t)) / t**3 * spin * spin
        inverse.add(evaluation, forward * rates, eye(3))
    return [parallel, across, carried, inverse]


def euler_parity(draw):
    """β = cos⁻¹ R33 + jπ with odd j is no angle between the axes (decision D-3)."""
    claim = Claim("cos(cos⁻¹ R33 + π) − R33 = −2 R33, not 0: odd j is wrong; used: ± cos⁻¹ R33 + 2 j π", "EULER, Description (D-3)")
    for region in euler_regions(draw, 2):
        claim.add(region.evaluation(), cos(acos(Q[2, 2]) + pi) - Q[2, 2], -2 * Q[2, 2])
    return [claim]


def constant_velocity(draw):
    """The printed angle B and the torsion (decision D-8)."""
    equation = Claim("B = −β and B = π − β solve e1a·b2 = e2a·b1, b1 = cos B e1b + sin B e2b, b2 = −sin B e1b + cos B e2b", "CONSTANT VELOCITY, Description (D-8)")
    length = Claim("|(e3a + e3b)/(1 + e3a·e3b)| = 1/cos(α/2): by so much a unit vector would differ; used: the conjugate one", "CONSTANT VELOCITY (D-8)")
    velocity = Claim("ω along each own shaft and along e3b × e3a with β̇ = 0: ω_a·e3a = ω_b·e3b", "CONSTANT VELOCITY, Description")
    for region in shaft_regions(draw, 2):
        ring = region.ring
        f, t = sympy.Symbol("f"), sympy.Symbol("t")
        evaluation = Evaluation(ring, region.numbers | {f: ring.named("f"), t: ring.named("t")}, region.angles)
        s = relative_state(Integer(0))
        for angle in (-4 * t, -4 * t + pi):
            b1 = cos(angle) * s.eb(1) + sin(angle) * s.eb(2)
            b2 = -sin(angle) * s.eb(1) + cos(angle) * s.eb(2)
            equation.add(evaluation, s.ea(1).dot(b2), s.ea(2).dot(b1))
        direction = (s.ea(3) + s.eb(3)) / (1 + s.r(3, 3))
        length.add(evaluation, direction.dot(direction) * cos(2 * f) ** 2, Integer(1))
        # β̇ = direction·(ω_b − ω_a) with ω_a = p e3a + q n, ω_b = r e3b + u n, n = e3b × e3a: β̇ = r − p.
        p, q, r, u = symbols("d0 d1 d2 l0")
        normal = s.eb(3).cross(s.ea(3))
        relative = (r * s.eb(3) + u * normal) - (p * s.ea(3) + q * normal)
        velocity.add(evaluation, direction.dot(relative), r - p)
    return [equation, length, velocity]


def flexion_composition(draw):
    """B = exp(α q) exp(β e3a) A, and α, β, θ by 3-2-3 angles."""
    claim = Claim("exp(α q^) exp(β e3a^) A = B", "FLEXION-TORSION, Description (D-16)")
    for region in shaft_regions(draw, 2):
        ring = region.ring
        f, t = sympy.Symbol("f"), sympy.Symbol("t")
        evaluation = Evaluation(ring, region.numbers | {f: ring.named("f"), t: ring.named("t")}, region.angles)
        s = relative_state(Integer(0))
        q = bend_axis(s)
        flexion = rodrigues(q, cos(4 * f), sin(4 * f))
        twist = rodrigues(Matrix([0, 0, 1]), cos(4 * t), sin(4 * t))
        claim.add(evaluation, flexion * twist, Q)
    return [claim]


def sliprings():
    """Flow forces ±f1 and the gradient of the energy (decision D-10)."""
    claim = Claim("l_ref ∂u1/∂Ψ_b = λ, printed 1: off by the strain λ − 1; used: the tension f1", "SLIPRING (D-10)")
    energy = Claim("−∂(W l_ref)/∂l_ref = T λ − W per unit flow: 51.25 where T = 50 at 5 % (W = K ε²/2)", "SLIPRING (D-10)")
    evaluation = plain(["d", "l0", "a", "b", "K", "l"])
    d, l0, a, b, stiffness, length = symbols("d l0 a b K l", positive=True)
    material = l0 + a - b
    claim.add(evaluation, material * (d / material - 1).diff(b), d / material)
    strain = d / length - 1
    work = stiffness * strain**2 / 2
    energy.add(evaluation, -(work * length).diff(length), stiffness * strain * (1 + strain) - work)
    epsilon = Rational(1, 20)
    energy.add(evaluation, 1000 * epsilon * (1 + epsilon) - 1000 * epsilon**2 / 2, Rational(5125, 100))
    return [claim, energy]


def planar_arm():
    """Contact at the rim, R F_C, against uniform pressure, 2 R/3 F_C (decision D-11)."""
    claim = Claim("∫ r · F_C/(π R²) · 2πr dr = (2/3) R F_C: the rim's R F_C differs by R F_C/3; κ chooses", "PLANAR, spin (D-11)")
    evaluation = plain(["R", "F"])
    r, radius, force = symbols("r R F", positive=True)
    claim.add(evaluation, sympy.integrate(r * force / (pi * radius**2) * 2 * pi * r, (r, 0, radius)), Rational(2, 3) * radius * force)
    return [claim]


def cylindrical_slip():
    """The slip of P = √(f1² + (m1/R)²) is the surface velocity."""
    claim = Claim("λ² = u̇1² + (R u̇r1)² for u̇ = λ ∂P/∂f", "CYLINDRICAL, Friction")
    names = ["f1", "m1", "R", "l"]
    evaluation = plain(names)
    f1, m1, radius, slip = symbols("f1 m1 R l", positive=True)
    potential = sqrt(f1**2 + (m1 / radius) ** 2)
    claim.add(evaluation, (slip * potential.diff(f1)) ** 2 + (radius * slip * potential.diff(m1)) ** 2, slip**2)
    return [claim]


def nodal_map(draw):
    """δd = Aᵀ(δx_b − δx_a) + d × Aᵀδθ_a, δQ = (Aᵀ(δθ_b − δθ_a))^ Q, and equilibrium of every row built on it (decision D-29)."""
    first = Claim("δ(Aᵀ(x_b − x_a)) = Aᵀ(δx_b − δx_a) + d × Aᵀδθ_a", "variation of d, A → exp(δθ_a^) A")
    second = Claim("δ(AᵀB) = (Aᵀ(δθ_b − δθ_a))^ AᵀB", "variation of Q")
    balance = Claim("forces −g, g; moments g × D − h, h: no resultant force, and no moment about any point", "frame at a: F × d on a (D-29)")
    angles = {name: draw.between(0.1, 1.4) for name in ("h", "a", "b", "k", "e", "g")}
    values = {name: draw.between(-2, 2) for name in [f"{v}{i}" for v in ("x", "y", "t", "u") for i in range(3)]}
    ring = Ring(values, angles)
    a, b = Matrix(3, 3, symbols("A:3:3")), Matrix(3, 3, symbols("B:3:3"))
    entries = rotation(ring, ("h", "a", "b")), rotation(ring, ("k", "e", "g"))
    numbers = {m[i, j]: e[i][j] for m, e in zip((a, b), entries) for i in range(3) for j in range(3)}
    x, y, t, u = (Matrix(symbols(f"{v}:3")) for v in ("x", "y", "t", "u"))
    numbers |= {symbol: ring.named(str(symbol)) for vector in (x, y, t, u) for symbol in vector}
    evaluation = Evaluation(ring, numbers)
    d = a.T * x
    first.add(evaluation, (skew(t) * a).T * x + a.T * y, a.T * y + d.cross(a.T * t))
    second.add(evaluation, (skew(t) * a).T * b + a.T * (skew(u) * b), skew(a.T * (u - t)) * a.T * b)
    balance.add(evaluation, (y.cross(x) - u) + u + x.cross(y), sympy.zeros(3, 1))
    return [first, second, balance]


def claims():
    draw = Draw(2)
    found = []
    for part in (revolute_constraint, universal_constraint, revolute_forms, revolute_branch, dual_axes, universal_misaligned,
                 rotation_moment, euler_parity, constant_velocity, flexion_composition, nodal_map):
        found += part(draw)
    for part in (constraint_moments, translator_forms, sliprings, planar_arm, cylindrical_slip):
        found += part()
    return found
