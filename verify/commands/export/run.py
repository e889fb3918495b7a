"""Runs exported Python programs: `run.py sympy|jax FOLDER`, where FOLDER has cases.json, and a module for each of its entries."""

import importlib
import json
import sys


def main():
    target, folder = sys.argv[1:]
    sys.path.insert(0, folder)
    with open(f"{folder}/cases.json", encoding="utf-8") as file:
        cases = json.load(file)
    if target == "sympy":
        from sympy import Float, Matrix

        def group(numbers, shape):
            exact = [Float(x, 50) for x in numbers]
            return exact[0] if shape == "number" else Matrix(3, 3, exact) if shape == "[3][3]" else exact

        def flat(results):
            if isinstance(results, (list, tuple)):
                return [x for result in results for x in flat(result)]
            return [float(results)]

    else:
        import numpy as np

        def group(numbers, shape):
            return np.float64(numbers[0]) if shape == "number" else np.array(numbers).reshape(3, 3) if shape == "[3][3]" else np.array(numbers)

        def flat(results):
            if isinstance(results, tuple):
                return [x for result in results for x in flat(result)]
            return [float(x) for x in np.asarray(results).ravel()]

    found = []
    for case in cases:
        function = getattr(importlib.import_module(case["module"]), case["function"])
        found.append([flat(function(*[group(*argument) for argument in state])) for state in case["states"]])
    json.dump(found, sys.stdout)


main()
