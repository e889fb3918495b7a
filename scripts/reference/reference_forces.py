# /// script
# requires-python = ">=3.11"
# dependencies = ["jax==0.10.2", "jaxlib==0.10.2", "numpy==2.4.6"]
# ///
"""Nodal forces and geometric stiffness of given component forces a second time, by JAX.

The states, and the branch of every angle, are those of src/audit/oracles/golden/jax.json; the formulas those of
reference_formulas.py. The forces of available components do work on their positions, whose sum is one
potential that JAX differentiates in reverse (nodal forces) and forward over reverse (stiffness). What the
manual prints for constrained rotations is written out here as a moment vector:
  REVOLUTE   m2 e2a + m3 e3a
  ALIGN      the moment M with M.axis_i = m_i about the axes of the initial Cardan angles, from a linear system
  SLIPRING   works with f1 on |d| - Psi_a + Psi_b
  FLOW-CONVERTER  m3 (e3a.(dtheta_a - dtheta_b) - beta_s dPsi_b)
The stiffness of a potential is its second derivative along exp(dtheta^); of a moment that a carries it is the
derivative of the nodal moments, not symmetric.

  python scripts/reference/reference_forces.py            writes src/audit/oracles/golden/forces.json
  python scripts/reference/reference_forces.py --check    recomputes every value of the file and compares
"""

import json
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np

import reference
from reference_evaluate import prepared
import owned  # noqa: F401, before what it makes importable
from reference_formulas import TABLE, Motion, jax, jnp, one_form, positions

TARGET = Path(__file__).parents[2] / "src/audit/oracles/golden/forces.json"
SCHEMA = "pintle-forces-golden/1"
STIFF = 2
"""Cases of each type whose stiffness is in the file, besides the misaligned one."""


def forces_of(type_name, number):
    """Of odd sizes and both signs, exact in binary."""
    letters = TABLE[type_name][0].replace(" ", "")
    return [((37 * (k + 1) + 11 * number) % 17 - 8) / 4 if letters[k] in "CA" else None for k in range(6)]


def potential(type_name, state, forces, variation):
    """Of the forces that do work on a function of the pose."""
    letters, translation, rotation, held = TABLE[type_name]
    motion = Motion(state, variation)
    if translation == "belt":
        stretched = jnp.sqrt(motion.d @ motion.d)
        return forces[0] * (stretched - variation[6] + variation[13]) + forces[1] * variation[13]
    position = positions(type_name, state, motion)
    work = forces[:3] @ position[:3]
    if rotation == "drum" or held == "all":
        return work
    if held == "axis":
        return work + forces[3] * position[3]
    return work + forces[3:] @ position[3:]


def carried(type_name, state, forces, variation):
    """Nodal forces of the forces that are printed in directions carried by a."""
    _, _, rotation, held = TABLE[type_name]
    triad = Motion(state, variation).a
    nothing = jnp.zeros(3)
    if rotation == "drum":
        return forces[5] * one_form(state, variation)
    if held == "axis":
        moment = forces[4] * triad[:, 1] + forces[5] * triad[:, 2]
    elif held == "all":
        relative = state["A0"].T @ state["B0"]
        alpha = jnp.arctan2(-relative[1, 2], relative[2, 2])
        axes = jnp.stack([jnp.array([1.0, 0.0, 0.0]), jnp.array([0.0, 1.0, 0.0]) * jnp.cos(alpha) + jnp.array([0.0, 0.0, 1.0]) * jnp.sin(alpha), relative[:, 2]])
        moment = triad @ jnp.linalg.solve(axes, forces[3:])
    else:
        moment = nothing
    return jnp.concatenate([nothing, -moment, jnp.zeros(1), nothing, moment, jnp.zeros(1)])


def computed(type_name, cases):
    """Nodal forces and geometric stiffness of every case of one type."""
    arrays = prepared(type_name, cases)
    arrays["forces"] = np.array([[f or 0.0 for f in case["forces"]] for case in cases])

    def one(state):
        forces = state.pop("forces")
        rest = jnp.zeros(14)
        _, pull = jax.vjp(lambda v: potential(type_name, state, forces, v), rest)
        nodal = pull(1.0)[0] + carried(type_name, state, forces, rest)
        second = jax.jacfwd(jax.grad(lambda v: potential(type_name, state, forces, v)))(rest)
        return nodal, second + jax.jacfwd(lambda v: carried(type_name, state, forces, v))(rest)

    nodal, stiffness = jax.jit(jax.vmap(one))(arrays)
    return np.asarray(nodal) + 0.0, np.asarray(stiffness) + 0.0


def entries():
    by_type = {}
    for number, case in enumerate(reference.load()["cases"]):
        if TABLE[case["type"]][0].count("M") < 3:
            by_type.setdefault(case["type"], []).append(case | {"forces": forces_of(case["type"], number)})
    with ThreadPoolExecutor(max_workers=2) as pool:
        results = dict(zip(by_type, pool.map(computed, by_type.keys(), by_type.values())))
    found = []
    for type_name, cases in by_type.items():
        stiff = 0
        for case, nodal, stiffness in zip(cases, *results[type_name]):
            entry = {key: case[key] for key in ("type", "name", "forces")} | {"nodal": nodal.tolist()}
            if "hessian" in case and (stiff < STIFF or case["name"] == "misaligned-1"):
                stiff += 1
                entry["stiffness"] = stiffness.tolist()
            found.append(entry)
    return found


def write():
    header = {"schema": SCHEMA, "versions": reference.versions()}
    lines = [json.dumps(header)[:-1] + ', "cases": [']
    lines.append(",\n".join(json.dumps(entry, separators=(",", ":"), allow_nan=False) for entry in entries()))
    lines.append("]}")
    TARGET.write_text("\n".join(lines) + "\n", encoding="utf-8")
    print(f"{TARGET}: {TARGET.stat().st_size / 1e3:.0f} kB")


def check():
    with TARGET.open(encoding="utf-8") as file:
        content = json.load(file)
    if content["schema"] != SCHEMA:
        sys.exit(f"{TARGET}: schema {content['schema']}, expected {SCHEMA}")
    comparison = reference.Comparison()
    fresh = entries()
    comparison.compare("cases", [[c["type"], c["name"]] for c in content["cases"]], [[c["type"], c["name"]] for c in fresh])
    for stored, entry in zip(content["cases"], fresh):
        for key in ("forces", "nodal", "stiffness"):
            comparison.compare(f"{entry['type']} {entry['name']} {key}", stored.get(key), entry.get(key))
    for failure in comparison.failures[:20]:
        print(failure)
    print(
        f"{comparison.count} numbers, {comparison.equal} bit-equal, worst difference {comparison.worst:.1e} "
        f"of max(1, |value|) at {comparison.where}; agreement {reference.AGREEMENT:.0e}"
    )
    sys.exit("the file and this script disagree" if comparison.failures else 0)


if __name__ == "__main__":
    modes = {(): write, ("--check",): check}
    if tuple(sys.argv[1:]) not in modes:
        sys.exit(__doc__)
    modes[tuple(sys.argv[1:])]()
