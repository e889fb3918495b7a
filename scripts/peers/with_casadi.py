"""CasADi: C generated from the Jacobian by twelve nodal degrees of freedom, compiled with gcc -O3 for this processor.

Usage: with_casadi.py STATES.json; started by scripts/measure.py.
"""

import ctypes
import pathlib
import subprocess
import sys
import tempfile

import casadi as ca
import numpy as np

from shared import States, least_time, serve

BATCHES = (32, 1000, 4096, 100_000)
FLAGS = ("-O3", "-march=native", "-fPIC", "-shared")
# Repeated in C: a call from Python takes as long as several states. What is in memory counts as changed each time.
LOOP = """
void batch_{index}(long times, long count, const double *states, double *values, double *rows) {{
    casadi_int iw[type_{index}_SZ_IW + 1];
    casadi_real w[type_{index}_SZ_W + 1];
    for (; times > 0; times--) {{
        for (long i = 0; i < count; i++) {{
            const casadi_real *arg[type_{index}_SZ_ARG + 1] = {{states + 27 * i}};
            casadi_real *res[type_{index}_SZ_RES + 1] = {{values + {n} * i, rows + {n} * 12 * i}};
            type_{index}(arg, res, iw, w, 0);
        }}
        __asm__ volatile("" ::: "memory");
    }}
}}
"""


def rotation_vector(q):
    """No branch near 0 and near pi."""
    v = ca.vertcat(q[2, 1] - q[1, 2], q[0, 2] - q[2, 0], q[1, 0] - q[0, 1])
    sine = ca.sqrt(ca.dot(v, v))
    return v * (ca.atan2(sine, ca.trace(q) - 1) / sine)


def revolute(q):
    return ca.vertcat(ca.atan2(-q[1, 2], q[2, 2]), q[0, 2], q[0, 1])


def cardan(q):
    across = ca.sqrt(q[1, 2] ** 2 + q[2, 2] ** 2)
    return ca.vertcat(ca.atan2(-q[1, 2], q[2, 2]), ca.atan2(q[0, 2], across), ca.atan2(-q[0, 1], q[0, 0]))


OF_POSITION = {"SLIDE-PLANE", "TRANSLATOR"}
OF_ROTATION = {"REVOLUTE": revolute, "TRANSLATOR": rotation_vector, "ROTATION": rotation_vector, "CARDAN": cardan}


def function(name, symbol):
    """The values and, row by row, the derivatives at no variation."""
    state, moved = ca.SX.sym("state", 27), ca.SX.sym("moved", 12)
    a, b = ca.reshape(state[9:18], 3, 3).T, ca.reshape(state[18:], 3, 3).T
    turned_a = a + ca.skew(moved[3:6]) @ a
    turned_b = b + ca.skew(moved[9:]) @ b
    stack = []
    if name in OF_POSITION:
        stack.append(turned_a.T @ (state[:3] + (state[6:9] + moved[6:9]) - (state[3:6] + moved[:3])))
    if name in OF_ROTATION:
        stack.append(OF_ROTATION[name](turned_a.T @ turned_b))
    value = ca.vertcat(*stack)
    still = ca.SX.zeros(12)
    outputs = ca.substitute([value, ca.jacobian(value, moved)], [moved], [still])
    value, jacobian = ca.cse([ca.densify(ca.simplify(outputs[0])), ca.densify(outputs[1].T)])
    return ca.Function(symbol, [state], [value, jacobian]), value.numel()


def compiled(folder, types):
    """The library, and the number of rows of each type."""
    generator = ca.CodeGenerator("peers", {"with_header": False, "mex": False})
    loops, rows = "", {}
    for index, name in enumerate(types):
        made, rows[name] = function(name, f"type_{index}")
        generator.add(made)
        loops += LOOP.format(index=index, n=rows[name])
        for what, size in zip(("ARG", "RES", "IW", "W"), (made.sz_arg(), made.sz_res(), made.sz_iw(), made.sz_w())):
            loops = f"#define type_{index}_SZ_{what} {size}\n{loops}"
    source = folder / "peers.c"
    source.write_text(generator.dump() + loops)
    library = folder / "peers.so"
    subprocess.run(["gcc", *FLAGS, "-o", library, source, "-lm"], check=True)
    return ctypes.CDLL(str(library)), rows


def caller(library, index, states, values, jacobian):
    """What goes through all states so many times. The arrays must outlive it."""
    run, pointer = getattr(library, f"batch_{index}"), ctypes.c_void_p
    run.argtypes = [ctypes.c_long, ctypes.c_long, pointer, pointer, pointer]
    arrays = (states.ctypes.data, values.ctypes.data, jacobian.ctypes.data)
    return lambda times: run(times, len(states), *arrays)


def versions():
    gcc = subprocess.run(["gcc", "-dumpfullversion"], capture_output=True, text=True, check=True).stdout.strip()
    return {"CasADi": ca.__version__, "gcc": gcc}


def main():
    states = States(sys.argv[1])
    with tempfile.TemporaryDirectory() as folder:
        library, rows = compiled(pathlib.Path(folder), states.types)

    def prepared(index, name, count):
        batch = states.repeated(count)
        values, jacobian = np.empty((count, rows[name])), np.empty((count, rows[name], 12))
        run, times = caller(library, index, batch, values, jacobian), max(1, 2048 // count)
        return lambda: run(times), times * count, (batch, values, jacobian)

    errors = {}
    for index, name in enumerate(states.types):
        call, _, (_, values, jacobian) = prepared(index, name, len(states.states))
        call()
        errors[name] = states.error(name, values, jacobian)

    def measure():
        times = {}
        for count in BATCHES:
            times[str(count)] = {}
            for index, name in enumerate(states.types):
                call, each, kept = prepared(index, name, count)
                times[str(count)][name] = least_time(call, each)
                del kept
        return {"CasADi C": times}

    serve({"CasADi C": errors}, versions(), measure)


if __name__ == "__main__":
    main()
