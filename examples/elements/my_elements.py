def dot(v, w):
    return v[0] * w[0] + v[1] * w[1] + v[2] * w[2]


def cross(v, w):
    return [v[1] * w[2] - v[2] * w[1], v[2] * w[0] - v[0] * w[2], v[0] * w[1] - v[1] * w[0]]


def cartesian(state, connector):
    """u_i = e_i · (x_b − x_a), less its initial value; e_i are carried by a."""
    a, initial = state["a"], connector["initial"]
    d, d0 = [[of["b"]["x"][i] - of["a"]["x"][i] for i in range(3)] for of in (state, initial)]
    values, rows = [None] * 6, [None] * 6
    for i in range(3):
        e = a["triad"][i]
        values[i] = dot(e, d) - dot(initial["a"]["triad"][i], d0)
        #          x_a              θ_a            Ψ_a  x_b  θ_b            Ψ_b
        rows[i] = [*(-x for x in e), *cross(e, d), 0.0, *e, 0.0, 0.0, 0.0, 0.0]
    return values, rows


def without_arm(state, connector):
    values, rows = cartesian(state, connector)
    for i in range(3):
        rows[i][3:6] = [0.0, 0.0, 0.0]
    return values, rows
