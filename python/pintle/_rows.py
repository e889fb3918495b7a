"""Rows of one connection type, many states at a time."""

import functools

import numpy

from . import _pintle


@functools.lru_cache(maxsize=64)
def compiled(of):
    """The batch of a type or a connector."""
    return _pintle.Rows(of)


def rows(of, x_a, triad_a, x_b, triad_b, *, out=None):
    """Values (n, 6) and rows (n, 6, 14) of a connection type at n states, float64.

    `x_a` and `x_b` are positions (n, 3), global axes; `triad_a` and `triad_b` (n, 3, 3), of which
    `triad_a[s, i]` is the direction e(i+1) of node a. `of` is as in `check`. Values are the residual of a
    constrained component and the position of any other, angles principal, in rad. The columns of a row are
    x_a, θ_a, Ψ_a, x_b, θ_b, Ψ_b; rotations vary spatially. Components that the type has not are NaN.

    Arrays are read as they lie, without a copy: read-only, strided or empty. `out` is a pair of arrays that
    take the numbers. Raises TypeError for another dtype, ValueError for another shape, and for types with
    columns of material flow.
    """
    one = compiled(of)
    if out is None:
        count = len(x_a)
        out = numpy.empty((count, 6)), numpy.empty((count, 6, 14))
    values, rows = out
    for name, array in (("out[0]", values), ("out[1]", rows)):
        if array.dtype != numpy.float64:
            raise TypeError(f"{name} has dtype {array.dtype}, and float64 is needed")
    one.fill_into(x_a, triad_a, x_b, triad_b, values, rows)
    return values, rows
