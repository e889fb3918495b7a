"""The formulas of scripts/reference/reference.py: the table of connection types, kinematics, derivatives (JAX, float64)."""

import math
import os

os.environ.setdefault("JAX_PLATFORMS", "cpu")

import jax
import jax.numpy as jnp
import jaxlib
import numpy as np

jax.config.update("jax_enable_x64", True)


# The table. Components u1 u2 u3, ur1 ur2 ur3: C constrained, A available, M measured only, . absent.
# Then the measure of the translations and of the rotations, and what the constrained rotations hold.

TABLE = {
    "JOIN": ("CCC ...", "frame", None, None),
    "SLOT": ("ACC ...", "frame", None, None),
    "SLIDE-PLANE": ("CAA ...", "frame", None, None),
    "CARTESIAN": ("AAA ...", "frame", None, None),
    "AXIAL": ("A.. ...", "length", None, None),
    "LINK": ("C.. ...", "length", None, None),
    "ALIGN": ("... CCC", None, "cardan", "all"),
    "REVOLUTE": ("... ACC", None, "cardan", "axis"),
    "ROTATION": ("... AAA", None, "vector", None),
    "ROTATION-ACCELEROMETER": ("... MMM", None, "vector", None),
    "CARDAN": ("... AAA", None, "cardan", None),
    "EULER": ("... AAA", None, "euler", None),
    "FLOW-CONVERTER": ("... ..C", None, "drum", None),
    "UNIVERSAL": ("... ACA", None, "cardan", "cross"),
    "BEAM": ("CCC CCC", "frame", "cardan", "all"),
    "WELD": ("CCC CCC", "frame", "cardan", "all"),
    "HINGE": ("CCC ACC", "frame", "cardan", "axis"),
    "CYLINDRICAL": ("ACC ACC", "frame", "cardan", "axis"),
    "PLANAR": ("CAA ACC", "frame", "cardan", "axis"),
    "TRANSLATOR": ("ACC CCC", "frame", "cardan", "all"),
    "RETRACTOR": ("CCC ..C", "frame", "drum", None),
    "UJOINT": ("CCC ACA", "frame", "cardan", "cross"),
    "SLIPRING": ("AAM ...", "belt", None, None),
    "ACCELEROMETER": ("MMM ...", "frame", None, None),
    "PROJECTION CARTESIAN": ("AAA ...", "middle", None, None),
    "RADIAL-THRUST": ("A.A ...", "radial", None, None),
    "CONSTANT VELOCITY": ("... .C.", None, "shafts", None),
    "FLEXION-TORSION": ("... AAA", None, "coupling", None),
    "PROJECTION FLEXION-TORSION": ("... AAA", None, "projection", None),
    "BUSHING": ("AAA AAA", "middle", "projection", None),
    "CVJOINT": ("CCC .C.", "frame", "shafts", None),
}
ROLES = {"C": "constrained", "A": "available", "M": "measured", ".": None}


def roles_of(type_name):
    return [ROLES[letter] for letter in TABLE[type_name][0].replace(" ", "")]


# Functions of t^2 that Rodrigues' formula is made of


def polynomial(coefficients):
    """Sum of coefficients[n] x^n as a function of x that is its own rule for derivatives.

    One sum over powers instead of a chain of Horner steps: XLA compiles it three times faster.
    """
    powers = np.arange(len(coefficients))
    slope = [n * c for n, c in enumerate(coefficients)][1:]

    @jax.custom_jvp
    def value(x):
        return jnp.sum(jnp.array(coefficients) * x**powers)

    @value.defjvp
    def value_jvp(primals, tangents):
        return value(*primals), (polynomial(slope)(*primals) if slope else 0.0) * tangents[0]

    return value


def series_or(square, coefficients, closed_form):
    """`closed_form(t)` of t = sqrt(square), its Maclaurin series in t^2 below 1; neither branch spoils derivatives."""
    small = square < 1.0
    series = polynomial(coefficients)(jnp.where(small, square, 0.0))
    return jnp.where(small, series, closed_form(jnp.sqrt(jnp.where(small, 1.0, square))))


def sine_ratio(square):
    """sin(t)/t."""
    coefficients = [(-1) ** n / math.factorial(2 * n + 1) for n in range(11)]
    return series_or(square, coefficients, lambda t: jnp.sin(t) / t)


def cosine(square):
    coefficients = [(-1) ** n / math.factorial(2 * n) for n in range(11)]
    return series_or(square, coefficients, jnp.cos)


def spin(v):
    zero = jnp.zeros_like(v[0])
    return jnp.array([[zero, -v[2], v[1]], [v[2], zero, -v[0]], [-v[1], v[0], zero]])


def rodrigues(rotation):
    """exp(rotation^) = I + (sin t/t) K + (1 - cos t)/t^2 K^2."""
    square = rotation @ rotation
    k = spin(rotation)
    half = sine_ratio(square / 4)
    return jnp.eye(3) + sine_ratio(square) * k + 0.5 * half * half * (k @ k)


# Quaternions (w, x, y, z)


def versor(rotation):
    quarter = rotation @ rotation / 4
    return jnp.concatenate([cosine(quarter)[None], 0.5 * sine_ratio(quarter) * rotation])


def after(p, q):
    """The product p q: rotation q followed by p."""
    return jnp.concatenate([(p[0] * q[0] - p[1:] @ q[1:])[None], p[0] * q[1:] + q[0] * p[1:] + jnp.cross(p[1:], q[1:])])


def reversed_rotation(q):
    return q * jnp.array([1.0, -1.0, -1.0, -1.0])


def quaternion_of(matrix):
    """Of a constant rotation matrix: the longest column of 4 q q^T (numpy, not differentiated)."""
    m = np.asarray(matrix)
    outer = np.empty((4, 4))
    outer[0, 0] = 1 + m[0, 0] + m[1, 1] + m[2, 2]
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        outer[0, i + 1] = outer[i + 1, 0] = m[k, j] - m[j, k]
        outer[i + 1, i + 1] = 1 + m[i, i] - m[j, j] - m[k, k]
        outer[i + 1, j + 1] = outer[j + 1, i + 1] = m[i, j] + m[j, i]
    column = outer[:, np.argmax(np.diag(outer))]
    return column / np.linalg.norm(column)


def principal_vector(q):
    """Rotation vector, at most pi long, of a unit quaternion of either sign.

    v/(|q| + |w|) is the tangent of a quarter of the angle along the axis; two more halvings leave at most
    tan(pi/16) = 0.199, where one alternating series serves every angle.
    """
    q = jnp.where(q[0] < 0.0, -q, q)
    p = q[1:] / (jnp.sqrt(q @ q) + q[0])
    for _ in range(2):
        p = p / (1.0 + jnp.sqrt(1.0 + p @ p))
    square = p @ p
    return 16.0 * polynomial([(-1) ** n / (2 * n + 1) for n in range(14)])(square) * p


def vector_on_sheet(q, sheet):
    """principal_vector, lengthened by `sheet` turns along itself."""
    principal = principal_vector(q)
    square = principal @ principal
    length = jnp.sqrt(jnp.where(sheet == 0.0, 1.0, square))
    return principal + jnp.where(sheet == 0.0, 0.0, 2 * jnp.pi * sheet / length) * principal


# Kinematics of one connector


class Motion:
    """The two nodes, displaced from a state by the 14 variations."""

    def __init__(self, state, variation):
        turn_a, turn_b = variation[3:6], variation[10:13]
        self.a = rodrigues(turn_a) @ (rodrigues(state["theta_a"]) @ state["A0"])
        self.b = rodrigues(turn_b) @ (rodrigues(state["theta_b"]) @ state["B0"])
        self.d = (state["X_b"] - state["X_a"]) + (state["U_b"] - state["U_a"]) + (variation[7:10] - variation[0:3])
        self.flow_a = state["flow_a"] + variation[6]
        self.flow_b = state["flow_b"] + variation[13]
        quaternion_a = after(after(versor(turn_a), versor(state["theta_a"])), state["quaternion_A0"])
        quaternion_b = after(after(versor(turn_b), versor(state["theta_b"])), state["quaternion_B0"])
        self.relative = after(reversed_rotation(quaternion_a), quaternion_b)


def frame(state, motion):
    return motion.d @ motion.a


def length(state, motion):
    distance = jnp.sqrt(motion.d @ motion.d)
    return jnp.stack([distance, 0.0 * distance, 0.0 * distance])


def belt(state, motion):
    first = state["X_b"] - state["X_a"]
    unstretched = jnp.sqrt(first @ first) + motion.flow_a - motion.flow_b
    return jnp.stack([jnp.sqrt(motion.d @ motion.d) / unstretched - 1.0, motion.flow_b, motion.flow_a])


def cardan(state, motion):
    nodes = jnp.cross(motion.b[:, 2], motion.a[:, 0])
    cosine_of_second = jnp.sqrt(nodes @ nodes)
    return jnp.stack(
        [
            jnp.arctan2(nodes @ motion.a[:, 2], nodes @ motion.a[:, 1]),
            jnp.arctan2(motion.a[:, 0] @ motion.b[:, 2], cosine_of_second),
            jnp.arctan2(nodes @ motion.b[:, 0], nodes @ motion.b[:, 1]),
        ]
    )


def euler(state, motion):
    nodes = state["side"] * jnp.cross(motion.a[:, 2], motion.b[:, 2])
    return jnp.stack(
        [
            jnp.arctan2(nodes @ motion.a[:, 1], nodes @ motion.a[:, 0]),
            state["side"] * jnp.arctan2(jnp.sqrt(nodes @ nodes), motion.a[:, 2] @ motion.b[:, 2]),
            jnp.arctan2(-(nodes @ motion.b[:, 1]), nodes @ motion.b[:, 0]),
        ]
    )


def radial(state, motion):
    """The part of d across e3a, as a vector: its length is the distance from the axis."""
    axis = motion.a[:, 2]
    along = axis @ motion.d
    outward = motion.d - along * axis
    return jnp.stack([jnp.sqrt(outward @ outward), 0.0 * along, along])


def carried_first(triad, middle):
    """e1 after the smallest rotation that takes e3 to the direction `middle`."""
    first, third = triad[:, 0], triad[:, 2]
    return first - (first @ middle) / (1.0 + third @ middle) * (third + middle)


def halfway(motion):
    """The third direction halfway between e3a and e3b, and the first directions of both triads carried to it."""
    both = motion.a[:, 2] + motion.b[:, 2]
    third = both / jnp.sqrt(both @ both)
    return third, carried_first(motion.a, third), carried_first(motion.b, third)


def torsion(motion):
    """The angle about the halfway direction between the two carried first directions."""
    third, from_a, from_b = halfway(motion)
    return jnp.arctan2(third @ jnp.cross(from_a, from_b), from_a @ from_b)


def middle_triad(state, motion):
    """Columns e1, e2, e3: e1 at half the torsion, its turns included, from a's carried first direction to b's."""
    third, from_a, _ = halfway(motion)
    half = 0.5 * torsion(motion) + jnp.pi * state["twist"]
    first = jnp.cos(half) * from_a + jnp.sin(half) * jnp.cross(third, from_a)
    return jnp.stack([first, jnp.cross(third, first), third], axis=1)


def middle(state, motion):
    return motion.d @ middle_triad(state, motion)


def shafts(state, motion):
    beta = torsion(motion)
    return jnp.stack([0.0 * beta, beta, 0.0 * beta])


def coupling(state, motion):
    """Chords for the flexion; the sweep is the direction of e3a x e3b seen from a."""
    chord, both = motion.a[:, 2] - motion.b[:, 2], motion.a[:, 2] + motion.b[:, 2]
    axis = jnp.cross(motion.a[:, 2], motion.b[:, 2])
    return jnp.stack(
        [
            2.0 * jnp.arctan2(jnp.sqrt(chord @ chord), jnp.sqrt(both @ both)),
            torsion(motion),
            jnp.arctan2(axis @ motion.a[:, 1], axis @ motion.a[:, 0]),
        ]
    )


def projection(state, motion):
    """The rotation vector of the smallest rotation from e3a to e3b, in the halfway directions."""
    shaft_a, shaft_b = motion.a[:, 2], motion.b[:, 2]
    swing = principal_vector(jnp.concatenate([(1.0 + shaft_a @ shaft_b)[None], jnp.cross(shaft_a, shaft_b)]))
    return jnp.concatenate([(swing @ middle_triad(state, motion))[:2], torsion(motion)[None]])


def vector(state, motion):
    return vector_on_sheet(motion.relative, state["sheet"])


def drum(state, motion):
    """No function of the pose exists: zeros that one_form replaces."""
    return jnp.zeros(3)


MEASURES = {
    None: drum, "frame": frame, "length": length, "belt": belt, "cardan": cardan, "euler": euler, "vector": vector, "drum": drum,
    "radial": radial, "middle": middle, "shafts": shafts, "coupling": coupling, "projection": projection,
}
WINDING = {"shafts": (1,), "coupling": (1, 2), "projection": (2,)}
"""Which of the three rotations wind, where torsion is measured."""


def has_torsion(type_name):
    _, translation, rotation, _ = TABLE[type_name]
    return translation == "middle" or rotation in WINDING


def positions(type_name, state, motion):
    _, translation, rotation, _ = TABLE[type_name]
    return jnp.concatenate([MEASURES[translation](state, motion), MEASURES[rotation](state, motion)])


def held_rotations(type_name, state, motion, displacements):
    """What the constrained rotations keep at zero, at their places among ur1, ur2, ur3."""
    kind = TABLE[type_name][3]
    if kind == "all":
        return principal_vector(after(motion.relative, reversed_rotation(state["quaternion_R0"])))
    if kind is None:
        return displacements
    swing = motion.a[:, 0] @ motion.b[:, 2]
    if kind == "cross":
        return jnp.stack([displacements[0], jnp.where(state["aligned"], swing, displacements[1]), displacements[2]])
    yaw = motion.a[:, 0] @ motion.b[:, 1]
    return jnp.stack(
        [
            displacements[0],
            jnp.where(state["aligned"], swing, displacements[1]),
            jnp.where(state["aligned"], yaw, displacements[2]),
        ]
    )


def displacements(type_name, state, motion):
    return positions(type_name, state, motion) + 2 * jnp.pi * state["turns"] - state["initial"]


def measures(type_name, state, variation):
    """Displacements of the available and measured components, residuals of the constrained ones."""
    motion = Motion(state, variation)
    free = displacements(type_name, state, motion)
    return jnp.concatenate([free[:3], held_rotations(type_name, state, motion, free[3:])])


def one_form(state, variation):
    """Row of FLOW-CONVERTER: e3a.(dtheta_a - dtheta_b) - beta_s dPsi_b."""
    e3 = Motion(state, variation).a[:, 2]
    nothing = jnp.zeros(3)
    return jnp.concatenate([nothing, e3, jnp.zeros(1), nothing, -e3, -state["beta_s"][None]])


def drum_increment(state, before, share):
    """Its increment over one of 1/share steps, from the step's beginning `before` (0..1)."""
    step_a, step_b = share * state["theta_a"], share * state["theta_b"]
    start = rodrigues(before * state["theta_a"]) @ state["A0"][:, 2]
    middle = rodrigues(0.5 * step_a) @ start
    return middle @ (step_a - step_b) - state["beta_s"] * share * state["flow_b"]


def along(state, time_):
    """The 14 variations at a time near zero, from the rates and accelerations of the nodes."""
    return state["rates"] * time_ + state["accelerations"] * (time_ * time_ / 2)


def value_jacobian_hessian(function, size):
    """Of a function at zero, from one trace: the inner derivatives are the by-products of the outer ones."""

    def inner(x):
        value = function(x)
        return value, value

    def outer(x):
        jacobian, value = jax.jacfwd(inner, has_aux=True)(x)
        return jacobian, (value, jacobian)

    hessian, (value, jacobian) = jax.jacfwd(outer, has_aux=True)(jnp.zeros(size))
    return value, jacobian, hessian


def derivatives(type_name, state):
    """Values, Jacobian, Hessian, rates and accelerations at the state.

    Time is one more variable beside the 14 variations, so that the rates are derivatives along the motion.
    """
    rest = jnp.zeros(14)

    def rows(variation_and_time):
        return measures(type_name, state, variation_and_time[:14] + along(state, variation_and_time[14]))

    measure, jacobian, hessian = value_jacobian_hessian(rows, 15)
    values = {
        "measure": measure,
        "position": positions(type_name, state, Motion(state, rest)) + 2 * jnp.pi * state["turns"],
        "displacement": displacements(type_name, state, Motion(state, rest)),
        "jacobian": jacobian[:, :14],
        "hessian": hessian[:, :14, :14],
        "velocity": jacobian[:, 14],
        "acceleration": hessian[:, 14, 14],
    }
    if TABLE[type_name][2] == "drum":

        def drum_rate(time_):
            path, slope = jax.jvp(lambda t: along(state, t), (time_,), (1.0,))
            return one_form(state, path) @ slope

        velocity, acceleration = jax.jvp(drum_rate, (0.0,), (1.0,))
        form = {
            "measure": state["accumulated"],
            "position": state["accumulated"],
            "displacement": state["accumulated"],
            "jacobian": one_form(state, rest),
            "hessian": jax.jacfwd(lambda v: one_form(state, v))(rest),
            "velocity": velocity,
            "acceleration": acceleration,
        }
        values = {key: values[key].at[5].set(form[key]) for key in values}
    if type_name == "ROTATION-ACCELEROMETER":
        directions = Motion(state, rest).b
        spin_rate = (state["rates"][10:13] - state["rates"][3:6]) @ directions
        spin_acceleration = (state["accelerations"][10:13] - state["accelerations"][3:6]) @ directions
        values["velocity"] = values["velocity"].at[3:].set(spin_rate)
        values["acceleration"] = values["acceleration"].at[3:].set(spin_acceleration)
    if type_name == "ACCELEROMETER":
        directions = Motion(state, rest).b
        values["velocity"] = values["velocity"].at[:3].set((state["rates"][7:10] - state["rates"][0:3]) @ directions)
        acceleration = (state["accelerations"][7:10] - state["accelerations"][0:3]) @ directions
        values["acceleration"] = values["acceleration"].at[:3].set(acceleration)
    return values


# The revolute-joint multi-point constraint


def joint_measures(state, variation):
    """rho(3) of C_S [C(phi_J a) C_M]^T, and the angle of C_M^T C_S about a0."""
    s = after(versor(variation[0:3]), versor(state["theta_S"]))
    m = after(versor(variation[3:6]), versor(state["theta_M"]))
    axis = rodrigues(variation[3:6]) @ (rodrigues(state["theta_M"]) @ state["axis"])
    followed = after(versor((state["phi_J"] + variation[6]) * axis), m)
    rho = principal_vector(after(s, reversed_rotation(followed)))
    relative = after(reversed_rotation(m), s)
    angle = 2.0 * jnp.arctan2(relative[1:] @ state["axis"], relative[0])
    return jnp.concatenate([rho, angle[None]])


def joint_derivatives(state):
    def rows(variation_and_time):
        return joint_measures(state, variation_and_time[:7] + along(state, variation_and_time[7]))

    measure, jacobian, hessian = value_jacobian_hessian(rows, 8)
    equivalent = rodrigues(state["theta_M"]) @ rodrigues(state["phi_J"] * state["axis"])
    return {
        "measure": measure,
        "jacobian": jacobian[:, :7],
        "hessian": hessian[:, :7, :7],
        "velocity": jacobian[:, 7],
        "acceleration": hessian[:, 7, 7],
        "defect": jnp.linalg.norm(rodrigues(state["theta_S"]) - equivalent),
    }
