"""What the peers of `cargo bench --bench work_precision` have in common: the file of states, errors against the truth in it, and the lines they
exchange with measure.py: points without times and what is not timed first, then the times of a round for each line read.
"""

import json
import sys

import numpy as np

from shared import least_time

# Where x_a, theta_a, x_b, theta_b stand among the fourteen degrees of freedom.
PLACE = [0, 1, 2, 3, 4, 5, 7, 8, 9, 10, 11, 12]


def read(path):
    with open(path) as file:
        return json.load(file)


def errors(order, found, subject):
    """The median over the states and the largest: of a value over its size, of a derivative over the largest number of its row."""
    count, rows = found.shape[:2]
    truth = {name: np.array(numbers) for name, numbers in subject["truth"].items()}
    want, first = truth[order].reshape(count, rows, -1), truth["Jacobian"].reshape(count, rows, 14)
    if order == "value":
        got = found.reshape(count, rows, 1)
        scale = np.array(subject["size_of_values"]).reshape(count, rows)
    elif order == "Jacobian":
        got, want = found, want[:, :, PLACE]
    else:
        got, want = found, want.reshape(count, rows, 14, 14)[:, :, PLACE][:, :, :, PLACE]
    got, want = got.reshape(count, rows, -1), want.reshape(count, rows, -1)
    if order != "value":
        scale = np.maximum(np.abs(want).max(axis=2), np.abs(first).max(axis=2))
    each = (np.abs(got - want).max(axis=2) / scale).max(axis=1)
    each = np.sort(np.where(np.isfinite(each), each, np.inf))
    return float(each[count // 2]), float(each[-1])


class Participant:
    """Ways whose errors are within their bounds, to be timed; the others are listed with their errors."""

    def __init__(self):
        self.points, self.untimed, self.calls = [], [], []

    def add(self, subject, method, order, found, states, call):
        """`found`: state by state what the way gives; `call` goes through so many `states`."""
        median, largest = errors(order, found, subject)
        name = {
            "connection": subject["connection"],
            "place": subject["place"],
            "order": order.lower(),
            "method": method,
        }
        bound = subject["bounds"][order]
        if not largest <= bound:
            why = f"its error is {largest:.1e} where {bound:.1e} is allowed"
            self.untimed.append({**name, "why": why})
            return
        times = {"nanoseconds": 0.0, "slowest_round": 0.0}
        self.points.append({**name, "step": None, "median_error": median, "largest_error": largest, **times})
        self.calls.append((states, call))

    def serve(self, versions):
        print(json.dumps({"points": self.points, "untimed": self.untimed, "versions": versions}), flush=True)
        for _ in sys.stdin:
            print(json.dumps([least_time(call, states) for states, call in self.calls]), flush=True)
