"""Scenes: their numbers as arrays, their audit, and the catalogue."""

import json
import os
import warnings
from collections.abc import Mapping

import numpy

from . import _pintle
from ._check import Report


def _plain(value):
    """What JSON can write: arrays and their numbers as lists and numbers, keys as text."""
    if isinstance(value, dict):
        return {str(key): _plain(one) for key, one in value.items()}
    if isinstance(value, (list, tuple)):
        return [_plain(one) for one in value]
    return value.tolist() if hasattr(value, "tolist") else value


def _states(states):
    """A path, or a document of states."""
    if states is None or isinstance(states, (str, os.PathLike)):
        return (None if states is None else os.fspath(states)), None
    return None, json.dumps({"schema": "pintle-states/1", "states": _plain(states)})


def _arrays(states):
    """Arrays by state and node, in C order."""
    found = {name: states[name] for name in states if name != "state"}
    if "node" not in found:
        raise ValueError("states have no array node, which names the nodes of the other arrays")
    found["node"] = [str(label) for label in numpy.asarray(found["node"]).ravel().tolist()]
    for name, array in found.items():
        if name == "node":
            continue
        array = numpy.asarray(array)
        if array.dtype.kind == "f" and array.dtype != numpy.float64:
            raise TypeError(f"{name} has dtype {array.dtype}, and float64 is needed: {name}.astype(numpy.float64) converts it")
        if array.dtype.kind not in "fiu":
            raise TypeError(f"{name} has dtype {array.dtype}, and numbers are needed")
        found[name] = numpy.ascontiguousarray(array, dtype=numpy.float64)
    return found


class Scene:
    """A scene of connectors and constraints: a deck (.inp), TOML or JSON, `gallery:NAME`, or such a text.

    Lengths in the unit of the deck, angles in rad, global axes. A text is what has a line break. Scenes
    pickle, with their states, to the last bit. Raises ValueError with file, line and remedy.
    """

    def __init__(self, path_or_text):
        text = os.fspath(path_or_text)
        if "\n" in text:
            form = {"{": "json", "*": "inp"}.get(text.lstrip()[:1], "toml")
            self._scene = _pintle.Scene.parse("the text", text, form)
        else:
            self._scene = _pintle.Scene.open(text)

    @classmethod
    def _parse(cls, name, text):
        self = cls.__new__(cls)
        self._scene = _pintle.Scene.parse(name, text, "json")
        return self

    def __reduce__(self):
        return Scene._parse, self._scene.written()

    @property
    def name(self):
        """The file it was read from."""
        return self._scene.written()[0]

    @property
    def connectors(self):
        """Of each connector, in the order of the arrays: `element`, `type` and `nodes` (a, b; None is the ground)."""
        keys = "element", "type", "nodes"
        return [dict(zip(keys, one)) for one in self._scene.connectors()]

    def __repr__(self):
        return f"<pintle.Scene {self.name}: {len(self.connectors)} connectors>"

    def evaluate(self, states=None, outputs=("CP", "CU", "RES"), order=1, *, out=None):
        """The numbers of every connector at every state, evaluated in order, as a dictionary of float64 arrays.

        `states` are one of

        - arrays by name, as `pintle states --format npz` writes them and numpy.load reads them: `node` (n,)
          names the nodes, and `u` (states, n, 3), `rotation_vector` (states, n, 3) or `quaternion`
          (states, n, 4) w, x, y, z, `velocity`, `angular_velocity`, `acceleration`, `angular_acceleration`,
          `flow` (states, n), `flow_velocity`, `flow_acceleration`, `time` (states,) move them
        - a list of states as in the JSON form, `{"time": 0.5, "nodes": {2: {"rotation": [0, 0, 0.3]}}}`
        - a path (.csv, .json), or None for those of the scene, or its initial state

        `outputs`: names as of `pintle eval`. Each is (states, connectors, 6), components u1 … ur3, NaN where
        a connector has none. `time` is (states,). `out` has arrays by name that take the numbers, in C order.

        Where all outputs follow from the motion alone, connectors of one kind are evaluated four at a time on
        all threads: CP, CU, CCU, RES, TURNS and rows then differ from those of `pintle eval` by roundings.

        `order` 1 adds `jacobian` (states, connectors, 6, 14): derivatives of the residual of a constrained
        component, of the position of any other, by x_a, θ_a, Ψ_a, x_b, θ_b, Ψ_b; rotations spatial. `order`
        2 adds `hessian` (states, connectors, 6, 14, 14).
        """
        is_arrays = isinstance(states, Mapping)
        path, document = (None, None) if is_arrays else _states(states)
        arrays = _arrays(states) if is_arrays else None
        return self._scene.evaluate(path, document, arrays, list(outputs), order, out)

    def jacobian(self, states=None, *, out=None):
        """The sparse constraint Jacobian at every state, in order, as a Jacobian: `.matrix(k)` is that of state k for SciPy.

        Rows are the constrained components of connectors and the equations of other constraints; columns the degrees
        of freedom of nodes that `*BOUNDARY`, before or in the first step, leaves free, along the axes of `*TRANSFORM`.
        Rotations vary spatially, C → exp(δθ^) C. `states` are as in `evaluate`. `out` (states, entries), in C order, takes the entries.
        A RuntimeWarning counts the values that need care, beside singular points, and names the first. Raises ValueError
        as `evaluate` does.
        """
        is_arrays = isinstance(states, Mapping)
        path, document = (None, None) if is_arrays else _states(states)
        arrays = _arrays(states) if is_arrays else None
        data, care, first = self._scene.jacobian(path, document, arrays, None if out is None else {"data": out})
        if care:
            what = "value needs" if care == 1 else "values need"
            warnings.warn(f"{care} {what} care; the first: {first}", RuntimeWarning, stacklevel=2)
        return Jacobian(self._scene, data)


class Jacobian:
    """The sparse constraint Jacobian of a scene, in compressed rows (CSR), whose pattern is the same at all states.

    - `data` (states, entries): the entries at each state; `indices`, `indptr`, `shape` as SciPy has them
    - `rows`: what each row is, as `HINGE 1 u1`; `columns`: node and degree of freedom (1–6, 10) of each column
    """

    def __init__(self, scene, data):
        self._scene, self.data = scene, data
        self.indptr, self.indices, width = scene.jacobian_pattern()
        self.shape = len(self.indptr) - 1, width

    @property
    def rows(self):
        """What each row is: connector or constraint, and the component."""
        return self._scene.jacobian_names()[0]

    @property
    def columns(self):
        """The node, as text, and the degree of freedom of each column."""
        return self._scene.jacobian_names()[1]

    def matrix(self, state=0):
        """The matrix at a state as a `scipy.sparse.csr_array` of its own. SciPy is needed."""
        from scipy.sparse import csr_array

        return csr_array((self.data[state], self.indices, self.indptr), shape=self.shape, copy=True)

    def __repr__(self):
        rows, columns = self.shape
        return f"<pintle.Jacobian: {rows} × {columns}, {len(self.indices)} entries, {len(self.data)} states>"


def audit(scene, states=None, *, model_only=False, seed="pintle"):
    """Is a scene right: its model, and every number at its states? Returns a report, as `check` does.

    `scene` is a Scene, or what makes one. `states` as in `Scene.evaluate`; without any, states are drawn.
    """
    one = scene if isinstance(scene, Scene) else Scene(scene)
    found = one._scene.audit(*_states(states), model_only, seed)
    return Report(found, f"pintle.audit({one.name if scene is one else scene!r})")


def catalog():
    """The connection types by name, each with `constrained`, `available` and `output_only` components."""
    return {one["name"]: one for one in json.loads(_pintle.catalog())["types"]}
