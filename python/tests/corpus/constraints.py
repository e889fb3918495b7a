"""Multi-point constraints by formulas of their own, right unless `wrong` names a mistake; jets as of connectors."""

import jets as j
import numpy
from jets import add, cross, dot, norm, scaled, sub

EYE = numpy.eye(3)


def carrying(vector, theta):
    """exp(theta^) vector of a rotation of any size, by its quaternion."""
    square = dot(theta, theta)
    if j.value(square) == 0:
        return j.turned(vector, theta)
    size = j.sqrt(square)
    c, s = j.cos(size), j.sin(size) / size
    along = dot(theta, vector) * ((1.0 - c) / square)
    return add(add(scaled(vector, c), scaled(cross(theta, vector), s)), scaled(theta, along))


def rotated(matrix, axis, angle):
    """The columns of a matrix of columns, turned about an axis."""
    return [carrying(column, scaled(axis, angle)) for column in matrix]


def numbers(kind, state, constraint, wrong):
    """Seven jets or None, of 14 variables, one for each hinge, and time."""
    hinges = {"REVOLUTE": 1, "UNIVERSAL": 2}.get(kind, 0)
    q = j.variables(numpy.zeros(15 + hinges))
    t = q[-1]
    x, u, c, flow = [], [], [], []
    for name, first in (("S", 0), ("M", 7)):
        node = state[name]
        v = [*node.get("velocity", [0] * 3), *node.get("angular_velocity", [0] * 3), node.get("flow_velocity", 0)]
        a = [*node.get("acceleration", [0] * 3), *node.get("angular_acceleration", [0] * 3), node.get("flow_acceleration", 0)]
        way = [q[first + i] + t * float(v[i]) + t * t * (0.5 * float(a[i])) for i in range(7)]
        x.append([float(node["x"][i]) + way[i] for i in range(3)])
        u.append([float(node["u"][i]) + way[i] for i in range(3)])
        c.append([j.turned([float(y) for y in e], way[3:6]) for e in node["triad"]])
        flow.append(float(node.get("flow", 0)) + way[6])
    speeds, hastes = (list(state.get(f"angle_{of}", [0] * hinges)) for of in ("velocities", "accelerations"))
    angles = [float(state["angles"][i]) + q[14 + i] + t * float(speeds[i]) + t * t * (0.5 * float(hastes[i])) for i in range(hinges)]
    arm = [float(y) for y in sub(constraint["initial"]["S"]["x"], constraint["initial"]["M"]["x"])]
    found = [None] * 7
    d = sub(x[0], x[1])
    of_arm = lambda triad: [sum(triad[k][i] * arm[k] for k in range(3)) for i in range(3)]
    if kind == "LINK":
        found[0] = dot(d, d) - sum(y * y for y in arm) if wrong == "square" else norm(d) - sum(y * y for y in arm) ** 0.5
    elif kind in ("PIN", "TIE"):
        found[:3] = sub(u[1], u[0]) if wrong == "reversed" else sub(u[0], u[1])
        if wrong == "positions":
            found[:3] = d
    elif kind == "BEAM":
        found[:3] = sub(d, arm if wrong == "arm fixed" else of_arm(c[0] if wrong == "arm of S" else c[1]))
        if wrong == "arm reversed":
            found[:3] = add(d, of_arm(c[1]))
    if kind == "TIE" and constraint["equations"][6] is not None:
        found[6] = flow[0] - flow[1]
    if kind in ("BEAM", "TIE", "REVOLUTE", "UNIVERSAL"):
        axes = [[float(y) for y in axis] for axis in constraint.get("axes", [])][:hinges]
        if wrong == "axes exchanged":
            axes.reverse()
        if wrong == "angle reversed":
            angles = [-y for y in angles]
        # C_M C(φ1 a1) C(φ2 a2), by columns: what is turned first stands last.
        inner = [[float(y) for y in e] for e in EYE]
        order = list(zip(axes, angles))
        for axis, angle in order if wrong == "order" else reversed(order):
            inner = rotated(inner, axis, angle) if wrong != "no hinge" else inner
        follows = [[sum(c[1][k][i] * column[k] for k in range(3)) for i in range(3)] for column in inner]
        if wrong == "vectors":
            of = [j.rotation_vector([[triad[k][i] for k in range(3)] for i in range(3)]) for triad in c]
            found[3:6] = sub(*of)
        else:
            r = [[sum(c[0][k][i] * follows[k][l] for k in range(3)) for l in range(3)] for i in range(3)]
            found[3:6] = j.rotation_vector(r)
        if wrong == "of M":
            found[3:6] = [dot(e, found[3:6]) for e in c[1]]
        if wrong == "half":
            found[3:6] = [y * 0.5 for y in found[3:6]]
    return found


def routine(kind, wrong="", change=None):
    def asked(state, constraint):
        found = numbers(kind, state, constraint, wrong)
        size = len(next(y for y in found if y is not None).g) - 1
        pick = lambda f: [None if y is None else f(y) for y in found]
        given = {
            "values": pick(lambda y: y.v),
            "rows": pick(lambda y: y.g[:size].copy()),
            "second_derivatives": pick(lambda y: y.h[:size, :size].copy()),
            "rates": pick(lambda y: y.g[size]),
            "accelerations": pick(lambda y: y.h[size, size]),
        }
        if change is not None:
            change(given, state)
        return given

    return asked


def of_rows(change):
    def spoil(given, state):
        given["rows"] = [None if row is None else change(row, k, state) for k, row in enumerate(given["rows"])]

    return spoil


def zero(row, *places):
    for first, end in places:
        row[first:end] = 0
    return row


def times(row, factor, first, end):
    row[first:end] *= factor
    return row


def small(row, k):
    if k < 3:
        return row
    row[:] = 0
    row[3 + k - 3], row[10 + k - 3] = 1, -1
    return row


def of_length(row, k, state):
    return row * numpy.linalg.norm(state["S"]["x"] - state["M"]["x"])


def no_centrifugal(given, state):
    # BEAM: the acceleration of the arm without ω × (ω × arm).
    omega = state["M"]["angular_velocity"]
    arm = numpy.array([[state["M"]["triad"][k][i] for k in range(3)] for i in range(3)]) @ ARM
    extra = numpy.cross(omega, numpy.cross(omega, arm))
    given["accelerations"][:3] = [x + extra[i] for i, x in enumerate(given["accelerations"][:3])]


def no_lever_rate(given, state):
    omega = state["M"]["angular_velocity"]
    arm = numpy.array([[state["M"]["triad"][k][i] for k in range(3)] for i in range(3)]) @ ARM
    given["rates"][:3] = [x + numpy.cross(omega, arm)[i] for i, x in enumerate(given["rates"][:3])]


ARM = numpy.array([0.7, -0.4, 0.9])
"""X_S − X_M of a constraint that is named by its kind."""

BOTH = ("values", "rows")
ALL = ("values", "rows", "second_derivatives", "rates", "accelerations")

CASES = [
    (name, f"MPC {kind}", words, routine(kind, *wrong), offers)
    for name, kind, words, wrong, offers in [
        ("mpc_link_square", "LINK", "the difference of squares, no root is taken", ("square",), BOTH),
        ("mpc_link_row", "LINK", "the row is the separation, not its direction: times the length", ("", of_rows(of_length)), BOTH),
        ("mpc_link_of_s", "LINK", "nothing at node M", ("", of_rows(lambda r, k, s: zero(r, (7, 10)))), BOTH),
        ("mpc_beam_fixed", "BEAM", "the arm does not turn", ("arm fixed",), BOTH),
        ("mpc_beam_of_s", "BEAM", "the arm turns with S instead of M", ("arm of S",), BOTH),
        ("mpc_beam_reversed", "BEAM", "the arm from S to M: its sign", ("arm reversed",), BOTH),
        ("mpc_beam_lever", "BEAM", "no lever term: the rotation of M moves nothing", ("", of_rows(lambda r, k, s: zero(r, (10, 13)) if k < 3 else r)), BOTH),
        ("mpc_beam_lever_sign", "BEAM", "the lever term has the wrong sign", ("", of_rows(lambda r, k, s: times(r, -1, 10, 13) if k < 3 else r)), BOTH),
        ("mpc_beam_half", "BEAM", "half of the rotation vector", ("half",), BOTH),
        ("mpc_beam_no_centrifugal", "BEAM", "no centrifugal term", ("", no_centrifugal), ("values", "accelerations")),
        ("mpc_beam_rate", "BEAM", "the angular velocity of M does not move S", ("", no_lever_rate), ("values", "rates")),
        ("mpc_pin_reversed", "PIN", "M less S: the opposite sign", ("reversed",), BOTH),
        ("mpc_pin_positions", "PIN", "positions instead of displacements: the initial separation is not subtracted", ("positions",), BOTH),
        ("mpc_tie_vectors", "TIE", "the difference of rotation vectors, no composition", ("vectors",), BOTH),
        ("mpc_tie_of_m", "TIE", "the rotation along the axes of M", ("of M",), BOTH),
        ("mpc_tie_small", "TIE", "small rotations: the rows are those of the difference of rotations", ("", of_rows(lambda r, k, s: small(r, k))), BOTH),
        ("mpc_revolute_no_hinge", "REVOLUTE", "the angle of the hinge is forgotten", ("no hinge",), BOTH),
        ("mpc_revolute_backwards", "REVOLUTE", "the hinge turns the other way", ("angle reversed",), BOTH),
        ("mpc_revolute_column", "REVOLUTE", "the column of the hinge has the wrong sign", ("", of_rows(lambda r, k, s: times(r, -1, 14, 15))), BOTH),
        ("mpc_universal_order", "UNIVERSAL", "the hinges in the other order", ("order",), BOTH),
        ("mpc_universal_axes", "UNIVERSAL", "the axes of the hinges exchanged", ("axes exchanged",), BOTH),
        ("mpc_universal_same_sign", "UNIVERSAL", "M has the sign of S in the rows", ("", of_rows(lambda r, k, s: times(r, -1, 7, 14))), BOTH),
    ]
]
