# The same number by these formulas

ALIGNED = 1e-12
"""Dot products of initial directions at most this large count as zero."""


def placed(nodes, **history):
    """A state of the formulas above: the triads as they are, turned by nothing more."""
    reference, (u_a, a, flow_a), (u_b, b, flow_b) = nodes
    none = np.zeros(3)
    state = {
        "X_a": none, "X_b": reference, "U_a": u_a, "U_b": u_b, "theta_a": none, "theta_b": none, "A0": a, "B0": b,
        "flow_a": flow_a, "flow_b": flow_b, "beta_s": BETA, "quaternion_A0": quaternion_of(a), "quaternion_B0": quaternion_of(b),
        "turns": np.zeros(6), "sheet": 0.0, "side": 1.0, "twist": 0.0,
    }
    return {key: jnp.array(value, dtype=float) for key, value in (state | history).items()}


def accumulated():
    """What the drum of a FLOW-CONVERTER has wound up."""
    total = START
    for triad, turn_a, turn_b, flow in INCREMENTS:
        before = rodrigues(-jnp.array(turn_a)) @ jnp.array(triad)
        step = {"theta_a": jnp.array(turn_a), "theta_b": jnp.array(turn_b), "A0": before, "beta_s": BETA, "flow_b": flow}
        total = total + drum_increment(step, 0.0, 1.0)
    return total


def summed(kind, places):
    initial = placed(INITIAL)
    a0, b0 = np.array(INITIAL[1][1]), np.array(INITIAL[2][1])
    swing, yaw = abs(a0[:, 0] @ b0[:, 2]), abs(a0[:, 0] @ b0[:, 1])
    rest = after(reversed_rotation(initial["quaternion_A0"]), initial["quaternion_B0"])
    state = placed(
        STATE, turns=TURNS, sheet=SHEET, side=SIDE, twist=TWIST, rates=RATES, accelerations=ACCELERATIONS, accumulated=accumulated(),
        initial=positions(kind, initial, Motion(initial, jnp.zeros(14))),
        quaternion_R0=[1.0, 0.0, 0.0, 0.0] if np.array_equal(a0, b0) else rest,
    )
    state["aligned"] = jnp.array(swing <= ALIGNED and (yaw <= ALIGNED or TABLE[kind][3] == "cross"))
    # What is not asked for is not compiled.
    active = [(place, by) for place, by in places if all(ACTIVE[j] for j in place[1:])]
    if not active:
        return 0.0

    def numbers(state):
        field = derivatives(kind, state)[FIELD]
        return jnp.stack([field[place] for place, _ in active])

    return float(np.dot(jax.jit(numbers)(state), [by for _, by in active]))


def counter_example():
    return sum(summed(kind, places) for kind, places in PLACES.items())
