"""Friction by JAX: P, F_C, F_N and Φ of every predefined friction with gradients and Hessians, and the stick/slip update with
its consistent tangent, by the formulas of scripts/reference/reference_friction_formulas.py. Writes src/audit/oracles/golden/friction.json; with --check
compares with it, and besides what the scripts of counter-examples solve, for any friction, with what is solved here for these.

The update is solved another way than in Rust: for P a norm, by bisection on the slip and Newton steps through which JAX
differentiates; for a quadratic potential by the scalar equation of its closest point.
"""

import json
import sys
from pathlib import Path

import jax
import jax.numpy as jnp
import numpy as np
from reference_friction_formulas import (
    FRICTIONS, SLIDING, Belt, Friction, belt_parts, coefficient, columns, first_root, magnitude, norm, polished,
)

GOLDEN = Path(__file__).resolve().parents[2] / "src/audit/oracles/golden/friction.json"
SCHEMA = "pintle-friction/1"
AGREEMENT = 1e-12
"""Relative to the largest entry of a result; what differs between machines is rounding."""


def radii(name, p, sliding):
    """What makes a force of a moment in P."""
    return [p[0] if name == "CYLINDRICAL" and k == 3 else 1.0 for k in sliding]


def applied(function, at):
    return function(at)


def curvatures(function, at):
    return columns(lambda y: columns(function, y), at)


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
                    normal = magnitude(contact + internal)
                    return jnp.array([tangential, contact, normal, tangential - mu * normal])

                value, gradient, hessian = (part(results, jnp.asarray(f)) for part in (applied, columns, curvatures))
                yield {
                    "type": name, "criterion": place, "parameters": p.tolist(), "coefficient": float(mu),
                    "forces": f.tolist(), "position": position.tolist(),
                    "values": np.asarray(value).tolist(), "gradients": np.asarray(gradient).tolist(),
                    "hessians": np.asarray(hessian).tolist(),
                }


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
        pressed, size, duration = magnitude(contact + internal), norm(*trial), x[12]

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
                    "values": value.tolist(), "tangent": np.asarray(columns(result, x)).tolist(),
                }
                state, before = value[:6].copy(), float(value[7])


def belt_cases(random):
    for _ in range(8):
        t, mu = random.uniform(0.3, 3.0, 3), random.uniform(0.1, 0.6)
        of = lambda t: belt_parts(t, mu)[jnp.array([0, 3])]
        yield {
            "tension": t[:2].tolist(), "angle": float(t[2]), "coefficient": float(mu),
            "values": np.asarray(of(jnp.asarray(t))).tolist(), "gradients": np.asarray(columns(of, t)).tolist(),
            "hessians": np.asarray(curvatures(of, t)).tolist(),
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
            "tangent": np.asarray(columns(result, arguments)).tolist(),
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


REST = {"force": [0.0] * 6, "accumulated_slip": 0.0, "stick_stiffness": None}
NOTHING = {"temperature": None, "fields": []}


def increment(friction, before, **of):
    """An increment as a counter-example has it."""
    case = {"friction": {"maximum": None, "radius": 1.0} | friction, "before": REST | before, "conditions": NOTHING}
    return case | {"position": [0.0] * 6, "motion": [0.0] * 6, "forces": [0.0] * 6, "duration": None} | of


def update_again(update):
    """The numbers of an update as the script of a counter-example solves them."""
    name, place, p = update["type"], update["criterion"], update["parameters"]
    sliding = SLIDING[name][place]
    at_rest, kinetic, decay = update["coefficients"]
    friction = {
        "criterion": {"tangential": {"Norm": list(zip(sliding, radii(name, p, sliding)))}, "pressing": {"Terms": []}},
        "coefficient": {"Exponential": {"at_rest": at_rest, "kinetic": kinetic, "decay": decay}},
        "stick_stiffness": {"Given": update["stick_stiffness"]},
    }
    friction["criterion"]["internal"] = {"Constant": 0.0}
    case = increment(
        friction, {"force": update["start"], "accumulated_slip": update["accumulated_slip"]}, position=update["position"],
        displacement=update["displacement"], forces=update["forces"], duration=update["duration"],
    )
    # Forces, Δγ, CASU and F_N.
    result, order = Friction(case, (name, place, p, [True] * 6)).solutions()[0], np.array([0, 1, 2, 3, 4, 5, 6, 9, 7])
    return {
        "values": np.asarray(result(jnp.zeros(13)))[order].tolist(),
        "tangent": np.asarray(columns(result, jnp.zeros(13)))[order].tolist(),
    }


def potential_again(of):
    """The same of a potential of three components with an internal contact force; the last column is by that, which no input is."""
    terms = [
        {"of": {"Component": k}, "scale": scale, "exponent": 2.0, "function": "abs", "shift": 0.0, "sign": 1.0}
        for k, scale in zip((0, 1, 3), of["scale"])
    ]
    friction = {
        "criterion": {
            "tangential": {"Potential": {"operator": "sum", "exponent": 2.0, "contributions": terms}},
            "pressing": {"Component": 2}, "internal": {"Constant": 0.0},
        },
        "coefficient": {"Constant": of["coefficient"]}, "stick_stiffness": {"Given": of["stick_stiffness"]},
        "radius": of["radius"],
    }
    spread = lambda x: [x[0], x[1], 0.0, x[2], 0.0, 0.0]
    case = increment(
        friction, {"force": spread(of["start"])}, displacement=spread(of["displacement"]),
        forces=[0.0, 0.0, of["normal"], 0.0, 0.0, 0.0],
    )
    result, rows = Friction(case).solutions()[0], np.array([0, 1, 3, 6])
    return {
        "values": np.asarray(result(jnp.zeros(13)))[rows].tolist(),
        "tangent": np.asarray(columns(result, jnp.zeros(13)))[rows][:, [0, 1, 3, 8]].tolist(),
    }


def belt_again(of):
    """The force of a belt that slips by much is Φ's limit, with its slopes."""
    belt = {"coefficient": {"Constant": of["coefficient"]}, "maximum": None, "stick_stiffness": {"Given": 1e6}}
    case = {
        "belt": belt, "before": REST, "flow": 1.0, "tension": of["tension"], "angle": of["angle"], "duration": None,
        "conditions": NOTHING,
    }
    return np.asarray(columns(Belt(case).solutions()[0], jnp.zeros(5)))[0, 3]


def again(result):
    """What the scripts of counter-examples say, of the same increments."""
    return {
        "updates": [case | update_again(case) for case in result["updates"]],
        "potentials": [case | potential_again(case) for case in result["potentials"]],
        "belts": [float(belt_again(case)) for case in result["belts"]],
    }


def closed(belt):
    """∂/∂α of T1 (exp(μ α) - 1)."""
    return belt["coefficient"] * belt["tension"][0] * float(np.exp(belt["coefficient"] * belt["angle"]))


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
        theirs = {key: result[key] for key in ("updates", "potentials")} | {"belts": list(map(closed, result["belts"]))}
        found += differences("again", again(result), theirs)
        for line in found[:20]:
            print(line, file=sys.stderr)
        cases = sum(len(result[key]) for key in ("criteria", "updates", "belts", "potentials"))
        print(f"{GOLDEN.name}: {cases} cases, {len(found)} differences")
        sys.exit(1 if found else 0)
    GOLDEN.write_text(json.dumps(result, separators=(",", ":")) + "\n")


if __name__ == "__main__":
    main()
