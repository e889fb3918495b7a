# /// script
# requires-python = ">=3.11"
# dependencies = ["jax==0.10.2", "jaxlib==0.10.2", "numpy==2.4.6"]
# ///
"""Equations, rigid bodies, couplings and ties a second time: other formulas, another language, another differentiation.

Knows nothing of the Rust source. JAX differentiates with respect to (x, theta, Psi) of each node in turn, rotations varying as
C -> exp(dtheta^) C. What the reference node M carries is written in directions that are carried, instead of in a turned back difference:
  carried   d_i = (C_M e_i).(x_S - x_M) - e_i.(X_S - X_M); rotations by quaternions, axes and cross products in space
  mean      d_i = (C_M e_i).(x_M - sum w x_n) - e_i.(X_M - sum w X_n); the rotation from the antisymmetric part of the
            cross-covariance sum w R_n r_n^T C_M, of deviations from the centres, by the inverse inertia of numpy
One state of each mean has M at the best fit of the cloud by singular values (Kabsch): there every equation is met.

  python scripts/reference/reference_relation.py            writes verify/golden/relation.json
  python scripts/reference/reference_relation.py --check    recomputes every value of the file and compares
"""

import json
import pathlib
import sys

import owned  # noqa: F401, before what it makes importable
from reference_formulas import (
    after, jnp, np, principal_vector, quaternion_of, reversed_rotation, rodrigues, value_jacobian_hessian, versor,
)
from reference_states import Draw

TARGET = pathlib.Path(__file__).parents[2] / "verify" / "golden" / "relation.json"
SCHEMA = "pintle-reference-relation/1"
SEED = "pintle relations"
AGREEMENT = 1e-12
CASES = 5
KINDS = ("EQUATION", "RIGID BODY", "KINEMATIC COUPLING", "DISTRIBUTING COUPLING", "TIE")


def turned(case, node, v):
    return after(versor(v[7 * node + 3 : 7 * node + 6]), versor(jnp.array(case["theta"][node])))


def matrix(case, node, v):
    return rodrigues(v[7 * node + 3 : 7 * node + 6]) @ rodrigues(jnp.array(case["theta"][node]))


def place(case, node, v):
    return jnp.array(case["u"][node]) + v[7 * node : 7 * node + 3]


def equation(case, v):
    sum_ = 0.0
    for node, axis, dof, factor in case["terms"]:
        if dof < 3:
            q = jnp.array(axis) @ place(case, node, v)
        elif dof < 6:
            sheet = round(float(np.linalg.norm(case["theta"][node])) / (2 * np.pi))
            principal = principal_vector(turned(case, node, v))
            length = jnp.linalg.norm(principal)
            with_turns = principal * (1.0 - 2 * np.pi * sheet / length)
            q = jnp.array(axis) @ (with_turns if sheet else principal)
        else:
            q = case["psi"][node] + v[7 * node + 6]
        sum_ = sum_ + factor * q
    return jnp.array([sum_])


def carried(case, v):
    """S is node 0, M is node 1."""
    axes, fixed = np.array(case["axes"]), case["fixed"]
    arm = np.array(case["X"][0]) - np.array(case["X"][1])
    c_m, c_s = matrix(case, 1, v), matrix(case, 0, v)
    apart = arm + place(case, 0, v) - place(case, 1, v)
    directions = [c_m @ axis for axis in axes]
    parts = [directions[i] @ apart - axes[i] @ arm for i in range(3) if fixed[i]]
    free = [k for k in range(3) if not fixed[3 + k]]
    if len(free) == 0:
        space = principal_vector(after(turned(case, 0, v), reversed_rotation(turned(case, 1, v))))
        parts += [direction @ space for direction in directions]
    if len(free) == 1:
        across = jnp.cross(directions[free[0]], c_s @ axes[free[0]])
        parts += [directions[i] @ across for i in range(3) if fixed[3 + i]]
    if len(free) == 2:
        # The volume of the two axes and the direction about which M may not turn against S.
        first, second = directions[free[0]], c_s @ axes[free[1]]
        sign = 1.0 if free == [0, 2] else -1.0
        parts.append(sign * (first @ second))
    return jnp.array(parts)


def mean(case, v):
    """M is node 0."""
    weights = np.array(case["weights"]) / np.sum(case["weights"])
    initial = np.array(case["X"][1:])
    centre = weights @ initial
    arms = initial - centre
    inertia = sum(w * (r @ r * np.eye(3) - np.outer(r, r)) for w, r in zip(weights, arms))
    now = jnp.stack([initial[n] + place(case, n + 1, v) for n in range(len(weights))])
    middle = weights @ now
    c_m = matrix(case, 0, v)
    off = np.array(case["X"][0]) + place(case, 0, v) - middle
    delta = c_m.T @ off - (np.array(case["X"][0]) - centre)
    covariance = jnp.einsum("n,ni,nj->ij", jnp.array(weights), (now - middle) @ c_m, jnp.array(arms))
    lag = jnp.array([
        covariance[1, 2] - covariance[2, 1], covariance[2, 0] - covariance[0, 2], covariance[0, 1] - covariance[1, 0],
    ])
    return jnp.concatenate([delta, np.linalg.inv(inertia) @ lag])


def function_of(case):
    return {"EQUATION": equation, "TIE": equation, "DISTRIBUTING COUPLING": mean}.get(case["kind"], carried)


def evaluate(case):
    count = 7 * len(case["u"])
    rates, accelerations = (jnp.array(case[key]).reshape(-1) for key in ("rates", "accelerations"))
    function = function_of(case)
    moved = lambda y: function(case, y[:count] + rates * y[count] + accelerations * (y[count] * y[count] / 2))
    value, jacobian, hessian = (np.asarray(x) for x in value_jacobian_hessian(moved, count + 1))
    return {
        "residual": value.tolist(),
        "velocity": jacobian[:, count].tolist(),
        "acceleration": hessian[:, count, count].tolist(),
        "jacobian": jacobian[:, :count].tolist(),
    }


def best_fit(case):
    """The rotation vector and displacement of M at the best fit of the cloud, by singular values."""
    weights = np.array(case["weights"]) / np.sum(case["weights"])
    initial = np.array(case["X"][1:])
    now = initial + np.array(case["u"][1:])
    arms, moved = initial - weights @ initial, now - weights @ now
    left, _, right = np.linalg.svd((weights[:, None] * moved).T @ arms)
    fit = left @ np.diag([1.0, 1.0, np.linalg.det(left @ right)]) @ right
    theta = np.asarray(principal_vector(jnp.asarray(quaternion_of(fit))))
    lever = np.array(case["X"][0]) - weights @ initial
    return theta.tolist(), (weights @ now + fit @ lever - np.array(case["X"][0])).tolist()


def states():
    masks = [[1, 1, 1, 0, 0, 0], [1, 0, 1, 1, 1, 1], [0, 1, 0, 1, 0, 1], [1, 1, 0, 0, 1, 0], [0, 0, 1, 0, 0, 1]]
    for kind in KINDS:
        draw = Draw(f"{SEED}/{kind}")
        for number in range(CASES):
            count = {"EQUATION": 4, "DISTRIBUTING COUPLING": 5}.get(kind, 2)
            case = {
                "kind": kind, "name": f"random-{number}",
                "X": [draw.vector(1.0) for _ in range(count)],
                "u": [draw.vector(1.0) for _ in range(count)],
                "theta": [draw.rotation(0.1, 2.5) for _ in range(count)],
                "psi": [draw.between(-1.0, 1.0) for _ in range(count)],
                "rates": [[draw.between(-1.0, 1.0) for _ in range(7)] for _ in range(count)],
                "accelerations": [[draw.between(-1.0, 1.0) for _ in range(7)] for _ in range(count)],
            }
            if kind in ("EQUATION", "TIE"):
                axes = [draw.orientation() for _ in range(count)]
                if kind == "TIE":
                    axes = [np.eye(3).tolist()] * count
                    case["terms"] = [[0, axes[0][number % 3], number % 3, 1.0], [1, axes[1][number % 3], number % 3, -1.0]]
                else:
                    dofs = [number % 3, 3 + number % 3, 6, 3 + (number + 1) % 3]
                    case["terms"] = [
                        [n, axes[n][dofs[n] % 3], dofs[n], draw.between(-3.0, 3.0)] for n in range(count)
                    ]
                    if number == 4:  # beyond half a turn
                        case["theta"][1] = (np.array(case["theta"][1]) * 4.5 / np.linalg.norm(case["theta"][1])).tolist()
            elif kind == "DISTRIBUTING COUPLING":
                case["weights"] = [draw.between(0.2, 3.0) for _ in range(count - 1)]
                if number == CASES - 1:
                    case["name"] = "best-fit"
                    # A cloud that is bent by half its size.
                    turn = np.asarray(rodrigues(np.array(draw.rotation(0.5, 2.0))))
                    for n in range(1, count):
                        x = np.array(case["X"][n])
                        case["u"][n] = (turn @ (x + 0.3 * np.array(draw.vector(1.0))) - x).tolist()
                    case["theta"][0], case["u"][0] = best_fit(case)
            else:
                case["axes"] = draw.orientation() if kind == "KINEMATIC COUPLING" else np.eye(3).tolist()
                case["fixed"] = [bool(x) for x in masks[number]]
                if kind == "RIGID BODY":
                    case["fixed"] = [True] * 3 + [number % 2 == 0] * 3
            yield case


def write():
    cases = [case | evaluate(case) for case in states()]
    lines = [json.dumps(case, separators=(",", ":"), allow_nan=False) for case in cases]
    text = json.dumps({"schema": SCHEMA, "seed": SEED})[:-1] + ', "cases": [\n' + ",\n".join(lines) + "\n]}\n"
    TARGET.write_text(text, encoding="utf-8")
    print(f"{TARGET}: {len(cases)} cases, {len(text) / 1e6:.1f} MB")


def gap_of(fresh, stored):
    if isinstance(fresh, str):
        return 0.0 if fresh == stored else 1.0
    if isinstance(fresh, list) and fresh and isinstance(fresh[0], list):
        return max(gap_of(one, other) for one, other in zip(fresh, stored, strict=True))
    difference = np.abs(np.array(fresh, dtype=float) - np.array(stored, dtype=float))
    return float(np.max(difference / np.maximum(1.0, np.abs(np.array(stored, dtype=float))), initial=0.0))


def check():
    content = json.loads(TARGET.read_text(encoding="utf-8"))
    fresh_states = list(states())
    worst, failures = 0.0, []
    if len(fresh_states) != len(content["cases"]):
        sys.exit("other cases than the file has")
    for stored, state in zip(content["cases"], fresh_states):
        fresh = state | evaluate({key: stored[key] for key in state})
        if stored["name"] == "best-fit":
            fitted = max(abs(x) for x in fresh["residual"])
            worst = max(worst, fitted)
            if not fitted <= AGREEMENT:
                failures.append(f"{stored['kind']} best-fit: {fitted}")
        for key, value in fresh.items():
            gap = 0.0
            if key == "terms":
                for one, other in zip(value, stored[key], strict=True):
                    gap = max(gap, gap_of(one[1], other[1]), gap_of([one[0], *one[2:]], [other[0], *other[2:]]))
            else:
                gap = gap_of(value, stored[key])
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
