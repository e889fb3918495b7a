"""What the peers have in common: the file of states, errors against the truth, timing, and the lines they exchange with measure.py."""

import json
import sys
import time

import numpy as np

BUDGET = 0.025  # s: the time of one measurement, of which the least call counts
BOUND = 1e-6  # the largest error over the largest entry of the row that lets a peer be timed


class States:
    """States as rows of X_b - X_a, U_a, U_b, A, B, and the truth of each type, as `cargo bench --bench peers -- --export` writes them."""

    def __init__(self, path):
        with open(path) as file:
            content = json.load(file)
        self.states = np.array(content["states"])
        self.truth = {
            name: (np.array(rows["values"]), np.array(rows["jacobian"])) for name, rows in content["types"].items()
        }
        self.types = tuple(self.truth)

    def repeated(self, count):
        return np.ascontiguousarray(np.resize(self.states, (count, self.states.shape[1])))

    def error(self, name, values, jacobian):
        """The largest error of an entry over the largest of its row."""
        value, rows = self.truth[name]
        scale = np.abs(rows).max(axis=2)
        # Python's max passes over what is no number where it comes second; numpy's does not.
        of_values = (np.abs(values - value) / np.maximum(scale, np.abs(value))).max()
        of_rows = (np.abs(jacobian - rows) / scale[:, :, None]).max()
        worst = np.maximum(of_values, of_rows)
        if not worst < BOUND:
            raise SystemExit(f"{name}: error {worst:.1e} where {BOUND:.0e} is allowed")
        return float(worst)


def least_time(call, calls=1):
    """The least time of one of `calls` within the budget, in ns."""
    begin, least, samples = time.perf_counter(), float("inf"), 0
    while samples < 3 or time.perf_counter() - begin < BUDGET:
        start = time.perf_counter_ns()
        call()
        least = min(least, (time.perf_counter_ns() - start) / calls)
        samples += 1
    return least


def serve(errors, versions, measure):
    """Errors first; then a round for each line read."""
    print(json.dumps({"errors": errors, "versions": versions}), flush=True)
    for _ in sys.stdin:
        print(json.dumps(measure()), flush=True)
