"""What `pintle eval` reports beside the exact moment where the printed moment is another one (PM), for scripts/proof/prove.py.

The moment M on b, from the nodal forces, must be both Σ m_i dual_i, the dual vectors of scripts/proof/proof_formulas.py, and Σ PM_i
direction_i, the directions as the page prints them.
"""

import json
import pathlib
import subprocess
import tempfile

import mpmath
import sympy
from proof_formulas import BASIC, midway, rodrigues
from proof_regions import Q, relative_state

ROUNDING = mpmath.mpf("1e-13")
"""Relative: a few dozen roundings of doubles."""

APART = 1e-3
"""Moments closer than this would not tell the printed formula from the exact one."""

PRINTED = {
    "ALIGN": ("m1 e1a + m2 e2a + m3 e3a", None),
    "REVOLUTE": ("m1 e1a + m2 e2a + m3 e3a", None),
    "ROTATION": ("m_i = M·e_i^a", ("ur1", "ur2", "ur3")),
    "UNIVERSAL": ("m1 e1a + m2 (cos α e2a + sin α e3a) + m3 e3b", ("ur1", "ur2", "ur3")),
    "PROJECTION FLEXION-TORSION": ("m1 e1 + m2 e2 + m3 e3", ("ur1", "ur2", "ur3")),
}
"""The printed moment, and the functions whose rows are the exact one; none where moments are reported about directions of their own."""

MOMENTS = (2.5, -1.5, 0.75)
PHI_A, PHI_B = (0.2, -0.4, 0.5), (0.7, 0.1, -0.3)
AXES = (0.8, 0.1, 0.6), (0.0, 1.0, 0.2)
"""Of the orientation at b: its 1-direction, and a second one in its 1–2 plane. That of a is global."""


def scene(type_name, available):
    motions = "".join(f'[[connector_motions]]\ntarget = "ONE"\ncomponent = {k}\nfixed = true\n\n' for k in available)
    return f"""nodes = {{ 1 = [0, 0, 0], 2 = [0, 0, 0] }}
connectors.1 = {{ a = 1, b = 2 }}
element_sets.ONE = [1]
orientations.OA = {{ a = [1, 0, 0], b = [0, 1, 0] }}
orientations.OB = {{ a = {list(AXES[0])}, b = {list(AXES[1])} }}

[[connector_sections]]
element_set = "ONE"
type = "{type_name}"
orientation_a = "OA"
orientation_b = "OB"

{motions}[[states]]
nodes.1 = {{ rotation = {list(PHI_A)} }}
nodes.2 = {{ rotation = {list(PHI_B)} }}
"""


def report(path, type_name):
    """CTM, PM and the moment on b."""
    listed = json.loads(subprocess.run([path, "list", "--format", "json"], check=True, stdout=subprocess.PIPE, text=True).stdout)
    with tempfile.TemporaryDirectory() as folder:
        deck, forces = pathlib.Path(folder) / "scene.toml", pathlib.Path(folder) / "forces.json"
        deck.write_text(scene(type_name, available_of(listed, type_name)), encoding="utf-8")
        given = {f"m{k}": moment for k, moment in enumerate(MOMENTS, 1)}
        forces.write_text(json.dumps({"schema": "pintle-forces/1", "states": [{"state": 0, "forces": {"1": given}}]}), encoding="utf-8")
        command = [path, "eval", str(deck), "--forces", str(forces), "--outputs", "CTF,PM,NF", "--format", "json"]
        done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    if done.returncode:
        raise SystemExit(f"prove.py: pintle eval ended with {done.returncode}: {done.stderr}")
    connector = json.loads(done.stdout)["scenes"][0]["states"][0]["connectors"][0]
    components = connector["components"]
    moment = [entry["force"] for entry in connector["nodal_forces"] if entry["name"].startswith("θb")]
    return ([components[f"ur{k}"][output] for k in (1, 2, 3)] for output in ("CTF", "PM")), moment


def available_of(listed, type_name):
    """The numbers of the available rotations."""
    found = next(entry for entry in listed["types"] if entry["name"] == type_name)
    return [k for k in (4, 5, 6) if f"ur{k - 3}" in found["available"]]


def exponential(phi):
    phi = mpmath.matrix([mpmath.mpf(x) for x in phi])
    angle = mpmath.norm(phi)
    unit = sympy.Matrix([sympy.Float(str(x), 60) for x in phi / angle])
    return rodrigues(unit, sympy.Float(str(mpmath.cos(angle)), 60), sympy.Float(str(mpmath.sin(angle)), 60))


def directions():
    """The state at 60 digits: A, and R_0, R = AᵀB."""
    first = sympy.Matrix([sympy.Float(x, 60) for x in AXES[0]])
    first /= first.norm()
    second = sympy.Matrix([sympy.Float(x, 60) for x in AXES[1]])
    third = first.cross(second)
    third /= third.norm()
    initial = sympy.Matrix.hstack(first, third.cross(first), third)
    a, b = exponential(PHI_A), exponential(PHI_B) * initial
    return a, initial, a.T * b


def reported(path):
    """For each type: its name, the printed formula, by how much the two sums miss M, relative to it, and how far PM and CTM are apart."""
    a, _, r = directions()
    numbers = dict(zip(Q, r))
    for type_name, (formula, rows) in PRINTED.items():
        (moments, printed), moment = report(path, type_name)
        state = relative_state(sympy.Integer(0))
        if type_name == "UNIVERSAL":
            alpha = sympy.atan2(-state.r(2, 3), state.r(3, 3))
            along = [state.ea(1), sympy.cos(alpha) * state.ea(2) + sympy.sin(alpha) * state.ea(3), state.eb(3)]
        elif type_name == "PROJECTION FLEXION-TORSION":
            along = midway(state)
        else:
            along = [state.ea(i) for i in (1, 2, 3)]
        exact = sympy.Matrix([sympy.Float(x, 60) for x in moment])
        size = exact.norm()

        def missed(parts, vectors):
            total = sum((sympy.Float(part, 60) * (a * vector.subs(numbers).evalf(60)) for part, vector in zip(parts, vectors)), sympy.zeros(3, 1))
            return mpmath.mpf(str((total - exact).norm() / size))

        errors = [missed(printed, along)]
        if rows:
            errors.append(missed(moments, [BASIC[type_name][name].rows[0].moment(state) for name in rows]))
        unequal = max(abs(m - p) for m, p in zip(moments, printed))
        yield type_name, formula, errors, unequal
