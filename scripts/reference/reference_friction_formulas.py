"""The formulas of scripts/reference/reference_friction.py: P, F_C and F_C^int of every predefined friction, of potentials and derived components;
coefficients and tables; what an increment does, and a belt around a ring (JAX, float64).

They know nothing of the Rust source. All derivatives are by forward mode along one direction after the other, so that at a kink they
are those from one side of it: SIDE says which. The equations of slip are solved by bisection where P is a norm, and by following
the solution from stick, the limit being lowered step by step, where it is a potential; derivatives come of one Newton step from there.
"""

import jax
import jax.numpy as jnp
import numpy as np

jax.config.update("jax_enable_x64", True)

SIDE = [1.0]
"""From which side of a kink slopes are: 1 ahead along the direction of differentiation, -1 behind."""


@jax.custom_jvp
def magnitude(x):
    return jnp.abs(x)


@magnitude.defjvp
def magnitude_along(point, direction):
    (x,), (dx,) = point, direction
    return magnitude(x), jnp.where(x == 0.0, SIDE[0] * jnp.sign(dx), jnp.sign(x)) * dx


@jax.custom_jvp
def bracket(x):
    """<x> = max(x, 0)."""
    return jnp.maximum(x, 0.0)


@bracket.defjvp
def bracket_along(point, direction):
    (x,), (dx,) = point, direction
    return bracket(x), jnp.where((x > 0.0) | ((x == 0.0) & (SIDE[0] * dx > 0.0)), 1.0, 0.0) * dx


@jax.custom_jvp
def smaller(x, y):
    return jnp.minimum(x, y)


@smaller.defjvp
def smaller_along(point, direction):
    (x, y), (dx, dy) = point, direction
    first = (x < y) | ((x == y) & (SIDE[0] * dx <= SIDE[0] * dy))
    return smaller(x, y), jnp.where(first, dx, dy)


@jax.custom_jvp
def length(x):
    """√(Σ x²) without overflow."""
    largest = jnp.max(jnp.abs(x))
    scale = jnp.where(largest > 0.0, largest, 1.0)
    return scale * jnp.sqrt(jnp.sum((x / scale) ** 2))


@length.defjvp
def length_along(point, direction):
    (x,), (dx,) = point, direction
    size = length(x)
    is_zero = size == 0.0
    divisor = jnp.where(is_zero, 1.0, size)
    return size, jnp.where(is_zero, SIDE[0] * length(dx), jnp.sum(x / divisor * dx))


def norm(*components):
    return length(jnp.stack([jnp.asarray(x, dtype=float) for x in components]))


def derivative(function, direction):
    return lambda y: jax.jvp(function, (y,), (direction,))[1]


def columns(function, at):
    """∂function_i/∂y_j, by forward mode."""
    at = jnp.asarray(at, dtype=float)
    return jax.vmap(lambda row: derivative(function, row)(at), out_axes=-1)(jnp.eye(len(at)))


def over(x, length):
    """x / length, or nothing where the length is zero: the term is left out."""
    return x / length if length != 0.0 else 0.0


def slide_plane(f, p, position):
    return norm(f[1], f[2]), magnitude(f[0]), p[0]


def slot(f, p, position):
    return magnitude(f[0]), norm(f[1], f[2]), p[0]


def translator(f, p, position):
    radial, bend, torque = norm(f[1], f[2]), norm(f[4], f[5]), magnitude(f[3])
    return magnitude(f[0]), over(torque, p[0]) + radial + over(2.0 * bend, p[1]), p[2]


def cylindrical(f, p, position):
    return norm(f[0], f[3] / p[0]), norm(f[1], f[2]) + over(2.0 * norm(f[4], f[5]), p[1]), p[2]


def hinge(f, p, position):
    radial = norm(f[1], f[2]) + over(2.0 * norm(f[4], f[5]), p[2])
    return magnitude(f[3]), p[1] * magnitude(f[0]) + p[0] * radial, p[3]


def puck(f, p, position):
    return norm(f[1], f[2]), magnitude(f[0]) + over(norm(f[4], f[5]), p[0]), p[1]


def puck_spin(f, p, position):
    return magnitude(f[3]), p[0] * magnitude(f[0]) + (norm(f[4], f[5]) if p[0] != 0.0 else 0.0), p[2]


def bearing(f, p, axis):
    along = f[0] * axis[0] + f[1] * axis[1] + f[2] * axis[2]
    across = norm(*(f[i] - along * axis[i] for i in range(3)))
    return p[2] * magnitude(along) + p[0] * (across + over(2.0 * magnitude(f[4]), p[1]))


def cross_of_a(f, p, position):
    return magnitude(f[3]), bearing(f, p, jnp.array([1.0, 0.0, 0.0])), p[4]


def second_axis(position):
    a, b = position[3], position[4]
    return jnp.stack([jnp.sin(b), -jnp.sin(a) * jnp.cos(b), jnp.cos(a) * jnp.cos(b)])


def cross_of_b(f, p, position):
    return magnitude(f[5]), bearing(f, p, second_axis(position)), p[5]


FRICTIONS = {
    "SLIDE-PLANE": ([slide_plane], 1, {1: 0, 2: 0}),
    "SLOT": ([slot], 1, {}),
    "TRANSLATOR": ([translator], 3, {}),
    "CYLINDRICAL": ([cylindrical], 3, {}),
    "HINGE": ([hinge], 4, {}),
    "PLANAR": ([puck, puck_spin], 3, {}),
    "UJOINT": ([cross_of_a, cross_of_b], 6, {}),
}
SLIDING = {
    "SLIDE-PLANE": [[1, 2]], "SLOT": [[0]], "TRANSLATOR": [[0]], "CYLINDRICAL": [[0, 3]], "HINGE": [[3]],
    "PLANAR": [[1, 2], [3]], "UJOINT": [[3], [5]],
}


@jax.custom_jvp
def weights(x, at, is_linear):
    """By what the rows at increasing places are multiplied, two of which x lies between: beyond the ends one, or as on the last segment."""
    i = jnp.clip(jnp.searchsorted(at, x, side="right") - 1, 0, len(at) - 2)
    t = (x - at[i]) / (at[i + 1] - at[i])
    t = jnp.where(is_linear, t, jnp.clip(t, 0.0, 1.0))
    places = jnp.arange(len(at))
    return jnp.where(places == i, 1.0 - t, 0.0) + jnp.where(places == i + 1, t, 0.0)


@weights.defjvp
def weights_along(point, direction):
    (x, at, is_linear), (dx, *_) = point, direction
    sides = [jnp.searchsorted(at, x, side=side) - 1 for side in ("right", "left")]
    segment = jnp.where(SIDE[0] * dx > 0.0, *sides)
    i = jnp.clip(segment, 0, len(at) - 2)
    slope = jnp.where(is_linear | (i == segment), 1.0 / (at[i + 1] - at[i]), 0.0)
    places = jnp.arange(len(at))
    return weights(x, at, is_linear), (jnp.where(places == i + 1, slope, 0.0) - jnp.where(places == i, slope, 0.0)) * dx


def tabulated(table, argument, output=0):
    """A table, a tree of curves over the first of its variables, at arguments by variable."""
    is_linear = jnp.asarray(table["extrapolation"] == "linear")

    def value(block, level):
        if "Values" in block:
            return jnp.asarray(block["Values"][output], dtype=float)
        at, blocks = block["Along"]["at"], block["Along"]["blocks"]
        below = [value(part, level - 1) for part in blocks]
        if len(at) == 1:
            return below[0]
        x = jnp.asarray(argument(table["variables"][level - 1][0]), dtype=float)
        return jnp.sum(weights(x, jnp.array(at), is_linear) * jnp.stack(below))

    return value(table["root"], len(table["variables"]))


def surroundings(conditions, of_column):
    """The arguments of a table: its own columns, temperature and field variables; what is not given is zero."""

    def argument(variable):
        if variable == "Temperature":
            return conditions["temperature"] or 0.0
        if "Field" in variable:
            fields = conditions["fields"]
            return fields[variable["Field"]] if variable["Field"] < len(fields) else 0.0
        return of_column(variable["Column"])

    return argument


def combined(derived, f, where):
    """A derived component: the sum of s NORM, s SUM, s MACAULEY SUM of α_i f_i."""
    return sum((part["sign"] * OPERATORS[part["operator"]](scaled(part, f, where)) for part in derived["parts"]), 0.0)


def scaled(part, f, where):
    """α_i f_i."""
    parts = [f[k] for k in part["components"]]
    if part["scale"] is None:
        return parts
    basis, others = part["independent"] or ("position", [])
    motions = where["position" if basis == "position" else "motion"]
    argument = surroundings(where["conditions"], lambda j: motions[others[j]] if j < len(others) else 0.0)
    return [tabulated(part["scale"], argument, i) * x for i, x in enumerate(parts)]


OPERATORS = {"norm": lambda x: norm(*x), "sum": sum, "macauley_sum": lambda x: sum(map(bracket, x))}


def potential(of, f, where):
    """(Σ s_i P_i^α_i)^(1/β) or max s_i P_i, with P_i = H(X/R_i - a_i); nothing where that is negative."""
    terms = of["contributions"]
    is_quadratic = of["operator"] == "sum" and of["exponent"] == 2.0 and all(term["exponent"] == 2.0 for term in terms)
    if is_quadratic and all(term["sign"] > 0.0 for term in terms):
        return norm(*(x for term in terms for x in roots(term, f, where)))
    values = [(term, FUNCTIONS[term["function"]](argument_of(term, f, where))) for term in terms]
    if of["operator"] == "max":
        found = -np.inf if not values else None
        for term, value in values:
            signed = term["sign"] * value
            found = signed if found is None else -smaller(-found, -signed)
        return bracket(found)
    total = sum(term["sign"] * (value if term["exponent"] == 1.0 else value ** term["exponent"]) for term, value in values)
    if of["exponent"] == 1.0:
        return bracket(total)
    is_positive = total > 0.0
    return jnp.where(is_positive, jnp.where(is_positive, total, 1.0) ** (1.0 / of["exponent"]), 0.0)


def source(term, f, where):
    return f[term["of"]["Component"]] if "Component" in term["of"] else combined(term["of"]["Derived"], f, where)


def argument_of(term, f, where):
    return source(term, f, where) / term["scale"] - term["shift"]


def roots(term, f, where):
    """Numbers whose squares are P_i²: of a norm its parts, for a square is smooth where it is zero."""
    parts = term["of"].get("Derived", {"parts": []})["parts"]
    if [part["operator"] for part in parts] == ["norm"] and term["function"] == "abs" and term["shift"] == 0.0:
        return [x / term["scale"] for x in scaled(parts[0], f, where)]
    argument = argument_of(term, f, where)
    return [bracket(argument) if term["function"] == "macauley" else argument]


FUNCTIONS = {"abs": magnitude, "macauley": bracket, "none": lambda x: x}


def coefficient(law, rate):
    return law[1] + (law[0] - law[1]) * jnp.exp(-law[2] * rate)


def coefficient_of(law, rate, normal, conditions):
    """μ of a number, of a table over slip rate and contact force, or falling with the slip rate."""
    if "Constant" in law:
        return law["Constant"]
    if "Table" in law:
        return tabulated(law["Table"], surroundings(conditions, lambda j: normal if j else rate))
    law = law["Exponential"]
    return coefficient([law["at_rest"], law["kinetic"], law["decay"]], rate)


def first_root(left, high, places=()):
    """Where a function that is positive at 0 first is not, by bisection; `places` are looked at on the way."""
    low = 0.0
    for place in sorted(x for x in places if 0.0 < x < high):
        if float(left(place)) <= 0.0:
            high = place
            break
        low = place
    for _ in range(1100):
        middle = 0.5 * (low + high)
        if not low < middle < high:
            break
        low, high = (middle, high) if float(left(middle)) > 0.0 else (low, middle)
    return low


def polished(left, root):
    """The root with its derivatives: Newton steps whose slope JAX does not differentiate, each of which is right to one order
    more."""
    root = jnp.asarray(root)
    slope = jax.lax.stop_gradient(derivative(left, jnp.asarray(1.0))(root))
    for _ in range(2):
        root = root - left(root) / slope
    return root


WAYS = 64
"""So many places on the way to the largest slip are looked at, for the limit may fall with it and rise again."""


def places_on_the_way(most, tables, rate_of, before):
    """Slips between which tables are linear, and others evenly between them."""
    rows = [x * rate_of for x in rows_of(tables[0])] + [x - before for x in rows_of(tables[1])]
    return [most * n / WAYS for n in range(1, WAYS)] + rows


def rows_of(of):
    """The values of one variable of a table at which slopes meet."""
    table, column = of
    if table is None:
        return []
    levels = [variable for variable, _ in table["variables"]]
    found = set()

    def collect(block, level):
        if "Along" in block:
            if levels[level - 1] == {"Column": column}:
                found.update(block["Along"]["at"])
            for part in block["Along"]["blocks"]:
                collect(part, level - 1)

    collect(table["root"], len(levels))
    return sorted(found)


THRESHOLD = 1e-12
"""Within this of the limit, rounding tells stick from slip: both are looked at."""


def branches_of(excess, limit):
    """Whether an increment slips, or may."""
    if abs(excess) <= THRESHOLD * limit:
        return [False, True]
    return [excess > 0.0]


class Friction:
    """A friction with all that it depends on: P, F_C, F_N and Φ, and what an increment does."""

    def __init__(self, case, named=None):
        self.case, self.named, self.of = case, named, case["friction"]
        self.criterion = self.of["criterion"]
        self.start = case["before"]
        tangential = self.criterion["tangential"]
        if "Norm" in tangential:
            self.radii = dict(map(tuple, tangential["Norm"]))
        else:
            sliding = sorted({k for term in tangential["Potential"]["contributions"] for k in components_of(term["of"])})
            self.radii = {k: self.of["radius"] if k >= 3 else 1.0 for k in sliding}
        self.sliding = list(self.radii)

    def where(self, y, slip):
        """What surrounds the friction after it has moved by y, and slipped."""
        return {
            "position": jnp.array(self.case["position"]) + y[:6], "motion": jnp.array(self.case["motion"]) + y[:6],
            "slip": slip, "conditions": self.case["conditions"],
        }

    def magnitude(self, f, where):
        tangential = self.criterion["tangential"]
        if "Norm" in tangential:
            return norm(*(f[k] / radius for k, radius in self.radii.items()))
        return potential(tangential["Potential"], f, where)

    def contact(self, f, where):
        pressing = self.criterion["pressing"]
        if pressing == "Nothing":
            return jnp.asarray(0.0)
        if "Component" in pressing:
            return f[pressing["Component"]]
        if "Derived" in pressing:
            return combined(pressing["Derived"], f, where)
        if self.named:
            name, place, parameters, present = self.named
            acting = [x if is_there else 0.0 * x for x, is_there in zip(f, present)]
            return FRICTIONS[name][0][place](acting, parameters, where["position"])[1]
        return sum((loaded(term, f, where) for term in pressing["Terms"]), jnp.asarray(0.0))

    def internal(self, where):
        if self.named:
            name, place, parameters, _ = self.named
            return FRICTIONS[name][0][place]([0.0] * 6, parameters, where["position"])[2]
        internal = self.criterion["internal"]
        if "Constant" in internal:
            return internal["Constant"]
        internal = internal["Table"]
        motions = where["position" if internal["basis"] == "position" else "motion"]
        others = internal["components"]
        column = lambda j: motions[others[j]] if j < len(others) else where["slip"]
        return tabulated(internal["table"], surroundings(where["conditions"], column))

    def capped(self, limit):
        return limit if self.of["maximum"] is None else smaller(limit, jnp.asarray(self.of["maximum"]))

    def parts(self, f):
        """P, F_C, F_N and Φ at the coefficient and the forces of the criterion."""
        where = self.where(jnp.zeros(6), self.case["accumulated_slip"])
        tangential, contact = self.magnitude(f, where), self.contact(f, where)
        normal = magnitude(contact + self.internal(where))
        return jnp.stack([tangential, contact, normal, tangential - self.capped(self.case["coefficient"] * normal)])

    def limit(self, y, slip):
        """F_N and min(μ F_N, τ_max) after a slip."""
        where = self.where(y, self.start["accumulated_slip"] + slip)
        forces = jnp.array(self.case["forces"]) + y[6:12]
        normal = magnitude(self.contact(forces, where) + self.internal(where))
        duration = self.case["duration"]
        rate = slip / (duration + y[12]) if duration is not None and duration > 0.0 else 0.0
        return normal, self.capped(coefficient_of(self.of["coefficient"], rate, normal, self.case["conditions"]) * normal)

    def stiffness(self, y):
        """K_s; nothing while nothing ever pressed."""
        rule, kept = self.of["stick_stiffness"], self.start["stick_stiffness"]
        if "Given" in rule:
            return jnp.asarray(rule["Given"])
        if kept is not None:
            return jnp.asarray(kept)
        at_rest = self.limit(y, 0.0)[1]
        return at_rest / rule["ElasticSlip"]

    def trial(self, y):
        stiffness = self.stiffness(y)
        moved = jnp.array(self.case["displacement"]) + y[:6]
        stretch = lambda k: stiffness * self.radii[k] ** 2 * moved[k] if k in self.radii else 0.0
        return jnp.stack([self.start["force"][k] + stretch(k) if k in self.radii else jnp.asarray(0.0) for k in range(6)])

    def excess(self, y):
        """P of what stick would give beyond the limit without slip."""
        return self.magnitude(self.trial(y), self.where(y, self.start["accumulated_slip"])) - self.limit(y, 0.0)[1]

    def solutions(self):
        """CSF, Δγ, F_N, the limit and CASU as functions of Δu, forces that press and Δt, of every branch there may be."""
        still = jnp.zeros(13)
        at_rest = float(self.limit(still, 0.0)[1])
        if at_rest <= 0.0:
            return [self.free]
        slips = branches_of(float(self.excess(still)), at_rest)
        return [self.slipping() if slip else self.sticking for slip in slips]

    def results(self, y, force, slip):
        normal, limit = self.limit(y, slip)
        return jnp.stack([*force, slip, normal, limit, self.start["accumulated_slip"] + slip])

    def sticking(self, y):
        return self.results(y, self.trial(y), jnp.asarray(0.0))

    def free(self, y):
        """Nothing holds: all of the motion, and what stick had stored, is slip."""
        moved = jnp.array(self.case["displacement"]) + y[:6]
        is_known = "Given" in self.of["stick_stiffness"] or self.start["stick_stiffness"] is not None
        stored = lambda k: self.start["force"][k] / (self.stiffness(y) * self.radii[k] ** 2) if is_known else 0.0
        slip = norm(*((moved[k] + stored(k)) * self.radii[k] for k in self.sliding))
        return self.results(y, jnp.zeros(6), slip)

    def slipping(self):
        still = jnp.zeros(13)
        if "Norm" in self.criterion["tangential"]:
            return self.radial(still)
        if self.case.get("returned_along"):
            return self.along_traction(still)
        return self.against_gradient(still)

    def places(self, most):
        table = self.of["coefficient"].get("Table")
        internal = self.criterion["internal"].get("Table")
        tables = [(table, 0), (internal and internal["table"], internal and len(internal["components"]))]
        return places_on_the_way(most, tables, self.case["duration"] or 0.0, self.start["accumulated_slip"])

    def radial(self, still):
        """P a norm: K Δγ is what P of the trial is beyond the limit after Δγ, and the force goes on along the trial."""

        def left(y):
            size = self.magnitude(self.trial(y), self.where(y, 0.0))
            return lambda slip: size - self.stiffness(y) * slip - self.limit(y, slip)[1]

        at_still = jax.jit(left(still))
        most = float(self.magnitude(self.trial(still), self.where(still, 0.0)) / self.stiffness(still))
        root = first_root(at_still, most, self.places(most))

        def result(y):
            slip = polished(left(y), root)
            trial = self.trial(y)
            size = self.magnitude(trial, self.where(y, 0.0))
            return self.results(y, trial / size * self.limit(y, slip)[1], slip)

        return result

    def equations(self, y, z, share=1.0):
        """What is left of f_k = f_tr,k - K_k Δγ ∂P/∂f_k and P(f) = L(Δγ), over sizes, of f and Δγ in sizes z; with a share of the way from
        the traction that stick would give to the limit."""
        size, slip_size = self.sizes
        force = self.spread(z[:-1] * size)
        slip = z[-1] * slip_size
        where = self.where(y, self.start["accumulated_slip"] + slip)
        trial, stiffness = self.trial(y), self.stiffness(y)
        gradient = columns(lambda f: self.magnitude(self.spread(f), where), z[:-1] * size)
        flow = [
            (force[k] - trial[k]) / size[i] + stiffness * self.radii[k] ** 2 * slip * gradient[i] / size[i]
            for i, k in enumerate(self.sliding)
        ]
        excess = self.magnitude(force, where) - self.limit(y, slip)[1]
        return jnp.stack([*flow, (excess - (1.0 - share) * self.beyond) / self.level])

    def spread(self, of_sliding):
        force = [jnp.asarray(0.0)] * 6
        for i, k in enumerate(self.sliding):
            force[k] = of_sliding[i]
        return jnp.stack(force)

    def against_gradient(self, still):
        trial = np.asarray(self.trial(still))[self.sliding]
        self.beyond = float(self.excess(still))
        self.level = float(self.limit(still, 0.0)[1]) + self.beyond
        largest = float(np.max(np.abs(trial) / np.array([self.radii[k] for k in self.sliding])))
        self.sizes = jnp.array([largest * self.radii[k] for k in self.sliding]), largest / float(self.stiffness(still))
        left = jax.jit(lambda z, share: self.equations(still, z, share))
        slopes = jax.jit(lambda z, share: columns(lambda z: self.equations(still, z, share), z))
        z, share, step = np.append(trial / np.asarray(self.sizes[0]), 0.0), 0.0, 0.125
        while share < 1.0 and step > 1e-9:
            there = newton(left, slopes, z, min(share + step, 1.0))
            if there is None:
                step *= 0.5
                continue
            z, share, step = there, min(share + step, 1.0), 2.0 * step
        if share < 1.0:
            raise SystemExit("JAX finds no solution of the equations of slip: undecided")
        matrix = np.linalg.inv(np.asarray(slopes(z, 1.0)))

        def result(y):
            end = z - matrix @ self.equations(y, jnp.asarray(z))
            return self.results(y, self.spread(end[:-1] * self.sizes[0]), end[-1] * self.sizes[1])

        return result

    def along_traction(self, still):
        """f = s f_tr with P(f) = L, and the slip that this takes."""

        def state(y, share):
            trial, where = self.trial(y), self.where(y, self.start["accumulated_slip"])
            stiffness = self.stiffness(y)
            size = self.magnitude(trial, where)
            whole = sum(trial[k] * (trial[k] / size) / (stiffness * self.radii[k] ** 2) for k in self.sliding)
            slip = (1.0 - share) * whole
            left = self.magnitude(trial * share, where) - self.limit(y, slip)[1]
            return trial * share, slip, left

        behind = first_root(jax.jit(lambda way: state(still, 1.0 - way)[2]), 1.0)

        def result(y):
            share = polished(lambda share: state(y, share)[2], 1.0 - behind)
            force, slip, _ = state(y, share)
            return self.results(y, force, slip)

        return result


def newton(left, slopes, z, share):
    """Newton's method without backtracking: near enough it needs none. Nothing where it does not settle."""
    for _ in range(25):
        matrix, rest = np.asarray(slopes(z, share)), np.asarray(left(z, share))
        if not (np.isfinite(matrix).all() and np.isfinite(rest).all()):
            return None
        try:
            step = np.linalg.solve(matrix, rest)
        except np.linalg.LinAlgError:
            return None
        z = z - step
        if np.max(np.abs(step)) <= 1e-13:
            return z if z[-1] >= -1e-13 else None
    return None


def components_of(form):
    if "Component" in form:
        return [form["Component"]]
    return [k for part in form["Derived"]["parts"] for k in part["components"]]


def loaded(term, f, where):
    """number · Π times / over · magnitude, of a predefined friction whose numbers are not those of one type."""
    factor = term["number"] * float(np.prod(term["times"])) / (1.0 if term["over"] is None else term["over"])
    kind, _, what = term["load"].partition(" ")
    if kind == "norm":
        listed = [int(k) for k in what[what.index("[") + 1 : what.index("]")].split(",")]
        return factor * norm(*(f[k] for k in listed if term["present"][k]), 0.0)
    axis = second_axis(where["position"]) if what == "e3b" else jnp.array([1.0, 0.0, 0.0])
    along = f[0] * axis[0] + f[1] * axis[1] + f[2] * axis[2]
    if kind == "along":
        return factor * magnitude(along)
    return factor * norm(*(f[i] - along * axis[i] for i in range(3)))


def belt_parts(t, mu, maximum=None):
    """P, the tension that holds (as F_C and F_N) and Φ of a belt, of T1, T2 and α."""
    first, second, angle = t
    tangential, held = magnitude(second - first), bracket(smaller(first, second))
    limit = held * jnp.expm1(mu * angle)
    limit = limit if maximum is None else smaller(limit, jnp.asarray(maximum))
    return jnp.stack([tangential, held, held, tangential - limit])


class Belt:
    """A belt around a ring in an increment, of ΔΨ, T1, T2, α, Δt."""

    def __init__(self, case):
        self.case, self.of, self.start = case, case["belt"], case["before"]
        rule, kept = self.of["stick_stiffness"], self.start["stick_stiffness"]
        self.given = rule["Given"] if "Given" in rule else kept
        force, flow = self.start["force"][1], case["flow"]
        towards = flow if self.given is None else force + self.given * flow
        self.sign = -1.0 if towards < 0.0 else 1.0

    def limit(self, y, slip):
        """The tension that holds, on the side from which material comes, and the limit."""
        tension = self.case["tension"][1 if self.sign < 0.0 else 0] + y[2 if self.sign < 0.0 else 1]
        held, duration = bracket(tension), self.case["duration"]
        rate = slip / (duration + y[4]) if duration is not None and duration > 0.0 else 0.0
        mu = coefficient_of(self.of["coefficient"], rate, held, self.case["conditions"])
        limit = held * jnp.expm1(mu * (self.case["angle"] + y[3]))
        return held, limit if self.of["maximum"] is None else smaller(limit, jnp.asarray(self.of["maximum"]))

    def stiffness(self, y):
        if self.given is not None:
            return jnp.asarray(self.given)
        return self.limit(y, 0.0)[1] / self.of["stick_stiffness"]["ElasticSlip"]

    def trial(self, y):
        return self.start["force"][1] + self.stiffness(y) * (self.case["flow"] + y[0])

    def results(self, y, force, slip):
        held, limit = self.limit(y, slip)
        return jnp.stack([force, slip, held, limit, self.start["accumulated_slip"] + slip])

    def sticking(self, y):
        return self.results(y, self.trial(y), jnp.asarray(0.0))

    def free(self, y):
        stored = 0.0 if self.given is None else self.start["force"][1] / self.given
        return self.results(y, jnp.asarray(0.0), magnitude(self.case["flow"] + y[0] + stored))

    def slipping(self):
        left = lambda y: lambda slip: self.sign * self.trial(y) - self.stiffness(y) * slip - self.limit(y, slip)[1]
        still = jnp.zeros(5)
        most = float(self.sign * self.trial(still) / self.stiffness(still))
        tables = [(self.of["coefficient"].get("Table"), 0), (None, None)]
        root = first_root(jax.jit(left(still)), most, places_on_the_way(most, tables, self.case["duration"] or 0.0, 0.0))

        def result(y):
            slip = polished(left(y), root)
            return self.results(y, self.sign * self.limit(y, slip)[1], slip)

        return result

    def solutions(self):
        still = jnp.zeros(5)
        at_rest = float(self.limit(still, 0.0)[1])
        if at_rest <= 0.0:
            return [self.free]
        excess = float(self.sign * self.trial(still)) - at_rest
        return [self.slipping() if slips else self.sticking for slips in branches_of(excess, at_rest)]

    def coefficients(self):
        """μ after the increment, of each branch there may be: the criterion is judged at it."""
        found = []
        for result in self.solutions():
            _, slip, held, *_ = map(float, result(jnp.zeros(5)))
            duration = self.case["duration"]
            rate = slip / duration if duration is not None and duration > 0.0 else 0.0
            found.append(coefficient_of(self.of["coefficient"], rate, held, self.case["conditions"]))
        return found
