# /// script
# requires-python = ">=3.11"
# dependencies = ["jax==0.10.2", "jaxlib==0.10.2", "numpy==2.4.6", "mpmath==1.3.0"]
# ///
"""Connection types a second time: other formulas, another language, another differentiation.

This script knows nothing of the Rust source. Its table of components is typed from the manual pages,
its formulas are chosen to differ from the usual ones:
  rotation matrices   Rodrigues, with sin(t)/t and (1 - cos t)/t^2 as series or closed form in t^2
  relative rotation   product of the nodal quaternions, never of the triads
  rotation vector     16 atan of the twice-halved modified Rodrigues parameters, one series for all angles
  flexion, torsion    chords between the third directions; the first directions carried to the one halfway between these
  Cardan, Euler       components of the line of nodes, e3b x e1a or e3a x e3b, in the two triads
JAX differentiates them with respect to the 14 nodal variations
(x_a, theta_a, Psi_a, x_b, theta_b, Psi_b), rotations varying as C -> exp(dtheta^) C.

  python scripts/reference/reference.py            writes src/audit/oracles/golden/jax.json (needs mpmath for the error estimates)
  python scripts/reference/reference.py --check    recomputes every value of the file and compares
  python scripts/reference/reference.py --mpmath   compares every value of the file with numerical differentiation
                                         at 110 digits of textbook formulas (scripts/reference/reference_truth.py)

Fields of a case, besides the state. Per component u1 u2 u3 ur1 ur2 ur3, null where it does not apply:
  role           available, constrained, or measured (output only)
  position       angles and rotation vectors continuous along (k/steps)(U, theta, Psi), k = 0..steps
  displacement   position minus initial position
  constitutive   position minus "reference" (degrees for angles), by default minus initial position
  residual       what a constrained component keeps at zero
  velocity, acceleration, jacobian, hessian
                 of the residual of a constrained component, else of the displacement. FLOW-CONVERTER:
                 hessian[j][k] = d row_j / d q_k, not symmetric; ROTATION-ACCELEROMETER: rates are
                 (omega_b - omega_a).e_i^b and (alpha_b - alpha_a).e_i^b; ACCELEROMETER: (v_b - v_a).e_i^b
                 and (a_b - a_a).e_i^b
  error          estimated absolute error of each of these fields
The mpc list holds the revolute-joint constraint, with derivatives in the order (theta_S, theta_M, phi_J):
residual = rotation vector of C_S [C(phi_J a) C_M]^T, a = C_M axis, in global components, and angle = the
turn of C_M^T C_S about the axis, continuous along the history. Its errors are one number for each field.
Some Hessians are left out to keep the file small; all of them are verified when the file is written.
"""

import json
import platform
import sys
import time
from pathlib import Path

import numpy as np

import reference_states as states
from reference_evaluate import check_known, evaluate_all, evaluate_joints
import owned  # noqa: F401, before what it makes importable
from reference_formulas import TABLE, jax, jaxlib, roles_of
from reference_states import SEED

TARGET = Path(__file__).parents[2] / "src/audit/oracles/golden/jax.json"
SCHEMA = "pintle-jax/1"
AGREEMENT = 1e-11
"""Largest difference that --check accepts, relative to max(1, |value|)."""
SPREAD = 16
"""Largest difference that --check accepts, in units of the stored error estimate."""
ACCURACY = 1e-14
"""Largest error that the file may contain, relative to the natural size of the quantity."""
UNIT_ROUNDOFF = 2.0**-53


# Error estimates

COMPONENT_FIELDS = ["position", "displacement", "residual", "constitutive", "velocity", "acceleration", "jacobian", "hessian"]
JOINT_FIELDS = [
    "residual", "angle", "velocity", "acceleration", "angle_velocity", "angle_acceleration",
    "jacobian", "angle_jacobian", "hessian", "angle_hessian",
]


def natural_sizes(jacobian, hessian, value, rates, accelerations, reach):
    """Size of each quantity of a component, for a change `reach` of the 14 (or 7) coordinates.

    This is what one rounding of the coordinates and of the value moves, in units of the roundoff.
    """
    jacobian, hessian = np.abs(jacobian), np.abs(hessian)
    rates, accelerations = np.abs(rates), np.abs(accelerations)
    bent = hessian @ reach
    return {
        "value": abs(value) + jacobian @ reach,
        "velocity": jacobian @ rates + rates @ bent,
        "acceleration": jacobian @ accelerations + accelerations @ bent + rates @ hessian @ rates * (1 + reach.max()),
        "jacobian": float(np.max(jacobian + bent)),
        "hessian": float(np.max(hessian)) * max(1.0, *reach),
    }


def reach_of(case):
    def size(key):
        return float(np.linalg.norm(case[key]))

    first = np.array(case["X_b"]) - np.array(case["X_a"])
    now = first + (np.array(case["U_b"]) - np.array(case["U_a"]))
    span = float(max(np.linalg.norm(first), np.linalg.norm(now), size("U_a"), size("U_b")))
    reach = []
    for node in "ab":
        reach += [span] * 3 + [max(1.0, size(f"theta_{node}"))] * 3 + [abs(case[f"flow_{node}"])]
    return np.array(reach)


def coordinates_of(case):
    return (
        np.array([*case["v_a"], *case["omega_a"], case["flow_v_a"], *case["v_b"], *case["omega_b"], case["flow_v_b"]]),
        np.array([*case["a_a"], *case["alpha_a"], case["flow_a_a"], *case["a_b"], *case["alpha_b"], case["flow_a_b"]]),
    )


def rounded_up(value):
    return float(f"{value * 1.05:.1e}") if value > 0 else 0.0


def error_estimate(case, result, truth):
    """Per field and component: twice the error found against 110 digits, and never below two roundings.

    Also returns the worst error in units of the natural size.
    """
    reach = reach_of(case)
    rates, accelerations = coordinates_of(case)
    estimate, worst = {field: [None] * 6 for field in COMPONENT_FIELDS}, (0.0, "")
    for c in range(6):
        if result["role"][c] is None:
            continue
        sizes = natural_sizes(
            np.array(result["jacobian"][c]), np.array(result["hessian"][c]), result["position"][c], rates, accelerations, reach
        )
        for field in COMPONENT_FIELDS:
            if result[field][c] is None:
                continue
            size = sizes.get(field, sizes["value"])
            given = case["reference"][c]
            if field == "constitutive" and given is not None:
                size += abs(given)
            error = float(np.max(np.abs(np.array(result[field][c]) - np.array(truth[field][c])), initial=0.0))
            estimate[field][c] = rounded_up(2 * error + 2 * UNIT_ROUNDOFF * size)
            worst = max(worst, (error / size if size > 0 else error, f"{case['type']} {case['name']} {field} {c + 1}"))
    return estimate, worst


def joint_error_estimate(case, result, truth):
    reach = np.array([max(1.0, np.linalg.norm(case[k])) for k in ("theta_S", "theta_M") for _ in range(3)])
    reach = np.append(reach, max(1.0, abs(case["phi_J"])))
    rates = np.array([*case["omega_S"], *case["omega_M"], case["phi_v_J"]])
    accelerations = np.array([*case["alpha_S"], *case["alpha_M"], case["phi_a_J"]])
    estimate, worst = {}, (0.0, "")
    for field in JOINT_FIELDS:
        about_angle = field.startswith("angle")
        kind = field.removeprefix("angle_")
        prefix = "angle_" if about_angle else ""
        values = [result["angle"]] if about_angle else result["residual"]
        size = 0.0
        for j, h, value in zip(np.atleast_2d(result[f"{prefix}jacobian"]), np.reshape(result[f"{prefix}hessian"], (-1, 7, 7)), values):
            sizes = natural_sizes(j, h, value, rates, accelerations, reach)
            size = max(size, sizes.get(kind, sizes["value"]))
        error = float(np.max(np.abs(np.array(result[field]) - np.array(truth[field]))))
        estimate[field] = rounded_up(2 * error + 2 * UNIT_ROUNDOFF * size)
        worst = max(worst, (error / size, f"MPC {case['name']} {field}"))
    return estimate, worst


# The file


def selected_hessians(cases):
    named = [case["name"] for case in cases if case["name"] in states.WITH_HESSIAN]
    preference = ["random-1", "tiny-2", "near-pi-2", "past-2pi-1", "misaligned-1", "random-2", "right-angle-1"]
    return [name for name in preference if name in named][: states.HESSIANS_PER_TYPE]


def generated():
    """Fresh states: {type: cases}, and the cases of the multi-point constraint."""
    return {name: states.states_of(name, roles_of(name)) for name in TABLE}, states.mpc_states()


def versions():
    found = {"python": platform.python_version()}
    return found | {module.__name__: module.__version__ for module in (jax, jaxlib, np)}


def finished(case, result, hessian):
    entry = {key: value for key, value in case.items() if key != "known"}
    entry |= result
    if not hessian:
        for key in ("hessian", "angle_hessian"):
            entry.pop(key, None)
            entry.get("error", {}).pop(key, None)
    return entry


def write():
    import reference_truth as truth

    by_type, joints = generated()
    entries, joint_entries, worst = [], [], (0.0, "")
    pending = []
    for type_name, found in evaluate_all(by_type).items():
        for case, result in zip(by_type[type_name], found):
            check_known(case, result)
            pending.append((case, result))
    exact = truth.truths([(case, result["role"], result["position"], TABLE[case["type"]], True) for case, result in pending])
    for (case, result), true_result in zip(pending, exact):
        result["error"], case_worst = error_estimate(case, result, true_result)
        worst = max(worst, case_worst)
        entries.append(finished(case, result, case["name"] in selected_hessians(by_type[case["type"]])))
    for number, (case, result) in enumerate(zip(joints, evaluate_joints(joints))):
        result["error"], case_worst = joint_error_estimate(case, result, truth.joint_truth(case, result["angle"]))
        worst = max(worst, case_worst)
        joint_entries.append(finished(case, result, number % 2 == 0))
    print(f"worst error against 110 digits: {worst[0]:.1e} of the natural size ({worst[0] / UNIT_ROUNDOFF:.1f} roundings), {worst[1]}")
    if worst[0] > ACCURACY:
        sys.exit("not accurate enough to be a reference; nothing written")
    header = {
        "schema": SCHEMA,
        "versions": versions() | {"mpmath": truth.version()},
        "seed": SEED,
        "degrees_of_freedom": "x_a(3) theta_a(3) Psi_a x_b(3) theta_b(3) Psi_b; rotations vary as exp(dtheta^) C",
        "error": "estimated absolute error of each field, per component: twice the error against 110 digits plus two roundings",
    }
    lines = [json.dumps(header)[:-1] + ', "cases": [']
    lines.append(",\n".join(json.dumps(entry, separators=(",", ":"), allow_nan=False) for entry in entries))
    lines.append('], "mpc": [')
    lines.append(",\n".join(json.dumps(entry, separators=(",", ":"), allow_nan=False) for entry in joint_entries))
    lines.append("]}")
    TARGET.parent.mkdir(parents=True, exist_ok=True)
    TARGET.write_text("\n".join(lines) + "\n", encoding="utf-8")
    print(f"{TARGET}: {len(entries)} cases of {len(by_type)} types, {len(joint_entries)} of the MPC, {TARGET.stat().st_size / 1e6:.1f} MB")


class Comparison:
    """Largest difference relative to max(1, |value|), and everything that differs by more than agreed."""

    def __init__(self):
        self.worst, self.where, self.count, self.equal, self.failures = 0.0, "none", 0, 0, []

    def compare(self, label, stored, fresh, error=None):
        """`error`: the stored estimate of the error of these numbers, if there is one."""
        if isinstance(stored, list) and isinstance(fresh, list) and len(stored) == len(fresh):
            errors = error if isinstance(error, list) else [error] * len(stored)
            for number, (s, f, e) in enumerate(zip(stored, fresh, errors), start=1):
                self.compare(f"{label}[{number}]", s, f, e)
        elif isinstance(stored, float) and isinstance(fresh, float):
            self.count += 1
            self.equal += stored == fresh
            gap = abs(stored - fresh)
            relative = gap / max(1.0, abs(stored))
            if not relative <= self.worst:
                self.worst, self.where = relative, label
            if not (relative <= AGREEMENT and (error is None or gap <= SPREAD * error)):
                self.failures.append(f"{label}: file {stored!r}, now {fresh!r}, estimated error {error}")
        elif stored != fresh or type(stored) is not type(fresh):
            self.failures.append(f"{label}: file {str(stored)[:80]}, now {str(fresh)[:80]}")

    def compare_inputs(self, label, stored_cases, fresh_cases):
        self.compare(f"{label} names", [c["name"] for c in stored_cases], [c["name"] for c in fresh_cases])
        for stored, fresh in zip(stored_cases, fresh_cases):
            for key in fresh.keys() - {"known"}:
                self.compare(f"{label} {fresh['name']} {key}", stored.get(key), fresh[key])

    def compare_outputs(self, label, stored, case, result, with_hessian):
        """`case`: the state as generated; `result`: computed from the state as stored."""
        expected = finished(case, result | {"error": dict.fromkeys(result)}, with_hessian)
        label = f"{label} {case['name']}"
        self.compare(f"{label} fields", sorted(stored), sorted(expected))
        for key in result.keys() & expected.keys() & stored.keys():
            self.compare(f"{label} {key}", stored[key], result[key], stored["error"].get(key))


def load():
    with TARGET.open(encoding="utf-8") as file:
        content = json.load(file)
    if content["schema"] != SCHEMA or content["seed"] != SEED:
        sys.exit(f"{TARGET}: schema {content['schema']}, seed {content['seed']}; expected {SCHEMA}, {SEED}")
    return content


def check():
    """Fresh states against the stored ones; fresh results at the stored states against the stored results."""
    began = time.perf_counter()
    content = load()
    by_type, joints = generated()
    comparison = Comparison()
    stored_types = list(dict.fromkeys(case["type"] for case in content["cases"]))
    comparison.compare("types", stored_types, list(TABLE))
    stored_by_type = {name: [case for case in content["cases"] if case["type"] == name] for name in stored_types if name in TABLE}
    results = evaluate_all(stored_by_type)
    loosest = (0.0, "none")
    for type_name, stored_cases in stored_by_type.items():
        fresh_cases = by_type[type_name]
        comparison.compare_inputs(type_name, stored_cases, fresh_cases)
        with_hessian = selected_hessians(fresh_cases)
        for stored, case, result in zip(stored_cases, fresh_cases, results[type_name]):
            check_known(case, result)
            comparison.compare_outputs(type_name, stored, case, result, case["name"] in with_hessian)
            loosest = max(loosest, loosest_error(stored, result, comparison))
    comparison.compare_inputs("MPC", content["mpc"], joints)
    for number, (stored, case, result) in enumerate(zip(content["mpc"], joints, evaluate_joints(content["mpc"]))):
        comparison.compare_outputs("MPC", stored, case, result, number % 2 == 0)
    for failure in comparison.failures[:20]:
        print(failure)
    if len(comparison.failures) > 20:
        print(f"... and {len(comparison.failures) - 20} more")
    for name, version in versions().items():
        if content["versions"][name] != version:
            print(f"note: the file was written with {name} {content['versions'][name]}, this is {version}")
    print(
        f"{comparison.count} numbers, {comparison.equal} bit-equal, worst difference {comparison.worst:.1e} "
        f"of max(1, |value|) at {comparison.where}; agreement {AGREEMENT:.0e}; "
        f"largest stored error estimate {loosest[0]:.1e} of the natural size at {loosest[1]}; "
        f"{time.perf_counter() - began:.0f} s"
    )
    sys.exit("the file and this script disagree" if comparison.failures else 0)


def loosest_error(case, result, comparison):
    """No stored error estimate may exceed what the accuracy asked for allows."""
    reach = reach_of(case)
    rates, accelerations = coordinates_of(case)
    worst = (0.0, "")
    for c in range(6):
        if result["role"][c] is None:
            continue
        sizes = natural_sizes(
            np.array(result["jacobian"][c]), np.array(result["hessian"][c]), result["position"][c], rates, accelerations, reach
        )
        for field, estimates in case["error"].items():
            if estimates[c] is None:
                continue
            size = sizes.get(field, sizes["value"]) + abs(case["reference"][c] or 0.0)
            label = f"{case['type']} {case['name']} {field} {c + 1}"
            if not 0.0 <= estimates[c] <= 2.1 * (ACCURACY + UNIT_ROUNDOFF) * size:
                comparison.failures.append(f"{label}: stored error estimate {estimates[c]}")
            if size > 0:
                worst = max(worst, (estimates[c] / size, label))
    return worst


def compare_with_mpmath():
    import reference_truth as truth

    content = load()
    exact = truth.truths(
        [(case, case["role"], case["position"], TABLE[case["type"]], "hessian" in case) for case in content["cases"]]
    )
    worst, failures, count = (0.0, ""), [], 0

    def judge(label, value, true_value, allowed):
        nonlocal worst, count
        count += np.size(value)
        error = float(np.max(np.abs(np.array(value) - np.array(true_value))))
        worst = max(worst, (error, label))
        if not error <= allowed:
            failures.append(f"{label}: error {error:.1e}, estimated {allowed:.1e}")

    for case, true_result in zip(content["cases"], exact):
        for field, estimates in case["error"].items():
            for c, allowed in enumerate(estimates):
                if allowed is not None:
                    judge(f"{case['type']} {case['name']} {field} {c + 1}", case[field][c], true_result[field][c], allowed)
    for case in content["mpc"]:
        true_result = truth.joint_truth(case, case["angle"])
        for field, allowed in case["error"].items():
            judge(f"MPC {case['name']} {field}", case[field], true_result[field], allowed)
    for failure in failures[:20]:
        print(failure)
    print(f"{count} numbers against 110 digits; worst absolute error {worst[0]:.1e} at {worst[1]}; {len(failures)} beyond their estimate")
    sys.exit("an error estimate of the file is too small" if failures else 0)


if __name__ == "__main__":
    modes = {(): write, ("--check",): check, ("--mpmath",): compare_with_mpmath}
    if tuple(sys.argv[1:]) not in modes:
        sys.exit(__doc__)
    modes[tuple(sys.argv[1:])]()
