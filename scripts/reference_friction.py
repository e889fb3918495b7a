"""Friction by JAX: P, F_C, F_N and Φ of every predefined friction with gradients and Hessians, and the stick/slip update with
its consistent tangent, from formulas written here apart. Writes verify/golden/friction.json; with --check compares with it.

The update is solved another way than in Rust: for P a norm, by bisection on the slip and Newton steps through which JAX
differentiates; for a quadratic potential by the scalar equation of its closest point.
"""

import json
import sys
from pathlib import Path

import jax
import jax.numpy as jnp
import numpy as np

jax.config.update("jax_enable_x64", True)

GOLDEN = Path(__file__).resolve().parent.parent / "verify" / "golden" / "friction.json"
SCHEMA = "pintle-friction/1"
AGREEMENT = 1e-12
"""Relative to the largest entry of a result; what differs between machines is rounding."""


def norm(*components):
    """√(Σ x²), away from zero."""
    return jnp.sqrt(sum(x * x for x in components))


def over(x, length):
    """x / length, or nothing where the length is zero: the term is left out."""
    return x / length if length != 0.0 else 0.0


def slide_plane(f, p, position):
    return norm(f[1], f[2]), jnp.abs(f[0]), p[0]


def slot(f, p, position):
    return jnp.abs(f[0]), norm(f[1], f[2]), p[0]


def translator(f, p, position):
    radial, bend, torque = norm(f[1], f[2]), norm(f[4], f[5]), jnp.abs(f[3])
    return jnp.abs(f[0]), over(torque, p[0]) + radial + over(2.0 * bend, p[1]), p[2]


def cylindrical(f, p, position):
    return norm(f[0], f[3] / p[0]), norm(f[1], f[2]) + over(2.0 * norm(f[4], f[5]), p[1]), p[2]


def hinge(f, p, position):
    radial = norm(f[1], f[2]) + over(2.0 * norm(f[4], f[5]), p[2])
    return jnp.abs(f[3]), p[1] * jnp.abs(f[0]) + p[0] * radial, p[3]


def puck(f, p, position):
    return norm(f[1], f[2]), jnp.abs(f[0]) + over(norm(f[4], f[5]), p[0]), p[1]


def puck_spin(f, p, position):
    return jnp.abs(f[3]), p[0] * jnp.abs(f[0]) + (norm(f[4], f[5]) if p[0] != 0.0 else 0.0), p[2]


def bearing(f, p, axis):
    along = f[0] * axis[0] + f[1] * axis[1] + f[2] * axis[2]
    across = norm(*(f[i] - along * axis[i] for i in range(3)))
    return p[2] * jnp.abs(along) + p[0] * (across + 2.0 * jnp.abs(f[4]) / p[1])


def cross_of_a(f, p, position):
    return jnp.abs(f[3]), bearing(f, p, jnp.array([1.0, 0.0, 0.0])), p[4]


def cross_of_b(f, p, position):
    a, b = position[3], position[4]
    axis = jnp.array([jnp.sin(b), -jnp.sin(a) * jnp.cos(b), jnp.cos(a) * jnp.cos(b)])
    return jnp.abs(f[5]), bearing(f, p, axis), p[5]


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


def radii(name, p, sliding):
    """What makes a force of a moment in P."""
    return [p[0] if name == "CYLINDRICAL" and k == 3 else 1.0 for k in sliding]


def criterion_cases(random):
    for name, (criteria, count, _) in FRICTIONS.items():
        for place, criterion in enumerate(criteria):
            for _ in range(6):
                p = random.uniform(0.2, 2.0, count)
                f = random.uniform(-3.0, 3.0, 6)
                position = random.uniform(-1.2, 1.2, 6)
                mu = random.uniform(0.1, 0.6)

                def results(f):
                    tangential, contact, internal = criterion(f, p, position)
                    normal = jnp.abs(contact + internal)
                    return jnp.array([tangential, contact, normal, tangential - mu * normal])

                value, gradient, hessian = (part(results)(f) for part in (lambda g: g, jax.jacfwd, jax.hessian))
                yield {
                    "type": name, "criterion": place, "parameters": p.tolist(), "coefficient": float(mu),
                    "forces": f.tolist(), "position": position.tolist(),
                    "values": np.asarray(value).tolist(), "gradients": np.asarray(gradient).tolist(),
                    "hessians": np.asarray(hessian).tolist(),
                }


def coefficient(law, rate):
    return law[1] + (law[0] - law[1]) * jnp.exp(-law[2] * rate)


def first_root(left, high):
    """Where a function that is positive at 0 first is not, by bisection."""
    low = 0.0
    for _ in range(200):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if float(left(middle)) > 0.0 else (low, middle)
    return low


def polished(left, root):
    """The root with its derivatives: Newton steps whose slope JAX does not differentiate, each of which is right to one order
    more."""
    slope = jax.lax.stop_gradient(jax.grad(left)(root))
    root = jnp.asarray(root)
    for _ in range(2):
        root = root - left(root) / slope
    return root


class Update:
    """Friction forces, slip, accumulated slip and contact force over an increment, as a function of Δu (6), forces (6), Δt."""

    def __init__(self, name, place, p, law, stiffness, start, before, position):
        self.criterion, self.sliding = FRICTIONS[name][0][place], SLIDING[name][place]
        self.scale = jnp.array(radii(name, p, self.sliding))
        self.p, self.law, self.stiffness = p, law, stiffness
        self.start, self.before, self.position = start, before, position

    def parts(self, x):
        tractions = jnp.array([self.start[k] for k in self.sliding]) / self.scale
        trial = tractions + self.stiffness * self.scale * jnp.array([x[k] for k in self.sliding])
        _, contact, internal = self.criterion(x[6:12], self.p, self.position + x[:6])
        pressed, size, duration = jnp.abs(contact + internal), norm(*trial), x[12]

        def left(slip):
            return size - self.stiffness * slip - coefficient(self.law, slip / duration) * pressed

        return trial, size, pressed, left

    def branch(self, x):
        """None in stick, else the slip."""
        _, size, _, left = self.parts(x)
        return None if float(left(0.0)) <= 0.0 else first_root(left, float(size) / self.stiffness)

    def along(self, branch):
        def result(x):
            trial, size, pressed, left = self.parts(x)
            if branch is None:
                slip, force = 0.0, trial * self.scale
            else:
                slip = polished(left, branch)
                force = trial / size * coefficient(self.law, slip / x[12]) * pressed * self.scale
            forces = [0.0] * 6
            for k, value in zip(self.sliding, force):
                forces[k] = value
            return jnp.array([*forces, slip, self.before + slip, pressed])

        return result


def update_cases(random):
    for name, (criteria, count, _) in FRICTIONS.items():
        for place in range(len(criteria)):
            state, before = np.zeros(6), 0.0
            for step in range(4):
                p = random.uniform(0.3, 1.5, count) if step == 0 else p
                law = (random.uniform(0.3, 0.6), random.uniform(0.1, 0.3), random.uniform(0.2, 2.0)) if step == 0 else law
                stiffness = 60.0
                amplitude = [0.002, 0.2, 0.01, 0.3][step]
                x = np.concatenate([
                    random.uniform(-amplitude, amplitude, 6), random.uniform(-3.0, 3.0, 6), [random.uniform(0.05, 0.5)],
                ])
                position0 = random.uniform(-0.6, 0.6, 6)

                update = Update(name, place, p, law, stiffness, state, before, position0)
                result = update.along(update.branch(x))
                value = np.asarray(result(jnp.asarray(x)))
                yield {
                    "type": name, "criterion": place, "parameters": p.tolist(), "coefficients": list(map(float, law)),
                    "stick_stiffness": stiffness, "start": state.tolist(), "accumulated_slip": float(before),
                    "displacement": x[:6].tolist(), "forces": x[6:12].tolist(), "duration": float(x[12]),
                    "position": (position0 + x[:6]).tolist(),
                    "values": value.tolist(), "tangent": np.asarray(jax.jacfwd(result)(jnp.asarray(x))).tolist(),
                }
                state, before = value[:6].copy(), float(value[7])


def belt_cases(random):
    def results(t, mu):
        first, second, angle = t
        tangential = jnp.abs(second - first)
        least = jnp.minimum(first, second)
        return jnp.array([tangential, tangential - least * (jnp.exp(mu * angle) - 1.0)])

    for _ in range(8):
        t, mu = random.uniform(0.3, 3.0, 3), random.uniform(0.1, 0.6)
        of = lambda t: results(t, mu)
        yield {
            "tension": t[:2].tolist(), "angle": float(t[2]), "coefficient": float(mu),
            "values": np.asarray(of(t)).tolist(), "gradients": np.asarray(jax.jacfwd(of)(t)).tolist(),
            "hessians": np.asarray(jax.hessian(of)(t)).tolist(),
        }


def ellipsoid(radii, stiffnesses, limit, start, x, t=None):
    """The closest point of Σ (f/R)² = L² to the trial force in the metric of the stiffness: f = f_tr/(1 + k t/R²) with the one
    t ≥ 0 that puts it there; the slip is t L. Without t it is looked for."""
    trial = jnp.asarray(start) + stiffnesses * x
    square = radii * radii

    def left(t):
        return jnp.sum((trial / radii / (1.0 + stiffnesses * t / square)) ** 2) - limit * limit

    if t is None:
        high = 1.0
        while float(left(high)) > 0.0:
            high *= 2.0
        return first_root(left, high)
    t = polished(left, t)
    return jnp.append(trial / (1.0 + stiffnesses * t / square), t * limit)


def potential_cases(random):
    for _ in range(8):
        scale = random.uniform(0.3, 2.0, 3)
        radius = random.uniform(0.3, 1.5)
        stiffness = 80.0
        stiffnesses = stiffness * np.array([1.0, 1.0, radius * radius])
        start, x = random.uniform(-0.2, 0.2, 3), random.uniform(-0.3, 0.3, 3)
        pressed, mu = random.uniform(0.5, 2.0), random.uniform(0.2, 0.6)

        t = ellipsoid(scale, stiffnesses, mu * pressed, start, x)

        def result(x):
            return ellipsoid(scale, stiffnesses, mu * x[3], start, x[:3], t)

        arguments = jnp.append(x, pressed)
        yield {
            "scale": scale.tolist(), "radius": float(radius), "stick_stiffness": stiffness, "start": start.tolist(),
            "displacement": x.tolist(), "normal": float(pressed), "coefficient": float(mu),
            "values": np.asarray(result(arguments)).tolist(),
            "tangent": np.asarray(jax.jacfwd(result)(arguments)).tolist(),
        }


def computed():
    random = np.random.default_rng(20_260_114)
    return {
        "schema": SCHEMA,
        "criteria": list(criterion_cases(random)),
        "updates": list(update_cases(random)),
        "belts": list(belt_cases(random)),
        "potentials": list(potential_cases(random)),
    }


def differences(path, ours, theirs):
    if isinstance(ours, dict):
        if ours.keys() != theirs.keys():
            yield f"{path}: {sorted(ours)} and {sorted(theirs)}"
            return
        for key in ours:
            yield from differences(f"{path}.{key}", ours[key], theirs[key])
    elif isinstance(ours, list) and ours and isinstance(ours[0], dict):
        if len(ours) != len(theirs):
            yield f"{path}: {len(ours)} and {len(theirs)} cases"
            return
        for i, (a, b) in enumerate(zip(ours, theirs)):
            yield from differences(f"{path}[{i}]", a, b)
    elif isinstance(ours, list):
        a, b = np.asarray(ours), np.asarray(theirs)
        if a.shape != b.shape or not np.all(np.abs(a - b) <= AGREEMENT * (1.0 + np.max(np.abs(a), initial=0.0))):
            yield f"{path}: {ours} and {theirs}"
    elif ours != theirs and not (isinstance(ours, float) and abs(ours - theirs) <= AGREEMENT * (1.0 + abs(ours))):
        yield f"{path}: {ours} and {theirs}"


def main():
    result = computed()
    if "--check" in sys.argv[1:]:
        found = list(differences("friction", result, json.loads(GOLDEN.read_text())))
        for line in found[:20]:
            print(line, file=sys.stderr)
        cases = sum(len(result[key]) for key in ("criteria", "updates", "belts", "potentials"))
        print(f"{GOLDEN.name}: {cases} cases, {len(found)} differences")
        sys.exit(1 if found else 0)
    GOLDEN.write_text(json.dumps(result, separators=(",", ":")) + "\n")


if __name__ == "__main__":
    main()
