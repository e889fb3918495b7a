# /// script
# requires-python = ">=3.11"
# dependencies = ["jax==0.10.2", "jaxlib==0.10.2", "numpy==2.4.6"]
# ///
"""Elastic and viscous forces a second time, for verify/golden/behavior.json.

The script knows nothing of the Rust source. Tables of one variable are sums of hinges,
f(x) = y0 + sum of (change of slope) max(x - x_i, 0); tables of several are sums over products of hat functions; matrices are
filled in the order of the keyword pages. JAX differentiates with respect to displacements and velocities.

  python scripts/reference/reference_behavior.py            writes the file
  python scripts/reference/reference_behavior.py --check    recomputes every value of the file and compares

A case has the suboptions as a deck writes them, the motion of the six components (position, constitutive displacement,
velocity), the temperature where one is needed, the forces CEF and CVF (null: none) and the 6 x 12 slopes by displacement, then
velocity. Positions change as displacements do.
"""

import itertools
import json
import sys
from pathlib import Path

import jax
import jax.numpy as jnp
import numpy as np

jax.config.update("jax_enable_x64", True)

TARGET = Path(__file__).parents[2] / "verify/golden/behavior.json"
SCHEMA = "pintle-behavior/1"
AGREEMENT = 1e-13
"""Largest difference that --check accepts, relative to the largest number of its array."""
draw = np.random.default_rng(20261121)


def number(x):
    return repr(float(x))


def lines(items):
    """Numbers, eight on a line."""
    texts = [number(item) for item in items]
    return "\n".join(", ".join(texts[i : i + 8]) for i in range(0, len(texts), 8))


def hinges(xs, ys, linear):
    """A piecewise linear function as a sum of hinges."""
    slopes = np.diff(ys) / np.diff(xs)
    if linear:
        jumps, start = np.diff(slopes), slopes[0]
        at = xs[1:-1]
    else:
        jumps, start = np.diff(np.concatenate([[0.0], slopes, [0.0]])), 0.0
        at = xs
    return lambda x: ys[0] + start * (x - xs[0]) + sum(j * jnp.maximum(x - a, 0.0) for j, a in zip(jumps, at))


def hats(xs):
    """The hat functions of a grid, constant beyond its ends."""

    def weights(x):
        x = jnp.clip(x, xs[0], xs[-1])
        found = []
        for i, at in enumerate(xs):
            rise = (x - xs[i - 1]) / (at - xs[i - 1]) if i > 0 else 1.0
            fall = (xs[i + 1] - x) / (xs[i + 1] - at) if i + 1 < len(xs) else 1.0
            found.append(jnp.maximum(0.0, jnp.minimum(rise, fall)))
        return found

    return weights


def grid(axes, values):
    """A table over several variables: values[i][j]... at axes[0][i], axes[1][j] ..."""
    functions = [hats(axis) for axis in axes]

    def evaluate(*x):
        weights = [function(value) for function, value in zip(functions, x)]
        total = 0.0
        for place in itertools.product(*(range(len(axis)) for axis in axes)):
            term = values[place]
            for weight, i in zip(weights, place):
                term = term * weight[i]
            total = total + term
        return total

    return evaluate


def rows(axes, values):
    """Rows of a deck: the dependent value, then the variables, the first one running fastest."""
    order = itertools.product(*(range(len(axis)) for axis in reversed(axes)))
    table = []
    for reverse in order:
        place = tuple(reversed(reverse))
        table.append(", ".join(map(number, [values[place], *(axis[i] for axis, i in zip(axes, place))])))
    return "\n".join(table)


def sorted_values(count, low, high):
    return np.sort(draw.uniform(low, high, count))


def linear(kind, k):
    c = draw.uniform(-50.0, 500.0)
    deck = f"*CONNECTOR {kind}, COMPONENT={k + 1}\n{number(c)}"
    return deck, {k: lambda p, u, v, t, drive: c * drive(u, v)[k]}


def by_temperature(kind, k):
    axis, values = sorted_values(4, 0.0, 100.0), draw.uniform(1.0, 9.0, 4)
    deck = f"*CONNECTOR {kind}, COMPONENT={k + 1}\n" + "\n".join(
        f"{number(c)}, , {number(t)}" for c, t in zip(values, axis)
    )
    table = hinges(axis, values, False)
    return deck, {k: lambda p, u, v, t, drive: table(t) * drive(u, v)[k]}


def coupled(kind, unsymmetric):
    if unsymmetric:
        d = draw.uniform(-9.0, 9.0, (6, 6))
        terms = [d[i, j] for j in range(6) for i in range(6)]
    else:
        half = draw.uniform(-9.0, 9.0, (6, 6))
        d = np.triu(half) + np.triu(half, 1).T
        terms = [d[i, j] for j in range(6) for i in range(j + 1)]
    deck = f"*CONNECTOR {kind}{', UNSYMM' if unsymmetric else ''}\n{lines(terms)}"
    return deck, {i: (lambda p, u, v, t, drive, i=i: jnp.dot(d[i], drive(u, v))) for i in range(6)}


def nonlinear(kind, k, is_linear):
    xs, ys = sorted_values(6, -1.0, 1.0), draw.uniform(-9.0, 9.0, 6)
    table = hinges(xs, ys, is_linear)
    extrapolation = "LINEAR" if is_linear else "CONSTANT"
    deck = f"*CONNECTOR {kind}, COMPONENT={k + 1}, NONLINEAR, EXTRAPOLATION={extrapolation}\n" + rows([xs], ys)
    return deck, {k: lambda p, u, v, t, drive: table(drive(u, v)[k])}


def independent(kind, k, others, basis):
    """A table over other components; a damping has its own velocity first."""
    own = kind == "DAMPING"
    axes = [sorted_values(3 + i, -1.0, 1.0) for i in range(len(others) + own)]
    values = draw.uniform(-9.0, 9.0, [len(axis) for axis in axes])
    table = grid(axes, values)
    deck = f"*CONNECTOR {kind}, COMPONENT={k + 1}, NONLINEAR, INDEPENDENT COMPONENTS={basis}\n"
    deck += ", ".join(str(other + 1) for other in others) + "\n" + rows(axes, values)

    def force(p, u, v, t, drive):
        motion = p if basis == "POSITION" else u
        return table(*([v[k]] if own else []), *(motion[other] for other in others))

    return deck, {k: force}


def evaluate(laws, motion):
    """CEF, CVF and the slopes of their sum by displacement, then velocity."""
    position, constitutive, velocity, temperature = motion
    drives = {"ELASTICITY": lambda u, v: u, "DAMPING": lambda u, v: v}

    def forces(kind, moved, v):
        u, p = constitutive + moved, position + moved
        total = [None] * 6
        for of, (_, parts) in laws:
            for k, part in parts.items() if of == kind else ():
                total[k] = part(p, u, v, temperature, drives[kind]) + (0.0 if total[k] is None else total[k])
        return total

    def both(moved, v):
        pairs = zip(forces("ELASTICITY", moved, v), forces("DAMPING", moved, v))
        return jnp.stack([jnp.asarray((a if a is not None else 0.0) + (b if b is not None else 0.0)) for a, b in pairs])

    still = jnp.zeros(6)
    slopes = jnp.concatenate(jax.jacfwd(both, (0, 1))(still, velocity), axis=1)
    listed = lambda kind: [None if f is None else float(f) for f in forces(kind, still, velocity)]
    return {"CEF": listed("ELASTICITY"), "CVF": listed("DAMPING"), "slopes": np.asarray(slopes).tolist()}


def cases():
    both = ("ELASTICITY", "DAMPING")
    sets = []
    for kind in both:
        sets.append([(kind, linear(kind, k)) for k in range(6)])
        sets.append([(kind, by_temperature(kind, 1)), (kind, by_temperature(kind, 4))])
        sets.append([(kind, coupled(kind, False))])
        sets.append([(kind, coupled(kind, True))])
        sets.append([(kind, nonlinear(kind, k, k % 2 == 0)) for k in range(6)])
        sets.append([(kind, independent(kind, 0, [1], "POSITION")), (kind, independent(kind, 5, [5, 2], "CONSTITUTIVE MOTION"))])
    sets.append([("ELASTICITY", coupled("ELASTICITY", False)), ("DAMPING", independent("DAMPING", 2, [0, 3], "POSITION"))])
    for laws in sets:
        for spread in (0.3, 1.0, 3.0):
            arrays = [jnp.asarray(draw.uniform(-spread, spread, 6)) for _ in range(3)]
            motion = (*arrays, float(draw.uniform(-20.0, 120.0)))
            yield {
                "deck": "\n".join(deck for _, (deck, _) in laws),
                "position": np.asarray(motion[0]).tolist(),
                "constitutive": np.asarray(motion[1]).tolist(),
                "velocity": np.asarray(motion[2]).tolist(),
                "temperature": motion[3],
                **evaluate(laws, motion),
            }


def differs(old, new):
    """Whether two values of the file differ by more than rounding."""
    if isinstance(old, list) and isinstance(new, list):
        flat_old, flat_new = np.ravel([0.0 if x is None else x for x in np.ravel(old)]), np.ravel(
            [0.0 if x is None else x for x in np.ravel(new)]
        )
        nulls = [x is None for x in np.ravel(old)] != [x is None for x in np.ravel(new)]
        scale = max(1.0, float(np.max(np.abs(flat_new.astype(float)), initial=0.0)))
        return nulls or flat_old.shape != flat_new.shape or bool(
            np.max(np.abs(flat_old.astype(float) - flat_new.astype(float)), initial=0.0) > AGREEMENT * scale
        )
    return old != new


def main():
    content = {"schema": SCHEMA, "script": "scripts/reference/reference_behavior.py", "jax": jax.__version__, "cases": list(cases())}
    if "--check" in sys.argv:
        stored = json.loads(TARGET.read_text())
        pairs = list(zip(stored["cases"], content["cases"], strict=True))
        wrong = [(i, key) for i, (old, new) in enumerate(pairs) for key in new if differs(old.get(key), new[key])]
        if wrong or stored["schema"] != SCHEMA:
            sys.exit(f"{TARGET.name} differs: {wrong[:5]}")
        print(f"{TARGET.name}: {len(pairs)} cases agree")
        return
    TARGET.write_text(json.dumps(content, indent=1) + "\n")
    print(f"{TARGET.name}: {len(content['cases'])} cases")


if __name__ == "__main__":
    main()
