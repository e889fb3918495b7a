"""A verification workbench for connector (joint) elements.

check     judges a routine of yours: which entry is wrong, and why
Scene     evaluates the connectors of a deck
audit     audits a scene
catalog   lists the connection types
"""

import json
import os
import shlex
import sys
import types

import numpy

from . import _native

__version__ = _native.VERSION
__all__ = ["Report", "Scene", "audit", "catalog", "check"]

_driver = types.ModuleType("pintle._driver")
exec(compile(_native.DRIVER, "pintle._driver", "exec"), _driver.__dict__)


class Report:
    """What a check or an audit found.

    ok        whether every number is right, and proven to be
    verdict   "pass", "wrong", "undecided" …: the severest
    worst     of the worst number: entry, got, want, units (of its tolerance), state; None where nothing is wrong
    cause     sentences that say why numbers are wrong
    codes     their codes, which `pintle explain` explains
    text      one screen
    """

    def __init__(self, told):
        self._told = told
        self._json = json.loads(told["json"])
        self.ok, self.text = told["ok"], told["brief"]
        wrong = [check for subject in self._json["subjects"] for check in subject["checks"] if check["verdict"] in _WRONG]
        self.verdict = wrong[0]["verdict"] if wrong else "pass" if self.ok else "undecided"
        found = [(check["worst"], check["worst_state"]) for check in wrong if check.get("worst")]
        found.sort(key=lambda worst: -_number(worst[0]["units"]))
        keys = "entry", "got", "want", "units"
        self.worst = {**{key: found[0][0][key] for key in keys}, "state": found[0][1]} if found else None
        causes = [cause for check in wrong for cause in (check.get("diagnosis") or {}).get("causes", [])]
        self.cause = list(dict.fromkeys(cause["sentence"] for cause in causes))
        self.codes = list(dict.fromkeys(cause["code"] for cause in causes))

    def to_json(self):
        """The report as JSON, schema pintle-audit/1."""
        return self._told["json"]

    def to_html(self):
        """The report as a page."""
        return self._told["html"]

    def assert_ok(self):
        """Raises AssertionError, with what is wrong and why, unless everything is right."""
        __tracebackhide__ = True
        if not self.ok:
            raise AssertionError("\n" + self.text)

    def __bool__(self):
        return self.ok

    def __repr__(self):
        return self.text

    def _repr_html_(self):
        return self._told["html"]


_WRONG = "unstable-formula", "wrong", "invalid"


def _number(x):
    return float("inf") if x is None else float(x)


def check(
    routine,
    of,
    *,
    offers=("values", "rows"),
    components=None,
    convention=None,
    memory=False,
    springs=None,
    states=200,
    near_singular_states=50,
    wide_states=30,
    histories=40,
    seed="pintle",
):
    """Checks a routine against a connection type, or a connector of a scene ("model.inp:106").

    routine(state, connector) gives values and rows: two lists of six, None where the connector has no such component; rows have 14
    columns, x, rotation and flow of a, then of b. Or it gives a dictionary of what `offers` names: values, rows, rates, accelerations,
    second_derivatives, nodal_forces, geometric_stiffness, element_forces, element_stiffness. A third argument is what is wanted now.
    state and connector are dictionaries of arrays; docs/reference/protocol.md has their keys, and those of `convention`.

    springs    six stiffnesses, None for none, of an element that gives element_forces
    histories  how many states end a history, where angles go on from state["previous"]["values"]
    memory     whether the routine keeps something from state to state, as "memory" of its answers

    Returns a Report. An exception of the routine is raised as it is.
    """
    name = f"{getattr(routine, '__module__', '?')}:{getattr(routine, '__qualname__', repr(routine))}"
    driver = _driver.Driver(routine, name, offers, components, convention, memory)
    given = [None if x is None else float(x) for x in (springs or [])]
    springs = (given + [None] * 6)[:6]
    try:
        told = _native.check_routine(
            lambda line: driver.line(line) or "",
            of,
            states,
            near_singular_states,
            wide_states,
            histories,
            springs,
            seed,
        )
    except ValueError:
        if driver.error is not None:
            raise driver.error
        raise
    return Report(told)


class Scene:
    """A deck, TOML or JSON scene, or "gallery:NAME".

    connectors   of each its element number, its connection type, and whether it has u1, u2, u3, ur1, ur2, ur3
    """

    def __init__(self, path):
        self.path = str(path)
        self._native = _native.Loaded(self.path)
        self.connectors = self._native.connectors()

    def __reduce__(self):
        return Scene, (self.path,)

    def evaluate(self, states=None, outputs=("CP", "CU", "RES"), order=1, independent=False):
        """Outputs of all connectors at all states.

        states        a file of states (.csv, .json); without it, those of the scene, or the initial one
        outputs       any of CP, CU, CV, CA, RES, RESV, RESA
        order         1 adds "jacobian", 2 adds "hessian"
        independent   each state follows the initial one, not the one before

        Returns arrays by name, (state, connector, component), "jacobian" with 14 columns after that, "hessian" with 14 × 14. What a
        connector has not is NaN. Lengths are those of the deck, angles in rad.
        """
        outputs = [outputs] if isinstance(outputs, str) else list(outputs)
        states = None if states is None else str(states)
        count, found = self._native.evaluate(states, outputs, order, independent)
        shape = count, len(self.connectors), 6
        more = {"jacobian": (14,), "hessian": (14, 14)}
        return {name: numpy.frombuffer(of).reshape(shape + more.get(name, ())) for name, of in found.items()}


def audit(scene, seed="pintle"):
    """Audits a Scene, or the scene of that name, at its states. Returns a Report."""
    scene = scene if isinstance(scene, Scene) else Scene(scene)
    return Report(_native.audit_scene(scene._native, seed))


def catalog():
    """The connection types: of each name the role of u1, u2, u3, ur1, ur2, ur3: "constrained", "available", "measured" or None."""
    return dict(_native.types())


def main():
    """The pintle command, whose --python asks this Python."""
    folder = os.path.dirname(sys.executable)
    os.environ["PATH"] = folder + os.pathsep + os.environ.get("PATH", os.defpath)
    os.environ["PINTLE_COMMAND"] = f"{shlex.quote(sys.executable)} -m pintle"
    sys.exit(_native.main(["pintle", *sys.argv[1:]]))
