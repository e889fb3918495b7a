"""Rows of one connection type, many states at a time."""

import functools

import numpy

from . import _pintle


@functools.lru_cache(maxsize=64)
def compiled(of):
    """The batch of a type or a connector."""
    return _pintle.Rows(of)


def pattern(of):
    """The columns (of the twelve x_a, θ_a, x_b, θ_b) of each row that may differ from zero, as (indptr, indices)."""
    rows = compiled(of).pattern
    indptr = numpy.cumsum([0, *(len(row) for row in rows)])
    return indptr, numpy.array([j for row in rows for j in row], dtype=int)


def initial(of):
    """The initial state: x_b − x_a (3,), and the directions of a and b (3, 3), of which row i is e(i+1).

    Of a type alone it is drawn, as in `check`; misalignments are measured from it.
    """
    return tuple(numpy.array(part) for part in compiled(of).initial)


def rows(of, x_a, triad_a, x_b, triad_b, *, columns=None, out=None):
    """Values (n, 6) and rows (n, 6, 14) of a connection type at n states, float64.

    `x_a` and `x_b` are positions (n, 3), global axes. `triad_a` and `triad_b` are, by their shapes,

    - (n, 3, 3): local directions, of which `triad_a[s, i]` is e(i+1) of node a
    - (n, 4): turns since the state `initial(of)` as quaternions w, x, y, z
    - (n, 3): the same as rotation vectors, in rad

    An array of one state holds for all n. `of` is as in `check`. Values are the residual of a
    constrained component and the position of any other, angles principal, in rad. The columns of a row are
    x_a, θ_a, Ψ_a, x_b, θ_b, Ψ_b; rotations vary spatially. Components that the type has not are NaN.

    With `columns` there are the m components that the type has and no others, values (n, m):

    - 14 or 12: rows (n, m, 14) or (n, m, 12), without material flow
    - 9: rows (n, m, 9) of θ_a, x_b, θ_b: x_a is the opposite of x_b
    - a list of places among the twelve: rows (n, m, len(list))
    - "sparse": rows (n, k), the values of a sparse matrix by rows, in the order of `pattern(of)`

    Arrays in C order are read where they lie; others are copied, a thousand states at a time. `out` is a
    pair of arrays that take the numbers; with `columns` in C order. Raises TypeError for another dtype,
    ValueError for another shape, and for types with columns of material flow.
    """
    one = compiled(of)
    given = [x_a, triad_a, x_b, triad_b]
    n = one.count(given)
    has = one.components
    asked = 14 if columns is None else columns
    width = one.width(asked)
    if out is not None:
        for name, array in zip(("out[0]", "out[1]"), out):
            if array.dtype != numpy.float64:
                raise TypeError(f"{name} has dtype {array.dtype}, and float64 is needed")
    shape = (n, width) if columns == "sparse" else (n, len(has), width // max(len(has), 1))
    if columns is not None:
        found = (numpy.empty((n, len(has))), numpy.empty(shape)) if out is None else out
        for name, array, wanted in zip(("out[0]", "out[1]"), found, ((n, len(has)), shape)):
            if array.shape != wanted or not array.flags.c_contiguous:
                raise ValueError(f"{name} has shape {array.shape}, not {wanted} in C order")
        one.fill_into(given, asked, *found)
        return tuple(found)
    found = (numpy.empty((n, 6)), numpy.empty((n, 6, 14))) if out is None else out
    for name, array, wanted in zip(("out[0]", "out[1]"), found, ((n, 6), (n, 6, 14))):
        if array.shape != wanted:
            raise ValueError(f"{name} has shape {array.shape}, not {wanted}")
        if not array.flags.writeable:
            raise ValueError(f"out cannot be written: {name} is read-only")
    if len(has) == 6 and all(array.flags.c_contiguous for array in found):
        one.fill_into(given, asked, *found)
        return tuple(found)
    values, rows = numpy.empty((n, len(has))), numpy.empty(shape)
    one.fill_into(given, asked, values, rows)
    for array, numbers in zip(found, (values, rows)):
        array[...] = numpy.nan
        array[:, has] = numbers
    return tuple(found)


def bias(of, x_a, triad_a, x_b, triad_b, v_a, w_a, v_b, w_b):
    """J̇v (n, 6) of a connection type at n states: the acceleration c̈ of each component that velocities alone make.

    c̈ = J v̇ + J̇v with v = (ẋ_a, ω_a, ẋ_b, ω_b), J the rows of `rows` with columns=12, and J̇v = ∂²c[v, v] along x and
    exp(δθ^) C. `v_a`, `w_a`, `v_b`, `w_b` are (n, 3), global axes, length/time and rad/time; the other arrays are as in
    `rows`. An array of one state holds for all n. Components that the type has not are NaN. No second
    derivative of a row is formed. Raises as `rows` does.
    """
    one = compiled(of)
    found = one.bias([x_a, triad_a, x_b, triad_b], [v_a, w_a, v_b, w_b])
    whole = numpy.full((len(found), 6), numpy.nan)
    whole[:, one.components] = found
    return whole


def geometric_stiffness(of, x_a, triad_a, x_b, triad_b, forces):
    """Σ_k λ_k ∂²c_k (n, 12, 12) of a connection type at n states: symmetric to rounding, by x_a, θ_a, x_b, θ_b.

    `forces` (n, 6) or (6,) are the λ of the components: multipliers of constraints, forces and moments of others; what the
    type has not is not read. Rotations vary along exp(δθ^) C. The other arrays are as in `rows`. Raises as `rows` does.
    """
    one = compiled(of)
    given = [x_a, triad_a, x_b, triad_b]
    n = one.count(given)
    forces = numpy.asarray(forces, dtype=float)
    if forces.shape not in ((6,), (1, 6), (n, 6)):
        raise ValueError(f"forces has shape {forces.shape}, not ({n}, 6) or (6,)")
    each = numpy.ascontiguousarray(numpy.broadcast_to(forces, (n, 6))[:, one.components])
    return one.geometric_stiffness(given, each).reshape(n, 12, 12)
