"""CasADi's C on the states of `cargo bench --bench work_precision`: values and Jacobians, with their errors against the truth in the same file.

Usage: with_casadi_precision.py STATES.json; started by scripts/measure.py. The states over and over.
"""

import pathlib
import sys
import tempfile

import numpy as np

from precision import Participant, read
from with_casadi import caller, compiled, versions


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
        run, times = caller(library, types.index(name), states, values, jacobian), 2048 // count
        kept.append((states, values, jacobian))
        run(1)
        participant.add(subject, "CasADi C", "Jacobian", jacobian, times * count, lambda run=run, times=times: run(times))
    participant.serve(versions())


if __name__ == "__main__":
    main()
