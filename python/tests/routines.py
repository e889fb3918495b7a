"""Right and wrong routines that the tests check."""

import numpy


def cartesian(state, connector):
    """u_i = e_i · (x_b − x_a), less its initial value; e_i are carried by a."""
    a, b, initial = state["a"], state["b"], connector["initial"]
    d = b["x"] - a["x"]
    values, rows = [None] * 6, [None] * 6
    for i in range(3):
        e = a["triad"][i]
        values[i] = e @ d - initial["a"]["triad"][i] @ (initial["b"]["x"] - initial["a"]["x"])
        rows[i] = numpy.concatenate([-e, numpy.cross(e, d), [0], e, [0, 0, 0, 0]])
    return values, rows


def without_arm(state, connector):
    values, rows = cartesian(state, connector)
    for i in range(3):
        rows[i][3:6] = 0
    return values, rows


def stacked(state, connector, *, sign=1.0):
    """The same on states along the first axis."""
    a, b, initial = state["a"], state["b"], connector["initial"]
    d, count = b["x"] - a["x"], len(a["x"])
    values, rows = numpy.full((count, 6), numpy.nan), numpy.full((count, 6, 14), numpy.nan)
    e = a["triad"]
    values[:, :3] = numpy.einsum("nij,nj->ni", e, d) - initial["a"]["triad"] @ (initial["b"]["x"] - initial["a"]["x"])
    rows[:, :3] = 0
    rows[:, :3, 0:3], rows[:, :3, 7:10] = -e, e
    rows[:, :3, 3:6] = sign * numpy.cross(e, d[:, None, :])
    return values, rows
