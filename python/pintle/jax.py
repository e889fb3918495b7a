"""Values of a connection type as a function of JAX, under `jit`, `grad` and `vmap`."""

import jax
import jax.numpy as jnp
import numpy

from ._rows import compiled
from ._rows import rows as _rows

_NAMES = "u1", "u2", "u3", "ur1", "ur2", "ur3"


def rows(of):
    """A function `values(x_a, triad_a, x_b, triad_b)` of one state: the components that the type has, (m,).

    Arguments are those of `pintle.rows` at one state: (3,), (3, 3). `values.components` names the
    components. Its derivatives are the rows of pintle, not traced: a triad varies by the rotation
    δθ = ½ Σ e_i × δe_i. First derivatives only, forwards and backwards. It needs `jax_enable_x64`.
    """
    has = numpy.array(compiled(of).components)

    def both(*state):
        batch = state[0].shape[:-1]
        flat = [numpy.asarray(x).reshape(-1, *shape) for x, shape in zip(state, ((3,), (3, 3), (3,), (3, 3)))]
        value, row = _rows(of, *flat, columns=12)
        return value.reshape(*batch, len(has)), row.reshape(*batch, len(has), 12)

    def called(*state):
        if any(jnp.asarray(x).dtype != jnp.float64 for x in state):
            raise TypeError('the state has too few digits: call jax.config.update("jax_enable_x64", True) first')
        shapes = jax.ShapeDtypeStruct((len(has),), float), jax.ShapeDtypeStruct((len(has), 12), float)
        return jax.pure_callback(both, shapes, *state, vmap_method="broadcast_all")

    @jax.custom_jvp
    def values(x_a, triad_a, x_b, triad_b):
        return called(x_a, triad_a, x_b, triad_b)[0]

    @values.defjvp
    def _(state, by):
        value, row = called(*state)
        turned = [jnp.cross(triad, along).sum(axis=0) / 2 for triad, along in zip(state[1::2], by[1::2])]
        return value, row @ jnp.concatenate([by[0], turned[0], by[2], turned[1]])

    values.components = tuple(_NAMES[k] for k in has)
    return values
