"""JAX: jit(vmap) of jacfwd by twelve nodal degrees of freedom, and of the relative ones with the maps to twelve written by hand.

Usage: with_jax.py STATES.json; started by scripts/measure.py.
"""

import os
import sys

os.environ["JAX_PLATFORMS"] = "cpu"
os.environ["XLA_FLAGS"] = "--xla_cpu_multi_thread_eigen=false intra_op_parallelism_threads=1"

import jax
import jax.numpy as jnp
import jaxlib
import numpy as np

jax.config.update("jax_enable_x64", True)

from shared import States, least_time, serve

BATCHES = (1000, 4096, 100_000)


def spin(v):
    zero = jnp.zeros_like(v[0])
    return jnp.array([[zero, -v[2], v[1]], [v[2], zero, -v[0]], [-v[1], v[0], zero]])


def rotation_vector(q):
    """No branch near 0 and near pi."""
    v = jnp.array([q[2, 1] - q[1, 2], q[0, 2] - q[2, 0], q[1, 0] - q[0, 1]])
    sine = jnp.sqrt(v @ v)
    return v * (jnp.arctan2(sine, jnp.trace(q) - 1.0) / sine)


def revolute(q):
    return jnp.array([jnp.arctan2(-q[1, 2], q[2, 2]), q[0, 2], q[0, 1]])


def cardan(q):
    across = jnp.sqrt(q[1, 2] ** 2 + q[2, 2] ** 2)
    return jnp.array(
        [jnp.arctan2(-q[1, 2], q[2, 2]), jnp.arctan2(q[0, 2], across), jnp.arctan2(-q[0, 1], q[0, 0])]
    )


# The functions of d and of Q that each type stacks.
OF_POSITION = {"SLIDE-PLANE", "TRANSLATOR"}
OF_ROTATION = {"REVOLUTE": revolute, "TRANSLATOR": rotation_vector, "ROTATION": rotation_vector, "CARDAN": cardan}


def parts(state):
    return state[:3], state[3:6], state[6:9], state[9:18].reshape(3, 3), state[18:].reshape(3, 3)


def naive(name):
    def rows(state):
        reference, ua, ub, a, b = parts(state)

        def measures(moved):
            turned_a = a + spin(moved[3:6]) @ a
            turned_b = b + spin(moved[9:]) @ b
            stack = []
            if name in OF_POSITION:
                stack.append(turned_a.T @ (reference + (ub + moved[6:9]) - (ua + moved[:3])))
            if name in OF_ROTATION:
                stack.append(OF_ROTATION[name](turned_a.T @ turned_b))
            value = jnp.concatenate(stack)
            return value, value

        jacobian, value = jax.jacfwd(measures, has_aux=True)(jnp.zeros(12))
        return value, jacobian

    return rows


def relative(name):
    def rows(state):
        reference, ua, ub, a, b = parts(state)
        separation = reference + (ub - ua)
        zero = jnp.zeros((3, 3))
        values, jacobians = [], []
        if name in OF_POSITION:
            values.append(a.T @ separation)
            jacobians.append(jnp.hstack([-a.T, jnp.cross(a.T, separation), a.T, zero]))
        if name in OF_ROTATION:

            def measures(rho):
                value = OF_ROTATION[name](a.T @ (b + spin(rho) @ b))
                return value, value

            h, value = jax.jacfwd(measures, has_aux=True)(jnp.zeros(3))
            values.append(value)
            jacobians.append(jnp.hstack([zero, -h, zero, h]))
        return jnp.concatenate(values), jnp.vstack(jacobians)

    return rows


def main():
    states = States(sys.argv[1])
    variants = {"JAX": naive, "JAX, relative": relative}
    programs = {
        variant: {name: jax.jit(jax.vmap(write(name))) for name in states.types} for variant, write in variants.items()
    }
    inputs = {count: jnp.asarray(states.repeated(count)) for count in BATCHES}
    errors = {}
    for variant, of in programs.items():
        found = {name: jax.tree.map(np.asarray, program(jnp.asarray(states.states))) for name, program in of.items()}
        errors[variant] = {name: states.error(name, *rows) for name, rows in found.items()}
        for program in of.values():
            for batch in inputs.values():
                jax.block_until_ready(program(batch))

    def measure():
        return {
            variant: {
                str(count): {
                    name: least_time(lambda: jax.block_until_ready(program(batch)), count)
                    for name, program in of.items()
                }
                for count, batch in inputs.items()
            }
            for variant, of in programs.items()
        }

    serve(errors, {"JAX": jax.__version__, "jaxlib": jaxlib.__version__}, measure)


if __name__ == "__main__":
    main()
