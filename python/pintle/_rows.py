"""Rows of one connection type, many states at a time."""

import functools

import numpy

from . import _pintle


@functools.lru_cache(maxsize=64)
def _compiled(of, components):
    return _pintle.Rows(of, components)


def compiled(of, components=None):
    """The batch of a type or a connector."""
    return _compiled(of, None if components is None else tuple(components))


def pattern(of, *, components=None):
    """The columns (of the twelve x_a, θ_a, x_b, θ_b) of each row that may differ from zero, as (indptr, indices).

    `components` chooses rows, as in `rows`.
    """
    rows = compiled(of, components).pattern
    indptr = numpy.cumsum([0, *(len(row) for row in rows)])
    return indptr, numpy.array([j for row in rows for j in row], dtype=int)


def initial(of):
    """The initial state: x_b − x_a (3,), and the directions of a and b (3, 3), of which row i is e(i+1).

    Of a type alone it is drawn, as in `check`; misalignments are measured from it.
    """
    return tuple(numpy.array(part) for part in compiled(of).initial)


def _is_out(name, array, shape, ordered=True):
    """Raises unless an array takes numbers of that shape; `ordered` means in C order."""
    if not isinstance(array, numpy.ndarray):
        raise TypeError(f"{name} is no NumPy array")
    if array.dtype != numpy.float64:
        raise TypeError(f"{name} has dtype {array.dtype}, and float64 is needed")
    if array.shape != shape or (ordered and not array.flags.c_contiguous):
        raise ValueError(f"{name} has shape {array.shape}, not {shape}{' in C order' if ordered else ''}")
    if not array.flags.writeable:
        raise ValueError(f"out cannot be written: {name} is read-only")


def _spread(array, has, numbers):
    """Components in an array of all six."""
    array[...] = numpy.nan
    array[:, has] = numbers


def rows(of, x_a, triad_a, x_b, triad_b, *, columns=None, components=None, out=None):
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

    With `components`, numbers from 1 to 6 in ascending order such as [1, 4], there are those m, and no others.

    Arrays in C order are read where they lie; others are copied, a thousand states at a time. `out` is a
    pair of arrays that take the numbers; with `columns` or `components` in C order. Raises TypeError for another
    dtype, ValueError for another shape, for components that there are not, and for columns of material flow.
    """
    one = compiled(of, components)
    given = [x_a, triad_a, x_b, triad_b]
    n, has = one.count(given), one.components
    asked = 14 if columns is None else columns
    width = one.width(asked)
    is_whole = columns is None and components is None
    shape = (n, width) if columns == "sparse" else (n, len(has), width // max(len(has), 1))
    shapes = ((n, 6), (n, 6, 14)) if is_whole else ((n, len(has)), shape)
    if out is None:
        found = tuple(numpy.empty(shape) for shape in shapes)
    else:
        found = tuple(out)
        if len(found) != 2:
            raise ValueError(f"out has {len(found)} arrays, not two: values and rows")
        for name, array, wanted in zip(("out[0]", "out[1]"), found, shapes):
            _is_out(name, array, wanted, ordered=not is_whole)
    if not is_whole or (len(has) == 6 and all(array.flags.c_contiguous for array in found)):
        one.fill_into(given, asked, *found)
        return found
    values, rows = numpy.empty((n, len(has))), numpy.empty(shape)
    one.fill_into(given, asked, values, rows)
    for array, numbers in zip(found, (values, rows)):
        _spread(array, has, numbers)
    return found


def bias(of, x_a, triad_a, x_b, triad_b, v_a, w_a, v_b, w_b, *, components=None, out=None):
    """J̇v (n, 6) of a connection type at n states: the acceleration c̈ of each component that velocities alone make.

    c̈ = J v̇ + J̇v with v = (ẋ_a, ω_a, ẋ_b, ω_b), J the rows of `rows` with columns=12, and J̇v = ∂²c[v, v] along x and
    exp(δθ^) C. `v_a`, `w_a`, `v_b`, `w_b` are (n, 3), global axes, length/time and rad/time; the other arrays are as in
    `rows`. An array of one state holds for all n. Components that the type has not are NaN. No second
    derivative of a row is formed. With `components` there are those m, (n, m).

    `out` takes the numbers; with `components`, or of a type with six, where it lies if it is in C order. Raises as `rows` does.
    """
    one = compiled(of, components)
    given, moving = [x_a, triad_a, x_b, triad_b], [v_a, w_a, v_b, w_b]
    n, has = one.count(given, moving), one.components
    is_whole = components is None
    shape = (n, 6 if is_whole else len(has))
    if out is None:
        out = numpy.empty(shape)
    else:
        _is_out("out", out, shape, ordered=not is_whole)
    if len(has) == shape[1] and out.flags.c_contiguous:
        one.bias_into(given, moving, out)
        return out
    numbers = numpy.empty((n, len(has)))
    one.bias_into(given, moving, numbers)
    _spread(out, has, numbers)
    return out


def geometric_stiffness(of, x_a, triad_a, x_b, triad_b, forces, *, along=None, components=None, out=None):
    """Σ_k λ_k ∂²c_k (n, 12, 12) of a connection type at n states: symmetric to rounding, by x_a, θ_a, x_b, θ_b.

    `forces` (n, 6) or (6,) are the λ of the components: multipliers of constraints, forces and moments of others; what the
    type has not is not read. With `components` they are (n, m) or (m,), of those m alone. Rotations vary along exp(δθ^) C.
    `along` = (v_a, w_a, v_b, w_b), each (n, 3), gives (Σ λ ∂²c) v (n, 12) instead, without the matrix.
    The other arrays are as in `rows`. `out`, in C order, takes the numbers where it lies. Raises as `rows` does.
    """
    one = compiled(of, components)
    given = [x_a, triad_a, x_b, triad_b]
    moving = None if along is None else list(along)
    if moving is not None and len(moving) != 4:
        raise ValueError(f"along has {len(moving)} arrays, not the four v_a, w_a, v_b, w_b")
    n, has = one.count(given, moving), one.components
    forces = numpy.asarray(forces, dtype=float)
    m = 6 if components is None else len(has)
    if forces.shape not in ((m,), (1, m), (n, m)):
        raise ValueError(f"forces has shape {forces.shape}, not ({n}, {m}) or ({m},)")
    each = numpy.broadcast_to(forces, (n, m))
    each = numpy.ascontiguousarray(each[:, has] if components is None else each)
    shape = (n, 12, 12) if moving is None else (n, 12)
    if out is None:
        out = numpy.empty(shape)
    else:
        _is_out("out", out, shape)
    if moving is None:
        one.geometric_stiffness_into(given, each, out)
    else:
        one.geometric_stiffness_along_into(given, each, moving, out)
    return out
