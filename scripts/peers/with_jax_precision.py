"""JAX on the states of `cargo bench --bench work_precision`: value, jacfwd and hessian, with their errors against the truth in the same file.

Usage: with_jax_precision.py STATES.json; started by scripts/measure.py. States are repeated to the batch that the bench takes.
"""

import os
import sys

os.environ["JAX_PLATFORMS"] = "cpu"
os.environ["XLA_FLAGS"] = "--xla_cpu_multi_thread_eigen=false intra_op_parallelism_threads=1"

import jax
import jax.numpy as jnp
import numpy as np

jax.config.update("jax_enable_x64", True)

from precision import Participant, read
from with_jax import OF_POSITION, OF_ROTATION, parts, relative


def turn(theta):
    """exp(theta^) to the second order, which is exact for derivatives at theta = 0."""
    x, y, z = theta
    zero = jnp.zeros_like(x)
    spin = jnp.array([[zero, -z, y], [z, zero, -x], [-y, x, zero]])
    return jnp.eye(3) + spin + 0.5 * spin @ spin


def measures(name, state):
    reference, ua, ub, a, b = parts(state)

    def of(moved):
        turned_a, turned_b = turn(moved[3:6]) @ a, turn(moved[9:]) @ b
        stack = []
        if name in OF_POSITION:
            stack.append(turned_a.T @ (reference + (ub + moved[6:9]) - (ua + moved[:3])))
        if name in OF_ROTATION:
            stack.append(OF_ROTATION[name](turned_a.T @ turned_b))
        return jnp.concatenate(stack)

    return of


def ways(name):
    zero = jnp.zeros(12)
    yield "JAX", "value", lambda state: measures(name, state)(zero)
    yield "JAX", "Jacobian", lambda state: jax.jacfwd(measures(name, state))(zero)
    yield "JAX, relative", "Jacobian", lambda state: relative(name)(state)[1]
    yield "JAX", "Hessian", lambda state: jax.hessian(measures(name, state))(zero)


def main():
    participant = Participant()
    for subject in read(sys.argv[1]):
        name, states, count = subject["connection"], np.array(subject["states"]), subject["batch"]
        batch = jnp.asarray(np.resize(states, (count, states.shape[1])))
        for method, order, way in ways(name):
            program = jax.jit(jax.vmap(way))
            found = np.asarray(program(jnp.asarray(states)))
            jax.block_until_ready(program(batch))
            call = lambda program=program, batch=batch: jax.block_until_ready(program(batch))
            participant.add(subject, method, order, found, count, call)
    participant.serve({"JAX": jax.__version__})


if __name__ == "__main__":
    main()
