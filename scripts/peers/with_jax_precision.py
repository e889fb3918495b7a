"""JAX on the states of `cargo bench --bench work_precision`: value, jacfwd and hessian, with their errors against the truth in the same file.

Usage: with_jax_precision.py STATES.json; started by scripts/measure.py. The first line written are points without times, then for each
line read the times (ns per state) in the same order. States are repeated to the batch that the bench takes.
"""

import json
import os
import sys

os.environ["JAX_PLATFORMS"] = "cpu"
os.environ["XLA_FLAGS"] = "--xla_cpu_multi_thread_eigen=false intra_op_parallelism_threads=1"

import jax
import jax.numpy as jnp
import numpy as np

jax.config.update("jax_enable_x64", True)

from with_jax import OF_POSITION, OF_ROTATION, parts, relative
from shared import least_time

# Where x_a, theta_a, x_b, theta_b stand among the fourteen degrees of freedom.
PLACE = [0, 1, 2, 3, 4, 5, 7, 8, 9, 10, 11, 12]


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


def errors(order, found, truth, first, size_of_values):
    """The median over the states and the largest: of a value over its size, of a derivative over the largest number of its row."""
    count, rows = found.shape[:2]
    want = truth.reshape(count, rows, -1)
    if order == "value":
        got = found.reshape(count, rows, 1)
    elif order == "Jacobian":
        got, want = found, want[:, :, PLACE]
    else:
        got, want = found, want.reshape(count, rows, 14, 14)[:, :, PLACE][:, :, :, PLACE]
    got, want = got.reshape(count, rows, -1), want.reshape(count, rows, -1)
    if order == "value":
        scale = size_of_values.reshape(count, rows)
    else:
        scale = np.maximum(np.abs(want).max(axis=2), np.abs(first.reshape(count, rows, 14)).max(axis=2))
    each = (np.abs(got - want).max(axis=2) / scale).max(axis=1)
    each = np.sort(np.where(np.isfinite(each), each, np.inf))
    finite = lambda x: float(x) if np.isfinite(x) else None
    return finite(each[count // 2]), finite(each[-1])


def main():
    with open(sys.argv[1]) as file:
        subjects = json.load(file)
    points, calls = [], []
    for subject in subjects:
        name, states = subject["connection"], np.array(subject["states"])
        truth = {order: np.array(numbers) for order, numbers in subject["truth"].items()}
        count, size_of_values = subject["batch"], np.array(subject["size_of_values"])
        batch = jnp.asarray(np.resize(states, (count, states.shape[1])))
        for method, order, way in ways(name):
            program = jax.jit(jax.vmap(way))
            found = np.asarray(program(jnp.asarray(states)))
            median, largest = errors(order, found, truth[order], truth["Jacobian"], size_of_values)
            jax.block_until_ready(program(batch))
            points.append({
                "connection": name,
                "place": subject["place"],
                "order": order.lower(),
                "method": method,
                "step": None,
                "median_error": median,
                "largest_error": largest,
                "nanoseconds": 0.0,
                "slowest_round": 0.0,
            })
            calls.append((count, lambda program=program, batch=batch: jax.block_until_ready(program(batch))))
    print(json.dumps({"points": points, "versions": {"JAX": jax.__version__}}), flush=True)
    for _ in sys.stdin:
        print(json.dumps([least_time(call, count) for count, call in calls]), flush=True)


if __name__ == "__main__":
    main()
