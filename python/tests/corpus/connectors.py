"""Connectors by formulas of their own, right unless `wrong` names a mistake: values, rows, second derivatives, rates, forces."""

import math

import jets as j
import numpy
from jets import Jet, atan2, cross, dot, norm, scaled, sub

TIME = 14


class Motion:
    """The two nodes, displaced by 14 variations and by time."""

    def __init__(self, state, connector, want=()):
        self.state, self.connector = state, connector
        self.constant = tuple(want) == ("values",)
        q = j.variables(numpy.zeros(15), self.constant)
        t = q[TIME]
        self.q = q
        self.x, self.e, self.flow = [], [], []
        for name, first in (("a", 0), ("b", 7)):
            node = state[name]
            v = [*node.get("velocity", [0] * 3), *node.get("angular_velocity", [0] * 3), node.get("flow_velocity", 0)]
            a = [*node.get("acceleration", [0] * 3), *node.get("angular_acceleration", [0] * 3), node.get("flow_acceleration", 0)]
            way = [q[first + i] + t * float(v[i]) + t * t * (0.5 * float(a[i])) for i in range(7)]
            self.x.append([float(node["x"][i]) + way[i] for i in range(3)])
            self.e.append([j.turned([float(x) for x in e], way[3:6]) for e in node["triad"]])
            self.flow.append(float(node.get("flow", 0)) + way[6])
        self.a, self.b = self.e
        self.d = sub(self.x[1], self.x[0])
        self.r = j.product(self.a, self.b)

    def initially(self):
        """The same at the initial state, of numbers."""
        initial = self.connector["initial"]
        still = {name: {"x": initial[name]["x"], "triad": initial[name]["triad"]} for name in "ab"}
        return Motion(still, self.connector, ("values",))

    def before(self):
        """The same at the state before."""
        return Motion({name: {k: v for k, v in self.state["previous"][name].items() if "veloc" not in k} for name in "ab"}, self.connector, ("values",))


def carried(first, third, middle):
    """first after the smallest rotation that takes third to middle."""
    share = j.over(dot(first, middle), 1.0 + dot(third, middle))
    return sub(first, scaled([x + y for x, y in zip(third, middle)], share))


def halfway(m):
    both = j.add(m.a[2], m.b[2])
    third = scaled(both, j.reciprocal(norm(both)))
    return third, carried(m.a[0], m.a[2], third), carried(m.b[0], m.b[2], third)


def swing(m):
    """The rotation vector of the smallest rotation from e3a to e3b, by their chord: no digits are lost near π."""
    chord, both = sub(m.a[2], m.b[2]), j.add(m.a[2], m.b[2])
    third = scaled(both, j.reciprocal(norm(both)))
    return scaled(cross(chord, third), j.quotient(dot(chord, chord) * 0.25, norm(both) * 0.5))


def torsion(m):
    third, from_a, from_b = halfway(m)
    return atan2(dot(third, cross(from_a, from_b)), dot(from_a, from_b))


def middle_triad(m, beta, share=0.5):
    """Directions halfway between both triads; beta is the torsion."""
    third, first, _ = halfway(m)
    second = cross(third, first)
    half = beta * share
    e1 = j.add(scaled(first, j.cos(half)), scaled(second, j.sin(half)))
    return [e1, cross(third, e1), third]


def cardan(m):
    r = m.r
    return [atan2(-r[1][2], r[2][2]), atan2(r[0][2], norm([r[1][2], r[2][2]])), atan2(-r[0][1], r[0][0])]


def euler(m, side=1.0):
    r = m.r
    return [atan2(r[0][2] * side, r[1][2] * -side), atan2(norm([r[0][2], r[1][2]]), r[2][2]) * side, atan2(r[2][0] * side, r[2][1] * side)]


def near(x, want):
    """An angle by the whole turns by which it is nearest to another."""
    return x if want is None or not math.isfinite(want) else x + 2 * math.pi * round((want - j.value(x)) / (2 * math.pi))


def on_sheet(vector, want):
    """A rotation vector, lengthened by the whole turns by which it is nearest to another."""
    size = math.sqrt(sum(j.value(x) ** 2 for x in vector))
    if want is None or not 0 < size < math.inf:
        return vector
    along = sum(w * j.value(x) for w, x in zip(want, vector)) / size
    turns = round((along - size) / (2 * math.pi))
    return vector if turns == 0 else scaled(vector, 1.0 + 2 * math.pi * turns / norm(vector))


def translation(kind, m, start, before):
    d = m.d
    if kind == "frame":
        return [dot(e, d) for e in m.a]
    if kind == "length":
        return [norm(d), None, None]
    if kind == "belt":
        first = j.value(norm(m.initially().d))
        return [norm(d) / (first + m.flow[0] - m.flow[1]) - 1.0, m.flow[1], m.flow[0]]
    if kind == "radial":
        along = dot(m.a[2], d)
        return [norm(sub(d, scaled(m.a[2], along))), None, along]
    if kind == "middle":
        beta = torsion(m)
        if before is not None:
            # Half of the torsion goes on from the state before, on the side on which its values are.
            old = m.before()
            last = torsion(old)
            side = [dot(e, old.d) for e in middle_triad(old, last)]
            want = [before[k] + start[k] for k in range(2)]
            if side[0] * want[0] + side[1] * want[1] < 0:
                last = last + 2 * math.pi
            beta = near(beta, last)
        return [dot(e, d) for e in middle_triad(m, beta)]
    return [None] * 3


def rotation(kind, m, start, before):
    total = None if before is None else [before[3 + k] + start[3 + k] for k in range(3)]
    pick = lambda k: None if total is None else total[k]
    if kind == "cardan":
        return [near(x, pick(k)) for k, x in enumerate(cardan(m))]
    if kind == "euler":
        both = [[near(x, pick(k)) for k, x in enumerate(euler(m, side))] for side in (1.0, -1.0)]
        return both[0] if total is None else min(both, key=lambda angles: sum((j.value(x) - w) ** 2 for x, w in zip(angles, total)))
    if kind == "vector":
        return on_sheet(j.rotation_vector(m.r), total)
    if kind == "shafts":
        return [None, near(torsion(m), pick(1)), None]
    if kind == "coupling":
        chord, both = sub(m.a[2], m.b[2]), j.add(m.a[2], m.b[2])
        return [atan2(norm(chord), norm(both)) * 2.0, near(torsion(m), pick(1)), near(atan2(m.r[0][2], -m.r[1][2]), pick(2))]
    if kind == "projection":
        beta = near(torsion(m), pick(2))
        frame = middle_triad(m, beta)
        return [dot(frame[0], swing(m)), dot(frame[1], swing(m)), beta]
    return [None] * 3


# Translations, rotations, and what constrained rotations hold: components u1 … ur3, C constrained, A available, . absent.
TYPES = {
    "JOIN": ("CCC...", "frame", None), "SLOT": ("ACC...", "frame", None), "SLIDE-PLANE": ("CAA...", "frame", None),
    "CARTESIAN": ("AAA...", "frame", None), "AXIAL": ("A.....", "length", None), "LINK": ("C.....", "length", None),
    "RADIAL-THRUST": ("A.A...", "radial", None), "PROJECTION CARTESIAN": ("AAA...", "middle", None),
    "ACCELEROMETER": ("AAA...", "frame", None), "SLIPRING": ("AAA...", "belt", None), "ALIGN": ("...CCC", None, "all"),
    "REVOLUTE": ("...ACC", None, "axis"), "UNIVERSAL": ("...ACA", None, "cross"), "CARDAN": ("...AAA", None, "cardan"),
    "EULER": ("...AAA", None, "euler"), "ROTATION": ("...AAA", None, "vector"), "ROTATION-ACCELEROMETER": ("...AAA", None, "vector"),
    "CONSTANT VELOCITY": ("....C.", None, "shafts"), "FLEXION-TORSION": ("...AAA", None, "coupling"),
    "PROJECTION FLEXION-TORSION": ("...AAA", None, "projection"), "FLOW-CONVERTER": (".....C", None, "drum"),
    "BEAM": ("CCCCCC", "frame", "all"), "WELD": ("CCCCCC", "frame", "all"), "HINGE": ("CCCACC", "frame", "axis"),
    "CYLINDRICAL": ("ACCACC", "frame", "axis"), "PLANAR": ("CAAACC", "frame", "axis"), "TRANSLATOR": ("ACCCCC", "frame", "all"),
    "UJOINT": ("CCCACA", "frame", "cross"), "CVJOINT": ("CCC.C.", "frame", "shafts"), "BUSHING": ("AAAAAA", "middle", "projection"),
    "RETRACTOR": ("CCC..C", "frame", "drum"),
}


def measures(name, m, before):
    """Six displacements or residuals; the initial ones are subtracted. `before` are the right values of the state before."""
    _, translations, rotations = TYPES[name]
    kind = {"axis": "cardan", "cross": "cardan", "all": None, "drum": None}.get(rotations, rotations)
    first = m.initially()
    start = [0.0 if x is None else j.value(x) for x in (*translation(translations, first, None, None), *rotation(kind, first, None, None))]
    given = [None if v is None or v != v else float(v) for v in before] if before is not None else [None] * 6
    known = None if all(v is None for v in given) else [0.0 if v is None else v for v in given]
    found = [*translation(translations, m, start, known), *rotation(kind, m, start, known)]
    found = [None if x is None else x - start[k] for k, x in enumerate(found)]
    if rotations in ("axis", "cross"):
        found[4] = dot(m.a[0], m.b[2])
    if rotations == "axis":
        found[5] = dot(m.a[0], m.b[1])
    if rotations == "all":
        # log(Q Q0ᵀ), along the directions of a.
        back = [[dot(m.r[i], [j.value(x) for x in first.r[k]]) for k in range(3)] for i in range(3)]
        found[3:6] = j.rotation_vector(back)
    if rotations == "drum":
        found[5] = drum(m, before)
    return [x if letter != "." else None for x, letter in zip(found, TYPES[name][0])]


def drum(m, before):
    """The one-form e3a·(δθ_a − δθ_b) − β_s δΨ_b, and its integral by the midpoint of the increment."""
    state, scale = m.state, float(m.connector["flow_scale"])
    turn_a, turn_b = ([float(x) for x in state[n]["increment"]] for n in "ab")
    e = rodrigues([0.5 * x for x in turn_a], [float(x) for x in state["previous"]["a"]["triad"][2]])
    flow = float(state["b"].get("flow", 0)) - float(state["previous"]["b"].get("flow", 0))
    moved = sum(e[i] * (turn_a[i] - turn_b[i]) for i in range(3)) - scale * flow
    row = numpy.zeros(15)
    row[3:6] = [j.value(x) for x in m.a[2]]
    row[10:13] = -row[3:6]
    row[13] = -scale
    return Jet((float(before[5]) if before is not None else 0.0) + moved, row, None if m.constant else numpy.zeros((15, 15)))


def rodrigues(theta, v):
    size = math.sqrt(sum(x * x for x in theta))
    if size == 0:
        return v
    k = [x / size for x in theta]
    c, s = math.cos(size), math.sin(size)
    along = sum(x * y for x, y in zip(k, v)) * (1 - c)
    across = [k[(i + 1) % 3] * v[(i + 2) % 3] - k[(i + 2) % 3] * v[(i + 1) % 3] for i in range(3)]
    return [c * v[i] + s * across[i] + along * k[i] for i in range(3)]


def skew(row):
    """What the derivative of a spatial gradient has beside the symmetric second derivatives: ½ ε_ijk g_k of each node's rotations."""
    matrix = numpy.zeros((14, 14))
    for first in (3, 10):
        for i in range(3):
            for k in range(3):
                n = 3 - i - k
                if i != k and 0 <= n < 3:
                    sign = 1.0 if (k - i) % 3 == 1 else -1.0
                    matrix[first + i, first + k] = 0.5 * sign * row[first + n]
    return matrix


def answers(found, connector):
    """All that there is to offer, of six jets or None."""
    pick = lambda f: [None if x is None else f(x) for x in found]
    if all(x is None or not isinstance(x, Jet) or x.h is None for x in found):
        return {"values": pick(j.value)}
    stiffness = lambda x: x.h[:14, :14] + skew(x.g)
    given = {
        "values": pick(lambda x: x.v),
        "rows": pick(lambda x: x.g[:14].copy()),
        "second_derivatives": pick(lambda x: x.h[:14, :14].copy()),
        "rates": pick(lambda x: x.g[TIME]),
        "accelerations": pick(lambda x: x.h[TIME, TIME]),
        "nodal_forces": pick(lambda x: x.g[:14].copy()),
        "geometric_stiffness": pick(lambda x: x.h[:14, :14].copy()),
    }
    if any(d is not None for d in connector.get("springs", [None])):
        springs = [(float(d), x) for d, x in zip(connector["springs"], found) if d is not None and x is not None and d == d]
        given["element_forces"] = sum(d * x.v * x.g[:14] for d, x in springs)
        given["element_stiffness"] = sum(d * (numpy.outer(x.g[:14], x.g[:14]) + x.v * stiffness(x)) for d, x in springs)
    return given


def right(name):
    """The right routine of a connection type."""

    def routine(state, connector, want=()):
        m = Motion(state, connector, want)
        given = answers(measures(name, m, state["previous"]["values"]), connector)
        if name in ("ACCELEROMETER", "ROTATION-ACCELEROMETER") and "rates" in given:
            first = 0 if name == "ACCELEROMETER" else 3
            for key, of in (("rates", "velocity"), ("accelerations", "acceleration")):
                of = of if first == 0 else f"angular_{of}"
                if of in state["a"]:
                    relative = state["b"][of] - state["a"][of]
                    given[key] = [None if x is None else float(state["b"]["triad"][k % 3] @ relative) for k, x in enumerate(given[key])]
        return given

    return routine
