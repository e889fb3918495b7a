"""The printed formulas of every connection type, typed from the manual's pages for scripts/proof/prove.py, in SymPy.

They are a second writing: nothing here is taken from the program or from the JAX reference. Each stands with its source, and with
the decision where our reading is part of it. Directions are columns of A and B; R_ij = e_i^a · e_j^b.
"""

from dataclasses import dataclass, field

import sympy
from sympy import Abs, Matrix, Rational, acos, asin, atan, atan2, cos, eye, pi, sin, sqrt, tan


@dataclass
class State:
    """What formulas are formed from: directions, d = x_b − x_a, material flow, and what the past decides."""

    a: Matrix
    b: Matrix
    d: Matrix
    flow_a: sympy.Expr
    flow_b: sympy.Expr
    initial: Matrix
    """R_0, the initial R."""
    length: sympy.Expr
    """The initial length of a belt segment."""
    flow_scale: sympy.Expr
    """β_s."""
    euler_sign: sympy.Expr = sympy.Integer(1)
    turns: sympy.Expr = sympy.Integer(0)
    """Whole turns: of the rotation vector, or of the torsion."""

    def ea(self, i):
        return self.a[:, i - 1]

    def eb(self, i):
        return self.b[:, i - 1]

    def r(self, i, j):
        return self.ea(i).dot(self.eb(j))


@dataclass
class Form:
    """One printed formula."""

    source: str
    value: callable
    modulo: sympy.Expr = sympy.Integer(0)
    """What the formula leaves open: + n π."""


@dataclass
class Row:
    """The printed force of a unit of a component: on b, as a moment on b, and on the material flows."""

    source: str
    force: callable = None
    moment: callable = None
    flow: callable = None


@dataclass
class Printed:
    """What is printed of one component: the formula, and the directions of its force or moment."""

    forms: list
    rows: list = field(default_factory=list)


NOTHING = sympy.zeros(3, 1)


def norm(v):
    return sqrt(v.dot(v))


# Translations


def coordinate(i, source):
    """e_i^a · (x_b − x_a), its force f_i e_i^a."""
    return Printed([Form(source, lambda s: s.ea(i).dot(s.d))], [Row(source, lambda s: s.ea(i))])


def distance(source):
    """l = |x_b − x_a|, its force f1 q."""
    return Printed([Form(source, lambda s: norm(s.d))], [Row(source, lambda s: s.d / norm(s.d))])


def radius(source):
    across = lambda s: s.ea(1).dot(s.d) * s.ea(1) + s.ea(2).dot(s.d) * s.ea(2)
    length = lambda s: sqrt(s.ea(1).dot(s.d) ** 2 + s.ea(2).dot(s.d) ** 2)
    return Printed([Form(source, length)], [Row(source, lambda s: across(s) / length(s))])


def strain(source):
    """λ − 1, λ = d_ab / l_ref, l_ref = l_0 + Ψ_a − Ψ_b; not work-conjugate to the flow forces (decision D-10)."""
    material = lambda s: s.length + s.flow_a - s.flow_b
    return Printed([Form(source, lambda s: norm(s.d) / material(s) - 1)])


def flow(which, source):
    return Printed([Form(source, lambda s: s.flow_a if which == 1 else s.flow_b)])


# Angles

CARDAN_PAGE = "CARDAN, Description"


def cardan(i, page=None):
    """α, β, γ of R = Rx(α) Ry(β) Rz(γ): alpha about e1a, beta about e2', gamma about e3b."""
    page = page or CARDAN_PAGE
    first = lambda s: atan2(-s.r(2, 3), s.r(3, 3))
    cos_b = lambda s: sqrt(1 - s.r(1, 3) ** 2)
    if i == 1:
        return Printed(
            [
                Form(f"{page}: −tan⁻¹(R23/R33) + nπ (D-1)", lambda s: -atan(s.r(2, 3) / s.r(3, 3)), pi),
                Form(f"{page}: its branch by two arguments (D-1)", first),
            ],
            [Row(f"{page}: m1 = M·e1a (D-4)", None, lambda s: (s.ea(1) - s.r(1, 3) * s.eb(3)) / cos_b(s) ** 2)],
        )
    if i == 2:
        return Printed(
            [Form(f"{page}: sin⁻¹ R13", lambda s: asin(s.r(1, 3)))],
            [
                Row(
                    f"{page}: e2' = cos α e2a + sin α e3a",
                    None,
                    lambda s: cos(first(s)) * s.ea(2) + sin(first(s)) * s.ea(3),
                )
            ],
        )
    return Printed(
        [Form(f"{page}: −tan⁻¹(R12/R11) + nπ", lambda s: -atan(s.r(1, 2) / s.r(1, 1)), pi)],
        [Row(f"{page}: m3 = M·e3b (D-4)", None, lambda s: (s.eb(3) - s.r(1, 3) * s.ea(1)) / cos_b(s) ** 2)],
    )


def euler(i):
    """α, β, γ of R = Rz(α) Rx(β) Rz(γ)."""
    page = "EULER, Description"
    sine_squared = lambda s: 1 - s.r(3, 3) ** 2
    if i == 1:
        return Printed(
            [Form(f"{page}: −tan⁻¹(R13/R23) + nπ", lambda s: -atan(s.r(1, 3) / s.r(2, 3)), pi)],
            [Row(f"{page}: m1 = M·e3a (D-4)", None, lambda s: (s.ea(3) - s.r(3, 3) * s.eb(3)) / sine_squared(s))],
        )
    if i == 2:
        first = lambda s: atan2(s.euler_sign * s.r(1, 3), -s.euler_sign * s.r(2, 3))
        return Printed(
            [Form(f"{page}: ±cos⁻¹ R33 (D-3)", lambda s: s.euler_sign * acos(s.r(3, 3)))],
            [
                Row(
                    f"{page}: e1' = cos α e1a + sin α e2a",
                    None,
                    lambda s: cos(first(s)) * s.ea(1) + sin(first(s)) * s.ea(2),
                )
            ],
        )
    return Printed(
        [Form(f"{page}: tan⁻¹(R31/R32) + nπ", lambda s: atan(s.r(3, 1) / s.r(3, 2)), pi)],
        [Row(f"{page}: m3 = M·e3b (D-4)", None, lambda s: (s.eb(3) - s.r(3, 3) * s.ea(3)) / sine_squared(s))],
    )


def cosine(i, j, source):
    """A constraint e_i^a · e_j^b = 0."""
    return Printed([Form(source, lambda s: s.r(i, j))])


def bend_axis(s):
    across = s.ea(3).cross(s.eb(3))
    return across / norm(across)


def flexion():
    return Printed(
        [Form("FLEXION-TORSION, Description: α = cos⁻¹(e3a·e3b)", lambda s: acos(s.r(3, 3)))],
        [Row("FLEXION-TORSION: m1 along q = e3a × e3b/|e3a × e3b|", None, bend_axis)],
    )


def torsion(page):
    return Printed(
        [
            Form(
                f"{page}: −tan⁻¹((R12 − R21)/(R11 + R22)) + mπ",
                lambda s: -atan((s.r(1, 2) - s.r(2, 1)) / (s.r(1, 1) + s.r(2, 2))),
                pi,
            ),
            Form(f"{page}: its branch by two arguments", lambda s: atan2(s.r(2, 1) - s.r(1, 2), s.r(1, 1) + s.r(2, 2))),
        ],
        [Row(f"{page}: (e3a + e3b)/(1 + e3a·e3b) (D-8)", None, lambda s: (s.ea(3) + s.eb(3)) / (1 + s.r(3, 3)))],
    )


def sweep():
    page = "FLEXION-TORSION, Description (D-16)"
    return Printed(
        [
            Form(f"{page}: −tan⁻¹(R13/R23) + nπ", lambda s: -atan(s.r(1, 3) / s.r(2, 3)), pi),
            Form(f"{page}: q = cos θ e1a + sin θ e2a", lambda s: atan2(bend_axis(s).dot(s.ea(2)), bend_axis(s).dot(s.ea(1)))),
        ],
        [
            Row(
                f"{page}: (e3a − c e3b)/sin²α",
                None,
                lambda s: (s.ea(3) - s.r(3, 3) * s.eb(3)) / (1 - s.r(3, 3) ** 2),
            )
        ],
    )


# Directions midway between a and b


def turned(v, axis, angle):
    """exp(angle axis^) v for a unit axis: Rodrigues."""
    return cos(angle) * v + sin(angle) * axis.cross(v) + (1 - cos(angle)) * axis.dot(v) * axis


def midway(s):
    """e1, e2, e3 by half the flexion about q and half the torsion about e3."""
    alpha, q = acos(s.r(3, 3)), bend_axis(s)
    third = (s.ea(3) + s.eb(3)) / norm(s.ea(3) + s.eb(3))
    carried = turned(s.ea(1), q, alpha / 2)
    beta = atan2(s.r(2, 1) - s.r(1, 2), s.r(1, 1) + s.r(2, 2)) + 2 * pi * s.turns
    first = cos(beta / 2) * carried + sin(beta / 2) * third.cross(carried)
    return [first, third.cross(first), third]


def midway_mean(s):
    """The same without branches: a1 and b1 carried to the plane across e3, e1 along their sum (while |β| < π)."""
    third = (s.ea(3) + s.eb(3)) / norm(s.ea(3) + s.eb(3))
    a1 = s.ea(1) - s.ea(1).dot(third) / (1 + s.ea(3).dot(third)) * (s.ea(3) + third)
    b1 = s.eb(1) - s.eb(1).dot(third) / (1 + s.eb(3).dot(third)) * (s.eb(3) + third)
    first = (a1 + b1) / norm(a1 + b1) * cos(pi * s.turns)
    return [first, third.cross(first), third]


def spin_of_midway(s):
    """T: δθ_mid = δθ_a + T (δθ_b − δθ_a)."""
    third = (s.ea(3) + s.eb(3)) / norm(s.ea(3) + s.eb(3))
    p = (s.ea(3) - s.eb(3)) / norm(s.ea(3) - s.eb(3))
    alpha = acos(s.r(3, 3))
    return eye(3) / 2 + tan(alpha / 2) / 2 * p * third.T - tan(alpha / 4) / 2 * third * p.T


def projected(i):
    page = "PROJECTION CARTESIAN, Description (D-17)"
    return Printed(
        [
            Form(f"{page}: e_i·d, directions by half turns", lambda s: midway(s)[i - 1].dot(s.d)),
            Form(f"{page}: e_i·d, directions by bisectors", lambda s: midway_mean(s)[i - 1].dot(s.d)),
        ],
        [
            Row(
                f"{page}: F = f_i e_i, moment on b Tᵀ (F × d)",
                lambda s: midway(s)[i - 1],
                lambda s: spin_of_midway(s).T * midway(s)[i - 1].cross(s.d),
            )
        ],
    )


def component_flexion(i):
    page = "PROJECTION FLEXION-TORSION, Description"

    def row(s):
        q, alpha = bend_axis(s), acos(s.r(3, 3))
        p = (s.ea(3) - s.eb(3)) / norm(s.ea(3) - s.eb(3))
        e1, e2, _ = midway(s)
        cos_chi, sin_chi = q.dot(e2), -q.dot(e1)
        kappa = alpha / 2 / sin(alpha / 2)
        return [-sin_chi * q - kappa * cos_chi * p, cos_chi * q - kappa * sin_chi * p][i - 1]

    return Printed(
        [Form(f"{page}: α_i = α q·e_i", lambda s: acos(s.r(3, 3)) * bend_axis(s).dot(midway(s)[i - 1]))],
        [Row(f"{page}: −sin χ q − κ cos χ p, cos χ q − κ sin χ p", None, row)],
    )


# Rotation vectors


def rotation_vector_of(r, turns):
    """φ = 2 atan2(|q|, q0) q/|q| of the quaternion (q0, q) of r, and whole turns along it."""
    scalar = sqrt(1 + r[0, 0] + r[1, 1] + r[2, 2]) / 2
    vector = Matrix([r[2, 1] - r[1, 2], r[0, 2] - r[2, 0], r[1, 0] - r[0, 1]]) / (4 * scalar)
    length = norm(vector)
    return (2 * atan2(length, scalar) + 2 * pi * turns) * vector / length


def relative_rotation(s):
    return Matrix(3, 3, lambda i, j: s.r(i + 1, j + 1))


def rates_to_vector(phi):
    """H⁻¹: φ̇ = H⁻¹ ω, with H = I + ((1 − cos t)/t²) φ^ + ((t − sin t)/t³) φ^²; t² = φ·φ."""
    t = norm(phi)
    spin = Matrix([[0, -phi[2], phi[1]], [phi[2], 0, -phi[0]], [-phi[1], phi[0], 0]])
    return eye(3) - spin / 2 + (1 / t**2 - (1 + cos(t)) / (2 * t * sin(t))) * spin * spin


def rotation_vector(i, along="a"):
    direction = {"a": State.ea, "b": State.eb}[along]
    page = {"a": "seed ROTATION, Description", "b": "seed ROTATION-ACCELEROMETER, Description (D-7)"}[along]

    def phi(s):
        local = rotation_vector_of(relative_rotation(s), s.turns)
        return s.a * local

    return Printed(
        [Form(f"{page}: φ_i = e_i^{along}·φ, e_i^b = exp(φ^)·e_i^a", lambda s: direction(s, i).dot(phi(s)))],
        [
            Row(
                "Rotation variables: δφ = H⁻¹ δθ; M = A H⁻ᵀ m (D-6)",
                None,
                lambda s: s.a * rates_to_vector(rotation_vector_of(relative_rotation(s), s.turns)).T * eye(3)[:, i - 1],
            )
        ],
    )


def misalignment(i):
    """What ALIGN holds where R_0 is frozen: log(R R_0ᵀ) = 0."""
    local = lambda s: rotation_vector_of(relative_rotation(s) * s.initial.T, 0)
    return Printed(
        [Form("ALIGN, Description: R = R0, as log(R R0ᵀ) = 0 (D-5)", lambda s: local(s)[i - 1])],
        [
            Row(
                "Rotation variables: H⁻¹ at log(R R0ᵀ)",
                None,
                lambda s: s.a * rates_to_vector(local(s)).T * eye(3)[:, i - 1],
            )
        ],
    )


def flow_conversion(source):
    """ur3 = e3a·(θ_a − θ_b) − β_s Ψ_b: a row, and no function of the pose (decision D-9)."""
    return Printed([], [Row(source, None, lambda s: -s.ea(3), lambda s: [0, -s.flow_scale])])


def coordinates(page):
    return {f"u{i}": coordinate(i, page) for i in (1, 2, 3)}


def align():
    printed = {f"ur{i}": cardan(i, "ALIGN, Description: the frozen Cardan angles") for i in (1, 2, 3)}
    return printed | {f"ur{i}_constraint": misalignment(i) for i in (1, 2, 3)}


REVOLUTE_PAGE = "seed REVOLUTE, Description"

# What each page prints, by the names of the exported functions.
BASIC = {
    "ACCELEROMETER": coordinates("ACCELEROMETER, Description: x_i = e_i^a·(x_b − x_a)"),
    "AXIAL": {"u1": distance("AXIAL, Description: l = |x_b − x_a|, f1 q")},
    "CARTESIAN": coordinates("CARTESIAN, Description: x, y, z = e_i^a·(x_b − x_a)"),
    "JOIN": coordinates("JOIN, Description: coordinates of b in the frame of a"),
    "LINK": {"u1": distance("connection type components, LINK: |x_b − x_a| = l_0")},
    "PROJECTION CARTESIAN": {f"u{i}": projected(i) for i in (1, 2, 3)},
    "RADIAL-THRUST": {
        "u1": radius("RADIAL-THRUST, Description: r, f1 e_r"),
        "u3": coordinate(3, "RADIAL-THRUST, Description: l = e3a·d"),
    },
    "SLIDE-PLANE": coordinates("seed SLIDE-PLANE, Description: x, y, z = e_i^a·(x_b − x_a)"),
    "SLOT": coordinates("SLOT, Description: l = e1a·d, y = e2a·d, z = e3a·d"),
    "ALIGN": align(),
    "CARDAN": {f"ur{i}": cardan(i) for i in (1, 2, 3)},
    "CONSTANT VELOCITY": {"ur2": torsion("CONSTANT VELOCITY, Description (D-8)")},
    "EULER": {f"ur{i}": euler(i) for i in (1, 2, 3)},
    "FLEXION-TORSION": {"ur1": flexion(), "ur2": torsion("FLEXION-TORSION, Description"), "ur3": sweep()},
    "FLOW-CONVERTER": {"ur3": flow_conversion("FLOW-CONVERTER, Description (D-9)")},
    "PROJECTION FLEXION-TORSION": {
        "ur1": component_flexion(1),
        "ur2": component_flexion(2),
        "ur3": torsion("PROJECTION FLEXION-TORSION, Description"),
    },
    "REVOLUTE": {
        "ur1": cardan(1, REVOLUTE_PAGE),
        "ur2": cardan(2, f"{REVOLUTE_PAGE}: second Cardan angle"),
        "ur3": cardan(3, f"{REVOLUTE_PAGE}: third Cardan angle"),
        "ur2_constraint": cosine(1, 3, f"{REVOLUTE_PAGE}: e1a·e3b = 0"),
        "ur3_constraint": cosine(1, 2, f"{REVOLUTE_PAGE}: e1a·e2b = 0"),
    },
    "ROTATION": {f"ur{i}": rotation_vector(i) for i in (1, 2, 3)},
    "ROTATION-ACCELEROMETER": {f"ur{i}": rotation_vector(i, "b") for i in (1, 2, 3)},
    "UNIVERSAL": {
        "ur1": cardan(1, "UNIVERSAL, Description"),
        "ur2": cardan(2, "UNIVERSAL, Description: second Cardan angle"),
        "ur3": cardan(3, "UNIVERSAL, Description"),
        "ur2_constraint": cosine(1, 3, "UNIVERSAL, Description: e1a·e3b = 0"),
    },
    "SLIPRING": {
        "u1": strain("SLIPRING, Description: strain λ − 1 (D-10)"),
        "u2": flow(2, "SLIPRING, Description: Ψb"),
        "u3": flow(1, "SLIPRING, Description: Ψa"),
    },
}

# "Imposes kinematic constraints … equivalent to combining connection types": the first half, the second.
ASSEMBLED = {
    "BEAM": ("JOIN", "ALIGN"),
    "BUSHING": ("PROJECTION CARTESIAN", "PROJECTION FLEXION-TORSION"),
    "CVJOINT": ("JOIN", "CONSTANT VELOCITY"),
    "CYLINDRICAL": ("SLOT", "REVOLUTE"),
    "HINGE": ("JOIN", "REVOLUTE"),
    "PLANAR": ("SLIDE-PLANE", "REVOLUTE"),
    "RETRACTOR": ("JOIN", "FLOW-CONVERTER"),
    "TRANSLATOR": ("SLOT", "ALIGN"),
    "UJOINT": ("JOIN", "UNIVERSAL"),
    "WELD": ("JOIN", "ALIGN"),
}


def printed(type_name):
    """Every printed component of a type, an assembled one by its halves."""
    if type_name in BASIC:
        return BASIC[type_name]
    first, second = ASSEMBLED[type_name]
    return BASIC[first] | BASIC[second]


TYPES = [*BASIC, *ASSEMBLED]


# Predefined friction: Φ = P(f) − μ F_N ≤ 0, F_N = |F_C + F_C^int|


@dataclass
class Friction:
    """One criterion: P and F_C of the forces f1 … m3 (places 0 … 5) and of the parameters by name."""

    criterion: int
    source: str
    potential: callable
    contact: callable
    internal: str
    limit: callable = None
    """What stands for μ F_N, where that is a law of its own."""

    @staticmethod
    def variables(inputs):
        """The forces, and the parameters by name, from the groups of inputs of an exported criterion."""
        parameters = {name: group[0] for name, group in inputs.items() if len(group) == 1}
        if "tension" in inputs:
            parameters |= dict(zip(("T1", "T2"), inputs["tension"])) | {"alpha": inputs["wrap"][0]}
        if "angles" in inputs:
            alpha, beta = inputs["angles"]
            parameters["e3b"] = Matrix([sin(beta), -sin(alpha) * cos(beta), cos(alpha) * cos(beta)])
        return inputs.get("f", []), parameters


def root(*terms):
    return sqrt(sum(term**2 for term in terms))


def translator_by_parts(f, p):
    """F_C = F_torq + F_r + F_bend, one contribution at a time."""
    m_torq = Abs(f[3])
    f_torq = m_torq / p["R_r"]
    f_r = sqrt(f[1] ** 2 + f[2] ** 2)
    m_bend = sqrt(f[4] ** 2 + f[5] ** 2)
    f_bend = 2 * m_bend / p["L"]
    return f_torq + f_r + f_bend


def translator_in_one_line(f, p):
    """F_C = |m1/R_r| + √(f2² + f3²) + √((β m2)² + (β m3)²), β = 2/L."""
    beta = 2 / p["L"]
    return Abs(f[3] / p["R_r"]) + root(f[1], f[2]) + root(beta * f[4], beta * f[5])


def hinge_contact(f, p):
    return Abs(f[0]) * p["R_a"] + p["R_p"] * (root(f[1], f[2]) + 2 * root(f[4], f[5]) / p["L_s"])


def planar_contact(f, p):
    return Abs(f[0]) + root(f[4], f[5]) / p["R"]


def cross_contact(axis):
    """UJOINT: M_C = R_a |f·t| + R_p (|f − (f·t) t| + 2 |m2|/L_a) (decision D-13); t along e_i^a."""

    def contact(f, p):
        t, force = axis(p), Matrix(f[:3])
        across = force - force.dot(t) * t
        return p["R_a"] * Abs(force.dot(t)) + p["R_p"] * (norm(across) + 2 * Abs(f[4]) / p["L_a"])

    return contact


def smaller(x, y, larger=False):
    return sympy.Piecewise((x, y < x if larger else x < y), (y, True))


FRICTION = {
    "SLIDE-PLANE": [Friction(1, "seed SLIDE-PLANE, Friction", lambda f, p: root(f[1], f[2]), lambda f, p: Abs(f[0]), "F_C_int")],
    "SLOT": [Friction(1, "SLOT, Friction", lambda f, p: Abs(f[0]), lambda f, p: root(f[1], f[2]), "F_C_int")],
    "TRANSLATOR": [
        Friction(1, "seed TRANSLATOR, Friction: F_torq + F_r + F_bend (D-18)", lambda f, p: Abs(f[0]), translator_by_parts, "F_C_int"),
        Friction(1, "seed TRANSLATOR, Friction: g(f) in one line", lambda f, p: Abs(f[0]), translator_in_one_line, "F_C_int"),
    ],
    "CYLINDRICAL": [
        Friction(
            1,
            "CYLINDRICAL, Friction",
            lambda f, p: root(f[0], f[3] / p["R"]),
            lambda f, p: root(f[1], f[2]) + 2 * root(f[4], f[5]) / p["L"],
            "F_C_int",
        )
    ],
    "HINGE": [Friction(1, "HINGE, Friction", lambda f, p: Abs(f[3]), hinge_contact, "M_C_int")],
    "PLANAR": [
        Friction(1, "PLANAR, Friction in 2–3", lambda f, p: root(f[1], f[2]), planar_contact, "F_C_int"),
        Friction(
            2,
            "PLANAR, spin: M_C = κ R F_C (D-11)",
            lambda f, p: Abs(f[3]),
            lambda f, p: p["kappa"] * p["R"] * planar_contact(f, p),
            "M_C_int",
        ),
    ],
    "UJOINT": [
        Friction(1, "UJOINT, about e1a (D-13)", lambda f, p: Abs(f[3]), cross_contact(lambda p: Matrix([1, 0, 0])), "M_C1_int"),
        Friction(2, "UJOINT, about e3b (D-13)", lambda f, p: Abs(f[5]), cross_contact(lambda p: p["e3b"]), "M_C3_int"),
    ],
    "SLIPRING": [
        Friction(
            1,
            "SLIPRING: max(T1, T2) ≤ min(T1, T2) exp(μ α)",
            lambda f, p: smaller(p["T2"], p["T1"], larger=True) - smaller(p["T1"], p["T2"]),
            lambda f, p: smaller(p["T1"], p["T2"]),
            None,
            lambda f, p: smaller(p["T1"], p["T2"]) * (sympy.exp(p["mu"] * p["alpha"]) - 1),
        )
    ],
}


# Multi-point constraint REVOLUTE


def rodrigues(unit, cosine_, sine_):
    """C = cos I + sin p^ + (1 − cos) p pᵀ (Rotation variables)."""
    x, y, z = unit
    spin = Matrix([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return cosine_ * eye(3) + sine_ * spin + (1 - cosine_) * unit * unit.T


HALF = Rational(1, 2)
