# /// script
# requires-python = ">=3.11"
# dependencies = ["jax==0.10.2", "jaxlib==0.10.2", "numpy==2.4.6"]
# ///
"""Multi-point constraints a second time: other formulas, another language, another differentiation.

Knows nothing of the Rust source; the formulas are in reference_mpc_formulas.py. JAX differentiates with respect to
(x_S, theta_S, Psi_S, x_M, theta_M, Psi_M, phi_1, phi_2), rotations varying as C -> exp(dtheta^) C.

  python scripts/reference/reference_mpc.py            writes verify/golden/mpc.json
  python scripts/reference/reference_mpc.py --check    recomputes every value of the file and compares
"""

import json
import pathlib
import sys

import owned  # noqa: F401, before what it makes importable
from reference_formulas import along, jnp, np, principal_vector, rodrigues, value_jacobian_hessian
from reference_mpc_formulas import HINGES, axes, equations
from reference_states import Draw

TARGET = pathlib.Path(__file__).parents[2] / "verify" / "golden" / "mpc.json"
SCHEMA = "pintle-reference-mpc/1"
SEED = "pintle multi-point constraints"
AGREEMENT = 1e-12
CASES = 6


def evaluate(case):
    kind = case["kind"]
    function = equations(case, kind)
    state = {key: jnp.array(case[key]) for key in ("rates", "accelerations")}
    value, jacobian, hessian = (
        np.asarray(found) for found in value_jacobian_hessian(lambda y: function(y[:16] + along(state, y[16])), 17)
    )
    angles = HINGES[kind] or 0
    count = len(value) - angles
    listed = lambda array: np.asarray(array).tolist()
    return {
        "residual": listed(value[:count]),
        "velocity": listed(jacobian[:count, 16]),
        "acceleration": listed(hessian[:count, 16, 16]),
        "jacobian": listed(jacobian[:count, :16]),
        "hessian": listed(hessian[:count, :16, :16]),
        "angles": listed(value[count:]),
        "angle_velocity": listed(jacobian[count:, 16]),
        "angle_acceleration": listed(hessian[count:, 16, 16]),
    }


def states():
    for kind in HINGES:
        draw = Draw(f"{SEED}/{kind}")
        for number in range(1, CASES + 1):
            nodes = [draw.vector(1.0) for _ in range(4)]
            if number == 2:  # default axes
                nodes[2] = nodes[3] = nodes[1]
            case = {"kind": kind, "name": f"random-{number}", "X": nodes}
            theta_m, phi = draw.rotation(0.1, 2.0), [draw.between(-2.5, 2.5), draw.between(-1.0, 1.0)]
            first, second = axes(case)
            c = np.asarray(rodrigues(np.array(theta_m)))
            for i, axis in list(enumerate([first, second]))[: HINGES[kind] or 0]:
                c = c @ np.asarray(rodrigues(phi[i] * axis))
            # S follows, but for a violation that grows with the number.
            miss = np.asarray(rodrigues(np.array(draw.rotation(0.0, 0.1 * (number - 1) + 1e-9))))
            theta_s = np.asarray(principal_vector(quaternion(miss @ c)))
            case |= {
                "u_S": draw.vector(1.0), "theta_S": theta_s.tolist(), "psi_S": draw.between(-1.0, 1.0),
                "u_M": draw.vector(1.0), "theta_M": theta_m, "psi_M": draw.between(-1.0, 1.0), "phi": phi,
                "rates": [draw.between(-1.0, 1.0) for _ in range(16)],
                "accelerations": [draw.between(-1.0, 1.0) for _ in range(16)],
            }
            yield case


def quaternion(c):
    from reference_formulas import quaternion_of

    return jnp.asarray(quaternion_of(jnp.asarray(c)))


def write():
    cases = [case | evaluate(case) for case in states()]
    lines = [json.dumps(case, separators=(",", ":"), allow_nan=False) for case in cases]
    text = json.dumps({"schema": SCHEMA, "seed": SEED})[:-1] + ', "cases": [\n' + ",\n".join(lines) + "\n]}\n"
    TARGET.write_text(text, encoding="utf-8")
    print(f"{TARGET}: {len(cases)} cases, {len(text) / 1e6:.1f} MB")


def check():
    content = json.loads(TARGET.read_text(encoding="utf-8"))
    fresh_states = list(states())
    worst, failures = 0.0, []
    if len(fresh_states) != len(content["cases"]):
        sys.exit("other cases than the file has")
    for stored, state in zip(content["cases"], fresh_states):
        fresh = state | evaluate({key: stored[key] for key in state})
        for key, value in fresh.items():
            if isinstance(value, str):
                gap = 0.0 if value == stored[key] else 1.0
            else:
                difference = np.abs(np.array(value) - np.array(stored[key]))
                gap = float(np.max(difference / np.maximum(1.0, np.abs(np.array(stored[key]))), initial=0.0))
            worst = max(worst, gap)
            if not gap <= AGREEMENT:
                failures.append(f"{stored['kind']} {stored['name']} {key}: {gap}")
    print(f"{len(fresh_states)} cases, worst difference {worst:.1e}")
    sys.exit("\n".join(failures) if failures else 0)


if __name__ == "__main__":
    modes = {(): write, ("--check",): check}
    if tuple(sys.argv[1:]) not in modes:
        sys.exit(__doc__)
    modes[tuple(sys.argv[1:])]()
