"""CARTESIAN: u_i = e_i^a · (x_b − x_a) − initial, and its rows. `evaluate` is right; `without_arm` forgets that e_i^a turns with a."""


def dot(v, w):
    return v[0] * w[0] + v[1] * w[1] + v[2] * w[2]


def cross(v, w):
    return [v[1] * w[2] - v[2] * w[1], v[2] * w[0] - v[0] * w[2], v[0] * w[1] - v[1] * w[0]]


def evaluate(state, connector):
    a, b, initial = state["a"], state["b"], connector["initial"]
    d = [b["x"][i] - a["x"][i] for i in range(3)]
    first = [initial["b"]["x"][i] - initial["a"]["x"][i] for i in range(3)]
    values, rows = [None] * 6, [None] * 6
    for i in range(3):
        e = a["triad"][i]
        values[i] = dot(e, d) - dot(initial["a"]["triad"][i], first)
        # x_a, θ_a, Ψ_a, x_b, θ_b, Ψ_b: a turn δθ_a moves e by δθ_a × e.
        rows[i] = [*(-x for x in e), *cross(e, d), 0.0, *e, 0.0, 0.0, 0.0, 0.0]
    return values, rows


def without_arm(state, connector):
    values, rows = evaluate(state, connector)
    for i in range(3):
        rows[i][3:6] = [0.0, 0.0, 0.0]
    return values, rows
