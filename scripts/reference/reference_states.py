"""States at which scripts/reference/reference.py evaluates the connection types.

Plain Python floats, random.Random.random() and square roots only, except where a rotation vector is
composed or a right angle is asked for, so that the states are the same on every machine. Each type
has a random stream of its own: adding a type leaves the states of the others as they are.

A state is a dictionary of the fields that the file src/audit/oracles/golden/jax.json documents. Orientations are
rows of the matrix whose columns are e1, e2, e3. Lengths and angles are in consistent units and radians,
constitutive reference angles in degrees.
"""

import math
import random
import sys

import owned  # noqa: F401
from reference_formulas import TABLE

SEED = 20261121
PI = math.pi
LARGEST_INCREMENT = 0.9
"""Bound on the sum of the rotation increments of both nodes in one step, rad."""

IDENTITY = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]
CUBE = [[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]

KNOWN = {None, "frame", "length", "belt", "radial", "middle", "cardan", "vector", "euler", "drum", "shafts", "coupling", "projection"}
"""The measures for which states are drawn here."""


def of(*measures, held=None):
    """The types of which a measure is one of these, of the table that reference_formulas.py types a second time."""
    return {name for name, (_, *both, holds) in TABLE.items() if set(both) & set(measures) and held in (None, holds)}


for name, (_, *both, _) in TABLE.items():
    for measure in set(both) - KNOWN:
        sys.exit(
            f"scripts/reference/reference_states.py: {name} is measured by {measure!r}, for which nothing says how its states are drawn. "
            "Add it to KNOWN and to a family: start() draws its initial axes, regular_along_path() keeps away from its singular points, "
            "near_pi() to right_angles() draw its special states."
        )

REVOLUTE_LIKE = of("cardan", held="axis")
UNIVERSAL_LIKE = of("cardan", held="cross")
ALIGN_LIKE = of("cardan", held="all")
CARDAN_LIKE = of("cardan")
EULER_LIKE = of("euler")
VECTOR_LIKE = of("vector")
DRUM_LIKE = of("drum")
MISALIGNABLE = REVOLUTE_LIKE | UNIVERSAL_LIKE | ALIGN_LIKE
TORSION_LIKE = of("shafts", "coupling", "projection", "middle")
FLOW_TYPES = of("drum", "belt")
HAS_FRAME = of("frame", "middle")
LENGTH_LIKE = of("length", "belt")
RADIAL_LIKE = of("radial")
COUPLING_LIKE = of("coupling")
SHAFTS_LIKE = of("shafts")
PROJECTION_LIKE = of("projection")

WITH_HESSIAN = {"random-1", "random-2", "tiny-2", "near-pi-2", "past-2pi-1", "misaligned-1", "right-angle-1"}
HESSIANS_PER_TYPE = 6


# Vectors, quaternions (w, x, y, z) and matrices on plain floats


def scaled(factor, vector):
    return [factor * x for x in vector]


def plain_sum(terms):
    """Left to right; the built-in sum() rounds differently from Python 3.12 on."""
    total = 0.0
    for term in terms:
        total += term
    return total


def added(*vectors):
    return [plain_sum(parts) for parts in zip(*vectors)]


def dot(a, b):
    return plain_sum(x * y for x, y in zip(a, b))


def norm(vector):
    return math.sqrt(dot(vector, vector))


def cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def unit(vector):
    return scaled(1.0 / norm(vector), vector)


def column(matrix, i):
    return [row[i] for row in matrix]


def product(a, b):
    return [[dot(row, column(b, j)) for j in range(3)] for row in a]


def transposed(a):
    return [column(a, i) for i in range(3)]


def matrix_of(quaternion):
    w, x, y, z = unit(quaternion)
    return [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]


def versor(rotation):
    angle = norm(rotation)
    if angle == 0.0:
        return [1.0, 0.0, 0.0, 0.0]
    return [math.cos(angle / 2), *scaled(math.sin(angle / 2) / angle, rotation)]


def matrix_exp(rotation):
    return matrix_of(versor(rotation))


def composed(second, first):
    """Rotation vector, at most pi long, of the rotation `first` followed by `second`."""
    p, q = versor(second), versor(first)
    w = p[0] * q[0] - dot(p[1:], q[1:])
    v = added(scaled(p[0], q[1:]), scaled(q[0], p[1:]), cross(p[1:], q[1:]))
    if w < 0.0:
        w, v = -w, scaled(-1.0, v)
    sine = norm(v)
    return [0.0, 0.0, 0.0] if sine == 0.0 else scaled(2.0 * math.atan2(sine, w) / sine, v)


def nearest_turn(rotation, target):
    """The rotation vector of the same rotation that is nearest to `target`."""
    axis = unit(rotation)
    turns = round((dot(axis, target) - norm(rotation)) / (2 * PI))
    return added(rotation, scaled(2 * PI * turns, axis))


def turned(*half_tangents_about):
    """Product of rotations given as (local axis number, tangent of the half angle)."""
    result = IDENTITY
    for axis, tangent in half_tangents_about:
        quaternion = [1.0, 0.0, 0.0, 0.0]
        quaternion[axis] = tangent
        result = product(result, matrix_of(quaternion))
    return result


class Draw(random.Random):
    def between(self, low, high):
        return low + (high - low) * self.random()

    def vector(self, size):
        return [self.between(-size, size) for _ in range(3)]

    def direction(self, dimension=3):
        while True:
            v = [self.between(-1.0, 1.0) for _ in range(dimension)]
            if 0.1 < norm(v) < 1.0:
                return unit(v)

    def orientation(self):
        return matrix_of(self.direction(4))

    def rotation(self, low, high):
        return scaled(self.between(low, high), self.direction())


def steps_for(*rotations):
    return max(1, math.ceil(sum(norm(r) for r in rotations) / LARGEST_INCREMENT))


# Orientation of b relative to a at the start


def bent(draw, twist):
    """Shafts at an angle, twisted about them by the angle of this half tangent."""
    swing = turned((3, draw.between(-0.8, 0.8)))
    return product(product(swing, turned((1, draw.between(0.3, 0.6)))), product(transposed(swing), turned((3, twist))))


def start(type_name, draw, misaligned=False):
    """A_0^T B_0: exactly admissible for the type, or, if asked for, misaligned by about half a radian."""
    if misaligned:
        return turned(*((axis, draw.between(0.12, 0.3)) for axis in (1, 2, 3)))
    if type_name in REVOLUTE_LIKE:
        return turned((1, draw.between(-0.4, 0.4)))
    if type_name in UNIVERSAL_LIKE:
        return turned((1, draw.between(-0.4, 0.4)), (3, draw.between(-0.4, 0.4)))
    if type_name in ALIGN_LIKE or type_name in VECTOR_LIKE:
        return IDENTITY
    if type_name in CARDAN_LIKE:
        return turned((1, draw.between(-0.5, 0.5)), (2, draw.between(-0.2, 0.2)), (3, draw.between(-0.5, 0.5)))
    if type_name in TORSION_LIKE:
        return bent(draw, draw.between(-0.4, 0.4))
    if type_name in EULER_LIKE:
        return turned((3, draw.between(-0.8, 0.8)), (1, draw.between(0.6, 1.0)), (3, draw.between(-0.8, 0.8)))
    return draw.orientation()


def regular_along_path(type_name, state, samples_per_step=8):
    """True when the state and the path to it stay clear of the singular points of the type."""
    if type_name in LENGTH_LIKE:
        d0 = added(state["X_b"], scaled(-1.0, state["X_a"]))
        d = added(d0, state["U_b"], scaled(-1.0, state["U_a"]))
        short = norm(d) < 0.2 * norm(d0)
        slack = norm(d0) + state["flow_a"] - state["flow_b"] < 0.3 * norm(d0)
        if short or slack:
            return False
    if type_name in RADIAL_LIKE:
        d = added(state["X_b"], scaled(-1.0, state["X_a"]))
        for u_a, u_b, theta_a in [([0.0] * 3, [0.0] * 3, [0.0] * 3), (state["U_a"], state["U_b"], state["theta_a"])]:
            axis = column(product(matrix_exp(theta_a), state["A0"]), 2)
            if norm(cross(axis, added(d, u_b, scaled(-1.0, u_a)))) <= 0.25 * norm(d):
                return False
    if type_name not in CARDAN_LIKE | TORSION_LIKE | EULER_LIKE:
        return True
    count = state["steps"] * samples_per_step
    for k in range(count + 1):
        a = product(matrix_exp(scaled(k / count, state["theta_a"])), state["A0"])
        b = product(matrix_exp(scaled(k / count, state["theta_b"])), state["B0"])
        if type_name in TORSION_LIKE:
            if norm(added(column(a, 2), column(b, 2))) < 0.9:
                return False
            if type_name in COUPLING_LIKE and norm(cross(column(a, 2), column(b, 2))) < 0.5:
                return False
            continue
        first = column(a, 2) if type_name in EULER_LIKE else column(a, 0)
        if norm(cross(first, column(b, 2))) < 0.2:
            return False
    return True


# States


def moved(type_name, draw, name, length=1.0, origin=0.0, a0=None, relative=None, theta_a=None, theta_b=None, still=False):
    """A state with drawn positions, rates and flows; `relative` is A_0^T B_0."""
    a0 = draw.orientation() if a0 is None else a0
    relative = start(type_name, draw) if relative is None else relative
    theta_a = [0.0, 0.0, 0.0] if theta_a is None else theta_a
    theta_b = [0.0, 0.0, 0.0] if theta_b is None else theta_b
    x_a = added(scaled(origin, draw.direction()), draw.vector(length))
    x_b = added(x_a, scaled(length * draw.between(0.6, 1.5), draw.direction()))
    drawn = {
        "U_a": draw.vector(0.2 * length),
        "U_b": draw.vector(0.2 * length),
        "v_a": draw.vector(length),
        "v_b": draw.vector(length),
        "a_a": draw.vector(2.0 * length),
        "a_b": draw.vector(2.0 * length),
        "omega_a": draw.vector(1.5),
        "omega_b": draw.vector(1.5),
        "alpha_a": draw.vector(2.0),
        "alpha_b": draw.vector(2.0),
    }
    flows = {
        key: draw.between(-size, size) * length
        for key, size in [
            ("flow_a", 0.2), ("flow_b", 0.2), ("flow_v_a", 1.0), ("flow_v_b", 1.0), ("flow_a_a", 2.0), ("flow_a_b", 2.0),
        ]
    }
    if type_name not in FLOW_TYPES:
        flows = dict.fromkeys(flows, 0.0)
    elif type_name in DRUM_LIKE:
        for key in ("flow_a", "flow_v_a", "flow_a_a"):
            flows[key] = 0.0
    if still:
        x_b = list(x_a)
    return {
        "type": type_name,
        "name": name,
        "steps": steps_for(theta_a, theta_b),
        "X_a": x_a,
        "X_b": x_b,
        "A0": a0,
        "B0": product(a0, relative),
        "theta_a": theta_a,
        "theta_b": theta_b,
        "beta_s": draw.between(0.5, 4.0) / length if type_name in DRUM_LIKE else 1.0,
        "reference": [None] * 6,
        **drawn,
        **flows,
    }


def regular(type_name, make):
    """The first regular state that `make` draws."""
    for _ in range(200):
        state = make()
        if regular_along_path(type_name, state):
            return state
    raise RuntimeError(f"{type_name}: no regular state found")


def general(type_name, draw, name, relative_angle, **options):
    """Both nodes turned, b by `relative_angle` rad more than a about a drawn axis."""

    def make():
        theta_a = draw.rotation(0.3, 1.2)
        theta_b = composed(scaled(relative_angle, draw.direction()), theta_a)
        return moved(type_name, draw, name, theta_a=theta_a, theta_b=theta_b, **options)

    return regular(type_name, make)


def free_axes(type_name, a0, b0):
    """Axes, one fixed in each node, about which large turns meet no singular point of the type."""
    if type_name in REVOLUTE_LIKE:
        return column(a0, 0), column(a0, 0)
    if type_name in CARDAN_LIKE:
        return column(a0, 0), column(b0, 2)
    if type_name in EULER_LIKE | TORSION_LIKE:
        return column(a0, 2), column(b0, 2)
    raise ValueError(type_name)


def tilted(draw, axis, amount):
    return unit(added(axis, scaled(amount, draw.direction())))


def near_pi(type_name, draw):
    gaps = [1e-3, 1e-6, -1e-4]
    if type_name in ALIGN_LIKE:
        gaps = [1e-3, 1e-6, 1e-4]
    for number, gap in enumerate(gaps, start=1):
        name = f"near-pi-{number}"

        def make():
            a0 = draw.orientation()
            relative = bent(draw, 0.0) if type_name in TORSION_LIKE else start(type_name, draw)
            b0 = product(a0, relative)
            if type_name in ALIGN_LIKE or type_name in VECTOR_LIKE:
                axis = tilted(draw, column(a0, 0), 0.5 if type_name in ALIGN_LIKE else 3.0)
                lead = draw.between(-0.8, 0.8)
                turns = scaled(lead, axis), scaled(lead + PI - gap, axis)
            elif type_name in CARDAN_LIKE | TORSION_LIKE | EULER_LIKE:
                _, axis = free_axes(type_name, a0, b0)
                axis = axis if number == 2 else tilted(draw, axis, 0.05)
                lead = draw.between(-0.5, 0.5) if type_name in REVOLUTE_LIKE else 0.0
                turns = scaled(lead, axis), scaled(lead + PI - gap, axis)
            else:
                turns = draw.rotation(PI - gap, PI - gap), draw.rotation(0.5, PI - gap)
            return moved(type_name, draw, name, a0=a0, relative=relative, theta_a=turns[0], theta_b=turns[1])

        yield regular(type_name, make)


def past_two_pi(type_name, draw):
    """Several turns; where the answer is known beforehand the state says so under "known"."""
    for number in (1, 2, 3):
        name = f"past-2pi-{number}"

        def make():
            a0 = draw.orientation()
            relative = start(type_name, draw)
            known = {}
            size = [7.0, 13.0, 19.0][number - 1] + draw.between(0.2, 0.7)
            if type_name in VECTOR_LIKE:
                axis = draw.direction()
                lead = 0.0 if number == 1 else draw.between(-2.0, 2.0)
                turns = scaled(lead, axis), scaled(lead + size, axis)
                known = {4 + i: size * dot(axis, column(a0, i)) for i in range(3)}
            elif type_name in ALIGN_LIKE:
                axis = draw.direction()
                turns = scaled(size, axis), added(scaled(size, axis), draw.rotation(0.05, 0.4))
            elif type_name in REVOLUTE_LIKE:
                axis = column(a0, 0)
                if number == 3:
                    turns = [0.0, 0.0, 0.0], scaled(size, tilted(draw, axis, 0.05))
                else:
                    lead = 0.0 if number == 1 else -5.0
                    turns = scaled(lead, axis), scaled(lead + size, axis)
                    known = {4: size}
            elif type_name in EULER_LIKE and number == 3:
                relative = turned((3, 0.2), (1, 0.5))
                turns = [0.0, 0.0, 0.0], scaled(7.4, column(product(a0, relative), 0))
                known = {4: 0.0, 5: 7.4, 6: 0.0}
            elif type_name in CARDAN_LIKE | TORSION_LIKE | EULER_LIKE:
                b0 = product(a0, relative)
                axis_a, axis_b = free_axes(type_name, a0, b0)
                tilt = 0.04 if number == 3 else 0.0
                back = [0.0, 8.0, 8.6][number - 1]
                turns = scaled(-back, tilted(draw, axis_a, tilt)), scaled(size, tilted(draw, axis_b, tilt))
                known = {4: back, 6: size}
                if type_name in TORSION_LIKE:
                    whole = back + size
                    known = {5: whole} if type_name in SHAFTS_LIKE else {6: whole} if type_name in PROJECTION_LIKE else {}
                    known = {4: 0.0, 5: whole, 6: back} if type_name in COUPLING_LIKE else known
                known = {} if tilt else known
            elif type_name in DRUM_LIKE:
                axis = column(a0, 2)
                if number == 3:
                    turns = scaled(45.0 + size, tilted(draw, axis, 0.3)), draw.rotation(2.0, 6.0)
                else:
                    many = 129.3 if number == 1 else 541.7
                    turns = scaled(many, axis), scaled(0.0 if number == 1 else -11.1, axis)
            else:
                turns = draw.rotation(size, size), draw.rotation(0.5, 9.0)
            state = moved(type_name, draw, name, a0=a0, relative=relative, theta_a=turns[0], theta_b=turns[1])
            if type_name in DRUM_LIKE and number != 3:
                drum = column(state["A0"], 2)
                turn = dot(drum, state["theta_a"]) - dot(drum, state["theta_b"])
                state["flow_b"] = turn / state["beta_s"] if number == 1 else 0.9 * turn / state["beta_s"]
                known = {6: turn - state["beta_s"] * state["flow_b"]}
            state["known"] = known
            return state

        if type_name in EULER_LIKE and number == 3:
            yield make()
        else:
            yield regular(type_name, make)


def right_angles(type_name, draw):
    quarter = PI / 2
    if type_name in EULER_LIKE | COUPLING_LIKE:
        relative = turned((1, 1.0))
        choices = [(relative, None, [0, 0, quarter]), (relative, None, [0, 0, PI])]
        about_b = True
    elif type_name in ALIGN_LIKE:
        choices = [(IDENTITY, None, [quarter, 0, 0]), (IDENTITY, [0, -quarter, 0], [0, -quarter, 0])]
        about_b = False
    elif type_name in UNIVERSAL_LIKE:
        choices = [(IDENTITY, None, [quarter, 0, 0]), (IDENTITY, [-quarter, 0, 0], [0, 0, -quarter])]
        about_b = False
    elif type_name in CARDAN_LIKE:
        choices = [(IDENTITY, None, [quarter, 0, 0]), (IDENTITY, None, [PI, 0, 0])]
        about_b = False
    elif type_name in VECTOR_LIKE or type_name in TORSION_LIKE:
        choices = [(IDENTITY, None, [0, quarter, 0]), (IDENTITY, None, [0, 0, PI])]
        about_b = False
    else:
        choices = [(IDENTITY, [0, quarter, 0], None), (IDENTITY, [PI, 0, 0], [0, -quarter, 0])]
        about_b = False
    for number, (relative, local_a, local_b) in enumerate(choices, start=1):
        b0 = product(CUBE, relative)
        frame_b = b0 if about_b else CUBE
        turn_a, turn_b = (
            None if local is None else [dot(row, [float(x) for x in local]) for row in frame]
            for local, frame in ((local_a, CUBE), (local_b, frame_b))
        )
        yield moved(
            type_name, draw, f"right-angle-{number}", a0=[list(row) for row in CUBE], relative=relative, theta_a=turn_a, theta_b=turn_b
        )


def with_reference(state, roles, draw):
    """Reference lengths and (in degrees) angles of the available components."""
    length = norm(added(state["X_b"], scaled(-1.0, state["X_a"])))
    for i, role in enumerate(roles):
        if role == "available":
            state["reference"][i] = draw.between(-1.0, 1.0) * (length if i < 3 else 40.0)


def states_of(type_name, roles):
    draw = Draw(f"{SEED}/{type_name}")
    states = []
    for number in range(1, 7):
        states.append(general(type_name, draw, f"random-{number}", draw.between(0.3, 1.0)))
    for number, angle in enumerate([1e-7, 1e-5, 1e-3], start=1):
        straight = {"relative": IDENTITY} if type_name in TORSION_LIKE - COUPLING_LIKE else {}
        states.append(general(type_name, draw, f"tiny-{number}", angle, **straight))
    states += near_pi(type_name, draw)
    states += past_two_pi(type_name, draw)
    states += right_angles(type_name, draw)
    if type_name in MISALIGNABLE:
        for number in (1, 2):
            relative = start(type_name, draw, misaligned=True)
            states.append(general(type_name, draw, f"misaligned-{number}", draw.between(0.2, 0.6), relative=relative))
    elif type_name in VECTOR_LIKE:
        relative = start(type_name, draw, misaligned=True)
        states.append(general(type_name, draw, "misaligned-1", 0.7, relative=relative))
    states.append(general(type_name, draw, "far", 0.6, origin=1e6))
    states.append(general(type_name, draw, "millimetre", 0.6, length=2e-3))
    states.append(general(type_name, draw, "kilometre", 0.6, length=2e3))
    if type_name in HAS_FRAME:
        states.append(general(type_name, draw, "coincident", 0.5, still=True))
    if type_name not in of("belt"):
        for state in states:
            if state["name"] in ("random-2", "random-5", "misaligned-1", "past-2pi-1"):
                with_reference(state, roles, draw)
    return states


def mpc_states():
    """States of the revolute-joint multi-point constraint: satisfied through turns, and violated."""
    draw = Draw(f"{SEED}/MPC")
    states = []
    kinds = [("satisfied", size, 0.0) for size in (0.7, -2.4, 8.3, -14.1, 19.6)]
    kinds += [("violated", size, miss) for size, miss in ((1.1, 1e-7), (-0.6, 1e-3), (9.4, 0.05), (-16.2, 0.4), (2.9, 1.0))]
    for number, (kind, angle, miss) in enumerate(kinds, start=1):
        axis = draw.direction()
        theta_m = draw.rotation(0.1, 0.5)
        theta_s = composed(theta_m, scaled(angle, axis))
        if miss:
            theta_s = composed(scaled(miss, draw.direction()), theta_s)
        theta_s = nearest_turn(theta_s, added(theta_m, scaled(angle, axis)))
        states.append(mpc_state(draw, f"{kind}-{number}", axis, theta_s, theta_m, angle))
    axis = draw.direction()
    states.append(mpc_state(draw, "satisfied-coaxial", axis, scaled(20.5, axis), scaled(-2.0, axis), 22.5))
    states.append(mpc_state(draw, "satisfied-right-angle", [0.0, 0.0, 1.0], [0.0, 0.0, PI / 2], [0.0, 0.0, 0.0], PI / 2))
    states.append(mpc_state(draw, "rest", draw.direction(), [0.0] * 3, [0.0] * 3, 0.0))
    return states


def mpc_state(draw, name, axis, theta_s, theta_m, angle):
    return {
        "name": name,
        "steps": steps_for(theta_s, theta_m),
        "axis": axis,
        "theta_S": theta_s,
        "theta_M": theta_m,
        "phi_J": angle,
        "omega_S": draw.vector(1.5),
        "omega_M": draw.vector(1.5),
        "phi_v_J": draw.between(-1.5, 1.5),
        "alpha_S": draw.vector(2.0),
        "alpha_M": draw.vector(2.0),
        "phi_a_J": draw.between(-2.0, 2.0),
    }
