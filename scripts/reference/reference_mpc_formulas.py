"""The formulas of scripts/reference/reference_mpc.py: equations of multi-point constraints and the angles of their hinges (JAX, float64).

Rotations are composed as quaternions, in the order of the theory with the axes as they are carried (C_S = C(phi_2 a2) C(phi_1 a1) C_M);
the angles of two hinges are Cardan angles of the relative rotation in the directions of the axes, turned by their angle beyond the
right one.
"""

import owned  # noqa: F401, before what it makes importable
from reference_formulas import after, jnp, np, principal_vector, reversed_rotation, rodrigues, versor

HINGES = {"BEAM": 0, "LINK": None, "PIN": None, "REVOLUTE": 1, "TIE": 0, "UNIVERSAL": 2}


def axes(case):
    """a1 from M to J1, or z; a2 from M to J2, or x."""
    found = []
    for node, otherwise in ((2, [0.0, 0.0, 1.0]), (3, [1.0, 0.0, 0.0])):
        line = np.array(case["X"][node]) - np.array(case["X"][1])
        length = np.linalg.norm(line)
        found.append(line / length if length > 0 else np.array(otherwise))
    return found


def equations(case, kind):
    """(residual and angles) of the 16 variations."""
    initial = [jnp.array(x) for x in case["X"]]
    first, second = (jnp.array(axis) for axis in axes(case))
    arm = initial[0] - initial[1]
    hinges = HINGES[kind]

    def function(v):
        u_s, u_m = jnp.array(case["u_S"]) + v[0:3], jnp.array(case["u_M"]) + v[7:10]
        q_s = after(versor(v[3:6]), versor(jnp.array(case["theta_S"])))
        q_m = after(versor(v[10:13]), versor(jnp.array(case["theta_M"])))
        c_m = rodrigues(v[10:13]) @ rodrigues(jnp.array(case["theta_M"]))
        phi = jnp.array(case["phi"]) + v[14:16]
        parts = []
        if kind in ("PIN", "TIE"):
            parts.append(u_s - u_m)
        if kind == "LINK":
            parts.append(jnp.linalg.norm(arm + u_s - u_m)[None] - jnp.linalg.norm(arm))
        if kind == "BEAM":
            parts.append((initial[0] + u_s) - (initial[1] + u_m) - c_m @ arm)
        if hinges is not None:
            followed, a1 = q_m, c_m @ first
            if hinges > 0:
                followed = after(versor(phi[0] * a1), followed)
            if hinges > 1:
                followed = after(versor(phi[1] * (rodrigues(phi[0] * a1) @ (c_m @ second))), followed)
            parts.append(principal_vector(after(q_s, reversed_rotation(followed))))
        if kind == "TIE":
            parts.append((case["psi_S"] + v[6] - case["psi_M"] - v[13])[None])
        relative = after(reversed_rotation(q_m), q_s)
        if hinges == 1:
            parts.append((2.0 * jnp.arctan2(relative[1:] @ first, relative[0]))[None])
        if hinges == 2:
            across = jnp.cross(second, first)
            sine, cosine = jnp.linalg.norm(across), first @ second
            triad = jnp.stack([first, across / sine, jnp.cross(first, across / sine)], axis=1)
            half = jnp.arctan2(-cosine, sine) / 2
            back = jnp.concatenate([jnp.cos(half)[None], -jnp.sin(half) * across / sine])
            turned = triad.T @ matrix(after(relative, back)) @ triad
            alpha = jnp.arctan2(-turned[1, 2], turned[2, 2])
            gamma = jnp.arctan2(-turned[0, 1], turned[0, 0])
            parts.append(jnp.stack([alpha, gamma]))
        return jnp.concatenate(parts)

    return function


def matrix(q):
    w, x, y, z = q
    v = jnp.array([x, y, z])
    spin = jnp.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return (w * w - v @ v) * jnp.eye(3) + 2.0 * jnp.outer(v, v) + 2.0 * w * spin
