import jax
import jax.numpy as jnp

jax.config.update("jax_enable_x64", True)


def projected(move, directions, a, b):
    """e_i · (x_b − x_a) after a small motion: x_a, θ_a, Ψ_a, x_b, θ_b, Ψ_b."""
    turned = directions + jnp.cross(move[3:6], directions)
    return turned @ (b + move[7:10] - a - move[:3])


def without_turning(move, directions, a, b):
    return directions @ (b + move[7:10] - a - move[:3])


def routine(formula):
    rows_of = jax.jit(jax.jacfwd(formula))
    values_of = jax.jit(formula)
    still, none = jnp.zeros(14), [None] * 3

    def ends(of):
        return [jnp.array(of["a"]["triad"]), jnp.array(of["a"]["x"]), jnp.array(of["b"]["x"])]

    def element(state, connector):
        values = values_of(still, *ends(state)) - values_of(still, *ends(connector["initial"]))
        return values.tolist() + none, rows_of(still, *ends(state)).tolist() + none

    return element


cartesian = routine(projected)
wrong = routine(without_turning)
