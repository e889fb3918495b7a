"""The values of scripts/reference/reference.py to 110 digits, from textbook formulas and numerical differentiation.

Nothing is shared with reference.py but the type's row of its table, and the reported position, which
only selects the branch of an angle. Orthonormal directions: the polar factors of the given orientations.
Derivatives are forward differences of 1e-25 (first and mixed second, error about 1e-25); rates are central
differences of the same size along C(t) = exp((omega t + alpha t^2/2)^) C, x(t) = x + v t + a t^2/2.
"""

import math
import multiprocessing

import mpmath
from mpmath import acos, asin, atan2, cos, mp, mpf, nint, pi, sin, sqrt

mp.dps = 110
STEP = mpf(10) ** -25
NOISE = mpf(10) ** -40
"""Differences of constants come out smaller than this."""
PROCESSES = 2
ALIGNED = 1e-12


def version():
    return mpmath.__version__


# Vectors and matrices as lists


def exactly(value):
    return [exactly(v) for v in value] if isinstance(value, list) else mpf(value)


def dot(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def plus(a, b, factor=1):
    return [x + factor * y for x, y in zip(a, b)]


def product(a, b):
    columns = list(zip(*b))
    return [[dot(row, column) for column in columns] for row in a]


def transposed(a):
    return [list(column) for column in zip(*a)]


def column(a, i):
    return [row[i] for row in a]


def orthonormal(a):
    """The polar factor, by Newton's iteration."""
    a = exactly(a)
    for _ in range(4):
        gram = product(transposed(a), a)
        a = product(a, [[(3 * (i == j) - gram[i][j]) / 2 for j in range(3)] for i in range(3)])
    return a


def exponential(v):
    """cos t I + sin t n^ + (1 - cos t) n n^T."""
    angle = sqrt(dot(v, v))
    if angle == 0:
        return [[mpf(i == j) for j in range(3)] for i in range(3)]
    n = [x / angle for x in v]
    c, s = cos(angle), sin(angle)
    cross = [[0, -n[2], n[1]], [n[2], 0, -n[0]], [-n[1], n[0], 0]]
    return [[c * (i == j) + s * cross[i][j] + (1 - c) * n[i] * n[j] for j in range(3)] for i in range(3)]


def logarithm(r):
    """Cosine from the trace, sine and axis from the skew part: 110 digits forgive what they lose near 0 and pi."""
    axial = [(r[2][1] - r[1][2]) / 2, (r[0][2] - r[2][0]) / 2, (r[1][0] - r[0][1]) / 2]
    length = sqrt(dot(axial, axial))
    if length == 0:
        return [mpf(0)] * 3
    angle = atan2(length, (r[0][0] + r[1][1] + r[2][2] - 1) / 2)
    return [angle / length * x for x in axial]


def nearest(angle, reported):
    return angle + 2 * pi * nint((mpf(reported) - angle) / (2 * pi))


def nearest_vector(v, reported):
    length = sqrt(dot(v, v))
    if length == 0:
        return v
    turns = nint((dot(v, [mpf(x) for x in reported]) / length - length) / (2 * pi))
    return [x * (1 + 2 * pi * turns / length) for x in v]


# Measures


def cardan(r, reported):
    angles = [atan2(-r[1][2], r[2][2]), asin(r[0][2]), atan2(-r[0][1], r[0][0])]
    return [nearest(angle, near) if i != 1 else angle for i, (angle, near) in enumerate(zip(angles, reported))]


def euler(r, reported):
    second = acos(r[2][2])
    best = None
    for s in (1, -1):
        angles = [atan2(s * r[0][2], -s * r[1][2]), s * second, atan2(s * r[2][0], s * r[2][1])]
        angles = [nearest(angle, near) for angle, near in zip(angles, reported)]
        gap = sum(abs(angle - near) for angle, near in zip(angles, reported))
        if best is None or gap < best[0]:
            best = gap, angles
    return best[1]


def flexion_and_torsion(r):
    """(phi, alpha, beta) of R = Rz(phi) Ry(alpha) Rz(beta - phi), the angles about z principal; phi = 0 without flexion."""
    alpha = atan2(sqrt(r[0][2] ** 2 + r[1][2] ** 2), r[2][2])
    phi = atan2(r[1][2], r[0][2]) if r[0][2] != 0 or r[1][2] != 0 else mpf(0)
    return phi, alpha, atan2(r[1][0] - r[0][1], r[0][0] + r[1][1])


def middle(a, phi, alpha, beta):
    """A Rz(phi) Ry(alpha/2) Rz((beta - 2 phi)/2)."""
    about_z = [exponential([mpf(0), mpf(0), angle]) for angle in (phi, (beta - 2 * phi) / 2)]
    return product(a, product(product(about_z[0], exponential([mpf(0), alpha / 2, mpf(0)])), about_z[1]))


class Connector:
    def __init__(self, case, role, reported, row):
        self.case, self.role, self.reported = case, role, [0.0 if x is None else x for x in reported]
        _, self.translation, self.rotation, self.held = row
        self.a0, self.b0 = orthonormal(case["A0"]), orthonormal(case["B0"])
        self.a = product(exponential(exactly(case["theta_a"])), self.a0)
        self.b = product(exponential(exactly(case["theta_b"])), self.b0)
        x_a, x_b, u_a, u_b = (exactly(case[key]) for key in ("X_a", "X_b", "U_a", "U_b"))
        self.d0 = plus(x_b, x_a, -1)
        self.d = plus(plus(self.d0, u_b), u_a, -1)
        self.r0 = product(transposed(self.a0), self.b0)
        self.aligned = abs(self.r0[0][2]) <= ALIGNED and (abs(self.r0[0][1]) <= ALIGNED or self.held == "cross")
        self.initial = self.positions(self.a0, self.b0, self.d0, mpf(0), mpf(0), [0, 0, 0])

    def with_torsion(self, a, b, d, reported, result):
        """The types whose directions lie halfway between a's and b's, or that measure torsion."""
        phi, alpha, beta = flexion_and_torsion(product(transposed(a), b))
        if self.rotation is not None:
            beta = nearest(beta, reported[2] if self.rotation == "projection" else reported[1])
        if self.translation == "middle":
            choices = [beta]
            if self.rotation is None and d is not self.d0:
                choices.append(beta + 2 * pi)
            found = []
            for choice in choices:
                directions = middle(a, phi, alpha, choice)
                x = [dot(column(directions, i), d) for i in range(3)]
                found.append((sum(abs(p - near) for p, near in zip(x, self.reported)), x))
            result[:3] = min(found)[1]
        if self.rotation == "shafts":
            result[4] = beta
        elif self.rotation == "coupling":
            result[3:] = [alpha, beta, nearest(phi + pi / 2, reported[2])]
        elif self.rotation == "projection":
            result[3:] = [-alpha * sin(phi - beta / 2), alpha * cos(phi - beta / 2), beta]

    def positions(self, a, b, d, flow_a, flow_b, reported):
        """Six components; zero where the type has none."""
        result = [mpf(0)] * 6
        length = sqrt(dot(d, d))
        if self.translation == "frame":
            result[:3] = [dot(column(a, i), d) for i in range(3)]
        elif self.translation == "length":
            result[0] = length
        elif self.translation == "belt":
            result[:3] = [length / (sqrt(dot(self.d0, self.d0)) + flow_a - flow_b) - 1, flow_b, flow_a]
        elif self.translation == "radial":
            x, y, z = [dot(column(a, i), d) for i in range(3)]
            result[:3] = [sqrt(x * x + y * y), mpf(0), z]
        if self.translation == "middle" or self.rotation in ("shafts", "coupling", "projection"):
            self.with_torsion(a, b, d, reported, result)
        if self.rotation in ("cardan", "euler", "vector"):
            r = product(transposed(a), b)
            if self.rotation == "cardan":
                result[3:] = cardan(r, reported)
            elif self.rotation == "euler":
                result[3:] = euler(r, reported)
            else:
                result[3:] = nearest_vector(logarithm(r), reported)
        return result

    def measures(self, variation):
        """(positions, rows): rows are the residuals of the constrained components, else displacements."""
        a, b = self.a, self.b
        if any(variation[3:6]):
            a = product(exponential(variation[3:6]), a)
        if any(variation[10:13]):
            b = product(exponential(variation[10:13]), b)
        d = plus(plus(self.d, variation[7:10]), variation[0:3], -1)
        flow_a, flow_b = mpf(self.case["flow_a"]) + variation[6], mpf(self.case["flow_b"]) + variation[13]
        positions = self.positions(a, b, d, flow_a, flow_b, self.reported[3:])
        rows = plus(positions, self.initial, -1)
        if self.held is not None:
            r = product(transposed(a), b)
            if self.held == "all":
                rows[3:] = logarithm(product(r, transposed(self.r0)))
            elif self.aligned:
                rows[4] = r[0][2]
                if self.held == "axis":
                    rows[5] = r[0][1]
        return positions, rows

    def form(self, variation):
        """Row of FLOW-CONVERTER."""
        e3 = column(product(exponential(variation[3:6]), self.a), 2)
        return [mpf(0)] * 3 + e3 + [mpf(0)] * 4 + [-x for x in e3] + [-mpf(self.case["beta_s"])]

    def accumulated(self):
        n = self.case["steps"]
        theta_a, theta_b = exactly(self.case["theta_a"]), exactly(self.case["theta_b"])
        difference = plus(theta_a, theta_b, -1)
        total = mpf(0)
        for k in range(n):
            middle = mpf(2 * k + 1) / (2 * n)
            e3 = column(product(exponential([middle * x for x in theta_a]), self.a0), 2)
            total += dot(e3, difference) / n
        return total - mpf(self.case["beta_s"]) * mpf(self.case["flow_b"])


def motion_of(case, rate, second, turn_rate, turn_second, flow_rate, flow_second):
    rates, seconds = [], []
    for node in "ab":
        rates += case[f"{rate}_{node}"] + case[f"{turn_rate}_{node}"] + [case[f"{flow_rate}_{node}"]]
        seconds += case[f"{second}_{node}"] + case[f"{turn_second}_{node}"] + [case[f"{flow_second}_{node}"]]
    return exactly(rates), exactly(seconds)


def differentiated(function, size, with_hessian):
    """Values, Jacobian and Hessian (or None) of a list-valued function at zero, [row][column]."""
    zero = [mpf(0)] * size

    def at(*moved):
        variation = list(zero)
        for i in moved:
            variation[i] += STEP
        return function(variation)

    value = at()
    single = [at(i) for i in range(size)]
    jacobian = [[(single[k][row] - value[row]) / STEP for k in range(size)] for row in range(len(value))]
    if not with_hessian:
        return value, jacobian, None
    hessian = [[[mpf(0)] * size for _ in range(size)] for _ in value]
    for j in range(size):
        for k in range(j + 1):
            both = at(j, k)
            for row in range(len(value)):
                entry = (both[row] - single[j][row] - single[k][row] + value[row]) / STEP**2
                hessian[row][j][k] = hessian[row][k][j] = entry
    return value, jacobian, hessian


def rates_of(function, rates, seconds):
    def at(time):
        return function([v * time + a * time**2 / 2 for v, a in zip(rates, seconds)])

    before, now, after = at(-STEP), at(mpf(0)), at(STEP)
    velocity = [(p - m) / (2 * STEP) for p, m in zip(after, before)]
    acceleration = [(p - 2 * c + m) / STEP**2 for p, c, m in zip(after, now, before)]
    return velocity, acceleration


def truth(task):
    case, role, reported, row, with_hessian = task
    connector = Connector(case, role, reported, row)
    rates, seconds = motion_of(case, "v", "a", "omega", "alpha", "flow_v", "flow_a")
    rest = [mpf(0)] * 14

    def rows(variation):
        return connector.measures(variation)[1]

    positions = connector.measures(rest)[0]
    measured, jacobian, hessian = differentiated(rows, 14, with_hessian)
    velocity, acceleration = rates_of(rows, rates, seconds)
    displacement = plus(positions, connector.initial, -1)
    if connector.rotation == "drum":
        positions[5] = displacement[5] = measured[5] = connector.accumulated()
        jacobian[5] = connector.form(rest)
        moved = []
        for k in range(14):
            variation = list(rest)
            variation[k] = STEP
            moved.append(connector.form(variation))
        if with_hessian:
            hessian[5] = [[(moved[k][j] - jacobian[5][j]) / STEP for k in range(14)] for j in range(14)]
        velocity[5] = sum(x * v for x, v in zip(jacobian[5], rates))
        later = connector.form([v * STEP for v in rates])
        acceleration[5] = (sum(x * (v + a * STEP) for x, v, a in zip(later, rates, seconds)) - velocity[5]) / STEP
    if connector.translation == "frame" and "measured" in role[:3]:
        for i in range(3):
            direction = column(connector.b, i)
            velocity[i] = dot(direction, plus(rates[7:10], rates[0:3], -1))
            acceleration[i] = dot(direction, plus(seconds[7:10], seconds[0:3], -1))
    if "measured" in role[3:]:
        for i in range(3):
            direction = column(connector.b, i)
            velocity[3 + i] = dot(direction, plus(rates[10:13], rates[3:6], -1))
            acceleration[3 + i] = dot(direction, plus(seconds[10:13], seconds[3:6], -1))
    constitutive = list(displacement)
    for c, given in enumerate(case["reference"]):
        if given is not None:
            constitutive[c] = positions[c] - (mpf(given) if c < 3 else mpf(given) * pi / 180)
    found = {
        "position": positions, "displacement": displacement, "residual": measured, "constitutive": constitutive,
        "velocity": velocity, "acceleration": acceleration, "jacobian": jacobian, "hessian": hessian,
    }
    return {key: rounded(value) for key, value in found.items()}


def rounded(value):
    if value is None:
        return None
    if isinstance(value, list):
        return [rounded(v) for v in value]
    if not math.isfinite(float(value)) or value.imag != 0:
        raise ValueError(f"no real truth: {value}")
    return float(value) if abs(value) > NOISE else 0.0


def truths(tasks):
    """The truth of (case, role, reported position, table row, with Hessian), in order."""
    with multiprocessing.get_context("spawn").Pool(PROCESSES) as pool:
        return pool.map(truth, tasks, chunksize=4)


# The revolute-joint multi-point constraint


def joint_truth(case, reported_angle):
    axis, theta_s, theta_m = (exactly(case[key]) for key in ("axis", "theta_S", "theta_M"))
    angle = mpf(case["phi_J"])
    c_s, c_m = exponential(theta_s), exponential(theta_m)
    length = sqrt(dot(axis, axis))

    def rows(variation):
        s = product(exponential(variation[0:3]), c_s)
        m = product(exponential(variation[3:6]), c_m)
        current = [dot(row, axis) for row in m]
        followed = product(exponential([(angle + variation[6]) * x for x in current]), m)
        rho = logarithm(product(s, transposed(followed)))
        relative = product(transposed(m), s)
        axial = [relative[2][1] - relative[1][2], relative[0][2] - relative[2][0], relative[1][0] - relative[0][1]]
        # tan(angle/2) = a0.v/w with (w, v) the quaternion: v = axial/(4 w), w^2 = (1 + trace)/4; and the double angle.
        trace = relative[0][0] + relative[1][1] + relative[2][2]
        w2 = (1 + trace) / 4
        vw = dot(axial, axis) / length / 4
        v2 = (dot(axis, [dot(row, axis) for row in relative]) / length**2 * 2 - trace + 1) / 4
        twist = atan2(2 * vw, w2 - v2)
        return rho + [nearest(twist, reported_angle)]

    rates = exactly(case["omega_S"] + case["omega_M"] + [case["phi_v_J"]])
    seconds = exactly(case["alpha_S"] + case["alpha_M"] + [case["phi_a_J"]])
    value, jacobian, hessian = differentiated(rows, 7, True)
    velocity, acceleration = rates_of(rows, rates, seconds)
    found = {
        "residual": value[:3], "angle": value[3], "velocity": velocity[:3], "acceleration": acceleration[:3],
        "angle_velocity": velocity[3], "angle_acceleration": acceleration[3],
        "jacobian": jacobian[:3], "angle_jacobian": jacobian[3], "hessian": hessian[:3], "angle_hessian": hessian[3],
    }
    return {key: rounded(v) for key, v in found.items()}
