"""CasADi's C on the states of `cargo bench --bench work_precision`: values and Jacobians, with their errors against the truth in the same file.

Usage: with_casadi_precision.py STATES.json; started by scripts/measure.py. The states over and over.
"""

import ctypes
import pathlib
import sys
import tempfile

import numpy as np

from precision import Participant, read
from with_casadi import compiled, versions


def main():
    subjects = read(sys.argv[1])
    types = list(dict.fromkeys(subject["connection"] for subject in subjects))
    with tempfile.TemporaryDirectory() as folder:
        library, rows = compiled(pathlib.Path(folder), types)
    participant, kept = Participant(), []
    for subject in subjects:
        name, states = subject["connection"], np.ascontiguousarray(subject["states"])
        count = len(states)
        values, jacobian = np.empty((count, rows[name])), np.empty((count, rows[name], 12))
        run = getattr(library, f"batch_{types.index(name)}")
        pointer = ctypes.c_void_p
        run.argtypes = [ctypes.c_long, pointer, pointer, pointer]
        arguments = (count, states.ctypes.data, values.ctypes.data, jacobian.ctypes.data)
        # The arrays must outlive the calls.
        kept.append((states, values, jacobian))
        run(*arguments)
        calls = 2048 // count

        def call(run=run, arguments=arguments):
            for _ in range(calls):
                run(*arguments)

        participant.add(subject, "CasADi C", "Jacobian", jacobian, calls * count, call)
    participant.serve(versions())


if __name__ == "__main__":
    main()
