"""The connection types at many states: branch of every angle along its history, then values and derivatives."""

import math
from concurrent.futures import ThreadPoolExecutor

import owned  # noqa: F401, before what it makes importable
from reference_formulas import (
    TABLE, WINDING, Motion, after, derivatives, drum_increment, has_torsion, jax, jnp, joint_derivatives, joint_measures, np, positions,
    quaternion_of, roles_of, torsion,
)

ALIGNED = 1e-12
"""Dot products of initial directions at most this large count as zero."""
FINER = 8
"""A branch found from the steps must be the one found from this many times as many."""


# Histories: which branch of an angle the path from the initial state leads to


def stacked(cases):
    """The numbers of the cases as arrays, with quaternions of the initial orientations."""
    keys = ["X_a", "X_b", "U_a", "U_b", "theta_a", "theta_b", "A0", "B0", "flow_a", "flow_b", "beta_s"]
    arrays = {key: np.array([case[key] for case in cases], dtype=float) for key in keys}
    arrays["quaternion_A0"] = np.array([quaternion_of(case["A0"]) for case in cases])
    arrays["quaternion_B0"] = np.array([quaternion_of(case["B0"]) for case in cases])
    for name, suffix, turn in [("rates", "v", "omega"), ("accelerations", "a", "alpha")]:
        arrays[name] = np.array(
            [
                [
                    *case[f"{suffix}_a"], *case[f"{turn}_a"], case[f"flow_{suffix}_a"],
                    *case[f"{suffix}_b"], *case[f"{turn}_b"], case[f"flow_{suffix}_b"],
                ]
                for case in cases
            ]
        )
    a0, b0 = arrays["A0"], arrays["B0"]
    swing = np.abs(np.einsum("ni,ni->n", a0[:, :, 0], b0[:, :, 2]))
    yaw = np.abs(np.einsum("ni,ni->n", a0[:, :, 0], b0[:, :, 1]))
    held = TABLE[cases[0]["type"]][3]
    arrays["aligned"] = (swing <= ALIGNED) & ((yaw <= ALIGNED) | (held == "cross"))
    return arrays


def at_fraction(state, fraction):
    moving = ("U_a", "U_b", "theta_a", "theta_b", "flow_a", "flow_b")
    return {key: value * fraction if key in moving else value for key, value in state.items()}


def sampled_history(type_name, state, fractions):
    """Principal positions along the path, and the torsion where the type has one."""

    def position(fraction):
        here = at_fraction(state, fraction) | {"sheet": 0.0, "side": 1.0, "twist": 0.0}
        motion = Motion(here, jnp.zeros(14))
        found = positions(type_name, here, motion)
        return jnp.append(found, torsion(motion)) if has_torsion(type_name) else found

    return jax.vmap(position)(fractions)


def nearest_angles(angles, previous):
    return angles + 2 * np.pi * np.round((previous - angles) / (2 * np.pi))


def follow(type_name, path):
    """Turns, sheet of the rotation vector and side of the Euler angles at the end of a sampled path."""
    kind = TABLE[type_name][2]
    branch = {"turns": np.zeros(6), "sheet": 0.0, "side": 1.0, "twist": 0.0, "largest_jump": 0.0}
    if has_torsion(type_name):
        angles = path[:, [3 + i for i in WINDING.get(kind, ())] + [6]]
        continued = np.unwrap(angles, axis=0)
        turns = np.round((continued[-1] - angles[-1]) / (2 * np.pi))
        for i, count in zip(WINDING.get(kind, ()), turns):
            branch["turns"][3 + i] = count
        branch["twist"] = turns[-1]
        branch["largest_jump"] = float(np.max(np.abs(np.diff(continued, axis=0))))
        branch["final"] = continued[-1]
        return branch
    if kind not in ("cardan", "euler", "vector"):
        return branch
    previous = path[0, 3:]
    for principal in path[1:, 3:]:
        side, sheet = 1.0, 0.0
        if kind == "vector":
            size = np.linalg.norm(principal)
            reference = np.linalg.norm(previous)
            if size < 0.1 and reference > 3.2:
                continue
            if size > 0.0:
                sheet = np.round((principal @ previous / size - size) / (2 * np.pi))
            angles = principal + (2 * np.pi * sheet / size * principal if sheet else 0.0)
            branch["sheet"] = sheet
        else:
            candidates = [(1.0, nearest_angles(principal, previous))]
            if kind == "euler":
                flipped = np.array([principal[0] + np.pi, -principal[1], principal[2] + np.pi])
                candidates.append((-1.0, nearest_angles(flipped, previous)))
            side, angles = min(candidates, key=lambda candidate: np.linalg.norm(candidate[1] - previous))
        branch["largest_jump"] = max(branch["largest_jump"], float(np.linalg.norm(angles - previous)))
        branch["side"] = side
        previous = angles
    branch["final"] = previous
    return branch


def principal_on_side(principal, side):
    if side > 0:
        return principal
    wrapped = (principal[[0, 2]] + 2 * np.pi) % (2 * np.pi) - np.pi
    return np.array([wrapped[0], -principal[1], wrapped[1]])


def branches(type_name, cases, arrays):
    """Initial positions and the branch of every case, the same from the steps and from eight times finer ones."""
    fractions, starts = [], [0]
    for case in cases:
        fine = case["steps"] * FINER
        fractions.append(np.arange(fine + 1) / fine)
        starts.append(starts[-1] + fine + 1)
    owner = np.repeat(np.arange(len(cases)), np.diff(starts))
    sampler = jax.jit(jax.vmap(lambda state, fraction: sampled_history(type_name, state, fraction[None])[0]))
    keys = [key for key in arrays if key not in ("rates", "accelerations", "aligned")]
    paths = np.asarray(sampler({key: arrays[key][owner] for key in keys}, np.concatenate(fractions)))
    found = []
    for case, first, last in zip(cases, starts[:-1], starts[1:]):
        fine = paths[first:last]
        branch = follow(type_name, fine[::FINER])
        singular_on_the_way = case["type"] == "EULER" and case["name"] == "past-2pi-3"
        finer = follow(type_name, fine)
        if "final" in branch and not singular_on_the_way:
            if not np.allclose(branch["final"], finer["final"], atol=1e-6):
                raise RuntimeError(f"{type_name} {case['name']}: the branch depends on the number of steps")
        if branch["largest_jump"] > 2.0:
            raise RuntimeError(f"{type_name} {case['name']}: increment {branch['largest_jump']} too large")
        branch["initial"] = fine[0][:6]
        if TABLE[type_name][2] in ("cardan", "euler"):
            principal = principal_on_side(fine[-1, 3:], branch["side"])
            branch["turns"][3:] = np.round((branch["final"] - principal) / (2 * np.pi))
        found.append(branch)
    return found


def accumulate(cases, arrays):
    """FLOW-CONVERTER: the sum of the increments of all steps."""
    owner = np.repeat(np.arange(len(cases)), [case["steps"] for case in cases])
    before = np.concatenate([np.arange(case["steps"]) / case["steps"] for case in cases])
    share = np.concatenate([np.full(case["steps"], 1.0 / case["steps"]) for case in cases])
    keys = ("theta_a", "theta_b", "A0", "flow_b", "beta_s")
    increments = np.asarray(jax.jit(jax.vmap(drum_increment))({key: arrays[key][owner] for key in keys}, before, share))
    return np.array([math.fsum(increments[owner == i]) for i in range(len(cases))])


# Results in the layout of the file


def listed(array):
    """Nested lists of plain floats, with no negative zeros."""
    return (np.asarray(array) + 0.0).tolist()


def evaluate_all(by_type):
    """Results of every case of every type, two types at a time: XLA takes most of the time to compile."""
    with ThreadPoolExecutor(max_workers=2) as pool:
        return dict(zip(by_type, pool.map(evaluate, by_type.keys(), by_type.values())))


def prepared(type_name, cases):
    """The numbers of the cases as arrays, with the branch that each history leads to."""
    arrays = stacked(cases)
    found = branches(type_name, cases, arrays)
    for key in ("initial", "turns", "sheet", "side") + (("twist",) if has_torsion(type_name) else ()):
        arrays[key] = np.array([branch[key] for branch in found], dtype=float)
    identity = np.array([1.0, 0.0, 0.0, 0.0])
    conjugate = arrays["quaternion_A0"] * np.array([1.0, -1.0, -1.0, -1.0])
    arrays["quaternion_R0"] = np.array(jax.vmap(after)(conjugate, arrays["quaternion_B0"]))
    same = np.all(arrays["A0"] == arrays["B0"], axis=(1, 2))
    arrays["quaternion_R0"][same] = identity
    arrays["accumulated"] = accumulate(cases, arrays) if TABLE[type_name][2] == "drum" else np.zeros(len(cases))
    return arrays


def evaluate(type_name, cases):
    """Results of every case of one type, all Hessians included."""
    arrays = prepared(type_name, cases)
    computed = jax.jit(jax.vmap(lambda state: derivatives(type_name, state)))(arrays)
    computed = {key: np.asarray(value) for key, value in computed.items()}
    check_chain_rule(type_name, computed, arrays)
    return [results(case, i, computed) for i, case in enumerate(cases)]


def check_chain_rule(type_name, computed, arrays):
    """The rates were differentiated along the motion; the Jacobian and Hessian must say the same."""
    rate, acceleration = arrays["rates"], arrays["accelerations"]
    velocity = np.einsum("nij,nj->ni", computed["jacobian"], rate)
    curvature = np.einsum("nijk,nj,nk->ni", computed["hessian"], rate, rate)
    second = np.einsum("nij,nj->ni", computed["jacobian"], acceleration) + curvature
    size = np.einsum("nij,nj->ni", np.abs(computed["jacobian"]), np.abs(rate) + np.abs(acceleration))
    size += np.einsum("nijk,nj,nk->ni", np.abs(computed["hessian"]), np.abs(rate), np.abs(rate))
    differentiated = {"ROTATION-ACCELEROMETER": slice(0, 3), "ACCELEROMETER": slice(3, 6)}.get(type_name, slice(0, 6))
    for name, expected in [("velocity", velocity), ("acceleration", second)]:
        gap = np.abs(computed[name] - expected)[:, differentiated]
        if np.any(gap > 1e-12 * (1e-300 + size[:, differentiated])):
            raise RuntimeError(f"{type_name}: {name} contradicts the derivatives")


def results(case, i, computed):
    role = roles_of(case["type"])
    position, displacement = computed["position"][i], computed["displacement"][i]

    def per_component(values, wanted):
        return [listed(values[c]) if role[c] in wanted else None for c in range(6)]

    every = ("constrained", "available", "measured")
    constitutive = list(displacement)
    for c, given in enumerate(case["reference"]):
        if given is not None:
            constitutive[c] = position[c] - (given if c < 3 else math.radians(given))
    return {
        "role": role,
        "position": per_component(position, every),
        "displacement": per_component(displacement, every),
        "residual": per_component(computed["measure"][i], ("constrained",)),
        "constitutive": per_component(np.array(constitutive), ("available",)),
        "velocity": per_component(computed["velocity"][i], every),
        "acceleration": per_component(computed["acceleration"][i], every),
        "jacobian": per_component(computed["jacobian"][i], every),
        "hessian": per_component(computed["hessian"][i], every),
    }


def check_known(case, result):
    """States made so that some displacements are known beforehand."""
    for component, expected in case.get("known", {}).items():
        value = result["displacement"][component - 1]
        scale = max(1.0, np.linalg.norm(case["theta_a"]) + np.linalg.norm(case["theta_b"]))
        if abs(value - expected) > 1e-14 * scale:
            raise RuntimeError(f"{case['type']} {case['name']}: ur{component - 3} = {value}, known to be {expected}")


# The revolute-joint multi-point constraint


def evaluate_joints(cases):
    keys = ["axis", "theta_S", "theta_M", "phi_J"]
    arrays = {key: np.array([case[key] for case in cases]) for key in keys}
    arrays["rates"] = np.array([[*c["omega_S"], *c["omega_M"], c["phi_v_J"]] for c in cases])
    arrays["accelerations"] = np.array([[*c["alpha_S"], *c["alpha_M"], c["phi_a_J"]] for c in cases])
    computed = jax.jit(jax.vmap(joint_derivatives))(arrays)
    computed = {key: np.asarray(value) for key, value in computed.items()}
    angle_of = jax.jit(jax.vmap(lambda state: joint_measures(state, jnp.zeros(7))[3]))
    found = []
    for i, case in enumerate(cases):
        rho = computed["measure"][i, :3]
        # |C_S - C'| of two differentiated at the angle rho is sqrt(8) |sin(rho/2)|.
        if abs(math.sqrt(8) * math.sin(np.linalg.norm(rho) / 2) - computed["defect"][i]) > 3e-14:
            raise RuntimeError(f"MPC {case['name']}: contradicts C_S = C_M C(phi_J a0)")
        if case["name"].startswith("satisfied") and np.linalg.norm(rho) > 1e-14:
            raise RuntimeError(f"MPC {case['name']}: not satisfied")
        ends = []
        for count in (case["steps"], FINER * case["steps"]):
            fractions = np.arange(count + 1) / count
            path = {key: np.array([arrays[key][i] * (f if key != "axis" else 1.0) for f in fractions]) for key in keys}
            unwrapped = 0.0
            for angle in np.asarray(angle_of(path)):
                unwrapped = nearest_angles(angle, unwrapped)
            ends.append(float(unwrapped))
        if abs(ends[0] - ends[1]) > 1e-6:
            raise RuntimeError(f"MPC {case['name']}: the turn depends on the number of steps")
        if case["name"].startswith("satisfied") and abs(ends[0] - case["phi_J"]) > 1e-13:
            raise RuntimeError(f"MPC {case['name']}: angle {ends[0]}, phi_J {case['phi_J']}")
        found.append(
            {
                "residual": listed(rho),
                "angle": ends[0] + 0.0,
                "velocity": listed(computed["velocity"][i, :3]),
                "acceleration": listed(computed["acceleration"][i, :3]),
                "angle_velocity": listed(computed["velocity"][i, 3]),
                "angle_acceleration": listed(computed["acceleration"][i, 3]),
                "jacobian": listed(computed["jacobian"][i, :3]),
                "angle_jacobian": listed(computed["jacobian"][i, 3]),
                "hessian": listed(computed["hessian"][i, :3]),
                "angle_hessian": listed(computed["hessian"][i, 3]),
            }
        )
    return found
