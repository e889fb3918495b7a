"""Wrong routines by a hand that had not read how causes are found: each with its mistake in words, written before it was run.

A routine is a formula of its own (six numbers with derivatives), or right numbers that are spoiled.
"""

import math
import os

import constraints
import frictions
import jets as j
import numpy
from connectors import Motion, answers, cardan, measures, on_sheet, right, skew, swing
from jets import atan2, cross, dot, norm, scaled, sub

OFFERS = os.environ.get("CORPUS_OFFERS", "values,rows").split(",")
"""What the command asks for: it reads the offers of a module."""

CASES = {}
"""By name: what is asked, what is offered, the mistake in words, the routine."""

BOTH = ("values", "rows")


def enter(name, of, words, routine, offers=BOTH, **more):
    routine.__name__ = routine.__qualname__ = name
    routine.__module__ = __name__
    globals()[name] = routine
    CASES[name] = {"of": of, "words": words, "routine": routine, "offers": offers, **more}


def formula(name, of, words, numbers, offers=BOTH):
    """A formula: numbers(m, m0, right) gives six jets, m0 of the initial state."""

    def routine(state, connector, want=()):
        m = Motion(state, connector, want)
        return answers(numbers(m, m.initially(), measures(of, m, state["previous"]["values"])), connector)

    enter(name, of, words, routine, offers)


def spoiled(name, of, words, change, offers=BOTH, **more):
    """Right numbers, changed in place by change(given, m)."""
    base = right(of)

    def routine(state, connector, want=()):
        given = base(state, connector, want)
        if tuple(want) == ("values",) and offers != want:
            # Values alone are asked for where the routine's own are differenced.
            return given
        given = {key: numpy.array(x) if key.startswith("element") else [None if y is None else numpy.array(y) for y in x] for key, x in given.items()}
        change(given, Motion(state, connector))
        return given

    enter(name, of, words, routine, offers, **more)


def none(*six):
    return [*six, *[None] * (6 - len(six))]


def replaced(found, **by):
    places = {"u1": 0, "u2": 1, "u3": 2, "ur1": 3, "ur2": 4, "ur3": 5}
    found = list(found)
    for key, x in by.items():
        found[places[key]] = x
    return found


def v(x):
    return j.value(x)


def vs(xs):
    return [j.value(x) for x in xs]


# Formulas

formula("axial_squared", "AXIAL", "the square of the length, no root is taken", lambda m, m0, ok: none(dot(m.d, m.d) - v(dot(m0.d, m0.d))))
formula("axial_reference_twice", "AXIAL", "the initial length is subtracted twice", lambda m, m0, ok: none(norm(m.d) - 2 * v(norm(m0.d))))
formula("axial_strain", "AXIAL", "a strain: over the initial length", lambda m, m0, ok: none((norm(m.d) - v(norm(m0.d))) * (1 / v(norm(m0.d)))))
formula("link_logarithm", "LINK", "a logarithmic strain, not a length", lambda m, m0, ok: none(j.log(norm(m.d)) - math.log(v(norm(m0.d)))))
formula("axial_linear", "AXIAL", "linearised: along the initial direction", lambda m, m0, ok: none(dot(scaled(vs(m0.d), 1 / v(norm(m0.d))), sub(m.d, vs(m0.d)))))
formula("cartesian_of_b", "CARTESIAN", "along the axes of b instead of a", lambda m, m0, ok: [*(dot(e, m.d) - v(dot(e0, m0.d)) for e, e0 in zip(m.b, m0.b)), *[None] * 3])
formula("cartesian_global", "CARTESIAN", "along the global axes, orientation ignored", lambda m, m0, ok: [*(x - v(y) for x, y in zip(m.d, m0.d)), *[None] * 3])
formula("cartesian_displacements", "CARTESIAN", "of displacements: the initial separation does not turn", lambda m, m0, ok: [*(dot(e, sub(m.d, vs(m0.d))) for e in m.a), *[None] * 3])
formula("cartesian_transposed", "CARTESIAN", "the triad is transposed: rows for columns", lambda m, m0, ok: [*(dot([e[i] for e in m.a], m.d) - v(dot([e[i] for e in m0.a], m0.d)) for i in range(3)), *[None] * 3])
formula("join_reversed", "JOIN", "from b to a: the opposite sign", lambda m, m0, ok: [*(-x for x in ok[:3]), *[None] * 3])
formula("thrust_exchanged", "RADIAL-THRUST", "radial and thrust components exchanged", lambda m, m0, ok: [ok[2], None, ok[0], *[None] * 3])
formula("radial_whole", "RADIAL-THRUST", "the radius is the whole length: the part along the axis is not taken off", lambda m, m0, ok: replaced(ok, u1=norm(m.d) - v(norm(m0.d))))
formula("radial_axis", "RADIAL-THRUST", "axis e1 instead of e3", lambda m, m0, ok: [norm([dot(m.a[1], m.d), dot(m.a[2], m.d)]) - v(norm([dot(m0.a[1], m0.d), dot(m0.a[2], m0.d)])), None, dot(m.a[0], m.d) - v(dot(m0.a[0], m0.d)), *[None] * 3])
formula("projection_of_a", "PROJECTION CARTESIAN", "the axes of a, not those halfway", lambda m, m0, ok: [*(dot(e, m.d) - v(dot(f, m0.d)) for e, f in zip(m.a, m0.a)), *[None] * 3])
formula("strip_without_flow", "SLIPRING", "the material that flows in is forgotten", lambda m, m0, ok: replaced(ok, u1=norm(m.d) * (1 / v(norm(m0.d))) - 1.0))
formula("strip_flow_reversed", "SLIPRING", "the flow has the opposite sign", lambda m, m0, ok: replaced(ok, u1=norm(m.d) / (v(norm(m0.d)) - m.flow[0] + m.flow[1]) - 1.0))
formula("revolute_degrees", "REVOLUTE", "ur1 in degrees", lambda m, m0, ok: replaced(ok, ur1=ok[3] * (180 / math.pi)))
formula("revolute_acos", "REVOLUTE", "acos of a cosine: the sign of the angle is lost", lambda m, m0, ok: replaced(ok, ur1=j.acos(j.over(m.r[2][2], norm([m.r[1][2], m.r[2][2]]))) - math.acos(v(m0.r[2][2]) / math.hypot(v(m0.r[1][2]), v(m0.r[2][2])))))
formula("revolute_principal", "REVOLUTE", "principal: turns are not counted", lambda m, m0, ok: replaced(ok, ur1=cardan(m)[0] - v(cardan(m0)[0])))
formula("revolute_backwards", "REVOLUTE", "ur1 of a against b: its sign", lambda m, m0, ok: replaced(ok, ur1=-ok[3]))
formula("revolute_exchanged", "REVOLUTE", "the two constraints exchanged", lambda m, m0, ok: replaced(ok, ur2=ok[5], ur3=ok[4]))
formula("revolute_not_initial", "REVOLUTE", "the initial angle is not subtracted", lambda m, m0, ok: replaced(ok, ur1=ok[3] + v(cardan(m0)[0])))
formula("universal_sine", "UNIVERSAL", "ur1 as the sine of the angle, small angles assumed", lambda m, m0, ok: replaced(ok, ur1=-m.r[1][2] + v(m0.r[1][2])))
formula("cardan_321", "CARDAN", "the sequence 3-2-1 for 1-2-3", lambda m, m0, ok: [None] * 3 + [x - v(y) for x, y in zip(zyx(m), zyx(m0))])
formula("cardan_reversed", "CARDAN", "the rotation from b to a: transposed", lambda m, m0, ok: [None] * 3 + [x - v(y) for x, y in zip(cardan(swapped(m)), cardan(swapped(m0)))])
formula("cardan_atan", "CARDAN", "atan without quadrant", lambda m, m0, ok: replaced(ok, ur1=j.atan(j.over(-m.r[1][2], m.r[2][2])) - math.atan(-v(m0.r[1][2]) / v(m0.r[2][2]))))
formula("cardan_asin", "CARDAN", "asin loses digits at a right angle", lambda m, m0, ok: replaced(ok, ur2=j.asin(m.r[0][2]) - math.asin(v(m0.r[0][2]))))
formula("euler_exchanged", "EULER", "first and third angle exchanged", lambda m, m0, ok: replaced(ok, ur1=ok[5], ur3=ok[3]))
formula("euler_acos", "EULER", "acos loses digits where the axes are aligned", lambda m, m0, ok: replaced(ok, ur2=j.acos(m.r[2][2]) - math.acos(v(m0.r[2][2]))))
formula("rotation_difference", "ROTATION", "difference of the nodes' rotation vectors, no composition", lambda m, m0, ok: [None] * 3 + sub(total_vector(m, "b"), total_vector(m, "a")))
formula("rotation_global", "ROTATION", "components along global axes", lambda m, m0, ok: [None] * 3 + sub(spatial_vector(m), vs(spatial_vector(m0))))
formula("rotation_half", "ROTATION", "the vector of the quaternion: half of the angle", lambda m, m0, ok: [None] * 3 + sub(j.quaternion(m.r)[1:], vs(j.quaternion(m0.r)[1:])))
formula("rotation_sine", "ROTATION", "twice the vector of the quaternion: a sine for an angle", lambda m, m0, ok: [None] * 3 + scaled(sub(j.quaternion(m.r)[1:], vs(j.quaternion(m0.r)[1:])), 2.0))
formula("rotation_acos", "ROTATION", "acos of the trace: digits lost at small angles and near π", lambda m, m0, ok: [None] * 3 + sub(on_sheet(by_trace(m), total(m, by_trace(m0))), vs(by_trace(m0))))
formula("align_skew", "ALIGN", "the skew part in place of the rotation vector", lambda m, m0, ok: [None] * 3 + [(x - y) * 0.5 for x, y in skew_pairs(back(m, m0))])
formula("align_global", "ALIGN", "components along global axes", lambda m, m0, ok: [None] * 3 + spatial_vector(m))
formula("flexion_acos", "FLEXION-TORSION", "flexion by acos: digits lost at zero flexion", lambda m, m0, ok: replaced(ok, ur1=j.acos(dot(m.a[2], m.b[2])) - math.acos(v(dot(m0.a[2], m0.b[2])))))
formula("flexion_exchanged", "FLEXION-TORSION", "torsion and sweep exchanged", lambda m, m0, ok: replaced(ok, ur2=ok[5], ur3=ok[4]))
formula("sweep_backwards", "FLEXION-TORSION", "the sweep turns the other way", lambda m, m0, ok: replaced(ok, ur3=-ok[5]))
formula("projection_flexion_of_a", "PROJECTION FLEXION-TORSION", "flexions along the axes of a, not those halfway", lambda m, m0, ok: replaced(ok, ur1=dot(m.a[0], swing(m)) - v(dot(m0.a[0], swing(m0))), ur2=dot(m.a[1], swing(m)) - v(dot(m0.a[1], swing(m0)))))
formula("velocity_double", "CONSTANT VELOCITY", "twice the torsion", lambda m, m0, ok: replaced(ok, ur2=ok[4] * 2.0))
formula("velocity_chord", "CONSTANT VELOCITY", "the dot product e1b·e2a in place of the angle", lambda m, m0, ok: replaced(ok, ur2=m.r[1][0] - v(m0.r[1][0])))
formula("bushing_cyclic", "BUSHING", "torsion first: ur1, ur2, ur3 stand in the order 3, 1, 2", lambda m, m0, ok: [*ok[:3], ok[5], ok[3], ok[4]])
formula("cylindrical_millimetres", "CYLINDRICAL", "u1 in mm, all else in m", lambda m, m0, ok: replaced(ok, u1=ok[0] * 1000.0))
formula("planar_sign", "PLANAR", "u2 has the opposite sign", lambda m, m0, ok: replaced(ok, u2=-ok[1]))
formula("ujoint_exchanged", "UJOINT", "ur1 and ur3 exchanged", lambda m, m0, ok: replaced(ok, ur1=ok[5], ur3=ok[3]))
formula("translator_initial_axes", "TRANSLATOR", "the axes of the slot stay those of the initial state", lambda m, m0, ok: [*(dot(vs(e), m.d) - v(dot(e, m0.d)) for e in m0.a), *ok[3:]])
formula("hinge_cardan_for_dot", "HINGE", "ur2 as an angle of half its size", lambda m, m0, ok: replaced(ok, ur2=ok[4] * 0.5))


def zyx(m):
    r = m.r
    return [atan2(r[2][1], r[2][2]), atan2(-r[2][0], norm([r[2][1], r[2][2]])), atan2(r[1][0], r[0][0])]


def swapped(m):
    m = Motion(m.state, m.connector, ("values",) if m.constant else ())
    m.r = [[m.r[k][i] for k in range(3)] for i in range(3)]
    return m


def total_vector(m, node):
    """The rotation vector of a node since the initial state."""
    e, first = m.a if node == "a" else m.b, m.connector["initial"][node]["triad"]
    c = [[dot([x[i] for x in e], [float(x[k]) for x in first]) for k in range(3)] for i in range(3)]
    return j.rotation_vector(c)


def spatial_vector(m):
    """log(B Aᵀ)."""
    return j.rotation_vector([[dot([e[i] for e in m.b], [e[k] for e in m.a]) for k in range(3)] for i in range(3)])


def skew_pairs(r):
    return [(r[(k + 2) % 3][(k + 1) % 3], r[(k + 1) % 3][(k + 2) % 3]) for k in range(3)]


def by_trace(m):
    angle = j.acos((m.r[0][0] + m.r[1][1] + m.r[2][2] - 1.0) * 0.5)
    return [(x - y) * 0.5 * (j.over(angle, j.sin(angle))) for x, y in skew_pairs(m.r)]


def total(m, first):
    """The right rotation vector at the state before."""
    before = m.state["previous"]["values"]
    return [float(before[3 + k] or 0.0) + v(first[k]) for k in range(3)]


def back(m, m0):
    return [[dot(m.r[i], vs(m0.r[k])) for k in range(3)] for i in range(3)]


# Rows


def each(change):
    """Applies a change to the row of each component that there is: change(row, k, m) gives the new one."""

    def spoil(given, m):
        given["rows"] = [None if row is None else change(row, k, m) for k, row in enumerate(given["rows"])]

    return spoil


def put(row, **blocks):
    row = row.copy()
    for name, block in blocks.items():
        first = {"xa": 0, "ta": 3, "xb": 7, "tb": 10}[name]
        row[first : first + 3] = block
    return row


def lever(k, m):
    return numpy.array(vs(cross(m.a[k], m.d)))


def length(m):
    return v(norm(m.d))


def at(k, change):
    return lambda row, i, m: change(row, m) if i == k else row


def axes_for_gradients(row, k, m):
    """The axes of the Cardan angles in place of their dual basis."""
    if k < 3:
        return row
    alpha = cardan(m)[0].v
    axes = [vs(m.a[0]), vs(j.add(scaled(m.a[1], math.cos(alpha)), scaled(m.a[2], math.sin(alpha)))), vs(m.b[2])]
    return put(row, ta=[-x for x in axes[k - 3]], tb=axes[k - 3])


def other_jacobian(given, m):
    """The inverse of the right for that of the left Jacobian: T for Tᵀ."""
    t = numpy.array([row[10:13] for row in given["rows"][3:]]) @ numpy.array([vs(e) for e in m.a]).T
    a = numpy.array([vs(e) for e in m.a])
    for k in range(3):
        row = t.T[k] @ a
        given["rows"][3 + k] = put(given["rows"][3 + k], ta=-row, tb=row)


spoiled("axial_not_normalised", "AXIAL", "the row is the separation, not its direction: times the length", each(lambda r, k, m: r * length(m)))
spoiled("axial_a_forgotten", "AXIAL", "nothing at node a", each(lambda r, k, m: put(r, xa=0)))
spoiled("slot_exchanged_rows", "SLOT", "the rows of u2 and u3 exchanged", lambda g, m: g.update(rows=[g["rows"][0], g["rows"][2], g["rows"][1], *[None] * 3]))
spoiled("plane_lever_doubled", "SLIDE-PLANE", "the lever term is taken twice", each(lambda r, k, m: put(r, ta=2 * r[3:6])))
spoiled("join_lever_at_b", "JOIN", "the moment acts on b instead of a", each(lambda r, k, m: put(r, ta=0, tb=r[3:6])))
spoiled("join_lever_of_initial", "JOIN", "the lever is that of the initial state", each(lambda r, k, m: put(r, ta=vs(cross(m.a[k], vs(m.initially().d))))))
spoiled("thrust_lever_missing", "RADIAL-THRUST", "no moment on a at all", each(lambda r, k, m: put(r, ta=0)))
spoiled("planar_lever_reversed", "PLANAR", "the lever term of the translations has the wrong sign", each(lambda r, k, m: put(r, ta=-r[3:6]) if k < 3 else r))
spoiled("revolute_same_sign", "REVOLUTE", "node a has the sign of node b", each(lambda r, k, m: put(r, ta=-r[3:6])))
spoiled("cardan_axes", "CARDAN", "the axes of the angles in place of their gradients", each(axes_for_gradients))
spoiled("rotation_small", "ROTATION", "small rotations: the axes, no tangent of the vector", each(lambda r, k, m: put(r, ta=[-x for x in vs(m.a[k - 3])], tb=vs(m.a[k - 3]))))
spoiled("rotation_other_tangent", "ROTATION", "the tangent of the vector is transposed", other_jacobian)
spoiled("euler_b_only", "EULER", "nothing at node a", each(lambda r, k, m: put(r, ta=0)))
spoiled("weld_body", "WELD", "rotations vary in the body: the columns turn with the nodes", lambda g, m: body_columns(g, m))
spoiled("beam_order", "BEAM", "rotations stand before displacements", each(lambda r, k, m: numpy.concatenate([r[3:6], r[0:3], r[6:7], r[10:13], r[7:10], r[13:14]])))
spoiled("cylindrical_nodes", "CYLINDRICAL", "the columns of a and b exchanged", each(lambda r, k, m: numpy.concatenate([r[7:], r[:7]])))
spoiled("ujoint_degrees", "UJOINT", "rotations in degrees in the columns", each(lambda r, k, m: put(r, ta=r[3:6] * (math.pi / 180), tb=r[10:13] * (math.pi / 180))))
spoiled("cvjoint_half", "CVJOINT", "the row of the torsion is half", each(lambda r, k, m: r * 0.5 if k == 4 else r))
spoiled("cvjoint_unit", "CVJOINT", "the direction e3a + e3b is made a unit vector: not divided by 1 + cos", each(lambda r, k, m: put(r, ta=r[3:6] / max(numpy.linalg.norm(r[3:6]), 1e-300), tb=r[10:13] / max(numpy.linalg.norm(r[10:13]), 1e-300)) if k == 4 else r))
spoiled("retractor_without_scale", "RETRACTOR", "the scale of the flow is left out", each(lambda r, k, m: numpy.concatenate([r[:13], [-1.0]]) if k == 5 else r))
spoiled("converter_of_b", "FLOW-CONVERTER", "the axis of b instead of a", each(lambda r, k, m: put(r, ta=vs(m.b[2]), tb=[-x for x in vs(m.b[2])]) if k == 5 else r))
spoiled("converter_flow_sign", "FLOW-CONVERTER", "the flow has the opposite sign", each(lambda r, k, m: numpy.concatenate([r[:13], -r[13:]]) if k == 5 else r))
spoiled("bushing_one_entry", "BUSHING", "one entry is zero: u2 by the second displacement of b", each(lambda r, k, m: numpy.where(numpy.arange(14) == 8, 0.0, r) if k == 1 else r))
spoiled("projection_frame_fixed", "PROJECTION CARTESIAN", "the axes halfway are taken as fixed: no rotation columns", each(lambda r, k, m: put(r, ta=0, tb=0)))
spoiled("link_nan_at_start", "LINK", "divides by the elongation: no number in the initial state", each(lambda r, k, m: r * ((length(m) - length(m.initially())) / (length(m) - length(m.initially())) if length(m) != length(m.initially()) else math.nan)))


def body_columns(given, m):
    a, b = (numpy.array([vs(e) for e in triad]) for triad in (m.a, m.b))
    given["rows"] = [None if r is None else put(r, ta=a @ r[3:6], tb=b @ r[10:13]) for r in given["rows"]]


# Second derivatives

SECOND = ("values", "rows", "second_derivatives")


def block(matrix, rows, columns, change):
    places = {"xa": slice(0, 3), "ta": slice(3, 6), "xb": slice(7, 10), "tb": slice(10, 13)}
    matrix[places[rows], places[columns]] = change(matrix[places[rows], places[columns]])


def matrices(change, key="second_derivatives"):
    def spoil(given, m):
        for k, matrix in enumerate(given[key]):
            if matrix is not None:
                given[key][k] = change(matrix, k, m)

    return spoil


def edited(*edits):
    def change(matrix, k, m):
        for rows, columns, f in edits:
            block(matrix, rows, columns, f)
        return matrix

    return change


def unsymmetric(matrix, k, m):
    return matrix + skewed(m, k)


def skewed(m, k):
    row = numpy.zeros(14)
    row[3:6] = lever(k, m)
    return skew(row)


spoiled("axial_second_undivided", "AXIAL", "not divided by the length", matrices(lambda h, k, m: h * length(m)), SECOND)
spoiled("link_second_whole", "LINK", "the identity over the length: the part along the link is not taken off", matrices(lambda h, k, m: whole(m)), SECOND)
spoiled("cartesian_second_order", "CARTESIAN", "one rotation after the other: not symmetric", matrices(unsymmetric), SECOND)
spoiled("cartesian_second_own", "CARTESIAN", "the second variation of the axes is missing", matrices(edited(("ta", "ta", lambda b: 0 * b))), SECOND)
spoiled("hinge_second_sign", "HINGE", "the mixed blocks of rotations have the wrong sign", matrices(edited(("ta", "tb", lambda b: -b), ("tb", "ta", lambda b: -b))), SECOND)
spoiled("rotation_second_none", "ROTATION", "no second derivatives at all", matrices(lambda h, k, m: 0 * h), SECOND)
spoiled("slot_second_half", "SLOT", "the mixed blocks of displacement and rotation are missing below the diagonal", matrices(edited(("ta", "xb", lambda b: 0 * b), ("ta", "xa", lambda b: 0 * b))), SECOND)
spoiled("cardan_second_double", "CARDAN", "twice as large: the half of a Taylor term", matrices(lambda h, k, m: 2 * h), SECOND)
spoiled("universal_second_a", "UNIVERSAL", "the block of node a alone is missing", matrices(edited(("ta", "ta", lambda b: 0 * b))), SECOND)


def whole(m):
    h = numpy.zeros((14, 14))
    i = numpy.eye(3) / length(m)
    h[0:3, 0:3] = h[7:10, 7:10] = i
    h[0:3, 7:10] = h[7:10, 0:3] = -i
    return h


# Rates

RATES = ("values", "rows", "rates")
ACCELERATIONS = ("values", "rows", "rates", "accelerations")


def moving(node, of):
    return lambda m: numpy.array(m.state[node][of])


def relative(m):
    return moving("b", "velocity")(m) - moving("a", "velocity")(m)


def numbers(key, change):
    """change(x, k, m) of each number."""

    def spoil(given, m):
        given[key] = [None if x is None else change(float(x), k, m) for k, x in enumerate(given[key])]

    return spoil


def e(m, k):
    return numpy.array(vs(m.a[k]))


def d(m):
    return numpy.array(vs(m.d))


def omega(m):
    return moving("a", "angular_velocity")(m)


def without_curvature(x, k, m):
    v_, q = relative(m), d(m) / length(m)
    return x - (v_ @ v_ - (q @ v_) ** 2) / length(m)


spoiled("cartesian_rate_fixed", "CARTESIAN", "the axes do not turn: no angular velocity of a", numbers("rates", lambda x, k, m: e(m, k) @ relative(m)), RATES)
spoiled("cartesian_no_coriolis", "CARTESIAN", "no Coriolis term", numbers("accelerations", lambda x, k, m: x - 2 * numpy.cross(omega(m), e(m, k)) @ relative(m)), ACCELERATIONS)
spoiled("cartesian_one_coriolis", "CARTESIAN", "the Coriolis term once, not twice", numbers("accelerations", lambda x, k, m: x - numpy.cross(omega(m), e(m, k)) @ relative(m)), ACCELERATIONS)
spoiled("join_no_centrifugal", "JOIN", "no centrifugal term", numbers("accelerations", lambda x, k, m: x - numpy.cross(omega(m), numpy.cross(omega(m), e(m, k))) @ d(m)), ACCELERATIONS)
spoiled("slot_no_euler", "SLOT", "no term of the angular acceleration", numbers("accelerations", lambda x, k, m: x - numpy.cross(moving("a", "angular_acceleration")(m), e(m, k)) @ d(m)), ACCELERATIONS)
spoiled("axial_no_curvature", "AXIAL", "no quadratic term: the rows times the accelerations alone", numbers("accelerations", without_curvature), ACCELERATIONS)
spoiled("rotation_rate_omega", "ROTATION", "the relative angular velocity for the rate of the vector", numbers("rates", lambda x, k, m: e(m, k - 3) @ (moving("b", "angular_velocity")(m) - omega(m))), RATES)
spoiled("revolute_rate_degrees", "REVOLUTE", "rates in degrees", numbers("rates", lambda x, k, m: x * 180 / math.pi), RATES)
spoiled("hinge_rate_sign", "HINGE", "the rate of ur1 has the wrong sign", numbers("rates", lambda x, k, m: -x if k == 3 else x), RATES)
spoiled("accelerometer_of_a", "ACCELEROMETER", "rates along the axes of a", numbers("rates", lambda x, k, m: e(m, k) @ relative(m)), RATES)
spoiled("accelerometer_derivative", "ROTATION-ACCELEROMETER", "rates along the axes of a", numbers("rates", lambda x, k, m: e(m, k - 3) @ (moving("b", "angular_velocity")(m) - omega(m))), RATES)
spoiled("translator_rate_of_b", "TRANSLATOR", "only the velocity of b enters", numbers("rates", lambda x, k, m: e(m, k) @ moving("b", "velocity")(m) if k == 0 else x), RATES)

# Forces

FORCES = ("nodal_forces",)
STIFFNESS = ("nodal_forces", "geometric_stiffness")
ELEMENT = ("element_forces", "element_stiffness")
SPRINGS = {"springs": (250.0, 40.0, 15.0, 7.0, 5.0, 3.0)}


def forces(change):
    def spoil(given, m):
        given["nodal_forces"] = [None if row is None else change(row, k, m) for k, row in enumerate(given["nodal_forces"])]

    return spoil


def of_springs(m, given):
    springs = [float(x) if x is not None and x == x else 0.0 for x in m.connector["springs"]]
    stiffness = lambda k: given["geometric_stiffness"][k] + skew(given["rows"][k])
    return [(dk, float(given["values"][k]), given["rows"][k], stiffness(k)) for k, dk in enumerate(springs) if given["values"][k] is not None]


def material_only(g, m):
    g["element_stiffness"] = sum(dk * numpy.outer(r, r) for dk, c, r, kg in of_springs(m, g))


def total_length(g, m):
    g["element_forces"] = sum(dk * (c + length(m.initially())) * r for dk, c, r, kg in of_springs(m, g))


def half_geometric(g, m):
    g["element_stiffness"] = sum(dk * (numpy.outer(r, r) + 0.5 * c * kg) for dk, c, r, kg in of_springs(m, g))


spoiled("cartesian_no_moment", "CARTESIAN", "no moment on a", forces(lambda r, k, m: put(r, ta=0)), FORCES)
spoiled("slot_on_the_body", "SLOT", "forces on the body: the opposite sign", forces(lambda r, k, m: -r), FORCES)
spoiled("plane_moment_at_b", "SLIDE-PLANE", "the moment of the force acts on b", forces(lambda r, k, m: put(r, ta=0, tb=r[3:6])), FORCES)
spoiled("euler_moments_b", "EULER", "no moment on a: not in equilibrium", forces(lambda r, k, m: put(r, ta=0)), FORCES)
spoiled("link_stiffness_sign", "LINK", "the geometric stiffness has the wrong sign", matrices(lambda h, k, m: -h, "geometric_stiffness"), STIFFNESS)
spoiled("axial_stiffness_none", "AXIAL", "no geometric stiffness", matrices(lambda h, k, m: 0 * h, "geometric_stiffness"), STIFFNESS)
spoiled("cartesian_stiffness_spatial", "CARTESIAN", "one rotation after the other: not symmetric", matrices(unsymmetric, "geometric_stiffness"), STIFFNESS)
spoiled("euler_stiffness_half", "EULER", "half of the geometric stiffness", matrices(lambda h, k, m: 0.5 * h, "geometric_stiffness"), STIFFNESS)
spoiled("axial_spring_total", "AXIAL", "the spring is slack at zero length: the total length is stretched", total_length, ("element_forces",), **SPRINGS)
spoiled("cartesian_spring_material", "CARTESIAN", "no geometric part in the stiffness", material_only, ELEMENT, **SPRINGS)
spoiled("cardan_spring_half", "CARDAN", "half of the geometric part in the stiffness", half_geometric, ELEMENT, **SPRINGS)
spoiled("axial_spring_sign", "AXIAL", "the forces on the body: the opposite sign, forces and stiffness", lambda g, m: g.update(element_forces=-g["element_forces"], element_stiffness=-g["element_stiffness"]), ELEMENT, **SPRINGS)

for entry in (*constraints.CASES, *frictions.CASES):
    enter(*entry)
