"""The formulas of the program, as `pintle export TYPE --as sympy` writes them, for scripts/proof/prove.py."""

import inspect
import json
import os
import pathlib
import subprocess

import sympy

ROOT = pathlib.Path(__file__).resolve().parents[2]

MATRIX = (3, 3)
SHAPES = {"d": 3, "Q": MATRIX, "Q0": MATRIX, "phi_ref": 3, "e_fixed": 3, "X": 3, "U_a": 3, "U_b": 3, "A": MATRIX, "B": MATRIX, "f": 6}
SHAPES |= {"angles": 2, "tension": 2}
"""The inputs that are no single number."""


def program():
    """The path of the built program: that of PINTLE_PROGRAM, or cargo builds it."""
    if os.environ.get("PINTLE_PROGRAM"):
        return os.environ["PINTLE_PROGRAM"]
    command = ["cargo", "build", "--quiet", "--locked", "--all-features", "--bin", "pintle", "--message-format=json"]
    built = subprocess.run(command, cwd=ROOT, check=True, stdout=subprocess.PIPE, text=True)
    messages = [json.loads(line) for line in built.stdout.splitlines() if line.startswith("{")]
    found = [message["executable"] for message in messages if message.get("executable")]
    if not found:
        raise SystemExit("prove.py: cargo named no program `pintle`")
    return found[-1]


def listed(path):
    """The names of the catalogue."""
    done = subprocess.run([path, "list", "--format", "json"], cwd=ROOT, check=True, stdout=subprocess.PIPE, text=True)
    return {entry["name"] for entry in json.loads(done.stdout)["types"]}


def symbols_of(name, **assumptions):
    """An input as symbols: d0 d1 d2, Q00 … Q22, or one."""
    shape = SHAPES.get(name)
    separator = "_" if name[-1].isdigit() else ""
    if shape is None:
        return sympy.Symbol(name, **assumptions)
    if isinstance(shape, tuple):
        return sympy.Matrix(3, 3, sympy.symbols(f"{name}{separator}:3:3", **assumptions))
    return list(sympy.symbols(f"{name}{separator}:{shape}", **assumptions))


def friction_input(name):
    """Forces, internal ones and angles of either sign; every other parameter is positive."""
    return symbols_of(name, **({"real": True} if name in SHAPES or name.endswith("_int") else {"positive": True}))


def select(less, than, yes, no):
    """As in the exported program, but without SymPy's rewriting of nested conditions, which takes minutes."""
    condition = sympy.StrictLessThan(sympy.sympify(less), sympy.sympify(than), evaluate=False)
    return sympy.Piecewise((yes, condition), (no, True), evaluate=False)


class Export:
    """One exported type: values and rows by the name of the function, criteria of friction by their number."""

    def __init__(self, text):
        self.text = text
        self.module = {}
        exec(compile(text, "exported", "exec"), self.module)
        if "select" in self.module:
            self.module["select"] = select
        self.names = self.module["FUNCTIONS"]
        self._values = dict(zip(self.module["VALUES"], self._called("values") if "values" in self.module else [], strict=True))
        self._rows = dict(zip(self.names, self._called("jacobian"), strict=True))
        self._seconds = None

    @classmethod
    def of(cls, path, type_name, variables="relative"):
        command = [path, "export", type_name, "--as", "sympy", "--variables", variables]
        done = subprocess.run(command, cwd=ROOT, stdout=subprocess.PIPE, text=True)
        if done.returncode:
            raise SystemExit(f"prove.py: {' '.join(command[1:])} ended with {done.returncode}")
        return cls(done.stdout)

    def _called(self, function):
        function = self.module[function]
        return function(*(symbols_of(name) for name in inspect.signature(function).parameters))

    def value(self, name):
        """The position, or what the constraint holds; zero for a one-form, which has none."""
        return sympy.sympify(self._values.get(name, 0))

    def row(self, name):
        return [sympy.sympify(entry) for entry in self._rows[name]]

    def second(self, name):
        """The second derivatives by two variations, row by row."""
        if self._seconds is None:
            self._seconds = dict(zip(self.names, self._called("hessian"), strict=True))
        return [[sympy.sympify(entry) for entry in row] for row in self._seconds[name]]

    @property
    def frictions(self):
        return sum(name.startswith("friction_") for name in self.module)

    def friction(self, number):
        """P, F_C, F_N, Φ; the gradient of Φ; the inputs by name, each as a list."""
        function = self.module[f"friction_{number}"]
        inputs = {name: friction_input(name) for name in inspect.signature(function).parameters}
        point, gradient, _ = function(*inputs.values())
        groups = {name: group if isinstance(group, list) else [group] for name, group in inputs.items()}
        return [sympy.sympify(entry) for entry in point], [sympy.sympify(entry) for entry in gradient], groups
